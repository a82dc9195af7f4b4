// Params as sliders, with entry of any number beside them.

const list = document.getElementById("param-list");
const panel = document.getElementById("params");
/** The inputs of each param by its name. */
let rows = new Map();
let signature = "";

/** What a slider can reach: the range that the program states, else one about the value. */
function reach({ value, range }) {
  if (range) return range;
  const size = Math.abs(value) || 1;
  return value < 0 ? [-2 * size, 2 * size] : [0, 2 * size];
}

const shownNumber = (x) => String(Math.fround(x) === x ? Number(x.toPrecision(7)) : x);

/** Shows these params; `set(name, text)` sets one to an expression, `null` to what the program says; `write(name)` writes
 * its value into the program. */
export function params(all, set, write) {
  panel.hidden = all.length === 0;
  const now = JSON.stringify(all.map(({ name, default: d, range, text }) => [name, d, range, typeof text]));
  if (now !== signature) build(all, set, write);
  signature = now;
  for (const param of all) {
    const { slider, entry, label, back } = rows.get(param.name);
    label.classList.toggle("changed", param.changed);
    back.disabled = !param.changed;
    // Nothing jumps under the hand that moves it.
    if (slider && document.activeElement !== slider) slider.value = param.value;
    if (document.activeElement !== entry) entry.value = param.text;
  }
}

function build(all, set, write) {
  rows = new Map();
  list.replaceChildren();
  for (const param of all) {
    const { name } = param;
    const label = document.createElement("label");
    label.textContent = name;
    label.htmlFor = `param-${name}`;
    label.title = `${name}; double-click: what the program says`;
    label.addEventListener("dblclick", () => set(name, null));
    let slider = null;
    if (typeof param.value === "number") {
      slider = document.createElement("input");
      slider.type = "range";
      [slider.min, slider.max] = reach(param);
      slider.step = "any";
      slider.id = `param-${name}`;
      slider.value = param.value;
      slider.addEventListener("input", () => {
        const text = shownNumber(Number(Number(slider.value).toPrecision(4)));
        entry.value = text;
        set(name, text);
      });
      slider.addEventListener("dblclick", () => {
        // It goes where the program says.
        slider.blur();
        set(name, null);
      });
    }
    const entry = document.createElement("input");
    entry.type = "text";
    entry.value = param.text;
    entry.spellcheck = false;
    entry.setAttribute("aria-label", `${name}, any value`);
    entry.addEventListener("change", () => set(name, entry.value));
    const back = document.createElement("button");
    back.textContent = "Write back";
    back.title = `Write this value of ${name} into the program`;
    back.addEventListener("click", () => write(name));
    list.append(label, slider ?? document.createElement("span"), entry, back);
    rows.set(name, { slider, entry, label, back });
  }
}
