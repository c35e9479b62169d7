// A stress–strain curve on uPlot's canvas, with E_b as a dashed line and Y_b as a mark.

import { useEffect, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import { number } from "../format";
import type { Curve } from "./bending";
import { axisLook, HEIGHT, ink, useDark } from "./look";
import { rangeOf } from "./series";

/** The curve; `label` says it all to who cannot see it. */
export function CurvePlot({ curve, label }: { curve: Curve; label: string }) {
  const place = useRef<HTMLDivElement>(null);
  const [told, tell] = useState("");
  const dark = useDark();
  useEffect(() => (place.current ? draw(place.current, curve, tell) : undefined), [curve, dark]);
  return (
    <figure class="plot">
      <figcaption>σ [kPa]</figcaption>
      <div ref={place} role="img" aria-label={label} />
      <p class="axis">
        ε <span class="quiet">strain</span>
      </p>
      <ul class="legend">
        <li>
          <span class="stroke" /> bending
        </li>
        {curve.stiffness && (
          <li>
            <span class="stroke dashed" /> E_b
          </li>
        )}
        {curve.strength && (
          <li>
            <span class="mark open" /> Y_b
          </li>
        )}
      </ul>
      <p class="told">{told || " "}</p>
    </figure>
  );
}

function draw(place: HTMLDivElement, curve: Curve, tell: (text: string) => void): () => void {
  const axis = axisLook(place);
  const xRange = rangeOf([0, ...curve.strain], false);
  const yRange = rangeOf([0, ...curve.stress], false);
  const order = curve.strain.map((_, k) => k).sort((a, b) => (curve.strain[a] ?? 0) - (curve.strain[b] ?? 0));
  const plot = new uPlot(
    {
      width: place.clientWidth,
      height: HEIGHT,
      legend: { show: false },
      cursor: { show: false },
      scales: { x: { time: false, range: () => xRange }, y: { range: () => yRange } },
      series: [{ label: "ε" }, { show: true, points: { show: false } }],
      axes: [{ ...axis, size: 34 }, { ...axis, size: 64 }],
      hooks: { draw: [(plot) => drawCurve(plot, place, curve)] },
    },
    [xRange, [null, null]],
    place,
  );
  const move = (event: MouseEvent) => {
    const strain = plot.posToVal(event.offsetX, "x");
    const near = order.find((k) => (curve.strain[k] ?? 0) >= strain);
    tell(near === undefined ? "" : `ε = ${number(curve.strain[near] ?? 0, 3)}: σ = ${number(curve.stress[near] ?? 0, 4)} kPa`);
  };
  plot.over.addEventListener("mousemove", move);
  plot.over.addEventListener("mouseleave", () => tell(""));
  const watch = new ResizeObserver(() => plot.setSize({ width: place.clientWidth, height: HEIGHT }));
  watch.observe(place);
  return () => {
    watch.disconnect();
    plot.destroy();
  };
}

/** In the order of the test: a cycle goes back on its way, which a series of uPlot cannot. */
function drawCurve(plot: uPlot, place: Element, curve: Curve): void {
  const { ctx } = plot;
  const dot = uPlot.pxRatio;
  const to = (x: number, y: number): [number, number] => [plot.valToPos(x, "x", true), plot.valToPos(y, "y", true)];
  ctx.save();
  ctx.lineWidth = 1.5 * dot;
  ctx.strokeStyle = ink(place, "--series-1");
  ctx.beginPath();
  curve.strain.forEach((strain, k) => ctx.lineTo(...to(strain, curve.stress[k] ?? 0)));
  ctx.stroke();
  ctx.strokeStyle = ink(place, "--series-2");
  if (curve.stiffness) {
    ctx.setLineDash([6 * dot, 4 * dot]);
    ctx.beginPath();
    curve.stiffness.forEach(([x, y]) => ctx.lineTo(...to(x, y)));
    ctx.stroke();
    ctx.setLineDash([]);
  }
  if (curve.strength) {
    const [x, y] = to(...curve.strength);
    const size = 6 * dot;
    ctx.strokeStyle = ink(place, "--ink");
    ctx.fillStyle = ink(place, "--paper");
    ctx.beginPath();
    ctx.moveTo(x, y - size);
    ctx.lineTo(x + size, y);
    ctx.lineTo(x, y + size);
    ctx.lineTo(x - size, y);
    ctx.closePath();
    ctx.fill();
    ctx.stroke();
  }
  ctx.restore();
}
