// One point of a beam: its stress–strain curve, with what was found in it.

import { useEffect, useMemo, useRef } from "preact/hooks";
import { artifactPath, listPoints, type Model, type PointRow, readHistory, readJob, type Sweep } from "../api/client";
import type { History } from "../api/history";
import { useLoaded } from "../api/load";
import { type Curve, curveOf, someRows } from "../charts/bending";
import { CurvePlot } from "../charts/curve";
import { reasonOf } from "../charts/cells";
import { number, parameter } from "../format";
import { parameterQuantity, resultQuantity } from "../quantity";
import { route, withView } from "../route";
import { Await } from "./states";

/** Rows of the curve that are told in words. */
const TOLD = 41;
const RESULTS = ["beam_stiffness", "ultimate_strength", "yield_strain", "ultimate_strength_lower_bound", "strain_reached"];

interface Props {
  sweep: Sweep;
  model: Model | undefined;
  version: number;
}

/** The point that the URL names; nothing if it names none. */
export function CurveSection(props: Props) {
  const point = route.value.view.curve ?? "";
  return /^\d+$/.test(point) ? <Chosen {...props} point={point} /> : null;
}

function Chosen({ sweep, model, version, point }: Props & { point: string }) {
  const load = async (signal: AbortSignal) => {
    const { items } = await listPoints(sweep.sweep, { where: [`point=${point}`], limit: 1 }, signal);
    const row = items[0];
    if (!row || row.state !== "done") return { row };
    const hash = (await readJob(row.job, signal)).artifacts.history;
    return { row, hash, history: hash ? await readHistory(hash, signal) : undefined };
  };
  const loaded = useLoaded(load, `${sweep.sweep} ${point}`, version);
  const heading = useRef<HTMLHeadingElement>(null);
  // Whoever asked for the curve is brought to it.
  useEffect(() => heading.current?.focus(), [point]);
  return (
    <section aria-labelledby="curve">
      <h2 id="curve" ref={heading} tabIndex={-1}>Point {point}: stress over strain</h2>
      <Await loaded={loaded} what="curve">
        {({ row, hash, history }) => {
          if (!row) return <p class="notice">The sweep has no point {point}.</p>;
          return (
            <>
              <p class="quiet">
                {told(row, model)} · <a href={withView({ curve: "" })}>Close</a>
              </p>
              {history && hash ? <Shown row={row} model={model} history={history} hash={hash} /> : <Missing row={row} />}
            </>
          );
        }}
      </Await>
    </section>
  );
}

function told(row: PointRow, model: Model | undefined): string {
  const parts = Object.entries(row.parameters).map(
    ([name, value]) => `${parameterQuantity(model, name).symbol} = ${parameter(value)} ${parameterQuantity(model, name).unit}`,
  );
  return parts.map((part) => part.trim()).join(", ");
}

function Missing({ row }: { row: PointRow }) {
  if (row.state === "done") return <p class="notice">Its record was not kept.</p>;
  return (
    <p class="notice">
      No curve: the point {row.failure ? "has failed" : `is ${row.state}`}. {row.failure?.message}
    </p>
  );
}

function Shown({ row, model, history, hash }: { row: PointRow; model: Model | undefined; history: History; hash: string }) {
  const curve = useMemo(() => curveOf(history, row.results), [history, row]);
  const facts = RESULTS.map((name) => ({ ...resultQuantity(model, name), value: row.results[name], why: reasonOf(row, name) }));
  const summary = facts.map(({ symbol, unit, scale, value, why }) =>
    typeof value === "number" ? `${symbol} = ${number(value * scale, 4)} ${unit}`.trim() : `no ${symbol}: ${why}`,
  );
  return (
    <>
      <CurvePlot curve={curve} label={`Stress σ in kPa over strain ε of point ${row.point}; ${summary.join(", ")}; a table below has the numbers`} />
      <dl class="facts">
        {facts.map(({ name, symbol, unit, sentence, scale, value, why }) => (
          <div key={name} title={sentence} data-result={name}>
            <dt>{symbol}</dt>
            <dd>{typeof value === "number" ? `${number(value * scale, 4)} ${unit}` : <span class="quiet">{why}</span>}</dd>
          </div>
        ))}
      </dl>
      <Rows curve={curve} />
      <p>
        <a href={artifactPath(hash)} download={`history-${row.point}.json`}>The whole record (JSON)</a>
      </p>
    </>
  );
}

function Rows({ curve }: { curve: Curve }) {
  return (
    <details>
      <summary>Numbers of the curve</summary>
      <table class="curve">
        <thead>
          <tr>
            <th scope="col">ε</th>
            <th scope="col">σ [kPa]</th>
          </tr>
        </thead>
        <tbody>
          {someRows(curve, TOLD).map(([strain, stress], place) => (
            <tr key={place}>
              <td class="number">{number(strain, 4)}</td>
              <td class="number">{number(stress, 4)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </details>
  );
}
