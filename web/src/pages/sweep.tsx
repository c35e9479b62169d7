// One sweep: how far it is, what failed, its plots and its tables.

import { useEffect } from "preact/hooks";
import { listSets, type Model, readModel, readSweep, type Sweep } from "../api/client";
import { useLoaded } from "../api/load";
import { count, duration, number, rate } from "../format";
import { fixedParameters } from "../quantity";
import { BeamSection } from "./beam_section";
import { CurveSection } from "./curve_section";
import { Failures } from "./failures";
import { type Live, useLive } from "./live";
import { PlotSection } from "./plot_section";
import { PointSection } from "./point_section";
import { Bar, State } from "./progress";
import { SetSection } from "./set_section";
import { Await } from "./states";

/** The most sets that are read, plotted and listed. */
const MOST_SETS = 2000;

export function SweepPage({ id }: { id: string }) {
  const live = useLive(id);
  const sweep = useLoaded((signal) => readSweep(id, signal), id, live.open ? 1 : 0);
  return (
    <Await loaded={sweep} what="sweep">
      {(first) => <Known sweep={{ ...first, ...live.summary }} live={live} />}
    </Await>
  );
}

function Known({ sweep, live }: { sweep: Sweep; live: Live }) {
  useEffect(() => {
    document.title = `${sweep.name} – Granary`;
  }, [sweep.name]);
  const model = useLoaded((signal) => readModel(sweep.model, signal), sweep.model, 0).value;
  return (
    <>
      <Summary sweep={sweep} live={live} />
      {sweep.points.failed > 0 && <Failures sweep={sweep} model={model} version={live.version} />}
      {sweep.model === "beam" && !isStudy(sweep) && !waits(sweep) && (
        <>
          <BeamSection sweep={sweep} model={model} version={live.version} />
          <CurveSection sweep={sweep} model={model} version={live.version} />
        </>
      )}
      {!waits(sweep) && (
        <>
          <Results sweep={sweep} model={model} version={live.version} />
          <PointSection sweep={sweep} model={model} version={live.version} />
        </>
      )}
    </>
  );
}

/** A study compares settings: its table of sets says it all. */
function isStudy(sweep: Sweep): boolean {
  return (sweep.spec as Record<string, unknown> | null | undefined)?.study !== undefined;
}

/** Without a choice of its pilot a sweep has no points yet. */
function waits(sweep: Sweep): boolean {
  return sweep.accuracy != null && sweep.accuracy.choice == null;
}

function Summary({ sweep, live }: { sweep: Sweep; live: Live }) {
  const { points } = sweep;
  const facts: [string, string][] = [
    ["done", `${count(points.done)} of ${count(points.total)}`],
    ["failed", count(points.failed)],
    ["running", count(points.running)],
    ["waiting", count(points.waiting)],
  ];
  if (points.cancelled > 0) facts.push(["cancelled", count(points.cancelled)]);
  if (sweep.state === "active" && sweep.points_per_second) facts.push(["rate", rate(sweep.points_per_second)]);
  if (typeof sweep.eta_s === "number") facts.push(["to go", duration(sweep.eta_s)]);
  return (
    <section class="summary" aria-label="Progress">
      <h1>{sweep.name || sweep.sweep}</h1>
      <p class="quiet">
        <State state={sweep.state} /> · {sweep.model}, preset {sweep.preset} · <code>{sweep.sweep}</code>
        {live.open === false && <strong class="bad"> · not connected, trying again</strong>}
      </p>
      <Bar points={points} />
      <dl class="facts">
        {facts.map(([name, value]) => (
          <div key={name} class={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
      </dl>
      {sweep.accuracy && <Accuracy accuracy={sweep.accuracy} />}
      {sweep.warnings.map((warning) => (
        <p key={warning} class="notice">{warning}</p>
      ))}
    </section>
  );
}

/** What was asked for, which pilot decides, and what it has chosen. */
function Accuracy({ accuracy }: { accuracy: NonNullable<Sweep["accuracy"]> }) {
  const targets = Object.entries(accuracy.targets).map(([name, most]) => `${name} within ${number(most, 3)}`);
  const { choice } = accuracy;
  const cost = typeof choice?.relative_cost === "number" && `, ${count(Math.round(100 * choice.relative_cost))} % of the reference's time`;
  return (
    <p class="notice accuracy">
      Asked for: {targets.join(", ")}. <a href={`#/sweeps/${accuracy.pilot}`}>Its pilot</a>
      {choice ? ` chose ${choice.setting}${cost || ""}${choice.reason ? `: ${choice.reason}` : ""}.` : " is still to decide."}
    </p>
  );
}

function Results({ sweep, model, version }: { sweep: Sweep; model: Model | undefined; version: number }) {
  const load = (signal: AbortSignal) => listSets(sweep.sweep, { limit: MOST_SETS }, signal);
  const sets = useLoaded(load, sweep.sweep, version);
  return (
    <Await loaded={sets} what="sets">
      {(page) =>
        page.total === 0 ? (
          <p class="notice">This sweep reduces nothing: its results are its points.</p>
        ) : (
          <>
            {sweep.model === "memory" && !isStudy(sweep) && (
              <PlotSection sets={page.items} model={model} fixed={fixedParameters(model, sweep)} />
            )}
            <SetSection sets={page} model={model} />
          </>
        )
      }
    </Await>
  );
}
