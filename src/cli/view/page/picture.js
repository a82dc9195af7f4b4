// The picture: half floats from the server become what the screen shows, through exposure and gamma; zoom and pan;
// a pinned picture to compare with; the histogram.

const frame = document.getElementById("frame-of-canvas");
const canvas = document.getElementById("canvas");
const cross = document.getElementById("cross");
const line = document.getElementById("wipe-line");
const histogram = document.getElementById("histogram");

/** Where the picture lies in its frame: screen pixels for one of the picture, and its corner. */
const view = { scale: 1, x: 0, y: 0, fitted: true };
/** What is shown: { width, height, components, halves }, and the size of the whole picture in pixels. */
let shown = null;
let pinned = null;
let whole = [1, 1];
let marked = null;
let exposure = 0;
let gamma = 1;
let wipe = 0.5;

/** The number that sixteen bits stand for. */
function halfToFloat(bits) {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 1023;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}
const FLOATS = Float32Array.from({ length: 65536 }, (_, bits) => halfToFloat(bits));

/** For each half what the screen shows, from 0 to 255. */
const screen = new Uint8ClampedArray(65536);
function expose() {
  const factor = 2 ** exposure;
  for (let bits = 0; bits < 65536; bits++) {
    const x = Math.max(0, FLOATS[bits] * factor) ** (1 / gamma);
    // IEC 61966-2-1.
    screen[bits] = 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
  }
}
expose();

/** Pixels that are no colour are magenta, as nothing else is likely to be. */
function colour(picture, out) {
  const { halves, components: c } = picture;
  const pixels = new Uint32Array(out.data.buffer);
  const bad = (bits) => (bits & 0x7c00) === 0x7c00;
  for (let i = 0, k = 0; i < pixels.length; i++, k += c) {
    const r = halves[k];
    const g = c > 1 ? halves[k + 1] : r;
    const b = c > 2 ? halves[k + 2] : c > 1 ? 0 : r;
    pixels[i] = bad(r) || bad(g) || bad(b)
      ? 0xffff00ff
      : 0xff000000 | (screen[b] << 16) | (screen[g] << 8) | screen[r];
  }
}

function draw() {
  if (!shown) return;
  const { width, height } = shown;
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext("2d", { alpha: false });
  const image = context.createImageData(width, height);
  colour(shown, image);
  context.putImageData(image, 0, 0);
  if (pinned) {
    const other = new OffscreenCanvas(pinned.width, pinned.height);
    const of = other.getContext("2d");
    const old = of.createImageData(pinned.width, pinned.height);
    colour(pinned, old);
    of.putImageData(old, 0, 0);
    const part = Math.round(wipe * pinned.width);
    if (part > 0) {
      context.drawImage(other, 0, 0, part, pinned.height, 0, 0, (part / pinned.width) * width, height);
    }
  }
  place();
  drawHistogram();
}

/** Puts the canvas where the view says. A coarse picture covers the same place as the whole one. */
function place() {
  if (!shown) return;
  if (view.fitted) {
    const { clientWidth: w, clientHeight: h } = frame;
    view.scale = Math.min(w / whole[0], h / whole[1]);
    view.x = (w - whole[0] * view.scale) / 2;
    view.y = (h - whole[1] * view.scale) / 2;
  }
  const [sx, sy] = [(view.scale * whole[0]) / shown.width, (view.scale * whole[1]) / shown.height];
  canvas.style.transform = `translate(${view.x}px, ${view.y}px) scale(${sx}, ${sy})`;
  canvas.classList.toggle("large", view.scale >= 2);
  cross.hidden = !marked;
  if (marked) {
    cross.style.left = `${view.x + (marked[0] + 0.5) * view.scale}px`;
    cross.style.top = `${view.y + (marked[1] + 0.5) * view.scale}px`;
  }
  line.hidden = !pinned;
  line.style.left = `${view.x + wipe * whole[0] * view.scale}px`;
}

/** Shows a picture of so many pixels, which stands for one of `size`. */
export function show(picture, size) {
  shown = picture;
  whole = size;
  draw();
}

