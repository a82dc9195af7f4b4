//! A trace as text: a line for each event, in columns.

use crate::cli::prints;
use pse::internal::diagnostic::Span;
use pse::internal::eval::{Birth, Event, EventKind, NotFinite, Printed, Trace};
use pse::internal::program::Program;
use pse::internal::value::PixelValue;
use pse::internal::visible::{visible, visible_name};

/// Columns of the source's text at most.
const WIDEST: usize = 44;

/// A trace, and what it is one of.
pub(super) struct About<'a> {
    pub trace: &'a Trace,
    pub program: &'a Program,
    /// The program's name in messages.
    pub name: &'a str,
    pub frame: f32,
}

/// A line before its columns are aligned.
struct Row {
    line: String,
    rounds: String,
    source: String,
    what: String,
    /// Does it tell of NaN or infinity?
    odd: bool,
    /// Is it one of those that say little?
    faint: bool,
}

/// The trace as text.
pub(super) fn text(about: &About<'_>, limit: usize, color: bool) -> String {
    let mut rows: Vec<Row> = Vec::new();
    let mut before: Option<(Span, u32)> = None;
    for event in &about.trace.events {
        let mut row = row(about, event, limit);
        // A line that stands there already is not told twice in a row.
        let placed = !matches!(event.kind, EventKind::Input { .. } | EventKind::Omitted { .. });
        let here = placed.then(|| (first_line(about, event.span), event.depth));
        if here.is_some() && here == before {
            (row.line, row.source) = Default::default();
        }
        before = here;
        row.source = visible_name(&row.source).into_owned();
        row.what = visible(&row.what).into_owned();
        row.line = visible_name(&row.line).into_owned();
        rows.push(row);
    }
    let width = |of: fn(&Row) -> &str| rows.iter().map(|r| of(r).chars().count()).max().unwrap_or(0);
    let (line, rounds, source) =
        (width(|r| &r.line).max(4), width(|r| &r.rounds), width(|r| &r.source).max(6));
    let paint = |text: String, code: &str| match color {
        // Colours come last: what is hidden in the text itself is shown.
        true if !text.trim().is_empty() && code != "0" => format!("\x1b[{code}m{}\x1b[0m", visible(&text)),
        _ => visible(&text).into_owned(),
    };
    let [x, y] = about.trace.pixel;
    let name = visible_name(about.name);
    let mut out = format!("pixel {x},{y} of {name}, frame {}\n\n", about.frame);
    let gap = if rounds > 0 { "  " } else { "" };
    // Without loops there is no column of rounds.
    let rounds = if rounds > 0 { rounds.max(5) } else { 0 };
    let heading = format!(
        "{:>line$}{gap}{:rounds$}  {:source$}  what happens",
        "line",
        &"round"[..rounds.min(5)],
        "source"
    );
    out += &paint(heading, "2");
    out.push('\n');
    for row in &rows {
        let code = match row {
            Row { odd: true, .. } => "31",
            Row { faint: true, .. } => "2",
            _ => "0",
        };
        let place = format!("{:>line$}{gap}{:rounds$}", row.line, row.rounds);
        let told =
            format!("{}  {:source$}  {}", paint(place, "2"), row.source, paint(row.what.clone(), code));
        out += told.trim_end();
        out.push('\n');
    }
    out + &end(about, &paint)
}

/// What the outputs hold, and where NaN and infinity come from.
fn end(about: &About<'_>, paint: &dyn Fn(String, &str) -> String) -> String {
    let mut out = String::new();
    let written = |name: &str| matches!(name, "color" | "alpha");
    let values = &about.trace.values;
    let colored = values.iter().any(|(name, _)| name == "color");
    for (name, value) in values.iter().filter(|(name, _)| !colored || written(name)) {
        let code = if NotFinite::of(value).is_some() { "31" } else { "1" };
        out += &format!("{}\n", paint(format!("{name} = {value}"), code));
    }
    for birth in &about.trace.births {
        out += &format!("{}\n", paint(born(about, birth), "31"));
    }
    if out.is_empty() { out } else { format!("\n{out}") }
}

