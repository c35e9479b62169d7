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

/** The axes that sets can be plotted against, the one with the most values first. */
export function axesOf(sets: SetRow[], fixed: Record<string, unknown>): string[] {
  const names = new Set(sets.flatMap((set) => Object.keys(set.parameters)));
  const numeric = [...names].filter((name) => sets.every((set) => typeof set.parameters[name] === "number"));
  const known = ALWAYS.filter((name) => !numeric.includes(name) && typeof fixed[name] === "number");
  const rank = (name: string) => (name === REPLICATE ? 0 : valuesOf(sets, name).size);
  return [...numeric.sort((a, b) => rank(b) - rank(a)), ...known];
}

function valuesOf(sets: SetRow[], name: string): Set<string> {
  return new Set(sets.map((set) => parameter(set.parameters[name])));
}

/** The series of `result` against `axis`; `symbol` names a parameter. */
export function seriesOf(
  sets: SetRow[],
  axis: string,
  result: Plotted,
  fixed: Record<string, unknown>,
  symbol: (name: string) => string,
): Series[] {
  const series = new Map<string, Series>();
  const compared = new Set<string>();
  const processed = new Set(sets.map((set) => set.processing)).size > 1;
  for (const set of sets) {
    const { [axis]: _, [REPLICATE]: replicate, ...others } = set.parameters;
    const key = JSON.stringify(others);
    let found = series.get(`${key} ${set.processing}`);
    if (!found) {
      const told = Object.keys(others).filter((name) => valuesOf(sets, name).size > 1);
      const parts = told.map((name) => `${symbol(name)} = ${parameter(others[name])}`);
      if (processed && set.processing) parts.push(set.processing);
      // What was published has one processing: it stands beside the first of ours.
      const published = compared.has(key) ? [] : choosePublished(PUBLISHED, { ...fixed, ...others }, axis, result);
      compared.add(key);
      found = { label: parts.join(", ") || "this sweep", marks: [], published };
      series.set(`${key} ${set.processing}`, found);
    }
    const mark = markOf(set, set.parameters[axis] ?? fixed[axis], result);
    const packing = axis === REPLICATE || replicate === undefined ? "" : `packing ${parameter(replicate)}`;
    if (mark) found.marks.push({ ...mark, replicate: packing });
  }
  return [...series.values()];
}

function markOf(set: SetRow, x: unknown, result: Plotted): Omit<Mark, "replicate"> | undefined {
  const y = set.results[result];
  if (typeof x !== "number" || typeof y !== "number") return undefined;
  return { x, y, sem: set.results[`${result}_sem`] ?? null, provisional: set.provisional };
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