export function setExposure(value) { exposure = value; expose(); draw(); }
export function setGamma(value) { gamma = value; expose(); draw(); }
export function setWipe(value) { wipe = value; draw(); }
export function mark(pixel) { marked = pixel; place(); }

/** Keeps what is shown to compare with, or lets go of it; tells which. */
export function pin() {
  pinned = pinned ? null : shown;
  draw();
  return Boolean(pinned);
}

export function fit() { view.fitted = true; place(); }
export function oneToOne() { zoom(1 / window.devicePixelRatio / view.scale); }
export function pan(dx, dy) { view.fitted = false; view.x += dx; view.y += dy; place(); }

/** Zooms by a factor about a place in the frame, its middle if none is given. */
export function zoom(factor, x = frame.clientWidth / 2, y = frame.clientHeight / 2) {
  const to = Math.min(64, Math.max(0.02, view.scale * factor));
  view.x = x - ((x - view.x) * to) / view.scale;
  view.y = y - ((y - view.y) * to) / view.scale;
  view.scale = to;
  view.fitted = false;
  place();
}

/** The pixel of the whole picture at a place on the page, or null. */
export function pixelAt(clientX, clientY) {
  const box = frame.getBoundingClientRect();
  const x = Math.floor((clientX - box.left - view.x) / view.scale);
  const y = Math.floor((clientY - box.top - view.y) / view.scale);
  return x >= 0 && y >= 0 && x < whole[0] && y < whole[1] ? [x, y] : null;
}

/** What the shown picture holds at a pixel of the whole one. */
export function valueAt([x, y]) {
  if (!shown) return [];
  const column = Math.min(shown.width - 1, Math.floor((x * shown.width) / whole[0]));
  const row = Math.min(shown.height - 1, Math.floor((y * shown.height) / whole[1]));
  const start = (row * shown.width + column) * shown.components;
  return Array.from(shown.halves.subarray(start, start + shown.components), (bits) => FLOATS[bits]);
}

function drawHistogram() {
  const context = histogram.getContext("2d");
  const { clientWidth: w, clientHeight: h } = histogram;
  const dense = window.devicePixelRatio;
  [histogram.width, histogram.height] = [w * dense, h * dense];
  context.scale(dense, dense);
  const { halves, components } = shown;
  const channels = Math.min(components, 3);
  let [least, most] = [Infinity, -Infinity];
  // Every pixel of small pictures; of large ones enough to see their shape.
  const step = Math.max(1, Math.floor(halves.length / components / 200000)) * components;
  for (let i = 0; i < halves.length; i += step) {
    for (let c = 0; c < channels; c++) {
      const x = FLOATS[halves[i + c]];
      if (Number.isFinite(x)) { least = Math.min(least, x); most = Math.max(most, x); }
    }
  }
  if (!(least <= most)) return;
  const span = most - least || 1;
  // Where all three are, it is white.
  context.globalCompositeOperation = "lighter";
  const colours = channels > 1 ? ["#a03030", "#30a030", "#3030a0"] : ["#989ca6"];
  for (let c = 0; c < channels; c++) {
    const bins = new Float64Array(256);
    for (let i = 0; i < halves.length; i += step) {
      const x = FLOATS[halves[i + c]];
      if (Number.isFinite(x)) bins[Math.min(255, Math.floor(((x - least) / span) * 256))]++;
    }
    // A background of one colour would press all else to the ground.
    const top = bins.toSorted()[250] || Math.max(...bins);
    context.fillStyle = colours[c];
    bins.forEach((n, i) => {
      const tall = Math.min(1, Math.sqrt(n / top)) * (h - 14);
      context.fillRect((i * w) / 256, h - tall, w / 256, tall);
    });
  }
  context.globalCompositeOperation = "source-over";
  context.fillStyle = "#989ca6";
  context.font = "11px system-ui";
  context.textAlign = "left";
  context.fillText(least.toPrecision(4), 4, 11);
  context.textAlign = "right";
  context.fillText(most.toPrecision(4), w - 4, 11);
}

new ResizeObserver(place).observe(frame);
new ResizeObserver(() => shown && drawHistogram()).observe(histogram);
