// A sweep as it happens: its summary from the stream, and a number that rises when its tables have changed.

import { useEffect, useState } from "preact/hooks";
import type { Sweep } from "../api/client";
import { followSweep } from "../api/events";
import { token } from "../api/token";

/** Least time between two readings of the tables [ms]. */
const PAUSE = 1000;

/** What the stream has said. */
export interface Live {
  /** The latest summary, if one has come. */
  summary?: Sweep;
  /** Rises when tables are worth reading again. */
  version: number;
  /** Whether the stream is open; none before it was. */
  open?: boolean;
}

/** Follows the sweep `id` for as long as the page shows it. */
export function useLive(id: string): Live {
  const [live, setLive] = useState<Live>({ version: 0 });
  const bearer = token.value;
  useEffect(() => {
    const abort = new AbortController();
    let due: ReturnType<typeof setTimeout> | undefined;
    const raise = () => {
      due ??= setTimeout(() => {
        due = undefined;
        setLive((old) => ({ ...old, version: old.version + 1 }));
      }, PAUSE);
    };
    const listener = {
      event({ event, data }: { event: string; data: string }) {
        if (event === "progress") setLive((old) => ({ ...old, summary: JSON.parse(data) as Sweep }));
        raise();
      },
      live(open: boolean) {
        setLive((old) => ({ ...old, open }));
        // What a restarted server knows may differ from what it said last.
        raise();
      },
    };
    void followSweep(id, listener, abort.signal);
    return () => {
      abort.abort();
      clearTimeout(due);
    };
  }, [id, bearer]);
  return live;
}
