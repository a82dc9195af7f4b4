//! All that can be told in one go of a program with several mistakes, without telling what follows from one alone.

use super::names;
use super::tree::Resolved;
use crate::diagnostic::{Diagnostic, Sources, Span};
use crate::syntax::MAX_ERRORS;

/// Names that are read and never assigned, and look like a slip of a name that is known. An input may have a
/// variable of that name after all: so they are warnings, and only told to who has to mend the program anyway.
pub(super) fn unassigned(program: &Resolved) -> impl Iterator<Item = Diagnostic> {
    let own = program.globals.iter().filter(|g| !g.library && (g.assigned.is_some() || g.framed.is_some()));
    let known: Vec<&str> = own
        .map(|g| g.name.as_str())
        .chain(names::CONSTANTS.iter().map(|c| c.name))
        .chain(names::SYSTEM.iter().map(|(name, _)| *name))
        .chain(names::USUAL_INPUTS.iter().copied())
        .collect();
    program.globals.iter().filter(|g| !g.library).filter_map(move |g| {
        if known.contains(&g.name.as_str()) {
            return None;
        }
        let near = names::nearest(&g.name, known.iter().copied())?;
        let warning = Diagnostic::error("name", format!("nothing assigns `{}`", g.name), g.read?).warning();
        Some(warning.hint(format!("Did you mean `{near}`?")))
    })
}

/// Of the faults that were found, the first of those that no error of reading the files, `syntax`, can be the cause of.
pub(super) fn credible(
    found: impl Iterator<Item = Diagnostic>,
    syntax: &[Diagnostic],
    sources: &Sources,
) -> Vec<Diagnostic> {
    let misses_a_file = syntax.iter().any(|d| d.code == "import");
    let bad: Vec<Span> = syntax.iter().flat_map(|d| &d.labels).map(|l| lines(l.span, sources)).collect();
    let blamed = |d: &Diagnostic| {
        let Some(span) = d.span() else { return false };
        let inside =
            |line: &Span| line.source == span.source && line.start <= span.start && span.start < line.end;
        // A statement that could not be read may define the name that another one misses.
        let defines = |line: &Span| words(sources.text(*line)).any(|word| word == sources.text(span));
        match d.code {
            // Whose block this is may be what could not be read.
            "place" => syntax.iter().any(|s| s.code != "import"),
            // A file that was not found may have it, if it is no slip of a name that is known.
            "name" if misses_a_file && !d.hints.iter().any(|h| h.starts_with("Did you mean")) => true,
            "name" => bad.iter().any(|line| inside(line) || defines(line)),
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
