// The heading of a column: symbol, unit, name; sorted by the server where asked.

import type { Quantity } from "../quantity";
import { route, withView } from "../route";

/** Symbol and unit, the sentence on hover, the name beneath. */
export function Heading({ quantity, sortable = false }: { quantity: Quantity; sortable?: boolean }) {
  const { name, symbol, unit, sentence } = quantity;
  const label = (
    <>
      <span class="symbol">{symbol}</span>
      {unit !== "" && <span class="unit"> [{unit}]</span>}
      {symbol !== name && <span class="name">{name.replaceAll("_", " ")}</span>}
    </>
  );
  if (!sortable) return <th scope="col" title={sentence}>{label}</th>;
  const sort = route.value.view.sort;
  const direction = sort === name ? "ascending" : sort === `-${name}` ? "descending" : "none";
  const next = { none: name, ascending: `-${name}`, descending: "" }[direction];
  const arrow = { none: "", ascending: " ↑", descending: " ↓" }[direction];
  return (
    <th scope="col" title={sentence} aria-sort={direction}>
      <a href={withView({ sort: next, after: "", from: "" })}>
        {label}
        {arrow}
      </a>
    </th>
  );
}
