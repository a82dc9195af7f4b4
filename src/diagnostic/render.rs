//! Diagnostics as text.

#[cfg(feature = "fancy")]
mod fancy;
#[cfg(not(feature = "fancy"))]
mod plain;

use super::{Diagnostic, Sources, Span, Style};
use crate::visible::{visible, visible_name, visible_sentence};
use std::borrow::Cow;

#[cfg(feature = "fancy")]
use fancy::excerpts;
#[cfg(not(feature = "fancy"))]
use plain::excerpts;

/// The whole message: what is wrong, the places, the hints, and the calls that led there.
pub(super) fn render(d: &Diagnostic, sources: &Sources, style: Style) -> String {
    let mut text = excerpts(d, sources, style);
    text.push_str(&calls(d, sources));
    text.lines().map(|line| line.trim_end().to_string() + "\n").collect()
}

/// Bytes of a sentence that are shown, at its beginning and at its end: names and values of megabytes may stand in it.
const SENTENCE: [usize; 2] = [1000, 300];

/// A sentence without the middle that nobody reads, and without hidden characters.
fn short(text: &str) -> Cow<'_, str> {
    let [first, last] = SENTENCE;
    if text.len() <= first + last {
        return visible_sentence(text);
    }
    let whole = |at: usize| (at..text.len()).find(|&i| text.is_char_boundary(i)).unwrap_or(text.len());
    let [first, last] = [&text[..whole(first)], &text[whole(text.len() - last)..]].map(visible_sentence);
    format!("{first} … {last}").into()
}

/// Lines of calls that are shown from either end.
const CALLS: usize = 4;

/// The calls that led to the fault, a line each, innermost first. A call that repeats itself, as a
/// recursion does, has one line.
fn calls(d: &Diagnostic, sources: &Sources) -> String {
    let mut runs: Vec<(&(String, Span), usize)> = Vec::new();
    for call in &d.trace {
        match runs.last_mut() {
            Some((last, times)) if *last == call => *times += 1,
            _ => runs.push((call, 1)),
        }
    }
    let mut lines = Vec::new();
    for (i, ((name, span), times)) in runs.iter().enumerate() {
        let from_end = runs.len() - i;
        if i >= CALLS && from_end > CALLS {
            if i == CALLS {
                let left_out: usize = runs[i..runs.len() - CALLS].iter().map(|(_, times)| times).sum();
                lines.push(format!("  … {left_out} more calls …\n"));
            }
            continue;
        }
        let (line, column) = sources.line_column(*span);
        let written = sources.text(*span);
        let short = written.chars().count() <= 40 && !written.contains('\n');
        let written = if short { written.to_string() } else { format!("{name}(…)") };
        let times = if *times > 1 { format!(", {times} times over") } else { String::new() };
        let (written, file) = (visible(&written), visible_name(&sources.get(span.source).name));
        lines.push(format!("  in `{name}()`, called as `{written}` at {file}:{line}:{column}{times}\n"));
    }
    lines.concat()
}
