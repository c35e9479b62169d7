// Loading, failed and out of date: what stands where a table is not (yet).

import type { ComponentChildren } from "preact";
import type { Loaded } from "../api/load";
import { TokenForm } from "./header";

interface Props<T> {
  loaded: Loaded<T>;
  /** What is awaited, for the reader. */
  what: string;
  children: (value: T) => ComponentChildren;
}

/** Shows `children` once there is something to show; says plainly why not otherwise. */
export function Await<T>({ loaded, what, children }: Props<T>) {
  const { value, error } = loaded;
  if (error?.status === 401) return <TokenForm />;
  if (value === undefined && error) {
    return (
      <p class="notice bad" role="alert">
        <strong>No {what}:</strong> {error.message}
        {error.status === 0 ? " It is tried again by itself." : " "}
        {error.status === 404 && <a href="#/">All sweeps</a>}
      </p>
    );
  }
  if (value === undefined) return <p class="quiet loading">Loading {what} …</p>;
  return (
    <>
      {error && (
        <p class="notice bad" role="alert">
          <strong>The {what} below may be out of date:</strong> {error.message}
        </p>
      )}
      {children(value)}
    </>
  );
}
