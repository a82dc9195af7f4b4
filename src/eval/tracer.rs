//! Records what happens while a machine runs one pixel: the hooks of the walk over the tree.
//!
//! The pixel is the batch's first lane, and the only one but for its shadows. So a statement that is run is run by it.

use super::bind::Source;
use super::fault::Result;
use super::machine::Machine;
use super::print::Part;
use super::trace::{Birth, Event, EventKind, NotFinite, TraceOptions};
use crate::diagnostic::Span;
use crate::resolve::names;
use crate::resolve::tree::*;
use crate::value::{Mask, PixelValue, Value};
use std::collections::VecDeque;

/// Numbers that all events together may hold.
const CELLS: usize = 1 << 22;

/// The values of the expressions right inside of the one that is computed, or of the statement.
struct Inside {
    statement: bool,
    values: Vec<(Span, PixelValue)>,
}

/// What was recorded so far.
pub(super) struct Tracer {
    options: TraceOptions,
    /// The first half of the events, and the last ones after it.
    head: Vec<Event>,
    tail: VecDeque<Event>,
    omitted: usize,
    /// Numbers in the events of either.
    cells: [usize; 2],
    /// In what runs once a frame?
    pub frame: bool,
    /// The loops of the running call.
    rounds: Vec<u32>,
    /// Those of its callers.
    callers: Vec<Vec<u32>>,
    inside: Vec<Inside>,
    births: Vec<Birth>,
}

impl Tracer {
    pub fn new(options: &TraceOptions) -> Tracer {
        Tracer {
            options: *options,
            head: Vec::new(),
            tail: VecDeque::new(),
            omitted: 0,
            cells: [0; 2],
            frame: false,
            rounds: Vec::new(),
            callers: Vec::new(),
            inside: Vec::new(),
            births: Vec::new(),
        }
    }

    /// The events, and where NaN and infinity came up.
    pub fn finish(mut self) -> (Vec<Event>, Vec<Birth>) {
        if self.omitted > 0 {
            let span = self.tail.front().or(self.head.last()).map_or(Span::default(), |event| event.span);
            let kind = EventKind::Omitted { events: self.omitted as u64 };
            self.head.push(Event { span, frame: false, depth: 0, rounds: Vec::new(), kind });
        }
        self.head.extend(self.tail);
        (self.head, self.births)
    }

    /// Adds an event; gives its number.
    fn record(&mut self, depth: usize, span: Span, kind: EventKind) -> Option<usize> {
        let depth = depth as u32;
        if depth > self.options.depth && !matches!(kind, EventKind::Print { .. }) {
            return None;
        }
        let number = self.head.len() + self.omitted + self.tail.len();
        let event = Event { span, frame: self.frame, depth, rounds: self.rounds.clone(), kind };
        let cells = cells(&event.kind);
        let half = self.options.limit.div_ceil(2);
        if self.tail.is_empty() && self.omitted == 0 && self.head.len() < half && self.cells[0] < CELLS / 2 {
            self.cells[0] += cells;
            self.head.push(event);
            return Some(number);
        }
        self.cells[1] += cells;
        self.tail.push_back(event);
        while self.tail.len() > self.options.limit - half || self.cells[1] > CELLS / 2 {
            let Some(event) = self.tail.pop_front() else { break };
            self.cells[1] -= self::cells(&event.kind);
            self.omitted += 1;
        }
        Some(number)
    }

    /// An event by its number, if it is still there.
    fn event(&mut self, number: usize) -> Option<&mut Event> {
        if number < self.head.len() {
            return self.head.get_mut(number);
        }
        self.tail.get_mut(number.checked_sub(self.head.len() + self.omitted)?)
    }

    fn open(&mut self, statement: bool) {
        self.inside.push(Inside { statement, values: Vec::new() });
    }

    fn close(&mut self) -> Vec<(Span, PixelValue)> {
        self.inside.pop().map_or(Vec::new(), |inside| inside.values)
    }

    /// Has the first one of its kind come up already?
    fn knows(&self, what: NotFinite) -> bool {
        self.births.iter().any(|birth| birth.what == what)
    }
}

/// How many numbers an event holds. (A call's result comes later; then only its arguments count.)
fn cells(kind: &EventKind) -> usize {
    match kind {
        EventKind::Input { value, .. }
        | EventKind::Param { value, .. }
        | EventKind::Assign { value, .. }
        | EventKind::Kept { value }
        | EventKind::Value { value }
        | EventKind::Branch { value, .. }
        | EventKind::Return { value } => value.cells().len(),
        EventKind::Round { element } => element.as_ref().map_or(0, |(_, value)| value.cells().len()),
        EventKind::Call { arguments, .. } => arguments.iter().map(|(_, value)| value.cells().len()).sum(),
        EventKind::Print { parts } => {
            let cells = |part: &Part| if let Part::Value(value) = part { value.cells().len() } else { 0 };
            parts.iter().map(cells).sum()
        }
        EventKind::LoopEnd { .. } | EventKind::Break | EventKind::Continue | EventKind::Omitted { .. } => 0,
    }
}

