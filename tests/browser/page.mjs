// What the tests and the measurements have in common: a server with a program of its own, and a page in Chromium.

import { spawn, execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const pse = process.env.PSE ?? join(root, "target/release/pse");
/** How long anything may take. */
const PATIENCE = 20_000;

/** A port that was free a moment ago. */
async function freePort() {
  const server = createServer();
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  const { port } = server.address();
  await new Promise((done) => server.close(done));
  return port;
}

/** `pse view` on a program in a folder of its own. */
export class Preview {
  static async start(text, ...args) {
    const preview = new Preview();
    preview.folder = mkdtempSync(join(tmpdir(), "pse-view-"));
    preview.name = "program.pse";
    preview.file = join(preview.folder, preview.name);
    preview.args = args;
    preview.port = await freePort();
    writeFileSync(preview.file, text);
    await preview.run();
    return preview;
  }

  async run() {
    const env = { ...process.env, XDG_STATE_HOME: this.folder };
    this.process = spawn(pse, ["view", this.name, "--port", String(this.port), ...this.args], { cwd: this.folder, env });
    this.process.stderr.pipe(process.stderr);
    this.address = await new Promise((done, fail) => {
      this.process.stdout.once("data", (line) => done(String(line).trim()));
      this.process.once("exit", (code) => fail(new Error(`pse view ended with ${code}`)));
    });
  }

  async stop() {
    const ended = new Promise((done) => this.process.once("exit", done));
    this.process.kill("SIGINT");
    await ended;
  }

  async end() {
    await this.stop();
    rmSync(this.folder, { recursive: true });
  }

  read() { return readFileSync(this.file, "utf8"); }

  /** Saves as editors do: a new file takes the name of the old one. */
  save(text) {
    const other = join(this.folder, ".program.pse.new");
    writeFileSync(other, text);
    renameSync(other, this.file);
  }

  /** What `pse trace` tells of a pixel. */
  trace([x, y]) {
    const args = ["trace", this.name, "--pixel", `${x},${y}`, "--calls", "--json", ...this.args];
    return JSON.parse(execFileSync(pse, args, { cwd: this.folder, maxBuffer: 1 << 28, stdio: ["ignore", "pipe", "ignore"] }));
  }
}

export const launch = () => chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  // Without a user's name spaces, as in a container, Chromium has no sandbox. The page is ours.
  args: ["--no-sandbox", "--no-proxy-server"],
});

/** A page of the preview, which fails at any error in its scripts. */
export async function open(browser, preview, options = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, colorScheme: "light", ...options });
  page.setDefaultTimeout(PATIENCE);
  page.faults = [];
  page.on("pageerror", (error) => page.faults.push(error.message));
  page.on("console", (message) => {
    // A server that is gone is one of the tests.
    if (message.type() === "error" && !message.text().includes("ERR_")) page.faults.push(message.text());
  });
  await page.goto(preview.address);
  await picture(page);
  return page;
}

/** Waits for a whole picture that is newer than this one, and gives its number. */
export async function picture(page, after = 0) {
  const found = await page.waitForFunction((id) => window.shown?.full && window.shown.id > id && window.shown.id, after);
  return found.jsonValue();
}

/** A number that is another one for another picture on the screen. */
export const sum = (page) => page.evaluate(() => {
  const canvas = document.getElementById("canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let hash = 0;
  for (const byte of data) hash = (Math.imul(hash, 31) + byte) | 0;
  return hash;
});
