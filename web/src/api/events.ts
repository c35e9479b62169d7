// A sweep's events as they happen: SSE by `fetch`, so that the token goes in a header.

import { ApiError, request } from "./client";

/** One event of a stream. */
export interface ServerEvent {
  id: string;
  event: string;
  data: string;
}

/** Reads a stream of server-sent events piece by piece, wherever the pieces are cut. */
export class EventParser {
  #rest = "";
  #id = "";
  #event = "";
  #data: string[] = [];

  /** The events that `piece` completes. */
  push(piece: string): ServerEvent[] {
    const events: ServerEvent[] = [];
    const text = this.#rest + piece;
    // A carriage return at the end may be half of a line's end.
    const end = text.endsWith("\r") ? text.length - 1 : text.length;
    const lines = text.slice(0, end).split(/\r\n|\r|\n/);
    this.#rest = (lines.pop() ?? "") + text.slice(end);
    for (const line of lines) {
      if (line === "") this.#dispatch(events);
      else this.#field(line);
    }
    return events;
  }

  #field(line: string): void {
    const colon = line.indexOf(":");
    const name = colon < 0 ? line : line.slice(0, colon);
    const value = colon < 0 ? "" : line.slice(colon + 1).replace(/^ /, "");
    if (name === "id") this.#id = value;
    else if (name === "event") this.#event = value;
    else if (name === "data") this.#data.push(value);
  }

  #dispatch(events: ServerEvent[]): void {
    if (this.#data.length > 0) {
      events.push({ id: this.#id, event: this.#event || "message", data: this.#data.join("\n") });
    }
    this.#event = "";
    this.#data = [];
  }
}

/** Who hears of a sweep's events. */
export interface Listener {
  event(event: ServerEvent): void;
  /** Whether events arrive; while they do not, it is tried again. */
  live(live: boolean): void;
}

/** Longest pause before the stream is asked for again [ms]. */
const LONGEST_PAUSE = 10_000;

/** Follows a sweep until `signal`; after a break it resumes where it was. */
export async function followSweep(sweep: string, listener: Listener, signal: AbortSignal): Promise<void> {
  let last = "";
  let pause = 500;
  while (!signal.aborted) {
    try {
      const headers: HeadersInit = last === "" ? {} : { "Last-Event-ID": last };
      const path = `/sweeps/${encodeURIComponent(sweep)}/events`;
      const response = await request(path, { headers, signal, cache: "no-store" });
      listener.live(true);
      pause = 500;
      for await (const event of events(response)) {
        if (event.id !== "") last = event.id;
        listener.event(event);
      }
    } catch (error) {
      // A refusal stays one: the page has asked the same server for the sweep and shows why.
      if (signal.aborted || (error instanceof ApiError && error.status >= 400 && error.status < 500)) return;
    }
    if (signal.aborted) return;
    listener.live(false);
    await new Promise((resolve) => setTimeout(resolve, pause * (0.5 + Math.random())));
    pause = Math.min(2 * pause, LONGEST_PAUSE);
  }
}

async function* events(response: Response): AsyncGenerator<ServerEvent> {
  if (!response.body) return;
  const parser = new EventParser();
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    yield* parser.push(value);
  }
}
