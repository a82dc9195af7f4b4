//! What happened at a pixel, as data: [`Trace`]. The recording is in [`super::tracer`].

use super::print::Part;
use crate::diagnostic::{Diagnostic, Span};
use crate::value::PixelValue;

/// How much of a pixel's run is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceOptions {
    /// How deep calls are gone into: 0 tells a call as one event, 1 also what happens in it, and so on.
    pub depth: u32,
    /// How many events are kept: of more than these, the first half and the last half. Vectors of millions of numbers
    /// can make it fewer.
    pub limit: usize,
}

impl Default for TraceOptions {
    fn default() -> TraceOptions {
        TraceOptions { depth: 0, limit: 4000 }
    }
}

/// What happened at one pixel, from the first statement to the last.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Trace {
    /// Column and row of the pixel in the picture.
    pub pixel: [i32; 2],
    /// In the order in which it happened: first what runs once a frame, then what the pixel began with, then its run.
    pub events: Vec<Event>,
    /// Where the first NaN and the first infinity came up, at most one of each.
    pub births: Vec<Birth>,
    /// The variables that the program assigns, with what they held in the end, and the image's `alpha` where it goes
    /// with a colour that has none.
    pub values: Vec<(String, PixelValue)>,
    /// What ended the run before its end.
    pub error: Option<Diagnostic>,
}

/// One thing that happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The statement, for a block the line that it begins with; or the expression or condition.
    pub span: Span,
    /// Did it happen once for the frame, before the pixels?
    pub frame: bool,
    /// In how many calls.
    pub depth: u32,
    /// The rounds of the loops around it in the same function, counted from 1, the outermost loop first.
    pub rounds: Vec<u32>,
    /// What it was.
    pub kind: EventKind,
}

/// What can happen.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// A variable that the pixel began with, from the image, the system or from outside.
    Input {
        /// The variable.
        name: String,
        /// What it holds.
        value: PixelValue,
    },
    /// A `param` line.
    Param {
        /// The param.
        name: String,
        /// What it holds.
        value: PixelValue,
        /// Was it set from outside?
        set: bool,
    },
    /// An assignment, also one to an element.
    Assign {
        /// The variable.
        name: String,
        /// All that it holds now.
        value: PixelValue,
        /// Was the value computed once for the whole frame?
        kept: bool,
    },
    /// A part of an expression that is computed once for the whole frame.
    Kept {
        /// What it gave.
        value: PixelValue,
    },
    /// An expression alone whose value nobody takes.
    Value {
        /// What it gave.
        value: PixelValue,
    },
    /// The condition of an `if` or `else if`.
    Branch {
        /// The condition.
        value: PixelValue,
        /// Is its block run?
        taken: bool,
    },
    /// A round of a loop begins; the last of [`Event::rounds`] is its number.
    Round {
        /// The variable of a `for`, and the element that it gets.
        element: Option<(String, PixelValue)>,
    },
    /// A loop has ended.
    LoopEnd {
        /// After so many rounds.
        rounds: u32,
    },
    /// `break`
    Break,
    /// `continue`
    Continue,
    /// `return`
    Return {
        /// What the call gives.
        value: PixelValue,
    },
    /// A call of a function of the program or of the library. What happens in it comes next.
    Call {
        /// The function.
        name: String,
        /// Its parameters, with what they got.
        arguments: Vec<(String, PixelValue)>,
        /// What it returned; `None` if it returned nothing, or did not come to its end.
        result: Option<PixelValue>,
    },
    /// A line of `print`.
    Print {
        /// Its parts in order.
        parts: Vec<Part>,
    },
    /// There were more events than are kept: here so many are left out.
    Omitted {
        /// How many.
        events: u64,
    },
}

/// A kind of number that is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotFinite {
    /// NaN.
    Nan,
    /// Plus or minus infinity.
    Infinity,
}

impl NotFinite {
    /// What of the kind a value holds; NaN if both.
    pub fn of(value: &PixelValue) -> Option<NotFinite> {
        let cells = value.cells();
        if cells.iter().any(|x| x.is_nan()) {
            return Some(NotFinite::Nan);
        }
        cells.iter().any(|x| x.is_infinite()).then_some(NotFinite::Infinity)
    }
}

/// Where NaN or an infinity came up first, out of values that held none of the kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Birth {
    /// Which.
    pub what: NotFinite,
    /// The expression; for `x op= e` the whole statement.
    pub span: Span,
    /// What it gave.
    pub value: PixelValue,
    /// What it was computed from: the operands or arguments that are no numbers in the text, with their values.
    pub operands: Vec<(Span, PixelValue)>,
    /// Nothing was computed: it came with a variable from the image, the system or from outside.
    pub given: bool,
    /// The calls that led there, innermost first: function and the call's place.
    pub calls: Vec<(String, Span)>,
    /// As [`Event::rounds`].
    pub rounds: Vec<u32>,
}
