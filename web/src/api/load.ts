// Something read from the server, as a component sees it: on its way, there, or failed.

import { useEffect, useRef, useState } from "preact/hooks";
import { ApiError } from "./client";
import { token } from "./token";

/** What is known of something asked for. */
export interface Loaded<T> {
  /** The latest answer; it stays while a newer one is on its way, or fails to come. */
  value?: T;
  /** Why there is no (newer) answer. */
  error?: ApiError;
}

/** After a slow answer the next question waits this many times as long, so that a reader never keeps a server busy. */
const REST = 4;

/** Loads when `what` changes, forgetting the old answer, and again when `version` does, keeping it. */
export function useLoaded<T>(
  load: (signal: AbortSignal) => Promise<T>,
  what: string,
  version: number,
): Loaded<T> {
  const [held, hold] = useState<{ what: string; loaded: Loaded<T> }>({ what, loaded: {} });
  const again = useRef(() => {});
  const bearer = token.value;
  useEffect(() => {
    const abort = new AbortController();
    let [busy, due] = [false, false];
    const run = async () => {
      if (abort.signal.aborted) return;
      [busy, due] = [true, false];
      const start = performance.now();
      const loaded = await settled(load(abort.signal));
      if (abort.signal.aborted) return;
      hold((old) => {
        const kept = loaded.error && old.what === what && old.loaded.value !== undefined ? { value: old.loaded.value } : {};
        return { what, loaded: { ...kept, ...loaded } };
      });
      setTimeout(() => {
        busy = false;
        if (due) void run();
      }, REST * (performance.now() - start));
    };
    // A question that is under way is not asked anew, only once more.
    again.current = () => {
      if (busy) due = true;
      else void run();
    };
    void run();
    return () => abort.abort();
  }, [what, bearer]);
  useEffect(() => {
    if (version > 0) again.current();
  }, [version]);
  return held.what === what ? held.loaded : {};
}

async function settled<T>(answer: Promise<T>): Promise<Loaded<T>> {
  try {
    return { value: await answer };
  } catch (error) {
    return { error: error instanceof ApiError ? error : new ApiError(0, String(error)) };
  }
}
