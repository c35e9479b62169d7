// The authors' published results, and which of them may stand beside ours.

import csv from "../../tests/data/waveform-memory-published.csv?raw";

/** One pack as it was published, under our names. */
export interface PublishedPack {
  shape: string;
  overlap: number;
  friction_coefficient: number;
  grains: number;
  delta0: number;
  gamma0: number;
  /** [Pa] */
  gain_e_delta0: number;
  fidelity: number;
}

/** The packs that were published for one value of an axis. */
export interface PublishedMark {
  x: number;
  grains: number;
  packs: number;
  mean: number;
  /** Standard error of the mean; none of a single pack. */
  sem: number | null;
}

const SHAPES: Record<string, string> = { tetra: "tetrahedron" };

/** Reads the file as it was published. */
export function parsePublished(text: string): PublishedPack[] {
  const [head = "", ...lines] = text.trim().split(/\r?\n/);
  const names = head.split(",");
  return lines.map((line) => {
    const cells = line.split(",");
    const cell = (name: string) => cells[names.indexOf(name)] ?? "";
    const value = (name: string) => Number(cell(name));
    return {
      shape: SHAPES[cell("shape")] ?? cell("shape"),
      overlap: value("overlap"),
      friction_coefficient: value("friction"),
      grains: value("grains"),
      delta0: value("delta0"),
      gamma0: value("gamma0"),
      gain_e_delta0: value("gain_E_delta0_pa"),
      fidelity: value("fidelity"),
    };
  });
}

export const PUBLISHED = parsePublished(csv);

const MATCHED = ["overlap", "friction_coefficient", "delta0", "gamma0"] as const;
const AXES: readonly string[] = [...MATCHED, "grains"];

/**
 * The published marks against `axis` of packs that are otherwise like `ours`.
 *
 * Where nothing of our size was published, the largest packs are taken; each mark says its size.
 */
export function choosePublished(
  packs: PublishedPack[],
  ours: Record<string, unknown>,
  axis: string,
  result: "gain_e_delta0" | "fidelity",
): PublishedMark[] {
  if (!AXES.includes(axis)) return [];
  const alike = packs.filter((pack) => isAlike(pack, ours, axis));
  const value = (pack: PublishedPack) => pack[axis as "grains"];
  const marks = [...new Set(alike.map(value))].map((x) => {
    const group = alike.filter((pack) => value(pack) === x);
    const own = group.filter((pack) => same(pack.grains, ours.grains));
    const largest = Math.max(...group.map((pack) => pack.grains));
    const chosen = own.length > 0 ? own : group.filter((pack) => pack.grains === largest);
    const { mean, sem } = moments(chosen.map((pack) => pack[result]));
    return { x, grains: chosen[0]?.grains ?? largest, packs: chosen.length, mean, sem };
  });
  return marks.sort((a, b) => a.x - b.x);
}

function isAlike(pack: PublishedPack, ours: Record<string, unknown>, axis: string): boolean {
  if (pack.shape !== ours.shape) return false;
  // A sphere has no overlap with itself.
  const matched = MATCHED.filter((name) => name !== axis && !(name === "overlap" && pack.shape === "sphere"));
  return matched.every((name) => same(pack[name], ours[name]));
}

function same(theirs: number, ours: unknown): boolean {
  return typeof ours === "number" && Math.abs(theirs - ours) <= 1e-9 * Math.abs(theirs);
}

/** Mean, and SEM = √(Σ(x − m)²/(n − 1)/n). */
export function moments(values: number[]): { mean: number; sem: number | null } {
  const n = values.length;
  const mean = values.reduce((sum, value) => sum + value, 0) / n;
  const squares = values.reduce((sum, value) => sum + (value - mean) ** 2, 0);
  return { mean, sem: n > 1 ? Math.sqrt(squares / (n - 1) / n) : null };
}
