// Numbers, times and rates as people read them.

const MINUS = "−";

/** A number with `digits` significant digits, as short as it goes. */
export function number(value: number, digits = 5): string {
  if (!Number.isFinite(value)) return "–";
  const magnitude = Math.abs(value);
  const text =
    magnitude !== 0 && (magnitude < 1e-3 || magnitude >= 1e6)
      ? exponential(value, digits)
      : String(Number(value.toPrecision(digits)));
  return text.replace(/^-/, MINUS);
}

function exponential(value: number, digits: number): string {
  const [mantissa = "", exponent = ""] = value.toExponential(Math.min(digits, 3) - 1).split("e");
  return `${mantissa}·10${superscript(Number(exponent))}`;
}

function superscript(value: number): string {
  return String(value).replace(/[-0-9]/g, (sign) => (sign === "-" ? "⁻" : ("⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(sign)] ?? "")));
}

/** A mean with its standard error: the error to two digits, the mean to the same place. */
export function withError(value: number, error: number | null): string {
  if (error === null || !(error > 0) || !Number.isFinite(error)) return number(value, 4);
  const largest = Math.max(Math.abs(value), error);
  if (largest < 1e-3 || largest >= 1e6) {
    const power = Math.floor(Math.log10(largest));
    return `(${withError(value / 10 ** power, error / 10 ** power)})·10${superscript(power)}`;
  }
  const places = 1 - Math.floor(Math.log10(Number(error.toPrecision(2))));
  if (places > 9) return `${number(value)} ± ${number(error, 2)}`;
  const unit = 10 ** -places;
  const rounded = (x: number) => (places >= 0 ? x.toFixed(places) : String(Math.round(x / unit) * unit));
  return `${rounded(value).replace(/^-/, MINUS)} ± ${rounded(error)}`;
}

/** A count with its thousands apart. */
export function count(value: number): string {
  return value.toLocaleString("en-US");
}

/** A duration in its two largest units. */
export function duration(seconds: number): string {
  if (seconds < 1) return "< 1 s";
  const units: [number, string][] = [[86_400, "d"], [3600, "h"], [60, "min"], [1, "s"]];
  const whole = Math.round(seconds);
  const first = units.findIndex(([size]) => whole >= size);
  const shown = units.slice(first, first + 2).map(([size, name], place) => {
    const above = place === 0 ? Infinity : (units[first]?.[0] ?? Infinity);
    return [Math.floor((whole % above) / size), name] as const;
  });
  return shown.filter(([amount]) => amount > 0).map(([amount, name]) => `${amount} ${name}`).join(" ");
}

/** Points per second, minute or hour, whichever reads best. */
export function rate(perSecond: number): string {
  if (perSecond >= 1) return `${number(perSecond, 2)}/s`;
  if (perSecond * 60 >= 1) return `${number(perSecond * 60, 2)}/min`;
  return `${number(perSecond * 3600, 2)}/h`;
}

/** How long ago an RFC 3339 time was. */
export function ago(time: string, now: number): string {
  return `${duration(Math.max(0, (now - Date.parse(time)) / 1000))} ago`;
}

/** A parameter's value as a spec writes it. */
export function parameter(value: unknown): string {
  if (typeof value === "number") return Number.isInteger(value) ? String(value) : number(value);
  if (value === undefined || value === null) return "";
  return typeof value === "string" ? value : JSON.stringify(value);
}
