import { describe, expect, test } from "vitest";
import { ago, duration, number, parameter, rate, withError } from "./format";

describe("numbers", () => {
  test("keep their significant digits and no empty ones", () => {
    expect([0, 1, -0.25, 0.912345678, 174_000, 123_456.789].map((value) => number(value))).toEqual([
      "0", "1", "−0.25", "0.91235", "174000", "123460",
    ]);
  });

  test("far from one are written with a power of ten", () => {
    expect(number(3e-15)).toBe("3.00·10⁻¹⁵");
    expect(number(-2.5e7, 2)).toBe("−2.5·10⁷");
  });

  test("without meaning are a dash", () => {
    expect(number(Number.NaN)).toBe("–");
  });
});

describe("a mean with its standard error", () => {
  test("ends where the error's second digit stands", () => {
    expect(withError(141.486, 5.8123)).toBe("141.5 ± 5.8");
    expect(withError(0.83589, 0.0302)).toBe("0.836 ± 0.030");
    expect(withError(-0.5, 0.25)).toBe("−0.50 ± 0.25");
  });

  test("rounds an error up into the next place", () => {
    expect(withError(10, 0.996)).toBe("10.0 ± 1.0");
  });

  test("of hundreds is rounded to the error's tens", () => {
    expect(withError(214_345, 119_876)).toBe("210000 ± 120000");
  });

  test("shares one power of ten where both are tiny", () => {
    expect(withError(2.8e-6, 1.5e-6)).toBe("(2.8 ± 1.5)·10⁻⁶");
  });

  test("is alone where there is no error", () => {
    expect(withError(0.9012, null)).toBe("0.9012");
    expect(withError(1, 0)).toBe("1");
  });
});

test("durations show their two largest units", () => {
  expect([0.2, 45, 60, 3725, 90_000, 86_400].map(duration)).toEqual([
    "< 1 s", "45 s", "1 min", "1 h 2 min", "1 d 1 h", "1 d",
  ]);
});

test("rates are per second, minute or hour", () => {
  expect([2.34, 0.5, 0.001].map(rate)).toEqual(["2.3/s", "30/min", "3.6/h"]);
});

test("a clock that runs ahead is no time ago, not a negative one", () => {
  const now = Date.parse("2026-01-01T00:01:30Z");
  expect(ago("2026-01-01T00:00:00Z", now)).toBe("1 min 30 s ago");
  expect(ago("2026-01-01T00:02:00Z", now)).toBe("< 1 s ago");
});

test("parameters read as in a spec", () => {
  expect([0.4, 1, "six/1", true, undefined, [1]].map(parameter)).toEqual(["0.4", "1", "six/1", "true", "", "[1]"]);
});