impl<'r> Machine<'r> {
    /// Records from now on.
    pub(super) fn trace(&mut self, tracer: Option<Box<Tracer>>) {
        self.watched |= tracer.is_some();
        self.tracer = tracer;
    }

    fn note(&mut self, span: Span, kind: EventKind) -> Option<usize> {
        let depth = self.calls.len();
        self.tracer.as_mut()?.record(depth, span, kind)
    }

    /// What a variable holds at the pixel.
    fn held(&self, place: Place) -> Option<PixelValue> {
        self.slot_of(place).value.as_ref().map(|value| value.pixel(0))
    }

    /// What the pixel begins with, of what the program reads.
    pub(super) fn trace_inputs(&mut self) {
        let program = self.program;
        for (i, global) in program.globals.iter().enumerate() {
            let constant = names::constant(&global.name).is_some() && !self.bound.has(&global.name);
            let Some(span) = global.read.filter(|_| !global.library && global.framed.is_none() && !constant)
            else {
                continue;
            };
            let place = Place::Global(i as u32);
            self.slot(place);
            if let Some(value) = self.held(place) {
                self.note(span, EventKind::Input { name: global.name.clone(), value });
            }
        }
    }

    /// A `param` line was run.
    pub(super) fn trace_param(&mut self, param: &Param, set: bool) {
        if let Some(value) = self.held(Place::Global(param.slot)) {
            self.note(param.span, EventKind::Param { name: param.name.clone(), value, set });
        }
    }

    /// Runs a statement and tells what it did.
    pub(super) fn traced(&mut self, stmt: &'r Stmt, mask: &Mask) -> Result<Mask> {
        let old = match &stmt.kind {
            StmtKind::Assign { place, op: Some(_), .. } => {
                self.slot(*place);
                self.held(*place)
            }
            _ => None,
        };
        let looping = matches!(stmt.kind, StmtKind::While(..) | StmtKind::For(..));
        if let Some(tracer) = &mut self.tracer {
            tracer.open(true);
            if looping {
                tracer.rounds.push(0);
            }
        }
        let through = self.exec(stmt, mask)?;
        let mut inside = self.tracer.as_mut().map_or(Vec::new(), |tracer| tracer.close());
        let last = inside.last().map(|(_, value)| value.clone());
        match (&stmt.kind, last) {
            (StmtKind::Assign { place, name, op, value, .. }, _) => {
                if let (Some(old), Some(_)) = (old, op) {
                    inside.insert(0, (*name, old));
                    self.trace_operator(stmt.span, *name, *place, &inside);
                }
                let kept = matches!(&value.kind, ExprKind::Kept(id, ..) if self.kept[*id as usize].is_some());
                if let Some(value) = self.held(*place) {
                    let name = self.name(*place).to_string();
                    self.note(stmt.span, EventKind::Assign { name, value, kept: kept && op.is_none() });
                }
            }
            (StmtKind::Expr(e), Some(value)) if !matches!(e.kind, ExprKind::Call(..)) => {
                self.note(stmt.span, EventKind::Value { value });
            }
            (StmtKind::Return(_), Some(value)) => {
                self.note(stmt.span, EventKind::Return { value });
            }
            (StmtKind::While(..) | StmtKind::For(..), _) => {
                let rounds = self.tracer.as_mut().and_then(|tracer| tracer.rounds.pop()).unwrap_or(0);
                self.note(stmt.span, EventKind::LoopEnd { rounds });
            }
            (StmtKind::Break, _) => {
                self.note(stmt.span, EventKind::Break);
            }
            (StmtKind::Continue, _) => {
                self.note(stmt.span, EventKind::Continue);
            }
            _ => {}
        }
        Ok(through)
    }

    /// The operator of an `op=`, which is no expression: has NaN come out of it?
    fn trace_operator(&mut self, span: Span, name: Span, place: Place, operands: &[(Span, PixelValue)]) {
        let Some(value) = self.held(place) else { return };
        let Some((_, old)) = operands.first() else { return };
        if let Some(what) = NotFinite::of(old).filter(|what| self.given(place, *what)) {
            self.trace_birth(what, name, old.clone(), Vec::new(), true);
        }
        if let Some(what) = NotFinite::of(&value)
            && operands.iter().all(|(_, operand)| NotFinite::of(operand) != Some(what))
        {
            self.trace_birth(what, span, value, operands.to_vec(), false);
        }
    }

    fn trace_birth(
        &mut self,
        what: NotFinite,
        span: Span,
        value: PixelValue,
        operands: Vec<(Span, PixelValue)>,
        given: bool,
    ) {
        let name = |f: u32| self.program.functions[f as usize].name.clone();
        let calls = self.calls.iter().rev().map(|(f, span)| (name(*f), *span)).collect();
        let Some(tracer) = self.tracer.as_mut().filter(|tracer| !tracer.knows(what)) else { return };
        let rounds = tracer.rounds.clone();
        tracer.births.push(Birth { what, span, value, operands, given, calls, rounds });
    }

