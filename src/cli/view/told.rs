//! What the pages are told, as JSON.

use super::session::{Session, State};
use crate::cli::failure::Failure;
use crate::cli::frames::Frame;
use pse::image::Image;
use pse::internal::diagnostic::{Diagnostic, Severity, SourceId, Style};
use pse::internal::program::Error;
use pse::internal::value::PixelValue;
use serde_json::{Value, json};

/// An event as pages hear it (the HTML standard, section 9.2: server-sent events). JSON has no line ends of its own.
pub(super) fn event(name: &str, value: &Value) -> String {
    format!("event: {name}\ndata: {value}\n\n")
}

/// A number as JSON has them; what is none as nothing.
fn number(x: f32) -> Value {
    x.to_string().parse::<f64>().map_or(Value::Null, |short| json!(short))
}

/// A frame's exact number, or its place between two frames.
fn frame(frame: Frame) -> Value {
    frame.number.map_or_else(|| number(frame.value), |number| json!(number))
}

/// All but pictures.
pub(super) fn state(session: &Session, state: &State) -> Value {
    let params: Vec<Value> = state
        .params
        .iter()
        .map(|param| {
            let set = state.set.iter().rev().find(|(name, ..)| *name == param.name);
            let value = set.map_or(&param.default, |(_, _, value)| value);
            let text = set.map_or_else(|| value.to_string(), |(_, text, _)| text.clone());
            let scalar = |value: &PixelValue| match value.cells() {
                [x] if value.shape().is_scalar() => number(*x),
                _ => Value::Null,
            };
            json!({
                "name": param.name,
                "value": scalar(value),
                "default": scalar(&param.default),
                "range": param.range.map(|ends| ends.map(number)),
                "text": text,
                "changed": set.is_some(),
            })
        })
        .collect();
    json!({
        "name": session.name(),
        "text": state.text,
        "from": state.from,
        "saved": state.disk.text() == Some(&state.text),
        "saves": state.saves,
        "conflict": state.conflict,
        "params": params,
        "frame": frame(state.frame),
        "animated": state.animated,
        "inputs": state.inputs,
        "assigned": state.assigned,
        "also": state.also,
        "error": state.error,
    })
}

/// A picture that pages may fetch.
pub(super) struct Told {
    pub id: u64,
    pub full: bool,
    /// Columns and rows of the whole picture.
    pub size: [usize; 2],
    pub milliseconds: f64,
    /// Pixels with NaN or infinity.
    pub odd: usize,
    pub frame: Frame,
}

/// What pages are told of a picture.
pub(super) fn picture(told: &Told, image: &Image<'_>) -> Value {
    let outputs: Vec<Value> = image
        .variables
        .iter()
        .filter(|variable| !variable.planes.is_empty())
        .map(|variable| {
            let components = variable.planes.len().min(super::server::COMPONENTS);
            json!({"name": variable.name, "shape": variable.shape.to_string(), "components": components})
        })
        .collect();
    json!({
        "id": told.id,
        "full": told.full,
        "size": told.size,
        "coarse": [image.width, image.height],
        "outputs": outputs,
        "milliseconds": told.milliseconds,
        "pixels": image.width * image.height,
        "odd": told.odd,
        "frame": frame(told.frame),
    })
}

/// What is wrong: as the command tells it, and where in the text.
pub(super) fn failure(failure: &Failure) -> Value {
    match failure {
        Failure::Program(error) => {
            let places: Vec<Value> = error.diagnostics.iter().filter_map(|d| place(d, error)).collect();
            json!({"rendered": error.render(Style::PLAIN).trim_end(), "places": places})
        }
        other => json!({"rendered": other.message(), "places": []}),
    }
}

/// Where a mistake is in the program's own text, counted as JavaScript counts.
fn place(diagnostic: &Diagnostic, error: &Error) -> Option<Value> {
    // Of a mistake in an import, the call that led there.
    let own = |span: &pse::internal::diagnostic::Span| span.source == SourceId::default();
    let labels = diagnostic.labels.iter().map(|label| label.span);
    let span = labels.chain(diagnostic.trace.iter().map(|(_, span)| *span)).find(own)?;
    let text = &error.sources.get(span.source).text;
    let units = |byte: u32| super::server::units(text, byte as usize);
    let mut message = diagnostic.message.clone();
    for hint in &diagnostic.hints {
        message = format!("{message}\n{hint}");
    }
    let severity = if diagnostic.severity == Severity::Warning { "warning" } else { "error" };
    Some(json!({"from": units(span.start), "to": units(span.end), "severity": severity, "message": message}))
}
