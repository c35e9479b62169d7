import { expect, test } from "vitest";
import type { SetRow } from "../api/client";
import { axesOf, isLogarithmic, rangeOf, seriesOf } from "./series";

function set(parameters: Record<string, unknown>, gain: number | null, more: Partial<SetRow> = {}): SetRow {
  const results = { gain_e_delta0: gain, gain_e_delta0_sem: 10 };
  return { set: 0, reduce: "mean_sem", processing: "SUB0", parameters, results, n: 3, of: 3, provisional: false, ...more };
}

const symbol = (name: string) => ({ overlap: "𝒪" })[name] ?? name;
const FIXED = { shape: "tetrahedron", overlap: 0.6, grains: 1024, delta0: 0.05, gamma0: 1e-3, friction_coefficient: 1 };

test("the axis of most values comes first, packings last, words never", () => {
  const sets = [set({ packing_seed: 1, overlap: 0.6, shape: "sphere" }, 1), set({ packing_seed: 2, overlap: 0.9, shape: "sphere" }, 1)];
  expect(axesOf(sets, FIXED)).toEqual(["overlap", "packing_seed", "friction_coefficient", "grains"]);
});

test("packings are marks of one series, other parameters a series each", () => {
  const sets = [0.6, 0.9].flatMap((overlap) => [1, 2].map((packing_seed) => set({ overlap, packing_seed, friction_coefficient: 1 }, 5)));
  const series = seriesOf(sets, "friction_coefficient", "gain_e_delta0", FIXED, symbol);
  expect(series.map(({ label, marks }) => [label, marks.length])).toEqual([["𝒪 = 0.6", 2], ["𝒪 = 0.9", 2]]);
  expect(series[0]?.published.map(({ x }) => x)).toEqual([0, 0.4, 1]);
  expect(series[1]?.published.map(({ x }) => x)).toEqual([1]);
});

test("processings are a series each, and what was published stands beside the first", () => {
  const sets = ["SUB0", "SUB2"].map((processing) => set({ friction_coefficient: 1 }, 5, { processing }));
  const series = seriesOf(sets, "friction_coefficient", "gain_e_delta0", FIXED, symbol);
  expect(series.map(({ label, published }) => [label, published.length])).toEqual([["SUB0", 3], ["SUB2", 0]]);
});

test("a set without a number is no mark", () => {
  const series = seriesOf([set({ friction_coefficient: 0 }, null)], "friction_coefficient", "gain_e_delta0", FIXED, symbol);
  expect(series.map(({ marks }) => marks.length)).toEqual([0]);
});

test("a sweep of one set is plotted at its fixed value", () => {
  const series = seriesOf([set({}, 7)], "grains", "gain_e_delta0", FIXED, symbol);
  expect(series[0]?.marks[0]).toMatchObject({ x: 1024, y: 7, sem: 10 });
});

test("an axis is logarithmic only where all is positive and far apart", () => {
  expect(isLogarithmic([0.01, 0.1, 1])).toBe(true);
  expect(isLogarithmic([0, 0.1, 1])).toBe(false);
  expect(isLogarithmic([325, 1024, 2000])).toBe(false);
});

test("an axis of one value has room on both sides", () => {
  expect(rangeOf([2], false)).toEqual([1, 3]);
  expect(rangeOf([0], false)).toEqual([-0.5, 0.5]);
  expect(rangeOf([], false)).toEqual([0, 1]);
});