    /// Computes an expression, and looks whether NaN or an infinity comes up in it.
    #[cold]
    pub(super) fn eval_traced(&mut self, e: &'r Expr, mask: &Mask) -> Result<Value> {
        // Numbers stand in the text for all to see.
        if matches!(e.kind, ExprKind::Number(_)) {
            return self.eval_here(e, mask);
        }
        let new = match &e.kind {
            ExprKind::Kept(id, _, reads) => !reads.is_empty() && self.kept[*id as usize].is_none(),
            _ => false,
        };
        if let Some(tracer) = &mut self.tracer {
            tracer.open(false);
        }
        let result = self.eval_here(e, mask)?;
        let operands = self.tracer.as_mut().map_or(Vec::new(), |tracer| tracer.close());
        let value = result.pixel(0);
        if let Some(what) = NotFinite::of(&value) {
            self.trace_not_finite(what, e, &value, operands);
        }
        // What is a part of a statement by itself is told with the statement.
        let part = self.tracer.as_ref().and_then(|t| t.inside.last()).is_some_and(|inside| !inside.statement);
        if let ExprKind::Kept(id, ..) = &e.kind
            && new
            && part
            && self.kept[*id as usize].is_some()
        {
            self.note(e.span, EventKind::Kept { value: value.clone() });
        }
        if let Some(inside) = self.tracer.as_mut().and_then(|tracer| tracer.inside.last_mut()) {
            inside.values.push((e.span, value));
        }
        Ok(result)
    }

    /// Looks whether an expression is where its NaN or infinity came up.
    fn trace_not_finite(
        &mut self,
        what: NotFinite,
        e: &Expr,
        value: &PixelValue,
        mut operands: Vec<(Span, PixelValue)>,
    ) {
        let given = match &e.kind {
            ExprKind::Variable(place) => self.given(*place, what),
            // A variable is looked into without being computed.
            ExprKind::Index(base, _) | ExprKind::Component(base, _) => match base.kind {
                ExprKind::Variable(place) => self.given(place, what),
                _ => false,
            },
            ExprKind::Unary(..) | ExprKind::Binary(..) | ExprKind::Builtin(..) | ExprKind::Host(..) => {
                if operands.iter().any(|(_, operand)| NotFinite::of(operand) == Some(what)) {
                    return;
                }
                // Defaults stand nowhere.
                operands.retain(|(span, _)| *span != e.span);
                return self.trace_birth(what, e.span, value.clone(), operands, false);
            }
            // It came up in a part of them.
            _ => false,
        };
        if given {
            self.trace_birth(what, e.span, value.clone(), Vec::new(), true);
        }
    }

    /// Must what a variable holds have come from outside? (Of NaN all is known that the program computes. An infinity can
    /// be that of the constant, which is meant.)
    fn given(&self, place: Place, what: NotFinite) -> bool {
        let Place::Global(i) = place else { return false };
        let global = &self.program.globals[i as usize];
        let outside = !matches!(self.bound.sources[i as usize], Source::Nowhere);
        let constant = names::constant(&global.name).is_some() && !self.bound.has(&global.name);
        outside && !constant && (what == NotFinite::Nan || global.assigned.is_none())
    }

    /// A condition was computed, and `taken` or not.
    #[cold]
    pub(super) fn trace_branch(&mut self, span: Span, value: &Value, taken: bool) {
        self.note(span, EventKind::Branch { value: value.pixel(0), taken });
    }

    /// A round of a loop begins.
    #[cold]
    pub(super) fn trace_round(&mut self, span: Span, element: Option<Place>) {
        if let Some(round) = self.tracer.as_mut().and_then(|tracer| tracer.rounds.last_mut()) {
            *round += 1;
        }
        let element = element.and_then(|place| Some((self.name(place).to_string(), self.held(place)?)));
        self.note(span, EventKind::Round { element });
    }

    /// A function is called with these values. Gives the number of the event.
    #[cold]
    pub(super) fn trace_call(&mut self, f: u32, span: Span, values: &[Value]) -> Option<usize> {
        let function = &self.program.functions[f as usize];
        let arguments = function.locals.iter().cloned().zip(values.iter().map(|v| v.pixel(0))).collect();
        let number =
            self.note(span, EventKind::Call { name: function.name.clone(), arguments, result: None });
        if let Some(tracer) = &mut self.tracer {
            let rounds = std::mem::take(&mut tracer.rounds);
            tracer.callers.push(rounds);
        }
        number
    }

    /// That call has returned.
    #[cold]
    pub(super) fn trace_return(&mut self, number: Option<usize>, value: Option<&Value>) {
        let Some(tracer) = &mut self.tracer else { return };
        tracer.rounds = tracer.callers.pop().unwrap_or_default();
        if let Some(event) = number.and_then(|number| tracer.event(number))
            && let EventKind::Call { result, .. } = &mut event.kind
        {
            *result = value.map(|value| value.pixel(0));
        }
    }

    /// A line was printed.
    pub(super) fn trace_print(&mut self, span: Span, parts: Vec<Part>) {
        self.note(span, EventKind::Print { parts });
    }
}
