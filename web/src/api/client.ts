// The server's API: the only place, with `events`, that fetches.

import { type History, parseHistory } from "./history";
import type { components } from "./schema";
import { token } from "./token";

type Schemas = components["schemas"];
export type Sweep = Schemas["Sweep"];
export type Problem = Schemas["Problem"];
export type Failure = Schemas["Failure"];
export type Job = Schemas["JobDetail"];
export type Model = Schemas["Model"];
export type SetRow = Schemas["Page_SetRow"]["items"][number];
export type PointRow = Schemas["Page_PointRow"]["items"][number];

/** Part of a list, and how long the whole is. */
export interface Page<T> {
  items: T[];
  next?: string | null;
  total: number;
}

/** What the server said instead of an answer; status 0 if it could not be reached. */
export class ApiError extends Error {
  constructor(
    readonly status: number,
    message: string,
  ) {
    super(message);
  }
}

/** What one asks of a table. */
export interface TableQuery {
  where?: string[];
  sort?: string | undefined;
  cursor?: string | undefined;
  limit?: number;
}

/** A GET with the token; throws `ApiError` for anything but success. */
export async function request(path: string, init: RequestInit = {}): Promise<Response> {
  const headers = new Headers(init.headers);
  if (token.value !== "") headers.set("Authorization", `Bearer ${token.value}`);
  let response: Response;
  try {
    // The browser's cache is asked with the ETag, so an unchanged table costs a 304.
    response = await fetch(`/api/v1${path}`, { cache: "no-cache", ...init, headers });
  } catch (error) {
    if (init.signal?.aborted) throw error;
    throw new ApiError(0, "The server does not answer.");
  }
  if (!response.ok) throw new ApiError(response.status, await reason(response));
  return response;
}

async function reason(response: Response): Promise<string> {
  const problem = (await response.json().catch(() => null)) as Problem | null;
  const mistakes = problem?.errors?.map((mistake) => mistake.detail).join("; ");
  return problem?.detail || mistakes || problem?.title || `The server answered ${response.status}.`;
}

async function read<T>(path: string, signal: AbortSignal): Promise<T> {
  const response = await request(path, { signal });
  return (await response.json()) as T;
}

function search(query: TableQuery): string {
  const pairs = (query.where ?? []).map((filter) => ["where", filter]);
  if (query.sort) pairs.push(["sort", query.sort]);
  if (query.cursor) pairs.push(["cursor", query.cursor]);
  if (query.limit) pairs.push(["limit", String(query.limit)]);
  return pairs.length > 0 ? `?${new URLSearchParams(pairs)}` : "";
}

/** The latest sweeps. */
export function listSweeps(query: TableQuery, signal: AbortSignal): Promise<Page<Sweep>> {
  return read(`/sweeps${search(query)}`, signal);
}

/** One sweep with its spec. */
export function readSweep(sweep: string, signal: AbortSignal): Promise<Sweep> {
  return read(`/sweeps/${encodeURIComponent(sweep)}`, signal);
}

/** The experiment that a sweep is of. */
export function readModel(name: string, signal: AbortSignal): Promise<Model> {
  return read(`/models/${encodeURIComponent(name)}`, signal);
}

/** A page of a sweep's sets. */
export function listSets(sweep: string, query: TableQuery, signal: AbortSignal): Promise<Page<SetRow>> {
  return read(`/sweeps/${encodeURIComponent(sweep)}/sets${search(query)}`, signal);
}

/** A page of a sweep's points. */
export function listPoints(sweep: string, query: TableQuery, signal: AbortSignal): Promise<Page<PointRow>> {
  return read(`/sweeps/${encodeURIComponent(sweep)}/points${search(query)}`, signal);
}

/** One job: why it failed, who ran it. */
export function readJob(job: string, signal: AbortSignal): Promise<Job> {
  return read(`/jobs/${encodeURIComponent(job)}`, signal);
}

/** Where a stored file is. */
export function artifactPath(hash: string): string {
  return `/api/v1/artifacts/${encodeURIComponent(hash)}`;
}

/** The record of a bending. */
export async function readHistory(hash: string, signal: AbortSignal): Promise<History> {
  const record = await read<unknown>(`/artifacts/${encodeURIComponent(hash)}`, signal);
  return parseHistory(record);
}
