// The table of sets: gain and fidelity of each combination of parameters.

import type { Model, Page, SetRow } from "../api/client";
import { count, number, parameter, withError } from "../format";
import { inOrder, parameterQuantity, type Quantity, resultQuantity } from "../quantity";
import { route, withView } from "../route";
import { reductions } from "./chosen";
import { Heading } from "./heading";

/** Sets shown at a time. */
const SHOWN = 100;
const VERDICTS = "front: no other setting is cheaper and at least as accurate. incomplete: some packing has no result.";
const NAMES: Record<string, string> = {
  gain_fidelity: "each packing",
  recognition: "recognition",
  mean_sem: "means ± SEM",
  study: "settings",
};

export function SetSection({ sets, model }: { sets: Page<SetRow>; model: Model | undefined }) {
  const { all, chosen } = reductions(sets.items);
  const rows = sets.items.filter((set) => set.reduce === chosen);
  const from = Math.max(0, Number(route.value.view.set ?? 0) || 0);
  const shown = rows.slice(from, from + SHOWN);
  return (
    <section aria-labelledby="sets">
      <h2 id="sets">Sets</h2>
      {all.length > 1 && (
        <p class="choices">
          {all.map((name) => (
            <a key={name} href={withView({ sets: name, set: "" })} aria-current={name === chosen}>
              {NAMES[name] ?? name}
            </a>
          ))}
        </p>
      )}
      <Table rows={shown} model={model} />
      <p class="pages">
        <span>
          {count(from + 1)}–{count(from + shown.length)} of {count(rows.length)}
          {sets.total > sets.items.length && ` (the first ${count(sets.items.length)} of ${count(sets.total)} sets)`}
        </span>
        {from > 0 && <a href={withView({ set: String(Math.max(0, from - SHOWN)) })}>Previous</a>}
        {from + SHOWN < rows.length && <a href={withView({ set: String(from + SHOWN) })}>Next</a>}
      </p>
    </section>
  );
}

function Table({ rows, model }: { rows: SetRow[]; model: Model | undefined }) {
  const studied = rows.some((row) => row.setting);
  const all = [...new Set(rows.flatMap((row) => Object.keys(row.parameters)))];
  const parameters = studied ? all.filter((name) => tellsScenes(rows, name)) : all;
  const names = [...new Set(rows.flatMap((row) => Object.keys(row.results)))];
  // An error stands beside its number.
  const means = names.filter((name) => !name.endsWith("_sem") && !name.endsWith("_error"));
  const fits = rows.some((row) => row.shape);
  const told = fits || rows.some((row) => row.processing);
  const results = inOrder(model, means).map((name) => resultQuantity(model, name));
  return (
    <div class="scroller" tabIndex={0} role="region" aria-labelledby="sets">
      <table class="sets">
        <thead>
          <tr>
            {studied && <th scope="col">Setting</th>}
            {studied && <th scope="col" title={VERDICTS}>Verdict</th>}
            {parameters.map((name) => (
              <Heading key={name} quantity={parameterQuantity(model, name)} />
            ))}
            {told && <th scope="col">{fits ? "Shape" : "Processing"}</th>}
            {results.map((quantity) => (
              <Heading key={quantity.name} quantity={quantity} />
            ))}
            <th scope="col" title="Members that count so far, of members in all.">n of m</th>
            <th scope="col">Remark</th>
          </tr>
        </thead>
        <tbody>
          {rows.map((row) => (
            <tr key={row.set} data-set={row.set} class={row.provisional ? "provisional" : ""}>
              {studied && <th scope="row">{row.setting}</th>}
              {studied && <td class={row.verdict === "front" ? "front" : ""}>{row.verdict}</td>}
              {parameters.map((name) => (
                <td key={name} class="number">{parameter(row.parameters[name])}</td>
              ))}
              {told && <td>{row.processing ?? row.shape}</td>}
              {results.map((quantity) => (
                <Cell key={quantity.name} row={row} quantity={quantity} />
              ))}
              <td class="number">{count(row.n)} of {count(row.of)}</td>
              <td class="remark">
                {row.provisional && <span class="state running">provisional</span>}
                {` ${[row.missing_reason, row.warning, confused(row)].filter(Boolean).join("; ")}`}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** Which words a classifier took for others, in a few words. */
function confused(row: SetRow): string | undefined {
  const [first] = row.confused ?? [];
  return first && `${count(row.confused?.length ?? 0)} confused, such as word ${first.word} taken for ${first.taken_for}`;
}

/** Whether a parameter tells scenes of a study apart; what settings differ in is told by their names. */
function tellsScenes(rows: SetRow[], name: string): boolean {
  const references = rows.filter((row) => row.verdict === "reference");
  return new Set(references.map((row) => parameter(row.parameters[name]))).size > 1;
}

function Cell({ row, quantity }: { row: SetRow; quantity: Quantity }) {
  const { name, scale } = quantity;
  const value = row.results[name];
  if (typeof value !== "number") return <td class="number quiet" title={row.missing_reason ?? ""}>–</td>;
  const error = row.results[`${name}_sem`] ?? row.results[`${name}_error`];
  const shown = typeof error === "number" ? withError(value * scale, error * scale) : number(value * scale, 4);
  return (
    <td class="number" data-result={name} title={String(value)}>
      <data value={String(value)}>{shown}</data>
    </td>
  );
}
