import { expect, test } from "vitest";
import { choosePublished, moments, PUBLISHED } from "./published";

const PAPER = {
  shape: "tetrahedron", overlap: 0.6, friction_coefficient: 1, grains: 1024, delta0: 0.05, gamma0: 1e-3,
};

test("every published pack is read", () => {
  expect(PUBLISHED).toHaveLength(41);
  expect(PUBLISHED.every((pack) => pack.grains > 0 && Number.isFinite(pack.gain_e_delta0))).toBe(true);
});

test("the demo finds its own size at full friction and the paper's elsewhere", () => {
  const marks = choosePublished(PUBLISHED, PAPER, "friction_coefficient", "gain_e_delta0");
  expect(marks.map(({ x, grains, packs }) => [x, grains, packs])).toEqual([[0, 10_240, 5], [0.4, 10_240, 5], [1, 1024, 5]]);
  // (149,240 + 148,980 + 120,940 + 152,390 + 135,880)/5, from the file by hand.
  expect(marks[2]?.mean).toBeCloseTo(141_486, 6);
});

test("against the number of grains every size stands by itself", () => {
  const marks = choosePublished(PUBLISHED, PAPER, "grains", "fidelity");
  expect(marks.map(({ x }) => x)).toEqual([325, 1024, 10_240]);
});

test("a sphere has no overlap to match", () => {
  const marks = choosePublished(PUBLISHED, { ...PAPER, shape: "sphere" }, "friction_coefficient", "fidelity");
  expect(marks.map(({ x, packs }) => [x, packs])).toEqual([[1, 5]]);
});

test("nothing stands beside other strains or unpublished axes", () => {
  expect(choosePublished(PUBLISHED, { ...PAPER, delta0: 0.1 }, "friction_coefficient", "fidelity")).toEqual([]);
  expect(choosePublished(PUBLISHED, PAPER, "time_step", "fidelity")).toEqual([]);
});

test("the error of a mean is that of textbooks, and none of a single value", () => {
  const { mean, sem } = moments([1, 2, 3]);
  expect(mean).toBe(2);
  expect(sem).toBeCloseTo(1 / Math.sqrt(3), 14);
  expect(moments([1]).sem).toBeNull();
});
