// The bearer token that the user pasted: kept for this tab alone, never in a URL.

import { signal } from "@preact/signals";

const KEY = "granary.token";

/** The token, or an empty text. */
export const token = signal(sessionStorage.getItem(KEY) ?? "");

/** Keeps a token, or forgets it if it is empty. */
export function keepToken(text: string): void {
  token.value = text.trim();
  if (token.value === "") sessionStorage.removeItem(KEY);
  else sessionStorage.setItem(KEY, token.value);
}
