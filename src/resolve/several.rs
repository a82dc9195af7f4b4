//! All that can be told in one go of a program with several mistakes, without telling what follows from one alone.

use super::tree::Resolved;
use super::unknown::{self, Doubt};
use crate::diagnostic::{Diagnostic, Sources, Span};
use crate::syntax::MAX_ERRORS;
use std::collections::HashSet;

/// What is to be said of the variables that the program reads and does not assign.
pub(super) fn unassigned<'p>(
    program: &'p Resolved,
    doubt: &'p Doubt<'_>,
) -> impl Iterator<Item = Diagnostic> + 'p {
    unknown::unassigned(program).filter_map(|(name, span)| doubt(program, name, span))
}

/// Of the faults that were found, the first of those that no error of reading the files, `syntax`, can be the cause of.
pub(super) fn credible(
    found: impl Iterator<Item = Diagnostic>,
    syntax: &[Diagnostic],
    sources: &Sources,
) -> Vec<Diagnostic> {
    let misses_a_file = syntax.iter().any(|d| d.code == "import");
    let bad: Vec<Span> = syntax.iter().flat_map(|d| &d.labels).map(|l| lines(l.span, sources)).collect();
    // A statement that could not be read may define the name that another one misses.
    let defined: HashSet<&str> = bad.iter().flat_map(|line| words(sources.text(*line))).collect();
    let blamed = |d: &Diagnostic| {
        let Some(span) = d.span() else { return false };
        let inside =
            |line: &Span| line.source == span.source && line.start <= span.start && span.start < line.end;
        match d.code {
            // Whose block this is may be what could not be read.
            "place" => syntax.iter().any(|s| s.code != "import"),
            // A file that was not found may have it, if it is no slip of a name that is known.
            "name"
                if misses_a_file
                    && !d
                        .hints
                        .iter()
                        .any(|h| h.starts_with("Did you mean") || h.starts_with("Or did you")) =>
            {
                true
            }
            "name" => defined.contains(sources.text(span)) || bad.iter().any(inside),
            _ => bad.iter().any(inside),
        }
    };
    found.filter(|d| !blamed(d)).take(MAX_ERRORS).collect()
}

/// The whole lines that a span touches.
fn lines(span: Span, sources: &Sources) -> Span {
    let text = &*sources.get(span.source).text;
    let (start, end) = (span.start as usize, span.end as usize);
    let start = text.get(..start).and_then(|before| before.rfind('\n')).map_or(0, |i| i + 1);
    let end = text.get(end..).and_then(|after| after.find('\n')).map_or(text.len(), |i| end + i);
    Span::new(span.source, start, end)
}

/// The names in a text, and whatever else is made of letters.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_'))
}
