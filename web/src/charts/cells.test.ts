import { expect, test } from "vitest";
import type { PointRow } from "../api/client";
import { heatmapsOf, labelOf, rangeOfMeans, reasonOf, shareOf } from "./cells";

type Results = PointRow["results"];

let count = 0;
function point(parameters: Record<string, unknown>, results: Results, more: Partial<PointRow> = {}): PointRow {
  return { point: count++, state: "done", parameters, results, warnings: [], job: "b3:0", ...more };
}

const AXES: [string, string] = ["friction_coefficient", "youngs_modulus"];
const FIXED = { friction_coefficient: 0.3, youngs_modulus: 1e8 };
const strength = (value: number | null, why?: string): Results => ({
  ultimate_strength: value,
  ...(why === undefined ? {} : { ultimate_strength_reason: why }),
});

test("a map for each protocol, friction rising to the right and stiffness upward", () => {
  const points = ["A", "B"].flatMap((protocol) =>
    [1e8, 5e6].flatMap((youngs_modulus) =>
      [0.6, 0.3].map((friction_coefficient) =>
        point({ protocol, youngs_modulus, friction_coefficient }, strength(youngs_modulus * friction_coefficient)),
      ),
    ),
  );
  const maps = heatmapsOf(points, AXES, "ultimate_strength", FIXED);
  expect(maps.map(({ others }) => labelOf(others, String))).toEqual(["protocol A", "protocol B"]);
  expect(maps[0]?.across).toEqual([0.3, 0.6]);
  expect(maps[0]?.upward).toEqual([1e8, 5e6]);
  expect(maps[0]?.cells.map((row) => row.map((cell) => cell?.mean))).toEqual([[3e7, 6e7], [1.5e6, 3e6]]);
  expect(rangeOfMeans(maps)).toEqual([1.5e6, 6e7]);
});

test("packings are averaged, and those without a number are counted and explained", () => {
  const at = (packing_seed: number) => ({ friction_coefficient: 0, packing_seed });
  const points = [
    point(at(1), strength(10)),
    point(at(2), strength(14)),
    point(at(3), strength(null, "not_prominent")),
    point(at(4), {}, { state: "failed", failure: { reason: "stopped", kind: "not_at_rest", message: "…" } }),
  ];
  const [map] = heatmapsOf(points, AXES, "ultimate_strength", FIXED);
  expect(map?.cells[0]?.[0]).toMatchObject({ mean: 12, sem: 2, n: 2, of: 4, reason: "not prominent; stopped: not at rest" });
});

test("a cell without any number says why, and a point the sweep lacks is no cell", () => {
  const points = [
    point({ friction_coefficient: 0, youngs_modulus: 1e8 }, strength(null, "run_too_short")),
    point({ friction_coefficient: 0.3, youngs_modulus: 5e6 }, {}, { state: "blocked" }),
  ];
  const [map] = heatmapsOf(points, AXES, "ultimate_strength", FIXED);
  expect(map?.cells[0]?.map((cell) => cell?.reason)).toEqual(["run too short", undefined]);
  expect(map?.cells[1]?.map((cell) => cell?.reason)).toEqual([undefined, "waits"]);
  expect(rangeOfMeans(map ? [map] : [])).toBeUndefined();
});

test("a parameter that does not vary has its fixed value", () => {
  const [map] = heatmapsOf([point({ friction_coefficient: 0.6 }, strength(1))], AXES, "ultimate_strength", FIXED);
  expect([map?.across, map?.upward]).toEqual([[0.6], [1e8]]);
});

test("a running point is computed, and a number needs no reason", () => {
  expect(reasonOf(point({}, {}, { state: "leased" }), "beam_stiffness")).toBe("is computed");
  expect(reasonOf(point({}, { beam_stiffness: 1 }), "beam_stiffness")).toBe("");
});

test("colors run from the least to the largest, and one number stands in the middle", () => {
  expect([10, 15, 20].map((mean) => shareOf(mean, [10, 20]))).toEqual([0, 0.5, 1]);
  expect(shareOf(7, [7, 7])).toBe(0.5);
});
