// How charts look: colors from the page's style sheet, drawn again when the reader turns the lights on or off.

import { useEffect, useState } from "preact/hooks";
import type uPlot from "uplot";
import { number } from "../format";
import type { Quantity } from "../quantity";

/** Height of a chart [px]. */
export const HEIGHT = 280;

/** The color that the page calls `name`, at `place`. */
export function ink(place: Element, name: string): string {
  return getComputedStyle(place).getPropertyValue(name).trim();
}

/** What both axes of a chart have in common. */
export function axisLook(place: Element): uPlot.Axis {
  const line = { stroke: ink(place, "--line"), width: 1 };
  return {
    stroke: ink(place, "--quiet"),
    font: "12px system-ui, sans-serif",
    grid: line,
    ticks: line,
    values: (_: uPlot, splits: (number | null)[]) => splits.map((value) => (value === null ? "" : number(value, 4))),
  };
}

/** Symbol and unit of an axis. */
export function title({ symbol, unit }: Quantity): string {
  return unit === "" ? symbol : `${symbol} [${unit}]`;
}

/** Whether the reader wants a dark page; a canvas must be drawn again when that changes. */
export function useDark(): boolean {
  const query = "(prefers-color-scheme: dark)";
  const [dark, setDark] = useState(() => matchMedia(query).matches);
  useEffect(() => {
    const media = matchMedia(query);
    const change = () => setDark(media.matches);
    media.addEventListener("change", change);
    return () => media.removeEventListener("change", change);
  }, []);
  return dark;
}
