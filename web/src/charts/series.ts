// What a plot shows: sets against an axis, one series for each combination of the other parameters.

import type { SetRow } from "../api/client";
import { parameter } from "../format";
import { choosePublished, PUBLISHED, type PublishedMark } from "../published";

/** One of our own sets. */
export interface Mark {
  x: number;
  y: number;
  sem: number | null;
  provisional: boolean;
  /** The parameters that the axis and the series do not say. */
  replicate: string;
}

/** Marks that differ in the axis only, or in the packing. */
export interface Series {
  label: string;
  marks: Mark[];
  published: PublishedMark[];
}

/** What can be plotted. */
export type Plotted = "gain_e_delta0" | "fidelity";

/** Packings are realizations of the same, not a series each. */
const REPLICATE = "packing_seed";
/** Axes along which results were published, offered even where the sweep does not vary them. */
const ALWAYS = ["friction_coefficient", "grains"];

/** The axes that sets can be plotted against, the best first. */
export function axesOf(sets: SetRow[], fixed: Record<string, unknown>): string[] {
  const names = new Set(sets.flatMap((set) => Object.keys(set.parameters)));
  const numeric = [...names].filter((name) => sets.every((set) => typeof set.parameters[name] === "number"));
  const varies = (name: string) => new Set(sets.map((set) => set.parameters[name])).size > 1;
  const known = ALWAYS.filter((name) => !numeric.includes(name) && typeof fixed[name] === "number");
  const rank = (name: string) => (name === REPLICATE ? 1 : 0) + (varies(name) ? 0 : 2);
  return [...numeric.sort((a, b) => rank(a) - rank(b)), ...known];
}

/** The series of `result` against `axis`. */
export function seriesOf(
  sets: SetRow[],
  axis: string,
  result: Plotted,
  fixed: Record<string, unknown>,
): Series[] {
  const series = new Map<string, Series>();
  for (const set of sets) {
    const x = set.parameters[axis] ?? fixed[axis];
    const y = set.results[result];
    const { [axis]: _, [REPLICATE]: replicate, ...others } = set.parameters;
    const label = labelOf(others, set.processing);
    let found = series.get(label);
    if (!found) {
      const ours = { ...fixed, ...others };
      found = { label, marks: [], published: choosePublished(PUBLISHED, ours, axis, result) };
      series.set(label, found);
    }
    if (typeof x !== "number" || typeof y !== "number") continue;
    const sem = set.results[`${result}_sem`] ?? null;
    found.marks.push({
      x,
      y,
      sem,
      provisional: set.provisional,
      replicate: replicate === undefined || axis === REPLICATE ? "" : `packing ${parameter(replicate)}`,
    });
  }
  const all = [...series.values()];
  // What every series shares does not tell them apart.
  return all.length === 1 ? all.map((only) => ({ ...only, label: "this sweep" })) : all;
}

function labelOf(parameters: Record<string, unknown>, processing: string | null | undefined): string {
  const parts = Object.entries(parameters).map(([name, value]) => `${name} ${parameter(value)}`);
  return [...parts, processing ?? ""].filter((part) => part !== "").join(", ");
}

/** Whether an axis with these values reads better in logarithms. */
export function isLogarithmic(values: number[]): boolean {
  const least = Math.min(...values);
  return values.length > 2 && least > 0 && Math.max(...values) / least >= 20;
}

/** The ends of an axis that shows all of `values` with some room around. */
export function rangeOf(values: number[], logarithmic: boolean): [number, number] {
  const finite = values.filter(Number.isFinite);
  if (finite.length === 0) return [0, 1];
  const [least, most] = [Math.min(...finite), Math.max(...finite)];
  if (logarithmic) return [least / 1.5, most * 1.5];
  const room = most > least ? 0.08 * (most - least) : Math.abs(most) * 0.5 || 0.5;
  return [least - room, most + room];
}
