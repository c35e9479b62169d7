// How far a sweep is: state, counts, rate, time to the end.

import type { Sweep } from "../api/client";
import { count } from "../format";

const PARTS = ["done", "failed", "running", "waiting", "cancelled"] as const;

/** A bar of points by state; what it shows is in its label too. */
export function Bar({ points }: { points: Sweep["points"] }) {
  const label = PARTS.filter((part) => points[part] > 0).map((part) => `${count(points[part])} ${part}`);
  return (
    <div
      class="bar"
      role="progressbar"
      aria-valuemin={0}
      aria-valuemax={points.total}
      aria-valuenow={points.done + points.failed}
      aria-label={`${label.join(", ")} of ${count(points.total)} points`}
      title={label.join(", ")}
    >
      {PARTS.slice(0, 3).map((part) => (
        <span key={part} class={part} style={{ width: `${(100 * points[part]) / Math.max(1, points.total)}%` }} />
      ))}
    </div>
  );
}

/** The state in a word, with a color that only repeats it. */
export function State({ state }: { state: string }) {
  return <span class={`state ${state}`}>{state}</span>;
}
