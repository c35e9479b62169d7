// Which reduction the URL names: plots and table show the same one.

import type { SetRow } from "../api/client";
import { route } from "../route";

/** The reductions of a sweep in their order, and the one chosen: the last unless the URL says otherwise. */
export function reductions(sets: SetRow[]): { all: string[]; chosen: string } {
  const all = [...new Set(sets.map((set) => set.reduce))];
  const asked = route.value.view.sets ?? "";
  return { all, chosen: all.includes(asked) ? asked : (all.at(-1) ?? "") };
}
