// Gain and fidelity against an axis, with the published packs where there are any.

import { useMemo } from "preact/hooks";
import type { Model, SetRow } from "../api/client";
import { Plot } from "../charts/plot";
import { axesOf, type Plotted, seriesOf } from "../charts/series";
import { parameterQuantity, resultQuantity } from "../quantity";
import { route, withView } from "../route";
import { reductions } from "./chosen";

interface Props {
  sets: SetRow[];
  model: Model | undefined;
  fixed: Record<string, unknown>;
}

const PLOTTED: Plotted[] = ["gain_e_delta0", "fidelity"];

export function PlotSection({ sets, model, fixed }: Props) {
  const { chosen } = reductions(sets);
  const rows = useMemo(() => sets.filter((set) => set.reduce === chosen), [sets, chosen]);
  const axes = axesOf(rows, fixed);
  const asked = route.value.view.x ?? "";
  const axis = axes.includes(asked) ? asked : axes[0];
  if (!axis) return null;
  const choose = (event: { currentTarget: HTMLSelectElement }) => {
    location.hash = withView({ x: event.currentTarget.value });
  };
  return (
    <section aria-labelledby="plots">
      <h2 id="plots">Gain and fidelity</h2>
      <p class="choices">
        <label>
          against{" "}
          <select value={axis} onChange={choose}>
            {axes.map((name) => (
              <option key={name} value={name}>
                {parameterQuantity(model, name).symbol} – {name.replaceAll("_", " ")}
              </option>
            ))}
          </select>
        </label>
      </p>
      <div class="plots">
        {PLOTTED.map((name) => (
          <Plot
            key={name}
            series={seriesOf(rows, axis, name, fixed, (name) => parameterQuantity(model, name).symbol)}
            x={parameterQuantity(model, axis)}
            y={resultQuantity(model, name)}
          />
        ))}
      </div>
    </section>
  );
}
