// What a heatmap shows: one result over two parameters, each cell the mean over packings or why there is none.

import type { PointRow } from "../api/client";
import { parameter } from "../format";
import { moments } from "../published";

/** One combination of both parameters. */
export interface Cell {
  /** Mean over the packings that have a number. */
  mean: number | null;
  /** Standard error of the mean; none of a single packing. */
  sem: number | null;
  /** Packings with a number, and in all. */
  n: number;
  of: number;
  /** Why packings have no number, in words; empty if all have one. */
  reason: string;
  /** Its first point. */
  point: number;
}

/** Cells that differ in the two parameters only, or in the packing. */
export interface Heatmap {
  /** The parameters that are the same in all cells and vary in the sweep, such as the protocol. */
  others: Record<string, unknown>;
  /** Values of the parameter across, from the smallest. */
  across: number[];
  /** Values of the parameter upward, from the largest, as rows are read. */
  upward: number[];
  /** By row and column; none where the sweep has no such point. */
  cells: (Cell | undefined)[][];
}

/** Packings are realizations of the same. */
const REPLICATE = "packing_seed";
const WAITING: readonly string[] = ["blocked", "ready", "leased"];

/** The heatmaps of `result`, one for each combination of the parameters that are neither `x` nor `y`. */
export function heatmapsOf(
  points: PointRow[],
  [x, y]: [string, string],
  result: string,
  fixed: Record<string, unknown>,
): Heatmap[] {
  const groups = new Map<string, { others: Record<string, unknown>; rows: PointRow[] }>();
  for (const row of points) {
    const { [x]: _x, [y]: _y, [REPLICATE]: _seed, ...others } = row.parameters;
    const key = JSON.stringify(others);
    const group = groups.get(key) ?? { others, rows: [] };
    group.rows.push(row);
    groups.set(key, group);
  }
  const at = (row: PointRow, name: string) => Number(row.parameters[name] ?? fixed[name]);
  return [...groups.values()].map(({ others, rows }) => {
    const values = (name: string) => [...new Set(rows.map((row) => at(row, name)))].filter(Number.isFinite);
    const across = values(x).sort((a, b) => a - b);
    const upward = values(y).sort((a, b) => b - a);
    const cells = upward.map((v) =>
      across.map((u) => cellOf(rows.filter((row) => at(row, x) === u && at(row, y) === v), result)),
    );
    return { others, across, upward, cells };
  });
}

function cellOf(rows: PointRow[], result: string): Cell | undefined {
  const [first] = rows;
  if (!first) return undefined;
  const numbers = rows.map((row) => row.results[result]).filter((value) => typeof value === "number");
  const { mean, sem } = numbers.length > 0 ? moments(numbers) : { mean: null, sem: null };
  const reasons = new Set(rows.map((row) => reasonOf(row, result)).filter((reason) => reason !== ""));
  return { mean, sem, n: numbers.length, of: rows.length, reason: [...reasons].join("; "), point: first.point };
}

/** Why a point has no number for `result`, in words; empty if it has one. */
export function reasonOf(row: PointRow, result: string): string {
  if (typeof row.results[result] === "number") return "";
  if (row.failure) return row.failure.kind ? `stopped: ${spaced(row.failure.kind)}` : "failed";
  if (WAITING.includes(row.state)) return row.state === "leased" ? "is computed" : "waits";
  const word = row.results[`${result}_reason`];
  return typeof word === "string" ? spaced(word) : row.state === "done" ? "no number" : row.state;
}

function spaced(word: string): string {
  return word.replaceAll("_", " ");
}

/** The least and the largest mean of all maps; none if there is no number. */
export function rangeOfMeans(maps: Heatmap[]): [number, number] | undefined {
  const means = maps.flatMap((map) => map.cells.flat()).flatMap((cell) => (cell && cell.mean !== null ? [cell.mean] : []));
  return means.length > 0 ? [Math.min(...means), Math.max(...means)] : undefined;
}

/** Where `mean` lies between both ends, from 0 to 1. */
export function shareOf(mean: number, [least, most]: [number, number]): number {
  return most > least ? (mean - least) / (most - least) : 0.5;
}

/** What a map is of, in words: `protocol A`. */
export function labelOf(others: Record<string, unknown>, symbol: (name: string) => string): string {
  const part = ([name, value]: [string, unknown]) =>
    typeof value === "string" ? `${spaced(name)} ${value}` : `${symbol(name)} = ${parameter(value)}`;
  return Object.entries(others).map(part).join(", ");
}
