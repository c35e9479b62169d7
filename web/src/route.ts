// The view that the URL names: `#/` or `#/sweeps/ID?KEY=VALUE`.

import { signal } from "@preact/signals";

/** What the page shows. */
export interface Route {
  /** The sweep, or none for the list. */
  sweep?: string;
  /** What was chosen on the page: axis, sort, filter, place in the table. */
  view: Record<string, string>;
}

/** Reads a hash; a strange one is the list of sweeps. */
export function parseRoute(hash: string): Route {
  const [path = "", query = ""] = hash.replace(/^#/, "").split("?", 2);
  const view = Object.fromEntries(new URLSearchParams(query));
  const found = /^\/sweeps\/([0-9a-fA-F-]+)$/.exec(path);
  return found?.[1] ? { sweep: found[1], view } : { view };
}

/** The hash of a view; what is empty stands for its default and is left out. */
export function hashOf(route: Route): string {
  const pairs = Object.entries(route.view).filter(([, value]) => value !== "");
  const query = pairs.length > 0 ? `?${new URLSearchParams(pairs)}` : "";
  return route.sweep ? `#/sweeps/${route.sweep}${query}` : `#/${query}`;
}

/** The present view. */
export const route = signal<Route>(parseRoute(location.hash));

addEventListener("hashchange", () => {
  route.value = parseRoute(location.hash);
});

/** The hash of the present view with some of it chosen otherwise. */
export function withView(changes: Record<string, string>): string {
  return hashOf({ ...route.value, view: { ...route.value.view, ...changes } });
}
