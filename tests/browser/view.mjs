// The page of `pse view` as its user has it.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { Preview, launch, open, picture, root, sum } from "./page.mjs";

const MARBLE = readFileSync(join(root, "examples/marble.pse"), "utf8");
const pictures = process.env.UPDATE ? join(root, "docs/pictures") : null;
const browser = await launch();
let failed = 0;

/** A test with a preview of its own, and a page. */
async function test(name, text, run, ...args) {
  const preview = await Preview.start(text, ...args);
  let page;
  try {
    page = await open(browser, preview);
    await run(page, preview);
    assert.deepEqual(page.faults, []);
    console.log(`ok      ${name}`);
  } catch (error) {
    failed++;
    console.log(`FAILED  ${name}\n${error.stack}`);
    if (page) await page.screenshot({ path: `/tmp/pse-view-failed-${failed}.png` }).catch(() => {});
  } finally {
    await page?.close();
    await preview.end();
  }
}

/** Replaces the text of the editor as a hand would. */
async function type(page, text) {
  await page.locator(".cm-content").click();
  await page.keyboard.press("Control+a");
  await page.keyboard.insertText(text);
}

/** Clicks at a pixel of the whole picture. */
async function click(page, x, y) {
  const box = await page.locator("#canvas").boundingBox();
  const [w, h] = await page.evaluate(() => [document.getElementById("canvas").width, document.getElementById("canvas").height]);
  await page.mouse.click(box.x + ((x + 0.5) * box.width) / w, box.y + ((y + 0.5) * box.height) / h);
}

const shown = (page) => page.evaluate(() => window.shown.id);
const small = ["--size", "160x120"];

