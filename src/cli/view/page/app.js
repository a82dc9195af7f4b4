// The page of `pse view`: what the server tells goes to its part, what the hand does goes to the server.

import { client, get, hear, post } from "./server.js";
import { editor } from "./editor.js";
import { params } from "./params.js";
import * as picture from "./picture.js";
import { probe } from "./probe.js";

const $ = (id) => document.getElementById(id);
/** The newest state that the server told, the newest picture, and the output that is shown. */
let state = null;
let newest = null;
let output = null;
let wanted = 0;
let place = null;
/** Of which state of the file the text here was made. */
let saves = 0;

const tell = (text) => { $("status").textContent = text; };
const failed = (error) => tell(String(error.message ?? error).trim());
/** Sends something, and tells whether it arrived. */
const send = (path, values) => post(path, values).then(() => true, (error) => { failed(error); return false; });

/** Sends the last of quickly following values, one at a time; `done` when there are no more. */
function latest(path, done = () => {}) {
  let [busy, next] = [false, null];
  const go = async () => {
    busy = true;
    let arrived = true;
    while (next) {
      const values = next;
      next = null;
      arrived = await send(path, values);
    }
    busy = false;
    done(arrived);
  };
  return (values) => { next = values; if (!busy) go(); };
}
/** Is there text here that the server does not know yet? What it tells is then older than what is here. */
let unsent = false;
let typing = 0;
const sendText = latest("text", (arrived) => { unsent = typing !== 0 || !arrived; });
const sendFrame = latest("frame");
const setters = new Map();
function setParam(name, value) {
  if (!setters.has(name)) setters.set(name, latest("set"));
  setters.get(name)({ name, value });
}

const code = editor($("editor"), {
  changed(text) {
    clearTimeout(typing);
    unsent = true;
    typing = setTimeout(() => { typing = 0; sendText({ text, saves }); }, 60);
    $("unsaved").hidden = false;
  },
  save,
  // What cannot be asked is not worth a message: there are just no hints.
  asks: (path, values) => post(path, values).then((answer) => answer.json()).catch(() => null),
});
function save() {
  clearTimeout(typing);
  typing = 0;
  unsent = true;
  send("save", { text: code.text(), saves }).then((arrived) => {
    unsent = !arrived;
    if (arrived) tell("saved");
  });
}

// What the server tells.
const handlers = {
  state(told) {
    const first = state === null;
    state = told;
    document.title = `${told.name} - pse view`;
    $("name").textContent = told.name;
    $("unsaved").hidden = told.saved;
    $("changed").hidden = !told.conflict;
    // What was written while the server was away.
    if (unsent && !typing) sendText({ text: code.text(), saves });
    if (!unsent && (first || told.from !== client)) code.take(told.text);
    // While there is a conflict, what is here is still of the old state.
    if (!unsent && !told.conflict) saves = told.saves;
    if (!told.error) drawing();
    variables(told);
    params(told.params, setParam, (name) => send("write", { name }));
    $("time").hidden = !told.animated;
    if (document.activeElement !== $("frame-number")) $("frame-number").value = told.frame;
    if (document.activeElement !== $("frame")) $("frame").value = told.frame;
    wrong(told.error);
  },
  async picture(told) {
    if (told.full) clearTimeout(waiting);
    newest = told;
    outputs(told.outputs);
    await fetchPicture();
    if (told.full) {
      const { milliseconds, pixels, odd } = told;
      const each = ((milliseconds * 1e6) / pixels).toPrecision(3);
      const bad = odd ? `, NaN or infinite at ${odd} pixels` : "";
      tell(`${told.size[0]}x${told.size[1]}, ${milliseconds.toFixed(1)} ms, ${each} ns/pixel${bad}`);
      $("progress").hidden = true;
      if (place) look(place);
      playOn();
    }
  },
  progress({ done, total }) {
    $("progress").hidden = false;
    $("progress").style.width = `${(100 * done) / total}%`;
  },
};

/** If it takes a while, the picture on the screen is an old one. */
let waiting = 0;
function drawing() {
  clearTimeout(waiting);
  waiting = setTimeout(() => tell("drawing…"), 300);
}

/** Shows what is wrong where it is; the picture stays. */
function wrong(error) {
  $("error").hidden = !error;
  $("error").textContent = error ? error.rendered : "";
  code.wrong(error ? error.places : []);
  if (error) {
    clearTimeout(waiting);
    if (newest) tell("showing the last good picture");
    $("progress").hidden = true;
  }
}

