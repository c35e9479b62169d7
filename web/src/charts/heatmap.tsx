// A heatmap without interpolation: a table whose cells are colored, so that every number can be read, also aloud.

import { number, parameter, withError } from "../format";
import type { Quantity } from "../quantity";
import { type Cell, type Heatmap, shareOf } from "./cells";
import { title } from "./look";

interface Props {
  map: Heatmap;
  /** What this map is of, such as the protocol; empty if the sweep has one map. */
  label: string;
  /** Ends of the colors, the same for maps that are compared. */
  range: [number, number] | undefined;
  result: Quantity;
  across: Quantity;
  upward: Quantity;
  /** Where the curve of a point is shown. */
  link: (point: number) => string;
}

export function HeatmapTable({ map, label, range, result, across, upward, link }: Props) {
  const name = [title(result), label].filter(Boolean).join(", ");
  return (
    <figure class="plot heat">
      <figcaption title={result.sentence}>{name}</figcaption>
      <div class="scroller" tabIndex={0} role="region" aria-label={`${name} over ${title(across)} and ${title(upward)}`}>
        <table>
          <thead>
            <tr>
              <th scope="col" title={`${upward.sentence} ${across.sentence}`}>
                {title(upward)} ↓ {title(across)} →
              </th>
              {map.across.map((value) => (
                <th key={value} scope="col" class="number">{parameter(value * across.scale)}</th>
              ))}
            </tr>
          </thead>
          <tbody>
            {map.cells.map((cells, row) => (
              <tr key={map.upward[row]}>
                <th scope="row" class="number">{parameter((map.upward[row] ?? 0) * upward.scale)}</th>
                {cells.map((cell, column) => (
                  <Value key={map.across[column]} cell={cell} range={range} result={result} link={link} />
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      {range && range[0] < range[1] && <Scale range={range} result={result} />}
    </figure>
  );
}

function Value({ cell, range, result, link }: { cell: Cell | undefined } & Pick<Props, "range" | "result" | "link">) {
  if (!cell) return <td class="empty" title="The sweep has no such point.">·</td>;
  const { scale, unit } = result;
  const why = cell.reason && `${cell.of - cell.n} of ${cell.of} without a number: ${cell.reason}`;
  if (cell.mean === null || !range) {
    return (
      <td class="none" title={why}>
        <a href={link(cell.point)}>{cell.reason}</a>
      </td>
    );
  }
  const share = shareOf(cell.mean, range);
  const told = withError(cell.mean * scale, cell.sem === null ? null : cell.sem * scale);
  const of = cell.n === cell.of ? `${cell.n}` : `${cell.n} of ${cell.of}`;
  return (
    <td
      class={share > 0.5 ? "number high" : "number"}
      style={{ "--share": `${(100 * share).toFixed(1)}%` }}
      title={[`${told} ${unit}, ${of} packing${cell.of === 1 ? "" : "s"}`, why].filter(Boolean).join("; ")}
    >
      <a href={link(cell.point)}>
        <data value={String(cell.mean)}>{number(cell.mean * scale, 3)}</data>
        {cell.n < cell.of && <span class="part"> {of}</span>}
      </a>
    </td>
  );
}

function Scale({ range: [least, most], result }: { range: [number, number]; result: Quantity }) {
  return (
    <p class="scale" aria-hidden="true">
      {number(least * result.scale, 3)}
      <span class="ramp" />
      {number(most * result.scale, 3)} {result.unit}
    </p>
  );
}
