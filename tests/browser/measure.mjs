// How long it takes from a save to the picture, and how many pictures a second a slider gives; `UPDATE=1` writes the
// table into docs/performance.md.

import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { Preview, launch, open, picture, root } from "./page.mjs";

const ROUNDS = 20;
const median = (all) => all.sort((a, b) => a - b)[Math.floor(all.length / 2)];
const browser = await launch();
const rows = [];
for (const [name, file] of [["marble", "marble.pse"], ["wrinkled", "wrinkled.pse"]]) {
  const text = readFileSync(join(root, "benches/workloads", file), "utf8");
  for (const size of ["640x480", "1920x1080"]) {
    const preview = await Preview.start(text, "--size", size);
    const page = await open(browser, preview);
    await page.evaluate(() => {
      // Every picture that comes onto the screen, with its time.
      window.all = [];
      let last = null;
      const look = () => {
        if (window.shown !== last) window.all.push(last = window.shown);
        requestAnimationFrame(look);
      };
      look();
    });
    const [first, full] = [[], []];
    for (let round = 0; round < ROUNDS; round++) {
      const id = await page.evaluate(() => window.shown.id);
      const begin = performance.timeOrigin + performance.now();
      preview.save(`${text}# ${round}\n`);
      await picture(page, id);
      const seen = await page.evaluate((id) => window.all.filter((picture) => picture.id > id), id);
      first.push(seen[0].at - begin);
      full.push(seen.find((picture) => picture.full).at - begin);
    }
    // A param that a hand drags for two seconds.
    preview.save(`param drag = 1 in [0 2]\n${text}color = color * drag\n`);
    await page.locator("#param-drag").waitFor();
    const pictures = await page.evaluate(async () => {
      const slider = document.getElementById("param-drag");
      const begin = window.all.length;
      const end = performance.now() + 2000;
      for (let i = 0; performance.now() < end; i++) {
        slider.value = (i % 100) / 50;
        slider.dispatchEvent(new Event("input"));
        await new Promise(requestAnimationFrame);
      }
      return (window.all.length - begin) / 2;
    });
    rows.push([`${name}, ${size}`, median(first).toFixed(0), median(full).toFixed(0), pictures.toFixed(0)]);
    await page.close();
    await preview.end();
  }
}
await browser.close();
const table = [["", "save to first picture, ms", "save to whole picture, ms", "pictures a second while a slider is dragged"],
  ["---", "---", "---", "---"], ...rows].map((row) => `| ${row.join(" | ")} |`).join("\n");
console.log(table);
if (process.env.UPDATE) {
  const path = join(root, "docs/performance.md");
  const [before, rest] = readFileSync(path, "utf8").split("<!-- preview begin -->\n");
  const after = rest.split("<!-- preview end -->")[1];
  writeFileSync(path, `${before}<!-- preview begin -->\n\n${table}\n\n<!-- preview end -->${after}`);
}
