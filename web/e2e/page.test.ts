// A physicist's way through the page, on a real sweep computed by a real worker.

import { type Browser, chromium, type Page } from "playwright-core";
import { afterAll, beforeAll, expect, test } from "vitest";
import { Service } from "./service";

const SPEC = {
  name: "tiny packs",
  model: "memory",
  fixed: { grains: 8 },
  numerics: { ramp: 1020, second_cycle: false },
  preparation: { gas_time: 50, preparation_ramp: 1020 },
  grid: [{ friction_coefficient: [0.4, 1], packing_seed: [1, 2], waveform: { suite: "six" } }],
  reduce: [
    { kind: "gain_fidelity", over: ["waveform"], processing: ["SUB0"] },
    { kind: "mean_sem", over: ["packing_seed"] },
  ],
};
const TOO_LARGE_A_STEP = { ...SPEC, name: "too large a step", numerics: { ...SPEC.numerics, time_step: 4 } };
/** How long anything may take that waits for the engine [ms]. */
const PATIENCE = 60_000;

let service: Service;
let browser: Browser;
let page: Page;
const complaints: string[] = [];

beforeAll(async () => {
  service = await Service.start();
  const args = ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"];
  browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args });
  page = await browser.newPage();
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("request", (request) => {
    if (new URL(request.url()).origin !== service.address) complaints.push(`asked for ${request.url()}`);
  });
});

afterAll(async () => {
  await browser?.close();
  await service?.stop();
});

test("a sweep is watched from nothing to its table, and the table says what the API says", async () => {
  await page.goto(service.address);
  await page.getByText("No sweep yet").waitFor();

  const sweep = await service.submit(SPEC);
  await page.getByRole("link", { name: SPEC.name }).click();
  expect(page.url()).toBe(`${service.address}/#/sweeps/${sweep}`);
  await fact("done", "0 of 24");
  await page.evaluate("window.opened = true");

  service.work();
  await fact("done", "24 of 24");
  await page.getByText("finished").first().waitFor();
  // The page was not loaded again: the numbers came by themselves.
  expect(await page.evaluate("window.opened")).toBe(true);

  type Sets = { items: { set: number; reduce: string; results: Record<string, number | null> }[] };
  const { items } = await service.get<Sets>(`/sweeps/${sweep}/sets`);
  expect(items).toHaveLength(6);
  await shows(items.filter((set) => set.reduce === "mean_sem"));
  await page.getByRole("link", { name: "each packing" }).click();
  await shows(items.filter((set) => set.reduce === "gain_fidelity"));
  await page.getByText("1–24 of 24").waitFor();

  type Points = { items: { results: object }[] };
  type Model = { results: { properties: object } };
  const points = await service.get<Points>(`/sweeps/${sweep}/points?limit=1`);
  const model = await service.get<Model>("/models/memory");
  // Every number of a point has a symbol and a unit.
  expect(Object.keys(model.results.properties)).toEqual(expect.arrayContaining(Object.keys(points.items[0]?.results ?? {})));
  await page.getByRole("columnheader", { name: "𝒢·E·δ0 [kPa]" }).waitFor();

  for (const plot of await page.locator(".plot canvas").all()) {
    expect(await plot.evaluate(inked)).toBeGreaterThan(100);
  }
  expect(await page.locator(".plot").count()).toBe(2);
}, 2 * PATIENCE);

test("a failed point is shown with its reason and its remedy", async () => {
  const sweep = await service.submit(TOO_LARGE_A_STEP);
  await page.goto(`${service.address}/#/sweeps/${sweep}`);
  await fact("failed", "24");
  const failures = page.getByRole("region", { name: "24 failed" });
  await failures.getByText("unstable", { exact: true }).first().waitFor();
  await failures.getByText(/use a time_step of at most/).first().waitFor();
  await failures.getByRole("link").click();
  const rows = page.locator(".points tbody tr");
  await rows.first().getByText(/unstable at step/).waitFor();
  // The link asks for failed points only: the table is empty until they come, and then shows the same ones.
  await expect.poll(() => rows.count(), { timeout: PATIENCE }).toBe(24);
}, 2 * PATIENCE);

test("a phone shows it all without the page moving sideways", async () => {
  await page.setViewportSize({ width: 360, height: 740 });
  await expect.poll(() => page.evaluate("document.documentElement.scrollWidth")).toBe(360);
});

test("the page never complained, and spoke to its own server only", () => {
  expect(complaints).toEqual([]);
});

/** Waits until the summary says `value` of `name`. */
async function fact(name: string, value: string): Promise<void> {
  const shown = page.locator(`.facts .${name} dd`).getByText(value, { exact: true });
  await shown.waitFor({ timeout: PATIENCE });
}

/** Waits until the set table holds exactly these numbers. */
async function shows(sets: { set: number; results: Record<string, number | null> }[]): Promise<void> {
  const expected = sets.flatMap(({ set, results }) =>
    ["gain", "gain_e_delta0", "fidelity", "correlation"].map((name) => [String(set), name, results[name]]),
  );
  const read = () =>
    page.locator(".sets td[data-result]").evaluateAll((cells) =>
      cells.map((cell) => [
        cell.closest("tr")?.dataset.set,
        (cell as HTMLElement).dataset.result,
        Number(cell.querySelector("data")?.value),
      ]),
    );
  await expect.poll(read, { timeout: PATIENCE }).toEqual(expected);
}

/** Pixels of a canvas in the color of the first series. */
function inked(element: Element): number {
  const canvas = element as HTMLCanvasElement;
  const pen = document.createElement("canvas").getContext("2d");
  if (!pen) return 0;
  pen.fillStyle = getComputedStyle(canvas).getPropertyValue("--series-1").trim();
  pen.fillRect(0, 0, 1, 1);
  const [r, g, b] = pen.getImageData(0, 0, 1, 1).data;
  const pixels = canvas.getContext("2d")?.getImageData(0, 0, canvas.width, canvas.height).data ?? [];
  let count = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    if (pixels[i] === r && pixels[i + 1] === g && pixels[i + 2] === b) count += 1;
  }
  return count;
}
