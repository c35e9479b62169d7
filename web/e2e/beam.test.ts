// Two small beams, computed by a real worker: their maps, and the curve behind a cell.

import { type Browser, chromium, type Page } from "playwright-core";
import { afterAll, beforeAll, expect, test } from "vitest";
import { Service } from "./service";

const SPEC = {
  name: "two beams",
  model: "beam",
  preset: "smoke",
  fixed: { protocol: "B" },
  numerics: { strain_end: 0.004 },
  grid: [{ friction_coefficient: [0.3, 1.2] }],
};
/** How long two beams may take [ms]. */
const PATIENCE = 240_000;

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
});

afterAll(async () => {
  await browser?.close();
  await service?.stop();
});

test("maps say what the API says, reasons for no number included, and lead to the curve", async () => {
  const sweep = await service.submit(SPEC);
  await page.goto(`${service.address}/#/sweeps/${sweep}`);
  await page.locator("[data-result=ultimate_strength] td").getByText("waits").first().waitFor();
  service.work();
  await page.locator(".facts .done dd").getByText("2 of 2", { exact: true }).waitFor({ timeout: PATIENCE });

  type Points = { items: { results: Record<string, number | string | null> }[] };
  const { items } = await service.get<Points>(`/sweeps/${sweep}/points`);
  const stiffness = items.map(({ results }) => results.beam_stiffness);
  const shown = () => page.locator("[data-result=beam_stiffness] td data").evaluateAll((all) => all.map((one) => Number((one as HTMLDataElement).value)));
  await expect.poll(shown).toEqual(stiffness);
  // A beam that is hardly bent has no strength, and both tables say why.
  const strengths = page.locator("[data-result=ultimate_strength] td");
  await expect.poll(() => strengths.allInnerTexts()).toEqual(["run too short", "run too short"]);

  await page.locator("[data-result=beam_stiffness] td a").first().click();
  const plot = page.getByRole("img", { name: /^Stress σ in kPa over strain ε of point 0; E_b = .* kPa, no Y_b: run too short/ });
  await plot.locator("canvas").waitFor();
  await page.getByText("Numbers of the curve").click();
  expect(await page.locator("table.curve tbody tr").count()).toBe(41);
  expect(complaints).toEqual([]);
}, PATIENCE + 60_000);
