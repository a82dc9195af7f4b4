//! A message with its source shown and the places underlined, drawn by miette.

use super::super::{Diagnostic, Label, Severity, SourceId, Sources, Span, Style};
use super::short;
use crate::visible::{self, visible_name};
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource};
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

/// A source text. Of lines longer than [`MOST`] bytes only the surroundings of the place are shown.
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

pub(super) fn excerpts(d: &Diagnostic, sources: &Sources, style: Style) -> String {
    let theme = if style.color { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let handler = GraphicalReportHandler::new_themed(theme)
        .with_width(style.width)
        .with_context_lines(1)
        .with_links(false)
        .without_cause_chain();
    let mut text = String::new();
    // The handler writes to a String, which cannot fail.
    let _ = handler.render_report(&mut text, &report(d, sources));
    text
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
        help: (!d.hints.is_empty()).then(|| d.hints.iter().map(|h| short(h)).collect::<Vec<_>>().join("\n")),
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
