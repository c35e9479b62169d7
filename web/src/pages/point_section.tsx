// The table of points: filtered, sorted and paged by the server.

import { listPoints, type Model, type Page, type PointRow, type Sweep } from "../api/client";
import { useLoaded } from "../api/load";
import { ago, count, number, parameter } from "../format";
import { inOrder, parameterQuantity, type Quantity, resultQuantity } from "../quantity";
import { hashOf, route, withView } from "../route";
import { brief } from "./failures";
import { Heading } from "./heading";
import { State } from "./progress";
import { Await } from "./states";

/** Points of a page. */
const SHOWN = 50;
const STATES = ["done", "failed", "poisoned", "leased", "ready", "blocked", "cancelled"];
/** Results that stand in the table unless all are asked for. */
const USUAL = [
  "encode_correlation", "hold_kinetic_energy", "beam_stiffness", "ultimate_strength", "yield_strain",
  "largest_overlap", "volume_fraction", "coordination_number",
];
const NUMBER = { name: "point", symbol: "point", unit: "", sentence: "Its number, from 0, in the order of the spec.", scale: 1 };
const STATE = { ...NUMBER, name: "state", symbol: "state", sentence: "Where its job stands." };

interface Props {
  sweep: Sweep;
  model: Model | undefined;
  version: number;
}

export function PointSection({ sweep, model, version }: Props) {
  const { state = "", sort, after, from = "1" } = route.value.view;
  const query = { where: state ? [`state=${state}`] : [], sort, cursor: after, limit: SHOWN };
  const what = `${sweep.sweep} ${JSON.stringify(query)}`;
  const loaded = useLoaded((signal) => listPoints(sweep.sweep, query, signal), what, version);
  return (
    <section aria-labelledby="points">
      <h2 id="points">Points</h2>
      <Choices state={state} />
      <Await loaded={loaded} what="points">
        {(page) =>
          page.items.length === 0 ? (
            <p class="quiet">No point {state ? `is ${state}` : "here"}.</p>
          ) : (
            <Table sweep={sweep} model={model} page={page} from={Number(from) || 1} />
          )
        }
      </Await>
    </section>
  );
}

function Choices({ state }: { state: string }) {
  const all = route.value.view.columns === "all";
  const choose = (event: { currentTarget: HTMLSelectElement }) => {
    location.hash = withView({ state: event.currentTarget.value, after: "", from: "" });
  };
  return (
    <p class="choices">
      <label>
        State{" "}
        <select value={state} onChange={choose}>
          <option value="">any</option>
          {STATES.map((name) => (
            <option key={name} value={name}>{name}</option>
          ))}
        </select>
      </label>
      <a href={withView({ columns: all ? "" : "all" })}>{all ? "Fewer columns" : "All columns"}</a>
    </p>
  );
}

function Table({ sweep, model, page, from }: { sweep: Sweep; model: Model | undefined; page: Page<PointRow>; from: number }) {
  const all = route.value.view.columns === "all";
  const names = [...new Set(page.items.flatMap((row) => Object.keys(row.results)))];
  const chosen = names.filter((name) => all || USUAL.includes(name));
  const results = inOrder(model, chosen).map((name) => resultQuantity(model, name));
  const last = from + page.items.length - 1;
  return (
    <>
      <div class="scroller" tabIndex={0} role="region" aria-labelledby="points">
        <table class="points">
          <thead>
            <tr>
              <Heading quantity={NUMBER} sortable />
              <Heading quantity={STATE} sortable />
              {sweep.axes.map((name) => (
                <Heading key={name} quantity={parameterQuantity(model, name)} sortable />
              ))}
              {results.map((quantity) => (
                <Heading key={quantity.name} quantity={quantity} sortable />
              ))}
              <th scope="col">Remark</th>
            </tr>
          </thead>
          <tbody>
            {page.items.map((row) => (
              <Row key={row.point} row={row} axes={sweep.axes} results={results} curve={sweep.model === "beam"} />
            ))}
          </tbody>
        </table>
      </div>
      <p class="pages">
        <span>{count(from)}–{count(last)} of {count(page.total)}</span>
        {from > 1 && <a href={withView({ after: "", from: "" })}>First</a>}
        {page.next && <a href={withView({ after: page.next, from: String(last + 1) })}>Next</a>}
      </p>
    </>
  );
}

function Row({ row, axes, results, curve }: { row: PointRow; axes: string[]; results: Quantity[]; curve: boolean }) {
  return (
    <tr data-point={row.point}>
      <td class="number">
        {curve ? <a href={withView({ curve: String(row.point) })} title="Its curve">{row.point}</a> : row.point}
      </td>
      <td><State state={row.state} /></td>
      {axes.map((name) => (
        <td key={name} class="number">{parameter(row.parameters[name])}</td>
      ))}
      {row.state === "done" && results.map(({ name, scale }) => <Cell key={name} value={row.results[name]} scale={scale} why={row.results[`${name}_reason`]} />)}
      <td class="remark" colSpan={row.state === "done" ? 1 : results.length + 1}>{remark(row)}</td>
    </tr>
  );
}

type Scalar = PointRow["results"][string] | undefined;

function Cell({ value, scale, why }: { value: Scalar; scale: number; why: Scalar }) {
  if (typeof value === "string") return <td>{value}</td>;
  if (typeof value !== "number") {
    return typeof why === "string" ? <td class="quiet">{why.replaceAll("_", " ")}</td> : <td class="number quiet">–</td>;
  }
  return <td class="number" title={String(value)}>{number(value * scale, 4)}</td>;
}

function remark({ failure, progress, warnings }: PointRow) {
  if (failure) return <span class="bad">{brief(failure.message)}</span>;
  if (!progress) return warnings.join(" ");
  const share = progress.steps > 0 ? (100 * progress.step) / progress.steps : 0;
  return `${share.toFixed(0)} % of simulated time; ${progress.worker}, last heard of ${ago(progress.last_heartbeat, Date.now())}`;
}

/** The hash of the points of `sweep` in one state. */
export function pointsIn(sweep: string, state: string): string {
  return hashOf({ sweep, view: { ...route.value.view, state, after: "", from: "" } });
}
