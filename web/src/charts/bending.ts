// A stress–strain curve from the file of a bending, and the lines that were found in it; stresses in kPa.

import type { PointRow } from "../api/client";
import type { History } from "../api/history";

/** The curve, and what E_b and Y_b say of it. */
export interface Curve {
  strain: number[];
  stress: number[];
  /** Both ends of the line σ = E_b ε + c, as far as the largest stress. */
  stiffness?: [[number, number], [number, number]];
  /** ε_Y and Y_b. */
  strength?: [number, number];
}

const KILO = 1e-3;

/** The curve of `history` with the lines that `results` name. */
export function curveOf({ strain, stress }: History, results: PointRow["results"]): Curve {
  const curve: Curve = { strain, stress: stress.map((value) => value * KILO) };
  const value = (name: string) => {
    const found = results[name];
    return typeof found === "number" ? found : undefined;
  };
  const [slope, intercept = 0] = [value("beam_stiffness"), value("beam_stiffness_intercept")];
  const [strength, at] = [value("ultimate_strength"), value("yield_strain")];
  if (slope !== undefined && slope > 0 && strain.length > 0) {
    const most = Math.max(...stress);
    const end = Math.min((most - intercept) / slope, Math.max(...strain));
    const on = (x: number): [number, number] => [x, (slope * x + intercept) * KILO];
    if (end > 0) curve.stiffness = [on(0), on(end)];
  }
  if (strength !== undefined && at !== undefined) curve.strength = [at, strength * KILO];
  return curve;
}

/** At most `most` rows of the curve, evenly spaced, the first and the last among them. */
export function someRows({ strain, stress }: Curve, most: number): [number, number][] {
  const last = strain.length - 1;
  const count = Math.min(most, strain.length);
  const places = Array.from({ length: count }, (_, k) => (count > 1 ? Math.round((k * last) / (count - 1)) : 0));
  return places.map((place) => [strain[place] ?? 0, stress[place] ?? 0]);
}
