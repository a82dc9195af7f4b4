// The program's text: colours, completion, documentation, what is wrong with it, and a pixel's values beside its lines.

import * as cm from "./codemirror.js";

const { Decoration, EditorView, StateEffect, StateField, WidgetType, tags } = cm;
/** The functions and constants of the language, and its keywords. */
let words = new Set();
let keywords = new Set();
/** Asks the server: completions, and what a name means. */
let ask = async () => null;

/** What colours a word: a line at a time, as the language's words are. */
const redo = new cm.Compartment();
const colour = () => cm.StreamLanguage.define({
  name: "pse",
  token(stream) {
    if (stream.eatSpace()) return null;
    if (stream.match(/^#.*/)) return "comment";
    if (stream.match(/^"(?:[^"\\]|\\.)*"?/)) return "string";
    if (stream.match(/^(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?/)) return "number";
    const name = stream.match(/^[A-Za-z_]\w*/);
    if (name) {
      if (keywords.has(name[0])) return "keyword";
      return words.has(name[0]) ? "standard(variableName)" : "variableName";
    }
    stream.next();
    return "operator";
  },
  tokenTable: { "standard(variableName)": tags.standard(tags.variableName) },
  languageData: { commentTokens: { line: "#" } },
});

const colours = cm.HighlightStyle.define([
  { tag: tags.keyword, color: "var(--word)" },
  { tag: tags.number, color: "var(--number)" },
  { tag: tags.string, color: "var(--text)" },
  { tag: tags.comment, color: "var(--faint)", fontStyle: "italic" },
  { tag: tags.standard(tags.variableName), color: "var(--call)" },
]);

const look = EditorView.theme({
  "&": { color: "var(--ink)", backgroundColor: "var(--panel)" },
  ".cm-content": { caretColor: "var(--ink)", fontFamily: "ui-monospace, monospace" },
  ".cm-cursor": { borderLeftColor: "var(--ink)" },
  ".cm-gutters": { backgroundColor: "var(--panel)", color: "var(--faint)", border: "none" },
  ".cm-activeLine, .cm-activeLineGutter": { backgroundColor: "color-mix(in srgb, var(--ink) 5%, transparent)" },
  "&.cm-focused .cm-selectionBackground, .cm-selectionBackground": {
    backgroundColor: "color-mix(in srgb, var(--accent) 30%, transparent) !important",
  },
  ".cm-tooltip": { backgroundColor: "var(--panel)", color: "var(--ink)", border: "1px solid var(--line)" },
  ".cm-panels": { backgroundColor: "var(--ground)", color: "var(--ink)" },
});

/** Values at the ends of lines. */
class Value extends WidgetType {
  constructor(text) { super(); this.text = text; }
  eq(other) { return other.text === this.text; }
  toDOM() {
    const span = document.createElement("span");
    span.className = "cm-value";
    span.textContent = this.text;
    return span;
  }
  ignoreEvent() { return true; }
}
const setValues = StateEffect.define();
const values = StateField.define({
  create: () => Decoration.none,
  update(old, transaction) {
    for (const effect of transaction.effects) if (effect.is(setValues)) return effect.value;
    // What was true of another text is not shown at this one.
    return transaction.docChanged ? Decoration.none : old;
  },
  provide: (field) => EditorView.decorations.from(field),
});

/** A little of Markdown: code, emphasis, paragraphs. */
function documentation(text) {
  const dom = document.createElement("div");
  dom.className = "cm-doc";
  const escaped = text.replace(/&/g, "&amp;").replace(/</g, "&lt;");
  // Code is taken as it is, and only what stands between has marks.
  dom.innerHTML = escaped.split(/(```\w*\n[\s\S]*?```|`[^`]+`)/).map((part, i) => {
    if (i % 2 === 0) {
      return part
        .replace(/\*([^*\n]+)\*/g, "<em>$1</em>")
        .replace(/\[([^\]]+)\]\([^)]*\)/g, "$1")
        .replace(/\n\n+/g, "<p>");
    }
    const block = part.match(/^```\w*\n([\s\S]*?)```$/);
    return block ? `<pre>${block[1]}</pre>` : `<code>${part.slice(1, -1)}</code>`;
  }).join("");
  return dom;
}

/** What each kind of name is to the editor. */
const KINDS = {
  function: "function", variable: "variable", param: "variable", constant: "constant", input: "property",
  keyword: "keyword", argument: "property", choice: "enum",
};

async function complete(context) {
  if (!context.explicit && !context.matchBefore(/[A-Za-z_]\w*$|"[a-z_]*$/)) return null;
  const found = await ask("complete", { text: context.state.doc.toString(), at: context.pos });
  if (!found || context.aborted) return null;
  return {
    from: found.from,
    options: found.items.map(({ name, kind, detail, documentation: text }) => ({
      label: name, type: KINDS[kind], detail, apply: kind === "argument" ? `${name} = ` : name,
      info: text ? () => documentation(text) : undefined,
    })),
    validFor: /^\w*$/,
  };
}

const hover = cm.hoverTooltip(async (view, at) => {
  const found = await ask("hover", { text: view.state.doc.toString(), at });
  if (!found) return null;
  return { pos: found.from, end: found.to, create: () => ({ dom: documentation(found.text) }) };
});

/** After a line that opens a block the next one is a step further in. */
const OPENS = /^\s*(?:if|else|while|for|function)\b/;
function newline(view) {
  const { state } = view;
  const { from, to } = state.selection.main;
  const line = state.doc.lineAt(from);
  const before = line.text.slice(0, from - line.from);
  const indent = before.match(/^\s*/)[0] + (OPENS.test(before) ? "    " : "");
  view.dispatch({
    changes: { from, to, insert: `\n${indent}` },
    selection: { anchor: from + 1 + indent.length },
    scrollIntoView: true,
    userEvent: "input",
  });
  return true;
}

/** An editor in `parent`: `changed(text)` after each change by hand, `save()` at Ctrl-S; `asks` answers what is asked of
 * the server. */
export function editor(parent, { changed, save, asks }) {
  ask = asks;
  let own = false;
  const view = new EditorView({
    parent,
    extensions: [
      cm.keymap.of([
        { key: "Mod-s", run: () => (save(), true) },
        { key: "Enter", run: newline },
        cm.indentWithTab,
        ...cm.completionKeymap, ...cm.closeBracketsKeymap, ...cm.searchKeymap, ...cm.lintKeymap, ...cm.historyKeymap,
        ...cm.defaultKeymap,
      ]),
      cm.lineNumbers(), cm.highlightActiveLineGutter(), cm.highlightSpecialChars(), cm.history(), cm.drawSelection(),
      cm.highlightActiveLine(), EditorView.lineWrapping, cm.bracketMatching(), cm.closeBrackets(), cm.highlightSelectionMatches(),
      cm.lintGutter(), cm.indentUnit.of("    "), cm.autocompletion({ override: [complete] }), hover,
      redo.of(colour()), cm.syntaxHighlighting(colours), look, values,
      EditorView.contentAttributes.of({ "aria-label": "Program" }),
      EditorView.updateListener.of((update) => {
        if (update.docChanged && !own) changed(update.state.doc.toString());
      }),
    ],
  });
  return {
    view,
    text: () => view.state.doc.toString(),
    /** Takes a text that comes from elsewhere, with as little stir as possible. */
    take(text) {
      const old = view.state.doc.toString();
      if (old === text) return;
      let from = 0;
      while (from < old.length && from < text.length && old[from] === text[from]) from++;
      let [to, end] = [old.length, text.length];
      while (to > from && end > from && old[to - 1] === text[end - 1]) { to--; end--; }
      own = true;
      view.dispatch({ changes: { from, to, insert: text.slice(from, end) } });
      own = false;
    },
    /** What is wrong, as `{ from, to, severity, message }` in characters of the text; all but in places is at the top. */
    wrong(list) {
      const length = view.state.doc.length;
      const within = list.map(({ from, to, severity, message }) => ({
        from: Math.min(from, length), to: Math.min(Math.max(to, from), length), severity, message,
      }));
      view.dispatch(cm.setDiagnostics(view.state, within));
    },
    /** Texts to show at the ends of lines, by the number of the line. */
    values(lines) {
      const { doc } = view.state;
      const widgets = [...lines]
        .filter(([line]) => line >= 1 && line <= doc.lines)
        .sort(([a], [b]) => a - b)
        .map(([line, text]) => Decoration.widget({ widget: new Value(text), side: 1 }).range(doc.line(line).to));
      view.dispatch({ effects: setValues.of(Decoration.set(widgets)) });
    },
    /** Goes to a line. */
    go(line) {
      const at = view.state.doc.line(Math.min(Math.max(line, 1), view.state.doc.lines)).from;
      view.dispatch({ selection: { anchor: at }, effects: EditorView.scrollIntoView(at, { y: "center" }) });
      view.focus();
    },
    /** The words that are known. */
    words(list) {
      words = new Set(list.words);
      keywords = new Set(list.keywords);
      // Colours that were given before are given again.
      view.dispatch({ effects: redo.reconfigure(colour()) });
    },
  };
}
