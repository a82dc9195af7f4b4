//! The one error type of the language: what is wrong, where, and how to mend it.
//!
//! A [`Diagnostic`] is built from facts wherever the fault is found, in the lexer as in the evaluator;
//! [`Diagnostic::render`] is the one place where it becomes text, through miette.

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

mod render {
    use super::{Diagnostic, Label, Severity, SourceId, Sources, Span, Style};
    use crate::visible::{self, visible, visible_name};
    use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource};
    use std::borrow::Cow;
    use std::fmt;

    /// One source's share of a diagnostic, as miette wants it: labels of one text only.
    struct Report {
        message: String,
        severity: Option<miette::Severity>,
        labels: Vec<LabeledSpan>,
        source: Option<NamedSource<Excerpt>>,
        help: Option<String>,
        related: Vec<Report>,
    }

    /// A text of which no more than so many bytes are shown at a place: nobody reads a line of a megabyte.
    struct Excerpt(String);

    /// Bytes of lines that are shown, and what is left of longer ones on either side of a place.
    const MOST: usize = 4000;
    const BESIDE: usize = 60;

    impl miette::SourceCode for Excerpt {
        fn read_span<'a>(
            &'a self,
            span: &miette::SourceSpan,
            before: usize,
            after: usize,
        ) -> Result<Box<dyn miette::SpanContents<'a> + 'a>, miette::MietteError> {
            let whole = self.0.read_span(span, before, after)?;
            if whole.data().len() <= MOST {
                return Ok(whole);
            }
            let line = self.0.read_span(span, 0, 0)?;
            let (first, last) = (line.span().offset(), line.span().offset() + line.data().len());
            let from = span.offset().saturating_sub(BESIDE).max(first);
            let to = (span.offset() + span.len().clamp(1, MOST) + BESIDE).min(last);
            // No letter is cut.
            let start = (from..=last).find(|&i| self.0.is_char_boundary(i)).unwrap_or(last);
            let end = (to..=last).find(|&i| self.0.is_char_boundary(i)).unwrap_or(last);
            let end = end.max(start);
            Ok(Box::new(miette::MietteSpanContents::new(
                &self.0.as_bytes()[start..end],
                (start, end - start).into(),
                line.line(),
                line.column(),
                line.line_count(),
            )))
        }
    }

    impl fmt::Debug for Report {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "{}", self.message)
        }
    }
    impl fmt::Display for Report {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "{}", self.message)
        }
    }
    impl std::error::Error for Report {}

    impl miette::Diagnostic for Report {
        fn severity(&self) -> Option<miette::Severity> {
            self.severity
        }
        fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
            self.help.as_ref().map(|h| Box::new(h) as Box<dyn fmt::Display>)
        }
        fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
            (!self.labels.is_empty()).then(|| Box::new(self.labels.iter().cloned()) as _)
        }
        fn source_code(&self) -> Option<&dyn miette::SourceCode> {
            self.source.as_ref().map(|s| s as _)
        }
        fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn miette::Diagnostic> + 'a>> {
            (!self.related.is_empty())
                .then(|| Box::new(self.related.iter().map(|r| r as &dyn miette::Diagnostic)) as _)
        }
    }

    /// Bytes of a sentence that are shown, at its beginning and at its end: names and values of megabytes may stand in it.
    const SENTENCE: [usize; 2] = [1000, 300];

    /// A sentence without the middle that nobody reads, and without hidden characters.
    fn short(text: &str) -> Cow<'_, str> {
        let [first, last] = SENTENCE;
        if text.len() <= first + last {
            return visible(text);
        }
        let whole = |at: usize| (at..text.len()).find(|&i| text.is_char_boundary(i)).unwrap_or(text.len());
        let [first, last] = [&text[..whole(first)], &text[whole(text.len() - last)..]].map(visible);
        format!("{first} … {last}").into()
    }

    pub(super) fn render(d: &Diagnostic, sources: &Sources, style: Style) -> String {
        let theme = if style.color { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
        let handler = GraphicalReportHandler::new_themed(theme)
            .with_width(style.width)
            .with_context_lines(1)
            .with_links(false)
            .without_cause_chain();
        let mut text = String::new();
        // The handler writes to a String, which cannot fail.
        let _ = handler.render_report(&mut text, &report(d, sources));
        text.push_str(&calls(d, sources));
        text.lines().map(|line| line.trim_end().to_string() + "\n").collect()
    }

    fn report(d: &Diagnostic, sources: &Sources) -> Report {
        let primary = d.span().map(|s| s.source);
        let mut message = short(&d.message).into_owned();
        if let Some([column, row]) = d.pixel {
            message += &format!(" (at pixel [{column} {row}])");
        }
        let shown = apart(&d.labels, sources);
        let excerpt = |id: SourceId| visible::Excerpt::new(&sources.get(id).text);
        let of_source = |id: SourceId| -> Vec<LabeledSpan> {
            let excerpt = excerpt(id);
            shown
                .iter()
                .filter(|l| l.span.source == id)
                .enumerate()
                .map(|(i, l)| {
                    let text = (!l.text.is_empty()).then(|| short(&l.text).into_owned());
                    let [start, end] = [l.span.start, l.span.end].map(|byte| excerpt.place(byte as usize));
                    let length = end - start;
                    // What is underlined is short, as what is shown is.
                    let long = length > MOST && !sources.text(l.span)[..].contains('\n');
                    let range = (start, if long { 1 } else { length });
                    match i {
                        0 if Some(id) == primary => LabeledSpan::new_primary_with_span(text, range),
                        _ => LabeledSpan::new_with_span(text, range),
                    }
                })
                .collect()
        };
        let named = |id: SourceId| {
            let name = visible_name(&sources.get(id).name).into_owned();
            NamedSource::new(name, Excerpt(excerpt(id).text.into_owned()))
        };
        let mut related = Vec::new();
        let mut seen: Vec<SourceId> = primary.into_iter().collect();
        for label in &d.labels {
            if !seen.contains(&label.span.source) {
                seen.push(label.span.source);
                related.push(Report {
                    message: "see also".into(),
                    severity: Some(miette::Severity::Advice),
                    labels: of_source(label.span.source),
                    source: Some(named(label.span.source)),
                    help: None,
                    related: Vec::new(),
                });
            }
        }
        Report {
            message,
            severity: Some(match d.severity {
                Severity::Error => miette::Severity::Error,
                Severity::Warning => miette::Severity::Warning,
            }),
            labels: primary.map_or(Vec::new(), of_source),
            source: primary.map(named),
            help: (!d.hints.is_empty())
                .then(|| d.hints.iter().map(|h| short(h)).collect::<Vec<_>>().join("\n")),
            related,
        }
    }

    /// The labels without the one thing that cannot be drawn: a place without a text that has other labels inside.
    /// Of `max(a, b)` around labels on `a` and `b` the `max` is left; of `a + b` nothing.
    fn apart(labels: &[Label], sources: &Sources) -> Vec<Label> {
        let cut = |outer: &Label| {
            let inside = |l: &&Label| l.span != outer.span && outer.span.holds(l.span);
            let first = labels.iter().filter(inside).map(|l| l.span.start).min();
            let Some(end) = first.filter(|_| outer.text.is_empty()) else { return Some(outer.clone()) };
            let before = Span { end, ..outer.span };
            let head = sources.text(before).trim_end_matches(|c: char| !c.is_alphanumeric() && c != '_');
            let span = Span { end: before.start + head.len() as u32, ..before };
            (!head.is_empty()).then(|| Label { span, text: String::new() })
        };
        labels.iter().filter_map(cut).collect()
    }

    /// So many lines of calls are shown from either end.
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
}
