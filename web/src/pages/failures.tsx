// What failed, why, and what to change: points that share a cause are told together.

import { type Failure, listPoints, type Model, type PointRow, readJob, type Sweep } from "../api/client";
import { useLoaded } from "../api/load";
import { count, parameter } from "../format";
import { parameterQuantity } from "../quantity";
import { pointsIn } from "./point_section";
import { Await } from "./states";

/** Failed points read for this section. */
const MOST = 500;
/** Causes told here. */
const MOST_CAUSES = 20;
const WORDS: Record<string, string> = {
  stopped: "the physics broke down",
  needs: "what it starts from failed",
  input: "the machine failed",
  poisoned: "set aside: it outlived too many workers",
};

interface Props {
  sweep: Sweep;
  model: Model | undefined;
  version: number;
}

export function Failures({ sweep, model, version }: Props) {
  const load = async (signal: AbortSignal) => {
    const query = (state: string) => ({ where: [`state=${state}`], limit: MOST });
    const pages = await Promise.all(
      ["failed", "poisoned"].map((state) => listPoints(sweep.sweep, query(state), signal)),
    );
    return pages.flatMap((page) => page.items);
  };
  const loaded = useLoaded(load, sweep.sweep, version);
  return (
    <section class="failures" aria-labelledby="failures">
      <h2 id="failures">{count(sweep.points.failed)} failed</h2>
      <Await loaded={loaded} what="failures">
        {(rows) => (
          <>
            <ul>
              {[...byCause(rows)].slice(0, MOST_CAUSES).map(([cause, points]) => (
                <Cause key={cause} points={points} sweep={sweep} model={model} />
              ))}
            </ul>
            {(byCause(rows).size > MOST_CAUSES || rows.length < sweep.points.failed) && (
              <p class="quiet">There are more; the table has every one with its reason.</p>
            )}
          </>
        )}
      </Await>
      <p>
        <a href={pointsIn(sweep.sweep, "failed")}>Show them in the table</a>
      </p>
    </section>
  );
}

/** Failed points by the job that is to blame. */
export function byCause(rows: PointRow[]): Map<string, PointRow[]> {
  const causes = new Map<string, PointRow[]>();
  for (const row of rows) {
    const cause = row.failure?.job ?? row.job;
    causes.set(cause, [...(causes.get(cause) ?? []), row]);
  }
  return causes;
}

/** A message with its hashes cut short. */
export function brief(message: string): string {
  return message.replace(/\b(b3:[0-9a-f]{8})[0-9a-f]{56}\b/g, "$1…");
}

function Cause({ points, sweep, model }: { points: PointRow[]; sweep: Sweep; model: Model | undefined }) {
  const own = points[0]?.failure;
  const blamed = own?.job;
  const load = async (signal: AbortSignal) => (blamed ? (await readJob(blamed, signal)).failure : undefined);
  const root = useLoaded<Failure | null | undefined>(load, blamed ?? "", 0).value;
  const failure = root ?? own;
  if (!failure) return null;
  return (
    <li>
      <p>
        <strong class="bad">{failure.kind ?? failure.reason}</strong>
        {own && own.reason !== failure.reason ? `, ${WORDS[own.reason] ?? own.reason}` : `, ${WORDS[failure.reason] ?? ""}`}
        <span class="quiet"> · {points.length === 1 ? "1 point" : `${count(points.length)} points`}: </span>
        {shared(points, sweep, model)}
      </p>
      <p>{brief(withoutRemedy(failure))}</p>
      {failure.remedy && (
        <p>
          <strong>What to change:</strong> {failure.remedy}
        </p>
      )}
    </li>
  );
}

function withoutRemedy({ message, remedy }: Failure): string {
  return remedy && message.endsWith(`; ${remedy}`) ? message.slice(0, -remedy.length - 2) : message;
}

/** The parameters that all these points have in common, or their numbers. */
function shared(points: PointRow[], sweep: Sweep, model: Model | undefined): string {
  const [first, ...others] = points;
  if (!first) return "";
  const same = sweep.axes.filter((name) =>
    others.every((row) => parameter(row.parameters[name]) === parameter(first.parameters[name])),
  );
  const parts = same.map((name) => `${parameterQuantity(model, name).symbol} = ${parameter(first.parameters[name])}`);
  return parts.join(", ") || `number ${first.point} and others`;
}