await test("a page shows the picture and the program", MARBLE, async (page) => {
  assert.equal(await page.title(), (await page.locator("#name").textContent()) + " - pse view");
  assert.match(await page.locator(".cm-content").textContent(), /param veins/);
  const colours = await page.evaluate(() => {
    const canvas = document.getElementById("canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  });
  assert.ok(colours > 1000, `only ${colours} colours`);
  assert.match(await page.locator("#status").textContent(), /640x480, .* ns\/pixel/);
});

await test("a mistake is shown in its place and the picture stays; mended, there is a new one", MARBLE, async (page, preview) => {
  const before = await sum(page);
  const id = await shown(page);
  preview.save(MARBLE.replace("turbulence(", "turbulense("));
  await page.locator("#error").waitFor();
  assert.match(await page.locator("#error").textContent(), /turbulense[\s\S]*Did you mean/);
  assert.equal(await page.locator(".cm-lintRange-error").textContent(), "turbulense");
  assert.equal(await sum(page), before);
  preview.save(MARBLE.replace("veins = 7", "veins = 2"));
  await picture(page, id);
  await page.locator("#error").waitFor({ state: "hidden" });
  assert.notEqual(await sum(page), before);
}, ...small);

await test("what is typed is drawn, and saved when that is wanted", "color = [1 0 0]\n", async (page, preview) => {
  const id = await shown(page);
  await type(page, "color = [0 1 0]\n");
  await picture(page, id);
  assert.equal(preview.read(), "color = [1 0 0]\n");
  assert.ok(await page.locator("#unsaved").isVisible());
  await page.keyboard.press("Control+s");
  await page.locator("#unsaved").waitFor({ state: "hidden" });
  assert.equal(preview.read(), "color = [0 1 0]\n");
}, ...small);

await test("a file that changes under changes of the page is not lost", "color = [1 0 0]\n", async (page, preview) => {
  await type(page, "color = [0 1 0]\n");
  await page.locator("#unsaved").waitFor();
  preview.save("color = [0 0 1]\n");
  await page.locator("#changed").waitFor();
  assert.match(await page.locator(".cm-content").textContent(), /0 1 0/);
  await page.locator("#take").click();
  await page.waitForFunction(() => document.querySelector(".cm-content").textContent.includes("0 0 1"));
  await page.locator("#changed").waitFor({ state: "hidden" });
}, ...small);

await test("sliders change the picture, and their values can be written back", MARBLE, async (page, preview) => {
  const before = await sum(page);
  let id = await shown(page);
  const slider = page.locator("#param-veins");
  await slider.fill("3");
  id = await picture(page, id);
  assert.notEqual(await sum(page), before);
  const entry = page.getByLabel("veins, any value");
  assert.equal(await entry.inputValue(), "3");
  // Beyond the range, and back to what the program says.
  await entry.fill("40");
  await entry.press("Enter");
  id = await picture(page, id);
  await slider.dblclick();
  await page.waitForFunction(() => document.getElementById("param-veins").value === "7");
  id = await picture(page, id);
  await page.waitForTimeout(300);
  assert.equal(await sum(page), before);
  await entry.fill("12");
  await entry.press("Enter");
  await picture(page, id);
  await page.getByTitle("Write this value of veins into the program").click();
  await page.waitForFunction(() => document.querySelector(".cm-content").textContent.includes("veins = 12 in"));
  await page.locator("#save").click();
  await page.locator("#unsaved").waitFor({ state: "hidden" });
  assert.match(preview.read(), /param veins = 12 in \[0 20\]/);
}, ...small);

await test("a click looks inside a pixel, and sees what pse trace sees", MARBLE, async (page, preview) => {
  await click(page, 80, 20);
  await page.locator("#probe").waitFor();
  const place = (await page.locator("#probe-place").textContent()).match(/\d+/g).map(Number);
  const trace = preview.trace(place);
  const told = await page.locator("#probe-list tr").evaluateAll((rows) => rows.map((row) => row.lastChild.textContent));
  const full = (value) => (Array.isArray(value) ? `[${value.map(full).join(" ")}]` : String(value));
  const assigned = trace.filter(({ event }) => event === "assign").map(({ name, value }) => `${name} = ${full(value)}`);
  assert.ok(assigned.length >= 3);
  assert.deepEqual(told.filter((text) => assigned.includes(text)), assigned);
  const color = trace.find(({ event, name }) => event === "assign" && name === "color");
  const beside = await page.locator(".cm-value").allTextContents();
  assert.ok(beside.includes(`[${color.value.map((x) => Number(x.toPrecision(6))).join(" ")}]`), beside.join(", "));
  // The arrows go to the neighbours.
  await page.locator("#frame-of-canvas").focus();
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction((x) => document.getElementById("probe-place").textContent.startsWith(`[${x} `), place[0] + 1);
}, ...small);

await test("two pages show the same", "param grey = 0.2 in [0 1]\ncolor = white * grey\n", async (page, preview) => {
  const other = await open(browser, preview, { viewport: { width: 390, height: 844 } });
  const id = await shown(other);
  await page.locator("#param-grey").fill("0.9");
  await picture(other, id);
  assert.equal(await other.getByLabel("grey, any value").inputValue(), "0.9");
  await page.waitForTimeout(300);
  assert.equal(await sum(page), await sum(other));
  await type(page, "color = [0.5 0 0]\n");
  await other.waitForFunction(() => document.querySelector(".cm-content").textContent.includes("0.5 0 0"));
  const width = await other.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 390, `the page is ${width} wide`);
  assert.deepEqual(other.faults, []);
  await other.close();
}, ...small);

await test("a server that comes back is found again", "color = [1 0 0]\n", async (page, preview) => {
  const before = await sum(page);
  await preview.stop();
  await page.locator("#gone").waitFor();
  assert.equal(await sum(page), before);
  preview.save("color = [0 0 1]\n");
  await preview.run();
  await page.locator("#gone").waitFor({ state: "hidden" });
  await page.waitForFunction(() => document.querySelector(".cm-content").textContent.includes("0 0 1"));
  await page.waitForTimeout(500);
  assert.notEqual(await sum(page), before);
}, ...small);

await test("outputs, variables, exposure, a pinned picture, frames and keys",
  "half = 0.5 * white\nalpha = 1\ncolor = half * (1 + 0.2 * frame)\n", async (page) => {
  const before = await sum(page);
  let id = await shown(page);
  assert.deepEqual(await page.locator("#outputs button").allTextContents(), ["color", "alpha"]);
  await page.locator("#also").selectOption("half");
  await page.waitForFunction(() => document.querySelectorAll("#outputs button").length === 3);
  await page.locator("#outputs button", { hasText: "alpha" }).click();
  await page.waitForTimeout(200);
  assert.notEqual(await sum(page), before);
  await page.locator("#outputs button", { hasText: "color" }).click();
  await page.waitForTimeout(200);
  assert.equal(await sum(page), before);
  await page.locator("#frame-of-canvas").focus();
  await page.keyboard.press("]");
  await page.keyboard.press("]");
  assert.equal(await page.locator("#exposure-value").textContent(), "1");
  assert.notEqual(await sum(page), before);
  await page.keyboard.press("[");
  await page.keyboard.press("[");
  assert.equal(await sum(page), before);
  // A pinned picture, beside that of another frame.
  await page.keyboard.press("p");
  id = await shown(page);
  await page.keyboard.press(".");
  await picture(page, id);
  const halves = await page.evaluate(() => {
    const canvas = document.getElementById("canvas");
    const at = (x) => canvas.getContext("2d").getImageData(x, 5, 1, 1).data[0];
    return [at(2), at(canvas.width - 3)];
  });
  assert.ok(halves[0] < halves[1], `${halves}`);
  await page.keyboard.press("?");
  assert.ok(await page.locator("#keys").isVisible());
  await page.keyboard.press("Escape");
}, ...small);

await test("completion and explanations come from the language itself", "color = white\n", async (page) => {
  await type(page, "color = turb");
  await page.keyboard.press("Control+Space");
  await page.locator(".cm-tooltip-autocomplete").waitFor();
  assert.match(await page.locator(".cm-tooltip-autocomplete").textContent(), /turbulence/);
  await page.keyboard.press("Escape");
  await type(page, "color = white * fBm(point)\n");
  await page.locator("#error").waitFor({ state: "hidden" });
  const line = await page.locator(".cm-line", { hasText: "fBm" }).boundingBox();
  // A pointer that moves, as hands do.
  for (const x of [90, 120, 150]) await page.mouse.move(line.x + x, line.y + 8, { steps: 3 });
  await page.locator(".cm-doc").waitFor();
  assert.match(await page.locator(".cm-doc").textContent(), /fBm\(/);
}, ...small);

if (pictures) {
  const preview = await Preview.start(MARBLE);
  for (const [name, options] of [
    ["view", {}],
    ["view-dark", { colorScheme: "dark" }],
    ["view-narrow", { viewport: { width: 390, height: 844 } }],
  ]) {
    const page = await open(browser, preview, options);
    await click(page, 320, 126);
    await page.locator("#probe").waitFor();
    await page.waitForTimeout(300);
    await page.screenshot({ path: join(pictures, `${name}.jpg`), type: "jpeg", quality: 88 });
    await page.close();
  }
  await preview.end();
}

await browser.close();
if (failed) process.exit(1);
