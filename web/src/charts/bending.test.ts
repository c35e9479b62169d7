import { expect, test } from "vitest";
import { parseHistory } from "../api/history";
import { curveOf, someRows } from "./bending";

const HISTORY = { strain: [0, 0.01, 0.02], stress: [0, 40_000, 60_000] };

test("stresses are in kPa, E_b a line as far as the largest stress, Y_b a mark", () => {
  const curve = curveOf(HISTORY, {
    beam_stiffness: 5e6, beam_stiffness_intercept: 1000, ultimate_strength: 50_000, yield_strain: 0.015,
  });
  expect(curve.stress).toEqual([0, 40, 60]);
  expect(curve.stiffness?.[0]).toEqual([0, 1]);
  expect(curve.stiffness?.[1][0]).toBeCloseTo(0.0118, 12);
  expect(curve.stiffness?.[1][1]).toBeCloseTo(60, 12);
  expect(curve.strength).toEqual([0.015, 50]);
});

test("a line that would leave the curve to the right ends with it", () => {
  expect(curveOf(HISTORY, { beam_stiffness: 1e6 }).stiffness?.[1]).toEqual([0.02, 20]);
});

test("what was not found is not drawn", () => {
  const curve = curveOf(HISTORY, { beam_stiffness: null, ultimate_strength: null, ultimate_strength_reason: "run_too_short" });
  expect([curve.stiffness, curve.strength]).toEqual([undefined, undefined]);
});

test("a table of the curve keeps both ends", () => {
  expect(someRows(curveOf(HISTORY, {}), 2)).toEqual([[0, 0], [0.02, 60]]);
  expect(someRows(curveOf(HISTORY, {}), 10)).toHaveLength(3);
  expect(someRows({ strain: [], stress: [] }, 10)).toEqual([]);
});

test("a file that is no record of a bending is refused", () => {
  for (const wrong of [null, {}, { strain: [0], stress: [] }, { strain: ["a"], stress: [1] }]) {
    expect(() => parseHistory(wrong)).toThrow("not the record");
  }
});
