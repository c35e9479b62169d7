// Stiffness and strength of beams over friction and stiffness of their grains, a map for each protocol.

import { listPoints, type Model, type Sweep } from "../api/client";
import { useLoaded } from "../api/load";
import { heatmapsOf, labelOf, rangeOfMeans } from "../charts/cells";
import { HeatmapTable } from "../charts/heatmap";
import { count } from "../format";
import { fixedParameters, parameterQuantity, resultQuantity } from "../quantity";
import { withView } from "../route";
import { Await } from "./states";

/** The most points that are read for the maps. */
const MOST_POINTS = 2000;
const [ACROSS, UPWARD] = ["friction_coefficient", "youngs_modulus"];
const RESULTS = ["beam_stiffness", "ultimate_strength"];

export function BeamSection({ sweep, model, version }: { sweep: Sweep; model: Model | undefined; version: number }) {
  const load = (signal: AbortSignal) => listPoints(sweep.sweep, { limit: MOST_POINTS }, signal);
  const points = useLoaded(load, sweep.sweep, version);
  const fixed = fixedParameters(model, sweep);
  const symbol = (name: string) => parameterQuantity(model, name).symbol;
  // Moduli of grains are told in MPa, as everybody tells them.
  const upward = { ...parameterQuantity(model, UPWARD), unit: "MPa", scale: 1e-6 };
  return (
    <section aria-labelledby="beams">
      <h2 id="beams">Stiffness and strength</h2>
      <Await loaded={points} what="points">
        {(page) => (
          <>
            {RESULTS.map((result) => {
              const maps = heatmapsOf(page.items, [ACROSS, UPWARD], result, fixed);
              return (
                <div key={result} class="plots" data-result={result}>
                  {maps.map((map) => (
                    <HeatmapTable
                      key={JSON.stringify(map.others)}
                      map={map}
                      label={labelOf(map.others, symbol)}
                      range={rangeOfMeans(maps)}
                      result={resultQuantity(model, result)}
                      across={parameterQuantity(model, ACROSS)}
                      upward={upward}
                      link={(point) => withView({ curve: String(point) })}
                    />
                  ))}
                </div>
              );
            })}
            {page.total > page.items.length && (
              <p class="quiet">
                Of the first {count(page.items.length)} of {count(page.total)} points.
              </p>
            )}
          </>
        )}
      </Await>
    </section>
  );
}
