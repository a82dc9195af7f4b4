//! A trace as JSON: an array of events, one a line. docs/trace.md says what is in them.

use super::text::About;
use pse::internal::diagnostic::{Diagnostic, Span};
use pse::internal::eval::{Birth, Event, EventKind, NotFinite, Part};
use pse::internal::shape::Shape;
use pse::internal::value::PixelValue;
use serde_json::{Map, Value, json};

/// The trace as JSON.
pub(super) fn json(about: &About<'_>) -> String {
    let trace = about.trace;
    let start = json!({
        "event": "pixel", "pixel": trace.pixel, "program": about.name, "frame": number(about.frame),
    });
    let values = trace
        .values
        .iter()
        .map(|(name, value)| json!({"event": "result", "name": name, "value": self::value(value)}));
    let all = std::iter::once(start)
        .chain(trace.events.iter().map(|e| event(about, e)))
        .chain(values)
        .chain(trace.births.iter().map(|b| birth(about, b)))
        .chain(trace.error.iter().map(|e| error(about, e)));
    let lines: Vec<String> = all.map(|event| format!("  {event}")).collect();
    format!("[\n{}\n]\n", lines.join(",\n"))
}

/// A number: as short as it can be read back. JSON has none for NaN and the infinities.
fn number(x: f32) -> Value {
    match x.to_string().parse::<f64>() {
        Ok(short) if x.is_finite() => json!(short),
        _ if x.is_nan() => json!("NaN"),
        _ => json!(if x > 0.0 { "infinity" } else { "-infinity" }),
    }
}

fn value(value: &PixelValue) -> Value {
    nested(value.shape(), value.cells())
}

fn nested(shape: &Shape, cells: &[f32]) -> Value {
    match shape.len() {
        None => number(cells[0]),
        Some(n) => (0..n).map(|i| nested(&shape.element(i), &cells[shape.cells_of(i)])).collect(),
    }
}

/// Where a span is: file, line, column, text.
fn place(about: &About<'_>, span: Span) -> Map<String, Value> {
    let sources = about.program.sources();
    let (line, column) = sources.line_column(span);
    let mut map = Map::new();
    map.insert("source".into(), json!(sources.get(span.source).name));
    map.insert("line".into(), json!(line));
    map.insert("column".into(), json!(column));
    map.insert("text".into(), json!(sources.text(span)));
    map
}

fn event(about: &About<'_>, event: &Event) -> Value {
    let (kind, more) = match &event.kind {
        EventKind::Input { name, value } => ("input", json!({"name": name, "value": self::value(value)})),
        EventKind::Param { name, value, set } => {
            ("param", json!({"name": name, "value": self::value(value), "set": set}))
        }
        EventKind::Assign { name, value, kept } => {
            ("assign", json!({"name": name, "value": self::value(value), "kept": kept}))
        }
        EventKind::Kept { value } => ("kept", json!({"value": self::value(value)})),
        EventKind::Value { value } => ("value", json!({"value": self::value(value)})),
        EventKind::Branch { value, taken } => {
            ("branch", json!({"value": self::value(value), "taken": taken}))
        }
        EventKind::Round { element: None } => ("round", json!({})),
        EventKind::Round { element: Some((name, value)) } => {
            ("round", json!({"name": name, "value": self::value(value)}))
        }
        EventKind::LoopEnd { rounds } => ("loop_end", json!({"count": rounds})),
        EventKind::Break => ("break", json!({})),
        EventKind::Continue => ("continue", json!({})),
        EventKind::Return { value } => ("return", json!({"value": self::value(value)})),
        EventKind::Call { name, arguments, result } => {
            let arguments: Vec<Value> =
                arguments.iter().map(|(name, v)| json!({"name": name, "value": self::value(v)})).collect();
            ("call", json!({"name": name, "arguments": arguments, "value": result.as_ref().map(self::value)}))
        }
        EventKind::Print { parts } => {
            let part = |part: &Part| match part {
                Part::Text(text) => json!({"text": text}),
                Part::Value(value) => json!({"value": self::value(value)}),
            };
            ("print", json!({"parts": parts.iter().map(part).collect::<Vec<_>>()}))
        }
        // It is at no place.
        EventKind::Omitted { events } => return json!({"event": "omitted", "count": events}),
    };
    let mut map = place(about, event.span);
    map.insert("event".into(), json!(kind));
    map.insert("once".into(), json!(event.frame));
    map.insert("depth".into(), json!(event.depth));
    map.insert("rounds".into(), json!(event.rounds));
    if let Value::Object(more) = more {
        map.extend(more);
    }
    Value::Object(map)
}

fn birth(about: &About<'_>, birth: &Birth) -> Value {
    let sources = about.program.sources();
    let mut map = place(about, birth.span);
    let what = match birth.what {
        NotFinite::Nan => "NaN",
        NotFinite::Infinity => "infinity",
    };
    let operand = |(span, value): &(Span, PixelValue)| json!({"text": sources.text(*span), "value": self::value(value)});
    let call = |(name, span): &(String, Span)| {
        let mut map = place(about, *span);
        map.insert("name".into(), json!(name));
        Value::Object(map)
    };
    map.insert("event".into(), json!("birth"));
    map.insert("what".into(), json!(what));
    map.insert("value".into(), value(&birth.value));
    map.insert("given".into(), json!(birth.given));
    map.insert("rounds".into(), json!(birth.rounds));
    map.insert("operands".into(), birth.operands.iter().map(operand).collect());
    map.insert("calls".into(), birth.calls.iter().map(call).collect());
    Value::Object(map)
}

fn error(about: &About<'_>, error: &Diagnostic) -> Value {
    let mut map = error.span().map_or(Map::new(), |span| place(about, span));
    map.insert("event".into(), json!("error"));
    map.insert("code".into(), json!(error.code));
    map.insert("message".into(), json!(error.message));
    map.insert("hints".into(), json!(error.hints));
    Value::Object(map)
}
