// The real binary on a free port, with a data directory of its own.

import { type ChildProcess, spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { createInterface } from "node:readline";

/** The program under test: `GRANARY`, or what `cargo build` leaves. */
const GRANARY = resolve(process.env.GRANARY ?? join(import.meta.dirname, "../../target/debug/granary"));

/** A server and whatever was started beside it. */
export class Service {
  private constructor(
    /** Where it serves, without a slash at the end. */
    readonly address: string,
    private readonly data: string,
    private readonly processes: ChildProcess[],
  ) {}

  /** Starts a server that computes nothing itself. */
  static async start(): Promise<Service> {
    const data = await mkdtemp(join(tmpdir(), "granary-page-"));
    const args = ["serve", "--listen", "127.0.0.1:0", "--data", join(data, "store"), "--workers", "0"];
    const server = spawn(GRANARY, args, { stdio: ["ignore", "ignore", "pipe"] });
    const said: string[] = [];
    for await (const line of createInterface({ input: server.stderr })) {
      said.push(line);
      const address = /serves at (http:\/\/\S+)/.exec(line)?.[1];
      if (!address) continue;
      server.stderr.resume();
      return new Service(address, data, [server]);
    }
    throw new Error(`the server did not start: ${said.join("\n")}`);
  }

  /** Starts a worker, so that what waits is computed. */
  work(): void {
    const args = ["worker", "--server", this.address, "--threads", "1", "--spool", join(this.data, "spool")];
    this.processes.push(spawn(GRANARY, args, { stdio: "ignore", cwd: this.data }));
  }

  /** Submits a sweep; its id. */
  async submit(spec: object): Promise<string> {
    const headers = { "Content-Type": "application/json" };
    const response = await fetch(`${this.address}/api/v1/sweeps`, { method: "POST", headers, body: JSON.stringify(spec) });
    const submitted = (await response.json()) as { sweep?: string };
    if (!submitted.sweep) throw new Error(`not submitted: ${JSON.stringify(submitted)}`);
    return submitted.sweep;
  }

  /** What the API says at `path`. */
  async get<T>(path: string): Promise<T> {
    const response = await fetch(`${this.address}/api/v1${path}`);
    return (await response.json()) as T;
  }

  /** Ends everything and leaves nothing behind. */
  async stop(): Promise<void> {
    const ends = this.processes.filter((process) => process.exitCode === null).map((process) => {
      process.kill("SIGTERM");
      return once(process, "exit");
    });
    await Promise.all(ends);
    await rm(this.data, { recursive: true, force: true });
  }
}
