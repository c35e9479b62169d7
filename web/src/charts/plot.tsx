// Series with error bars against one axis, drawn on uPlot's canvas; published marks are open, ours filled.

import { useEffect, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import { count, number, withError } from "../format";
import type { Quantity } from "../quantity";
import { axisLook, HEIGHT, ink as inkOf, title, useDark } from "./look";
import { isLogarithmic, rangeOf, type Series } from "./series";

/** Series told apart by color. */
const COLORS = 8;
/** How far apart marks of equal x stand at most, all together; and how near a pointer must be [px]. */
const APART = 6;
const SPREAD = 24;
const NEAR = 24;
/** Steps of an axis of whole numbers. */
const WHOLE = [0, 1, 2, 3, 4, 5, 6, 7, 8].flatMap((power) => [1, 2, 5].map((step) => step * 10 ** power));

interface Props {
  series: Series[];
  x: Quantity;
  y: Quantity;
}

/** One mark as it is drawn. */
interface Drawn {
  x: number;
  y: number;
  sem: number;
  /** Sideways, so that marks of equal x do not hide one another [px]. */
  shift: number;
  color: string;
  open: boolean;
  faint: boolean;
  text: string;
}

export function Plot({ series, x, y }: Props) {
  const place = useRef<HTMLDivElement>(null);
  const [told, tell] = useState("");
  const dark = useDark();
  const marks = drawn(series, x, y);
  const what = `${title(y)} against ${title(x)}`;
  const content = JSON.stringify([marks, x, y]);
  useEffect(() => {
    if (!place.current) return;
    return draw(place.current, marks, x, tell);
  }, [content, dark]);
  const ours = marks.filter((mark) => !mark.open).length;
  return (
    <figure class="plot">
      <figcaption title={y.sentence}>{title(y)}</figcaption>
      <div
        ref={place}
        role="img"
        aria-label={`${what}: ${ours} of this sweep, ${marks.length - ours} published; the table below has the numbers`}
      />
      <p class="axis" title={x.sentence}>
        {title(x)}
        {x.symbol !== x.name && <span class="quiet"> {x.name.replaceAll("_", " ")}</span>}
      </p>
      <Legend series={series} />
      <p class="told">{told || (marks.length === 0 ? "No number yet." : " ")}</p>
    </figure>
  );
}

function Legend({ series }: { series: Series[] }) {
  const sizes = new Set(series.flatMap((one) => one.published.map((mark) => mark.grains)));
  const published = [...sizes].map((grains) => count(grains)).join(" and ");
  return (
    <ul class="legend">
      {series.slice(0, COLORS).map((one, place) => (
        <li key={one.label}>
          <span class="mark" style={{ background: `var(--series-${place + 1})` }} /> {one.label}
        </li>
      ))}
      {series.length > COLORS && <li>and {series.length - COLORS} more, in grey</li>}
      {published !== "" && (
        <li>
          <span class="mark open" /> published, N = {published}
        </li>
      )}
    </ul>
  );
}

function drawn(series: Series[], x: Quantity, y: Quantity): Drawn[] {
  const text = (at: number, value: number, sem: number | null, whose: string) =>
    `${x.symbol} = ${number(at)}: ${y.symbol} = ${withError(value * y.scale, sem === null ? null : sem * y.scale)}` +
    `${y.unit && ` ${y.unit}`} (${whose})`;
  const apart = Math.min(APART, SPREAD / (2 * series.length - 1));
  return series.flatMap((one, place) => {
    const color = place < COLORS ? `--series-${place + 1}` : "--quiet";
    const shift = apart * (2 * place - (series.length - 1));
    const ours = one.marks.map((mark) => ({
      x: mark.x,
      y: mark.y * y.scale,
      sem: (mark.sem ?? 0) * y.scale,
      shift: shift - apart / 2,
      color,
      open: false,
      faint: mark.provisional,
      text: text(mark.x, mark.y, mark.sem, [one.label, mark.replicate, mark.provisional ? "provisional" : ""].filter(Boolean).join(", ")),
    }));
    const published = one.published.map((mark) => ({
      x: mark.x,
      y: mark.mean * y.scale,
      sem: (mark.sem ?? 0) * y.scale,
      shift: shift + apart / 2,
      color: series.length > 1 ? color : "--ink",
      open: true,
      faint: false,
      text: text(mark.x, mark.mean, mark.sem, `published, ${mark.packs} packs of N = ${count(mark.grains)}`),
    }));
    return [...ours, ...published];
  });
}

/** Draws into `place`; gives what takes it away again. */
function draw(place: HTMLDivElement, marks: Drawn[], x: Quantity, tell: (text: string) => void): () => void {
  const ink = (name: string) => inkOf(place, name);
  const xs = marks.map((mark) => mark.x);
  const logarithmic = isLogarithmic(xs);
  const xRange = rangeOf(xs, logarithmic);
  const yRange = rangeOf([0, ...marks.flatMap((mark) => [mark.y - mark.sem, mark.y + mark.sem])], false);
  const axis = axisLook(place);
  const plot = new uPlot(
    {
      width: place.clientWidth,
      height: HEIGHT,
      legend: { show: false },
      cursor: { show: false },
      scales: {
        x: { time: false, distr: logarithmic ? 3 : 1, range: () => xRange },
        y: { range: () => yRange },
      },
      series: [{ label: x.symbol }, { show: true, points: { show: false } }],
      axes: [{ ...axis, size: 34, ...(xs.every(Number.isInteger) && { incrs: WHOLE }) }, { ...axis, size: 64 }],
      hooks: { draw: [(plot) => marks.forEach((mark) => drawMark(plot, mark, ink(mark.color), ink("--paper")))] },
    },
    [xRange, [null, null]],
    place,
  );
  const move = (event: MouseEvent) => tell(nearest(plot, marks, event.offsetX, event.offsetY)?.text ?? "");
  plot.over.addEventListener("mousemove", move);
  plot.over.addEventListener("mouseleave", () => tell(""));
  const watch = new ResizeObserver(() => plot.setSize({ width: place.clientWidth, height: HEIGHT }));
  watch.observe(place);
  return () => {
    watch.disconnect();
    plot.destroy();
  };
}

function drawMark(plot: uPlot, mark: Drawn, color: string, paper: string): void {
  const { ctx } = plot;
  const dot = uPlot.pxRatio;
  const at = (y: number) => plot.valToPos(y, "y", true);
  const x = plot.valToPos(mark.x, "x", true) + mark.shift * dot;
  const y = at(mark.y);
  ctx.save();
  ctx.globalAlpha = mark.faint ? 0.45 : 1;
  ctx.strokeStyle = color;
  ctx.lineWidth = 1.5 * dot;
  ctx.beginPath();
  if (mark.sem > 0) {
    const [low, high, cap] = [at(mark.y - mark.sem), at(mark.y + mark.sem), 4 * dot];
    ctx.moveTo(x, low);
    ctx.lineTo(x, high);
    for (const end of [low, high]) {
      ctx.moveTo(x - cap, end);
      ctx.lineTo(x + cap, end);
    }
    ctx.stroke();
    ctx.beginPath();
  }
  const size = 5 * dot;
  if (mark.open) {
    ctx.moveTo(x, y - size);
    ctx.lineTo(x + size, y);
    ctx.lineTo(x, y + size);
    ctx.lineTo(x - size, y);
    ctx.closePath();
  } else {
    ctx.arc(x, y, 4.5 * dot, 0, 2 * Math.PI);
  }
  ctx.fillStyle = mark.open ? paper : color;
  ctx.fill();
  ctx.stroke();
  ctx.restore();
}

function nearest(plot: uPlot, marks: Drawn[], x: number, y: number): Drawn | undefined {
  const distance = (mark: Drawn) =>
    Math.hypot(plot.valToPos(mark.x, "x") + mark.shift - x, plot.valToPos(mark.y, "y") - y);
  const [best] = [...marks].sort((a, b) => distance(a) - distance(b));
  return best && distance(best) <= NEAR ? best : undefined;
}