/// Where NaN or an infinity came up.
fn born(about: &About<'_>, birth: &Birth) -> String {
    let sources = about.program.sources();
    let text = |span: Span| one_line(sources.text(span));
    let what = match birth.what {
        NotFinite::Nan => "NaN",
        NotFinite::Infinity => "infinity",
    };
    let came = if birth.given { "came with" } else { "came from" };
    let place = prints::line(birth.span, sources);
    let mut out = format!("the first {what} {came} `{}` in line {place}", text(birth.span));
    if !birth.rounds.is_empty() {
        out += &format!(", round {}", rounds(&birth.rounds));
    }
    out += &format!(": it is {}", birth.value);
    let operands: Vec<String> =
        birth.operands.iter().map(|(span, value)| format!("{} = {value}", text(*span))).collect();
    if !operands.is_empty() {
        out += &format!(", with {}", operands.join(", "));
    }
    for (name, span) in &birth.calls {
        out += &format!("\n    in a call of {name}(), line {}", prints::line(*span, sources));
    }
    out
}

/// A text that may go over several lines, in one.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn rounds(rounds: &[u32]) -> String {
    rounds.iter().map(u32::to_string).collect::<Vec<_>>().join(".")
}

/// The line that a span begins in.
fn first_line(about: &About<'_>, span: Span) -> Span {
    let text = &about.program.sources().get(span.source).text;
    let start = text.get(..span.start as usize).and_then(|t| t.rfind('\n')).map_or(0, |i| i + 1);
    let end = text.get(start..).and_then(|t| t.find('\n')).map_or(text.len(), |i| start + i);
    Span::new(span.source, start, end)
}

fn row(about: &About<'_>, event: &Event, limit: usize) -> Row {
    let sources = about.program.sources();
    let (number, _) = sources.line_column(event.span);
    let line = match event.span.source.0 {
        0 => number.to_string(),
        _ => {
            let name = &sources.get(event.span.source).name;
            format!("{}:{number}", name.rsplit('/').next().unwrap_or(name))
        }
    };
    let code = sources.text(first_line(about, event.span)).trim_end();
    let code = format!("{}{code}", "  ".repeat(event.depth as usize));
    let mut source: String = code.chars().take(WIDEST).collect();
    if source.len() < code.len() {
        source.pop();
        source.push('…');
    }
    let (what, odd) = told(about, event);
    let mut row = Row { line, rounds: rounds(&event.rounds), source, what, odd, faint: false };
    match &event.kind {
        EventKind::Input { .. } => (row.line, row.source) = (String::new(), "(input)".into()),
        EventKind::Omitted { events } => {
            row.what = format!("… {events} events omitted (--limit {limit})");
            (row.line, row.source, row.rounds) = Default::default();
        }
        EventKind::Branch { taken: false, .. } | EventKind::LoopEnd { .. } => row.faint = true,
        _ => {}
    }
    row
}

/// An event in words, and whether it holds NaN or infinity.
fn told(about: &About<'_>, event: &Event) -> (String, bool) {
    let holds = |value: &PixelValue| NotFinite::of(value).is_some();
    let named = |name: &str, value: &PixelValue| (format!("{name} = {value}"), holds(value));
    let frame = |(text, odd): (String, bool)| (format!("{text}  (once a frame)"), odd);
    match &event.kind {
        EventKind::Input { name, value } => named(name, value),
        EventKind::Param { name, value, set: false } => named(name, value),
        EventKind::Param { name, value, set: true } => (format!("{name} = {value}  (set)"), holds(value)),
        EventKind::Assign { name, value, kept } if *kept || event.frame => frame(named(name, value)),
        EventKind::Assign { name, value, .. } => named(name, value),
        EventKind::Kept { value } => frame(named(&one_line(about.program.sources().text(event.span)), value)),
        EventKind::Value { value } => (value.to_string(), holds(value)),
        EventKind::Branch { value, taken: true } => (format!("yes ({value})"), false),
        EventKind::Branch { value, taken: false } => (format!("no ({value})"), false),
        EventKind::Round { element: None } => ("a round begins".into(), false),
        EventKind::Round { element: Some((name, value)) } => named(name, value),
        EventKind::LoopEnd { rounds: 1 } => ("ends after 1 round".into(), false),
        EventKind::LoopEnd { rounds } => (format!("ends after {rounds} rounds"), false),
        EventKind::Break => ("leaves the loop".into(), false),
        EventKind::Continue => ("on to the next round".into(), false),
        EventKind::Return { value } => (format!("returns {value}"), holds(value)),
        EventKind::Call { name, arguments, result } => {
            let list: Vec<String> =
                arguments.iter().map(|(name, value)| format!("{name} = {value}")).collect();
            let call = format!("{name}({})", list.join(", "));
            match result {
                Some(value) => (format!("{call} gives {value}"), holds(value)),
                None => (call, false),
            }
        }
        EventKind::Print { parts } => {
            let printed = Printed { pixel: None, span: event.span, parts: parts.clone() };
            (format!("print: {printed}"), false)
        }
        EventKind::Omitted { .. } => Default::default(),
    }
}
