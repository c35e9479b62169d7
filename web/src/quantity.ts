// Symbols and units: of parameters from the server's model, of results from the table below.

import type { Model, Sweep } from "./api/client";

/** How one column or axis is named. */
export interface Quantity {
  name: string;
  symbol: string;
  /** Empty for a pure number. */
  unit: string;
  sentence: string;
  /** What a value of the API is multiplied by to be in `unit`. */
  scale: number;
}

/** Name, symbol, unit, sentence, scale. */
type Row = [string, string, string, string, number?];

const RESULTS: Row[] = [
  ["gain", "𝒢", "", "Gain: how much of the stored signal comes back."],
  ["gain_e_delta0", "𝒢·E·δ0", "kPa", "Gain times Young's modulus and volume strain.", 1e-3],
  ["fidelity", "𝓕", "", "Fidelity: 1 if what comes back has exactly the stored shape."],
  ["correlation", "C", "", "Correlation of the recalled with the stored signal; 𝓕 = 1 − √(1 − C²)."],
  ["encode_correlation", "C_enc", "", "Correlation of the shear stress with the waveform while it is stored."],
  ["hold_kinetic_energy", "K_hold", "E R³", "Kinetic energy per grain at the end of the hold."],
  ["largest_overlap", "δ_max", "R", "Largest overlap of two spheres in the whole run."],
  ["critical_time_step", "Δt_crit", "t_c", "Time step above which the integration would be unstable."],
  ["time_step", "Δt", "t_c", "Time step taken."],
  ["volume_fraction", "φ", "", "Volume fraction."],
  ["coordination_number", "Z", "", "Touching grains per grain."],
  ["sphere_contacts_per_grain", "Z_s", "", "Contacts between spheres per grain."],
  ["wall_contacts_per_grain", "Z_w", "", "Contacts with walls per grain."],
  ["kinetic_energy", "K", "E R³", "Kinetic energy per grain."],
];

/** Where a result stands in the table above; unknown ones come last. */
export function resultOrder(name: string): number {
  const place = RESULTS.findIndex(([known]) => known === name);
  return place < 0 ? RESULTS.length : place;
}

/** How a result is named; `…_compressed` is the same at the end of the compression. */
export function resultQuantity(name: string): Quantity {
  const compressed = name.endsWith("_compressed");
  const base = name.replace(/_compressed$/, "");
  const [, symbol, unit, sentence, scale] = RESULTS.find(([known]) => known === base) ?? [base, base, "", ""];
  return {
    name,
    symbol: compressed ? `${symbol}*` : symbol,
    unit,
    sentence: compressed ? `${sentence} At full compression.` : sentence,
    scale: scale ?? 1,
  };
}

interface Property {
  "x-symbol"?: string;
  "x-unit"?: string;
  description?: string;
  default?: unknown;
}

function properties(model: Model | undefined): Record<string, Property> {
  const schema = model?.parameters as { properties?: Record<string, Property> } | undefined;
  return schema?.properties ?? {};
}

/** How a parameter is named. */
export function parameterQuantity(model: Model | undefined, name: string): Quantity {
  const property = properties(model)[name];
  return {
    name,
    symbol: property?.["x-symbol"] ?? name,
    unit: property?.["x-unit"] ?? "",
    sentence: property?.description ?? "",
    scale: 1,
  };
}

/** Every parameter that does not vary: defaults, then the preset's, then what the spec fixes. */
export function fixedParameters(model: Model | undefined, sweep: Sweep): Record<string, unknown> {
  const defaults = Object.entries(properties(model)).map(([name, property]) => [name, property.default]);
  const preset = model?.presets.find((known) => known.name === sweep.preset)?.values;
  const spec = (sweep.spec ?? {}) as Record<string, Record<string, unknown> | undefined>;
  return { ...Object.fromEntries(defaults), ...preset, ...spec.fixed, ...spec.numerics, ...spec.preparation };
}
