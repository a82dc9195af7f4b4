//! What `print` tells: a line for each pixel that comes to it, of which the first are kept.
//!
//! Batches and threads run the pixels in any order. The lines are those of the first pixels, row by row, and of one
//! pixel in the order of its statements.

use super::fault::Result;
use super::machine::Machine;
use super::pixels::Batch;
use crate::diagnostic::Span;
use crate::resolve::tree::{Expr, PrintPart};
use crate::value::{Mask, PixelValue, Value};
use std::fmt;
use std::ops::Range;

/// A line that `print` told.
#[derive(Clone, Debug, PartialEq)]
pub struct Printed {
    /// Column and row of the pixel; `None` in what runs once a frame.
    pub pixel: Option<[i32; 2]>,
    /// Where the statement stands.
    pub span: Span,
    /// What it told, in order.
    pub parts: Vec<Part>,
}

/// A part of a line that `print` told.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    /// A text of the program.
    Text(String),
    /// A value.
    Value(PixelValue),
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Part::Text(text) => f.write_str(text),
            Part::Value(value) => value.fmt(f),
        }
    }
}

/// The parts with blanks between.
impl fmt::Display for Printed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts: Vec<String> = self.parts.iter().map(Part::to_string).collect();
        f.write_str(&parts.join(" "))
    }
}

/// The first lines that `print` told, in the order of the pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prints {
    /// As many of them as were asked for.
    pub lines: Vec<Printed>,
    /// How many there were in all.
    pub count: u64,
}

impl Prints {
    /// Adds lines of other pixels, and keeps the first.
    pub(super) fn add(&mut self, other: &Prints, limit: usize) {
        self.count += other.count;
        self.lines.extend(other.lines.iter().cloned());
        self.cut(limit);
    }

    fn cut(&mut self, limit: usize) {
        // Stable: the lines of a pixel stay in order.
        self.lines.sort_by_key(|line| line.pixel.map(|[column, row]| (row, column)));
        self.lines.truncate(limit);
    }
}

/// Collects the lines of a batch.
#[derive(Default)]
pub(super) struct Printer {
    /// How many are kept; with 0 they are not counted either.
    pub limit: usize,
    /// The columns of the picture whose pixels print; `None`: all.
    pub columns: Option<Range<i32>>,
    /// In what runs once a frame, which is at no pixel?
    pub frame: bool,
    lines: Prints,
}

impl Printer {
    /// Forgets the last batch.
    pub fn reset(&mut self) {
        self.lines.lines.clear();
        self.lines.count = 0;
    }

    /// Adds the lines of the batch to others.
    pub fn give(&self, to: &mut Prints) {
        if self.lines.count > 0 {
            to.add(&self.lines, self.limit);
        }
    }
}

/// The parts of a line, of values that were computed for it.
fn parts(parts: &[PrintPart], values: &[Value], lane: usize) -> Vec<Part> {
    let mut values = values.iter();
    let part = |part: &PrintPart| match part {
        PrintPart::Text(text) => Some(Part::Text(text.clone())),
        PrintPart::Value(_) => values.next().map(|value| Part::Value(value.pixel(lane))),
    };
    parts.iter().filter_map(part).collect()
}

impl<'r> Machine<'r> {
    /// Notes a line for each active pixel. Shadows tell nothing.
    pub(super) fn print(&mut self, span: Span, what: &'r [PrintPart], mask: &Mask) -> Result<()> {
        // Also if nobody listens: what a program does must not depend on that.
        let mut values: Vec<Value> = Vec::new();
        for part in what {
            if let PrintPart::Value(e) = part {
                let e: &'r Expr = e;
                values.push(self.eval(e, mask)?);
            }
        }
        if self.tracer.is_some() {
            self.trace_print(span, parts(what, &values, 0));
        }
        let limit = self.printer.limit;
        if limit == 0 {
            return Ok(());
        }
        // The first pixels of the batch: no more lines than are kept can be among the first of all.
        let mut told = 0;
        for lane in mask.lanes(self.pixels()) {
            let pixel = (!self.printer.frame).then(|| self.position(lane));
            let outside = |columns: &Range<i32>| pixel.is_some_and(|[column, _]| !columns.contains(&column));
            if self.printer.columns.as_ref().is_some_and(outside) {
                continue;
            }
            self.printer.lines.count += 1;
            if told < limit {
                told += 1;
                let parts = parts(what, &values, lane);
                self.printer.lines.lines.push(Printed { pixel, span, parts });
            }
        }
        // A loop prints many times.
        if self.printer.lines.lines.len() > 4 * limit.max(super::BATCH) {
            self.printer.lines.cut(limit);
        }
        Ok(())
    }

    /// Column and row of a pixel of the batch.
    pub(super) fn position(&self, lane: usize) -> [i32; 2] {
        self.bound.position(match &self.pixels {
            Batch::Run(start, _) => start + lane,
            Batch::List(list) => list[lane],
        })
    }
}
