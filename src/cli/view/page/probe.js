// What happened at a pixel: all of it in a list, and the values beside the lines of the program.

const panel = document.getElementById("probe");
const list = document.getElementById("probe-list");
const where = document.getElementById("probe-place");

/** Six digits are enough to read; the list has them all. */
function short(value) {
  if (Array.isArray(value)) return `[${value.map(short).join(" ")}]`;
  return typeof value === "number" ? String(Number(value.toPrecision(6))) : String(value);
}
function full(value) {
  return Array.isArray(value) ? `[${value.map(full).join(" ")}]` : String(value);
}

/** An event in words. */
function words(event) {
  const of = (name, value) => `${name} = ${full(value)}`;
  switch (event.event) {
    case "input": case "param": case "assign": return of(event.name, event.value);
    case "branch": return `${event.text} is ${full(event.value)}: ${event.taken ? "taken" : "not taken"}`;
    case "round": return event.name ? `round ${event.rounds.at(-1)}: ${of(event.name, event.value)}` : `round ${event.rounds.at(-1)}`;
    case "loop_end": return `${event.count} rounds`;
    case "return": return `return ${full(event.value)}`;
    case "call": return `${event.name}(${event.arguments.map((a) => of(a.name, a.value)).join(", ")})`
      + (event.value === null ? "" : ` = ${full(event.value)}`);
    case "print": return event.parts.map((part) => part.text ?? full(part.value)).join(" ");
    case "kept": case "value": return `${event.text} = ${full(event.value)}`;
    case "omitted": return `… ${event.count} events are left out …`;
    case "birth": return `first ${event.what}: ${event.text} = ${full(event.value)}`;
    case "error": return event.message;
    default: return event.event;
  }
}

/** Shows a trace as `pse trace --json` gives it, or why there is none. */
export function probe(events, [x, y], code, failure) {
  panel.hidden = false;
  where.textContent = `[${x} ${y}]`;
  if (!events) {
    list.textContent = failure;
    code.values(new Map());
    return;
  }
  const program = events.find(({ event }) => event === "pixel")?.program;
  const lines = new Map();
  // What is looked for most comes first.
  const born = ({ event }) => event === "birth" || event === "error";
  events = [...events.filter(born), ...events.filter((event) => !born(event))];
  const rows = [];
  let unfold = null;
  for (const event of events) {
    if (event.event === "pixel" || event.event === "result") continue;
    const own = event.source === program;
    const depth = event.depth ?? 0;
    if (own && depth === 0) {
      if (event.event === "assign" || event.event === "param") lines.set(event.line, short(event.value));
      if (event.event === "branch" && !lines.has(event.line)) lines.set(event.line, event.taken ? "taken" : "not taken");
      if (event.event === "print") lines.set(event.line, words(event));
    } else if (own && (event.event === "assign" || event.event === "return")) {
      // Of a function that is called several times, the last call.
      lines.set(event.line, short(event.value));
    }
    const row = document.createElement("tr");
    const [line, what] = [document.createElement("td"), document.createElement("td")];
    line.textContent = own ? event.line ?? "" : "";
    what.textContent = words(event);
    what.style.paddingLeft = `${0.7 + depth * 1.2}em`;
    if (event.event === "birth" || event.event === "error") row.className = "bad";
    if (event.rounds?.length) row.title = `round ${event.rounds.join(", ")}`;
    if (own && event.line) row.addEventListener("click", () => code.go(event.line));
    // What happens in a call is folded away until the call is clicked.
    if (depth > 0) {
      row.hidden = true;
      unfold?.push(row);
    }
    if (event.event === "call" && depth === 0) {
      const inner = [];
      unfold = inner;
      what.prepend("▸ ");
      row.addEventListener("click", () => {
        inner.forEach((other) => { other.hidden = !other.hidden; });
        what.firstChild.textContent = inner[0]?.hidden === false ? "▾ " : "▸ ";
      });
    }
    row.append(line, what);
    rows.push(row);
  }
  const table = document.createElement("table");
  table.append(...rows);
  list.replaceChildren(table);
  code.values(lines);
}
