// The record of a bending, a file that its job left.

/** What the file `history` of a bending holds, as far as it is drawn; SI units. */
export interface History {
  strain: number[];
  stress: number[];
}

/** Reads the file; throws if it is none of a bending. */
export function parseHistory(value: unknown): History {
  const { strain, stress } = (value ?? {}) as Partial<History>;
  const numbers = (list: unknown): list is number[] => Array.isArray(list) && list.every((x) => typeof x === "number");
  if (!numbers(strain) || !numbers(stress) || strain.length !== stress.length) {
    throw new Error("The file is not the record of a bending.");
  }
  return { strain, stress };
}