async function fetchPicture() {
  const told = newest;
  if (!told) return;
  const of = told.outputs.find(({ name }) => name === output) ?? told.outputs[0];
  if (!of) return;
  const turn = ++wanted;
  try {
    const answer = await get("picture", { id: told.id, output: of.name });
    const halves = new Uint16Array(await answer.arrayBuffer());
    if (turn !== wanted) return;
    const [width, height] = told.coarse;
    picture.show({ width, height, components: of.components, halves }, told.size);
    under();
    // For who measures: what is on the screen since when.
    window.shown = { id: told.id, full: told.full, text: told.text, at: performance.timeOrigin + performance.now() };
  } catch (error) {
    // A newer picture is on its way if this one is gone.
    if (turn === wanted && newest === told) failed(error);
  }
}

function outputs(list) {
  if (!list.some(({ name }) => name === output)) output = list[0]?.name ?? null;
  const tabs = $("outputs");
  tabs.replaceChildren(...list.map(({ name, shape }) => {
    const tab = document.createElement("button");
    tab.textContent = name;
    tab.title = shape;
    tab.role = "tab";
    tab.setAttribute("aria-selected", name === output);
    tab.addEventListener("click", () => choose(name));
    return tab;
  }));
}
/** Variables that may be shown beside the outputs. */
function variables({ assigned, inputs, also }) {
  const names = [...new Set([...assigned, ...inputs, ...also])];
  $("also").hidden = names.length === 0;
  $("also").replaceChildren(new Option("variables…", ""), ...names.map((name) =>
    new Option(also.includes(name) ? `hide ${name}` : name, name)));
}
$("also").addEventListener("change", () => {
  const name = $("also").value;
  if (!state.also.includes(name)) output = name;
  send("show", { name });
});
function choose(name) {
  output = name;
  for (const tab of $("outputs").children) tab.setAttribute("aria-selected", tab.textContent === name);
  fetchPicture();
}

/** Looks inside a pixel. */
async function look(pixel) {
  place = pixel;
  picture.mark(pixel);
  try {
    const answer = await get("probe", { x: pixel[0], y: pixel[1] });
    probe(await answer.json(), pixel, code);
  } catch (error) {
    probe(null, pixel, code, String(error.message ?? error));
  }
}

// The tools.
const range = (id, use) => {
  const slider = $(id);
  const set = (value) => { slider.value = value; use(Number(slider.value)); };
  slider.addEventListener("input", () => use(Number(slider.value)));
  return set;
};
const setExposure = range("exposure", (x) => { picture.setExposure(x); $("exposure-value").value = x; });
const setGamma = range("gamma", (x) => { picture.setGamma(x); $("gamma-value").value = x; });
const setWipe = range("wipe", picture.setWipe);
$("exposure").addEventListener("dblclick", () => setExposure(0));
$("gamma").addEventListener("dblclick", () => setGamma(1));
function pin() {
  const pinned = picture.pin();
  $("pin").setAttribute("aria-pressed", pinned);
  $("wipe-label").hidden = !pinned;
}
$("pin").addEventListener("click", pin);
$("fit").addEventListener("click", picture.fit);
$("one").addEventListener("click", picture.oneToOne);
$("save").addEventListener("click", save);
$("take").addEventListener("click", () => send("take", {}));
$("keep").addEventListener("click", () => {
  saves = state.saves;
  sendText({ text: code.text(), saves });
  send("keep", {});
});
$("help").addEventListener("click", () => $("keys").showModal());

// The pointer on the picture: a click looks inside a pixel, dragging moves it, the wheel zooms, two fingers do both.
const frame = $("frame-of-canvas");
let pointer = null;
/** What the picture holds under the pointer. */
function under() {
  const at = pointer && picture.pixelAt(...pointer);
  const values = at && picture.valueAt(at).map((x) => x.toPrecision(3)).join(" ");
  $("under").textContent = at ? `[${at.join(" ")}] ${values}` : "";
}
const pointers = new Map();
let moved = 0;
frame.addEventListener("pointerdown", (event) => {
  frame.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  if (pointers.size === 1) moved = 0;
});
frame.addEventListener("pointermove", (event) => {
  pointer = [event.clientX, event.clientY];
  under();
  const before = pointers.get(event.pointerId);
  if (!before) return;
  const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
  moved += Math.hypot(dx, dy);
  if (pointers.size === 2) {
    const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
    const far = (x, y) => Math.hypot(x - other[0], y - other[1]) || 1;
    const box = frame.getBoundingClientRect();
    picture.zoom(far(event.clientX, event.clientY) / far(...before), other[0] - box.left, other[1] - box.top);
  } else if (moved > 4) {
    picture.pan(dx, dy);
  }
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
});
const release = (event) => {
  const alone = pointers.size === 1;
  if (!pointers.delete(event.pointerId) || event.type === "pointercancel") return;
  const at = picture.pixelAt(event.clientX, event.clientY);
  if (alone && moved <= 4 && at) look(at);
};
frame.addEventListener("pointerup", release);
frame.addEventListener("pointercancel", release);
frame.addEventListener("wheel", (event) => {
  event.preventDefault();
  const box = frame.getBoundingClientRect();
  picture.zoom(1.0015 ** -event.deltaY, event.clientX - box.left, event.clientY - box.top);
}, { passive: false });

