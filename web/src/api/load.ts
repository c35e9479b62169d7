// Something read from the server, as a component sees it: on its way, there, or failed.

import { useEffect, useState } from "preact/hooks";
import { ApiError } from "./client";
import { token } from "./token";

/** What is known of something asked for. */
export interface Loaded<T> {
  /** The latest answer; it stays while a newer one is on its way, or fails to come. */
  value?: T;
  /** Why there is no (newer) answer. */
  error?: ApiError;
}

/** Loads when `what` changes, forgetting the old answer, and again when `version` does, keeping it. */
export function useLoaded<T>(
  load: (signal: AbortSignal) => Promise<T>,
  what: string,
  version: number,
): Loaded<T> {
  const [held, hold] = useState<{ what: string; loaded: Loaded<T> }>({ what, loaded: {} });
  const bearer = token.value;
  useEffect(() => {
    const abort = new AbortController();
    load(abort.signal).then(
      (value) => hold({ what, loaded: { value } }),
      (error: unknown) => {
        if (abort.signal.aborted) return;
        const known = error instanceof ApiError ? error : new ApiError(0, String(error));
        hold((old) => ({ what, loaded: old.what === what ? { ...old.loaded, error: known } : { error: known } }));
      },
    );
    return () => abort.abort();
  }, [what, version, bearer]);
  return held.what === what ? held.loaded : {};
}
