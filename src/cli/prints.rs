//! What `print` told, as lines of text.

use super::failure::warn;
use pse::internal::diagnostic::{Sources, Span};
use pse::internal::eval::{Printed, Prints};

/// The lines of a run, of which so many are shown.
pub(super) struct Shown {
    limit: usize,
    shown: usize,
    /// How many there were in all.
    count: u64,
}

impl Shown {
    pub fn new(limit: usize) -> Shown {
        Shown { limit, shown: 0, count: 0 }
    }

    /// How many lines a run has to keep. Those that are not shown are still counted.
    pub fn wanted(&self) -> usize {
        if self.limit == 0 { 0 } else { (self.limit - self.shown).max(1) }
    }

    /// Shows what a frame printed.
    pub fn frame(&mut self, prints: &Prints, sources: &Sources, frame: Option<i64>) {
        self.count += prints.count;
        for line in prints.lines.iter().take(self.limit - self.shown) {
            warn(&place(line, sources, frame));
            self.shown += 1;
        }
    }

    /// Says how many there were that it did not show.
    pub fn end(&self) {
        let left = self.count - self.shown as u64;
        if left > 0 {
            let s = if left == 1 { "" } else { "s" };
            warn(&format!("print: {left} more line{s} not shown; --print N shows more"));
        }
    }
}

/// A line with where it comes from.
fn place(printed: &Printed, sources: &Sources, frame: Option<i64>) -> String {
    let frame = frame.map_or(String::new(), |frame| format!("frame {frame} "));
    let pixel = printed.pixel.map_or(String::new(), |[column, row]| format!("pixel {column},{row} "));
    format!("{frame}{pixel}line {}: {printed}", line(printed.span, sources)).trim_end().to_string()
}

/// The line of a span, with its file if that is not the program itself.
pub(super) fn line(span: Span, sources: &Sources) -> String {
    let (line, _) = sources.line_column(span);
    if span.source.0 == 0 { line.to_string() } else { format!("{line} of {}", sources.get(span.source).name) }
}
