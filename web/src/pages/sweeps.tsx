// The list of sweeps, the latest first; asked for again while somebody looks.

import { useEffect, useState } from "preact/hooks";
import { listSweeps, type Page, type Sweep } from "../api/client";
import { useLoaded } from "../api/load";
import { ago, count, duration, rate } from "../format";
import { route, withView } from "../route";
import { Bar, State } from "./progress";
import { Await } from "./states";

/** Time between two looks at the list [ms]. */
const LOOK = 2000;

export function SweepsPage() {
  const [looks, look] = useState(0);
  useEffect(() => {
    document.title = "Granary";
    const timer = setInterval(() => document.visibilityState === "visible" && look((n) => n + 1), LOOK);
    return () => clearInterval(timer);
  }, []);
  const cursor = route.value.view.after;
  const loaded = useLoaded((signal) => listSweeps({ cursor, limit: 50 }, signal), `sweeps ${cursor}`, looks);
  return (
    <>
      <h1>Sweeps</h1>
      <Await loaded={loaded} what="sweeps">
        {(page) => (page.total === 0 ? <Empty /> : <Table page={page} />)}
      </Await>
    </>
  );
}

function Empty() {
  return (
    <div class="notice">
      <p>
        <strong>No sweep yet.</strong> Submit one from a terminal:
      </p>
      <pre>
        <code>granary submit examples/six-325.toml --server {location.origin}</code>
      </pre>
    </div>
  );
}

function Table({ page }: { page: Page<Sweep> }) {
  return (
    <>
      <div class="scroller" tabIndex={0} role="region" aria-label="Sweeps">
        <table class="sweeps">
          <thead>
            <tr>
              <th scope="col">Name</th>
              <th scope="col">State</th>
              <th scope="col">Points</th>
              <th scope="col" class="number">Done</th>
              <th scope="col" class="number">Failed</th>
              <th scope="col" class="number">Running</th>
              <th scope="col" class="number">Rate</th>
              <th scope="col" class="number">To go</th>
              <th scope="col" class="number">Submitted</th>
            </tr>
          </thead>
          <tbody>
            {page.items.map((sweep) => (
              <Row key={sweep.sweep} sweep={sweep} />
            ))}
          </tbody>
        </table>
      </div>
      <p class="pages">
        <span>{count(page.total)} in all</span>
        {route.value.view.after && <a href={withView({ after: "" })}>Latest</a>}
        {page.next && <a href={withView({ after: page.next })}>Earlier</a>}
      </p>
    </>
  );
}

function Row({ sweep }: { sweep: Sweep }) {
  const { points } = sweep;
  return (
    <tr>
      <th scope="row">
        <a href={`#/sweeps/${sweep.sweep}`}>{sweep.name || sweep.sweep}</a>
        <span class="quiet"> {sweep.model}, {sweep.preset}</span>
      </th>
      <td><State state={sweep.state} /></td>
      <td class="wide"><Bar points={points} /></td>
      <td class="number" data-label="done">{count(points.done)} of {count(points.total)}</td>
      <td class={points.failed > 0 ? "number bad" : "number"} data-label="failed">{count(points.failed)}</td>
      <td class="number" data-label="running">{count(points.running)}</td>
      <td class="number" data-label="rate">{sweep.state === "active" && sweep.points_per_second ? rate(sweep.points_per_second) : "–"}</td>
      <td class="number" data-label="to go">{typeof sweep.eta_s === "number" ? duration(sweep.eta_s) : "–"}</td>
      <td class="number" data-label="submitted" title={sweep.created_at}>{ago(sweep.created_at, Date.now())}</td>
    </tr>
  );
}
