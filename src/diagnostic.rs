//! The one error type of the language: what is wrong, where, and how to mend it.
//!
//! A [`Diagnostic`] is built from facts wherever the fault is found, in the lexer as in the evaluator;
//! [`Diagnostic::render`] is the one place where it becomes text, through miette.

mod render;

use std::fmt;
use std::sync::Arc;

/// Identifies a source text; an index into [`Sources`].
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

    /// Whether the other span is inside this one.
    pub fn holds(self, other: Span) -> bool {
        self.source == other.source && self.start <= other.start && other.end <= self.end
    }

    /// The smallest span that holds both; they must be of the same source.
    pub fn to(self, end: Span) -> Span {
        Span { source: self.source, start: self.start.min(end.start), end: self.end.max(end.end) }
    }
}

/// One source text of a program: the program itself, an import, or a file of the library.
#[derive(Clone, Debug)]
pub struct Source {
    /// The name in messages: a path as the user wrote it, or `<command line>`.
    pub name: String,
    /// The text, UTF-8.
    pub text: Arc<str>,
}

/// All source texts that spans can refer to.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    list: Vec<Source>,
}

impl Sources {
    /// Adds a text and returns its id.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<Arc<str>>) -> SourceId {
        self.list.push(Source { name: name.into(), text: text.into() });
        SourceId(self.list.len() as u32 - 1)
    }

    /// Finds the text with this name.
    pub fn find(&self, name: &str) -> Option<SourceId> {
        self.list.iter().position(|s| s.name == name).map(|i| SourceId(i as u32))
    }

    /// All texts, in the order of their ids.
    pub fn iter(&self) -> impl Iterator<Item = &Source> {
        self.list.iter()
    }

    /// Returns the text with this id.
    pub fn get(&self, id: SourceId) -> &Source {
        &self.list[id.0 as usize]
    }

    /// Returns the text of a span.
    pub fn text(&self, span: Span) -> &str {
        self.get(span.source).text.get(span.start as usize..span.end as usize).unwrap_or("")
    }

    /// Returns line and column of a span's start, both from 1; columns count characters.
    pub fn line_column(&self, span: Span) -> (usize, usize) {
        let text = &self.get(span.source).text;
        let before = text.get(..span.start as usize).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}

/// The severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The program cannot run, or had to stop.
    Error,
    /// The program runs, but probably not as intended.
    Warning,
}

/// A range of source text with a note.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// The note at the place; may be empty.
    pub text: String,
}

/// A fact about a fault in a program, for the user.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// The kind of fault, as a stable identifier: `syntax`, `name`, `arity`, `shape`, `index`, `limit`, …
    pub code: &'static str,
    /// The fact, in one sentence without a full stop.
    pub message: String,
    /// The places; the first is the primary one. Empty for a fault without a place in a program.
    pub labels: Vec<Label>,
    /// The remedies; each is a sentence.
    pub hints: Vec<String>,
    /// The calls that led to the fault, innermost first: function name and the call's span.
    pub trace: Vec<(String, Span)>,
    /// For a fault at run time: column and row of the pixel, from 0, as `pixel` counts them.
    pub pixel: Option<[i32; 2]>,
}

impl Diagnostic {
    /// Creates an error with its primary place.
    pub fn error(code: &'static str, message: impl Into<String>, span: Span) -> Diagnostic {
        Diagnostic::bare(code, message).label(span, "")
    }

    /// Creates an error without a place in a program.
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

    /// Turns the error into a warning.
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

    /// Adds a remedy.
    pub fn hint(mut self, text: impl Into<String>) -> Diagnostic {
        self.hints.push(text.into());
        self
    }

    /// Returns the primary place.
    pub fn span(&self) -> Option<Span> {
        self.labels.first().map(|l| l.span)
    }

    /// Renders the whole message as text, with the source lines and the places underlined.
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

/// The style of a rendered message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Style {
    /// Use colours, as ANSI sequences.
    pub color: bool,
    /// The column to wrap at.
    pub width: usize,
}

impl Style {
    /// No colours and 100 columns, for files, tests and logs.
    pub const PLAIN: Style = Style { color: false, width: 100 };
}
