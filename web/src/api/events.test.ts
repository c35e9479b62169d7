import { expect, test, vi } from "vitest";

vi.stubGlobal("sessionStorage", { getItem: () => null });
const { EventParser } = await import("./events");

const STREAM =
  "id: 7\nevent: point\ndata: {\"a\":\ndata: 1}\n\n: keep-alive\n\nevent: progress\r\ndata: {}\r\n\r\ndata:plain\n\n";
const EVENTS = [
  { id: "7", event: "point", data: '{"a":\n1}' },
  { id: "7", event: "progress", data: "{}" },
  { id: "7", event: "message", data: "plain" },
];

test("events are the same wherever the stream is cut", () => {
  for (let size = 1; size <= STREAM.length; size += 1) {
    const parser = new EventParser();
    const pieces = STREAM.match(new RegExp(`[^]{1,${size}}`, "g")) ?? [];
    expect(pieces.flatMap((piece) => parser.push(piece))).toEqual(EVENTS);
  }
});

test("an event that has not ended is not told", () => {
  expect(new EventParser().push("event: point\ndata: 1\n")).toEqual([]);
});
