//! The one error type of the language: what is wrong, where, and how to mend it.
//!
//! A [`Diagnostic`] is built from facts wherever the fault is found, in the lexer as in the evaluator;
//! [`Diagnostic::render`] is the one place where it becomes text, through miette.

mod render;

use std::fmt;
use std::sync::Arc;

/// Which source text a span points into; an index into [`Sources`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SourceId(pub u32);

/// A range of bytes of one source text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// The text.
    pub source: SourceId,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// The bytes `start..end` of `source`.
    pub fn new(source: SourceId, start: usize, end: usize) -> Span {
        Span { source, start: start as u32, end: end as u32 }
    }

    /// Is the other one inside of it?
    pub fn holds(self, other: Span) -> bool {
        self.source == other.source && self.start <= other.start && other.end <= self.end
    }

    /// The smallest span that holds both; they must be of the same source.
    pub fn to(self, end: Span) -> Span {
        Span { source: self.source, start: self.start.min(end.start), end: self.end.max(end.end) }
    }
}

/// One text that a program is made of: the program itself, an import, or a file of the library.
#[derive(Clone, Debug)]
pub struct Source {
    /// The name to show: a path as the user gave it, or `<command line>`.
    pub name: String,
    /// The text, UTF-8.
    pub text: Arc<str>,
}

/// All the texts that spans may point into.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    list: Vec<Source>,
}

impl Sources {
    /// Adds a text, and tells how spans name it.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<Arc<str>>) -> SourceId {
        self.list.push(Source { name: name.into(), text: text.into() });
        SourceId(self.list.len() as u32 - 1)
    }

    /// The text of that name.
    pub fn find(&self, name: &str) -> Option<SourceId> {
        self.list.iter().position(|s| s.name == name).map(|i| SourceId(i as u32))
    }

    /// All texts, in the order of their ids.
    pub fn iter(&self) -> impl Iterator<Item = &Source> {
        self.list.iter()
    }

    /// The text that `id` names.
    pub fn get(&self, id: SourceId) -> &Source {
        &self.list[id.0 as usize]
    }

    /// The bytes a span covers.
    pub fn text(&self, span: Span) -> &str {
        self.get(span.source).text.get(span.start as usize..span.end as usize).unwrap_or("")
    }

    /// Line and column of a span's start, both from 1; columns count characters.
    pub fn line_column(&self, span: Span) -> (usize, usize) {
        let text = &self.get(span.source).text;
        let before = text.get(..span.start as usize).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The program cannot run, or had to stop.
    Error,
    /// It runs, but probably not as meant.
    Warning,
}

/// A stretch of source with a word on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What is there; may be empty.
    pub text: String,
}

/// What is wrong with a program, or what went wrong in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// The kind of fault, as a stable word: `syntax`, `name`, `arity`, `shape`, `index`, `limit`, …
    pub code: &'static str,
    /// One sentence without a full stop: what is wrong.
    pub message: String,
    /// Where; the first is the primary place. Empty for a fault with no place in a program.
    pub labels: Vec<Label>,
    /// How to mend it; each a sentence.
    pub hints: Vec<String>,
    /// The calls that led there, innermost first: function name and the call's span.
    pub trace: Vec<(String, Span)>,
    /// For a fault at run time: column and row of the pixel, from 0, as `pixel` counts them.
    pub pixel: Option<[i32; 2]>,
}

impl Diagnostic {
    /// An error with its primary place.
    pub fn error(code: &'static str, message: impl Into<String>, span: Span) -> Diagnostic {
        Diagnostic::bare(code, message).label(span, "")
    }

    /// An error that has no place in a program.
    pub fn bare(code: &'static str, message: impl Into<String>) -> Diagnostic {
        Diagnostic {
            severity: Severity::Error,
            code,
            message: message.into(),
            labels: Vec::new(),
            hints: Vec::new(),
            trace: Vec::new(),
            pixel: None,
        }
    }

    /// The same as a warning.
    pub fn warning(mut self) -> Diagnostic {
        self.severity = Severity::Warning;
        self
    }

    /// Adds a place; on the primary place (the same span again) it sets the text.
    pub fn label(mut self, span: Span, text: impl Into<String>) -> Diagnostic {
        match self.labels.iter_mut().find(|l| l.span == span) {
            Some(label) => label.text = text.into(),
            None => self.labels.push(Label { span, text: text.into() }),
        }
        self
    }

    /// Adds a way to mend it.
    pub fn hint(mut self, text: impl Into<String>) -> Diagnostic {
        self.hints.push(text.into());
        self
    }

    /// The primary place.
    pub fn span(&self) -> Option<Span> {
        self.labels.first().map(|l| l.span)
    }

    /// The whole message as text, with the source shown and the places underlined.
    pub fn render(&self, sources: &Sources, style: Style) -> String {
        render::render(self, sources, style)
    }
}

/// The message alone, with its place in bytes; [`Diagnostic::render`] shows the source.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.message)
    }
}

impl std::error::Error for Diagnostic {}

/// How a rendered message looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Style {
    /// Colours, by ANSI sequences.
    pub color: bool,
    /// Columns to wrap at.
    pub width: usize,
}

impl Style {
    /// No colours, 100 columns: for files, tests and logs.
    pub const PLAIN: Style = Style { color: false, width: 100 };
}
