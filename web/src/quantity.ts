// Symbols and units of parameters and results, from the server's model.

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

interface Property {
  "x-symbol"?: string;
  "x-unit"?: string;
  description?: string;
  default?: unknown;
}

type Properties = Record<string, Property>;

function properties(schema: Record<string, unknown> | undefined): Properties {
  return (schema?.properties as Properties | undefined) ?? {};
}

function quantity(all: Properties, name: string): Quantity {
  const property = all[name];
  return {
    name,
    symbol: property?.["x-symbol"] ?? name,
    unit: property?.["x-unit"] ?? "",
    sentence: property?.description ?? "",
    scale: 1,
  };
}

/** How a parameter is named. */
export function parameterQuantity(model: Model | undefined, name: string): Quantity {
  return quantity(properties(model?.parameters), name);
}

/** How a result is named; pressures are told in kPa. */
export function resultQuantity(model: Model | undefined, name: string): Quantity {
  const known = quantity(properties(model?.results), name);
  return known.unit === "Pa" ? { ...known, unit: "kPa", scale: 1e-3 } : known;
}

/** Results in the order of the model; unknown ones come last. */
export function inOrder(model: Model | undefined, names: string[]): string[] {
  const order = Object.keys(properties(model?.results));
  const place = (name: string) => (order.includes(name) ? order.indexOf(name) : order.length);
  return [...names].sort((a, b) => place(a) - place(b));
}

/** Every parameter that does not vary: defaults, then the preset's, then what the spec fixes. */
export function fixedParameters(model: Model | undefined, sweep: Sweep): Record<string, unknown> {
  const defaults = Object.entries(properties(model?.parameters)).map(([name, property]) => [name, property.default]);
  const preset = model?.presets.find((known) => known.name === sweep.preset)?.values;
  const spec = (sweep.spec ?? {}) as Record<string, Record<string, unknown> | undefined>;
  return { ...Object.fromEntries(defaults), ...preset, ...spec.fixed, ...spec.numerics, ...spec.preparation };
}