// Frames.
let playing = false;
function setFrame(number) {
  if (!Number.isFinite(number)) return;
  $("frame").value = number;
  $("frame-number").value = number;
  sendFrame({ frame: number });
}
/** The next frame when the last one is shown, no faster than a film. */
function playOn() {
  if (!playing) return;
  const last = Number($("frame-last").value);
  setTimeout(() => playing && setFrame(state.frame >= last ? 0 : state.frame + 1), 1000 / 24);
}
function play() {
  playing = !playing;
  $("play").textContent = playing ? "Stop" : "Play";
  $("play").setAttribute("aria-pressed", playing);
  playOn();
}
$("play").addEventListener("click", play);
$("frame").addEventListener("input", () => setFrame(Number($("frame").value)));
$("frame-number").addEventListener("change", () => setFrame(Number($("frame-number").value)));
$("frame-last").addEventListener("change", () => { $("frame").max = $("frame-last").value; });

// Keys, where nothing is typed.
const step = (by) => {
  const tabs = [...$("outputs").children];
  const i = tabs.findIndex((tab) => tab.textContent === output);
  if (tabs.length) choose(tabs[(i + by + tabs.length) % tabs.length].textContent);
};
const KEYS = [
  ["0", "the whole picture", picture.fit],
  ["1", "a pixel for a pixel", picture.oneToOne],
  ["+", "nearer", () => picture.zoom(1.25)],
  ["-", "further", () => picture.zoom(0.8)],
  ["[", "darker", () => setExposure(Number($("exposure").value) - 0.5)],
  ["]", "brighter", () => setExposure(Number($("exposure").value) + 0.5)],
  ["{", "less gamma", () => setGamma(Number($("gamma").value) - 0.1)],
  ["}", "more gamma", () => setGamma(Number($("gamma").value) + 0.1)],
  ["p", "pin this picture, or let it go", pin],
  ["<", "wipe to the left", () => setWipe(Number($("wipe").value) - 0.05)],
  [">", "wipe to the right", () => setWipe(Number($("wipe").value) + 0.05)],
  ["n", "the next output", () => step(1)],
  ["N", "the output before", () => step(-1)],
  [" ", "play, or stop", play],
  [",", "a frame back", () => setFrame(state.frame - 1)],
  [".", "a frame on", () => setFrame(state.frame + 1)],
  ["e", "into the program", () => code.view.focus()],
  ["?", "these keys", () => $("keys").showModal()],
];
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
document.addEventListener("keydown", (event) => {
  if ((event.ctrlKey || event.metaKey) && event.key === "s") { event.preventDefault(); save(); return; }
  const typed = event.target.closest("input:not([type=range]), .cm-editor, dialog");
  if (event.key === "Escape" && event.target.closest(".cm-editor") && !event.defaultPrevented) frame.focus();
  if (typed || event.ctrlKey || event.metaKey || event.altKey) return;
  const arrow = ARROWS[event.key];
  if (arrow && event.target === frame) {
    event.preventDefault();
    // The arrows move the pixel that is looked into; with shift by ten.
    const by = event.shiftKey ? 10 : 1;
    const [w, h] = newest?.size ?? [1, 1];
    const [x, y] = place ?? [w >> 1, h >> 1];
    const clamp = (v, n) => Math.min(n - 1, Math.max(0, v));
    look([clamp(x + arrow[0] * by, w), clamp(y + arrow[1] * by, h)]);
    return;
  }
  if (event.key === " " && event.target.closest("button, summary")) return;
  const key = KEYS.find(([key]) => key === event.key);
  if (key) { event.preventDefault(); key[2](); }
});
$("key-list").replaceChildren(...[...KEYS, ["arrows", "move the pixel that is looked into, with Shift by ten"],
  ["Ctrl-S", "write the file"], ["Esc", "out of the program, to the picture"]].flatMap(([key, what]) => {
  const [dt, dd] = [document.createElement("dt"), document.createElement("dd")];
  dt.textContent = key === " " ? "space" : key;
  dd.textContent = what;
  return [dt, dd];
}));

get("words").then((answer) => answer.json()).then(code.words).catch(failed);
hear(handlers, (gone) => { $("gone").hidden = !gone; });
