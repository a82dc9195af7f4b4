//! The state of one thread's evaluation: variables, calls, and the count of steps.

use super::bind::Bound;
use super::fault::{Fault, Result};
use super::limits::Limits;
use super::pixels::Batch;
use super::plan::Plans;
use super::print::Printer;
use super::profile::Clock;
use super::samples::Places;
use super::tracer::Tracer;
use crate::diagnostic::{Diagnostic, Span};
use crate::lanes::Isa;
use crate::resolve::names;
use crate::resolve::tree::*;
use crate::stack::Nesting;
use crate::value::{Mask, Value, Width, live_bytes};
use std::sync::atomic::{AtomicBool, Ordering};

/// Vectors of more scalars than this are large: to compute one counts as several steps.
const LARGE: usize = 256;

/// Scalars of a large vector that count as a step.
const CELLS_A_STEP: usize = 32;

/// A batch that has taken so many steps may be on its way to the limit: it goes on in narrower ones, so that a
/// runaway program comes to its end sooner.
const LONG: u32 = 8192;

/// Lanes of a batch that is narrow enough for long runs.
const NARROW: usize = 256;

/// Steps between looks at the cancellation.
const POLL: u32 = 64;

/// A variable: its value, and the lanes in which it has one.
#[derive(Clone, Debug)]
pub(super) struct Slot {
    pub value: Option<Value>,
    pub defined: Mask,
}

impl Slot {
    pub const EMPTY: Slot = Slot { value: None, defined: Mask::None };

    /// A variable that every lane has.
    pub fn full(value: Value) -> Slot {
        Slot { value: Some(value), defined: Mask::All }
    }
}

/// The lanes that left a loop's round early.
pub(super) struct Loop {
    pub broken: Mask,
    pub continued: Mask,
}

/// What a running call has returned so far.
pub(super) struct Frame {
    pub returned: Option<Value>,
    pub lanes: Mask,
    /// Where the caller's locals begin.
    pub caller_base: usize,
}

/// Runs batches of one program, bound to one image, on one thread.
pub(super) struct Machine<'r> {
    pub program: &'r Resolved,
    pub bound: &'r Bound<'r>,
    pub isa: Isa,
    pub limits: Limits,
    pub cancel: Option<&'r AtomicBool>,
    /// Lanes of the batch that runs.
    pub n: usize,
    /// Is the whole batch one pixel, so that the steps are exactly those of its lanes?
    single: bool,
    /// Lanes of a pixel: one, or three with its shadows. See [`super::shadow`].
    pub lanes_a_pixel: usize,
    pub globals: Vec<Slot>,
    /// Which of them are still to be filled from the image.
    pub pending: Vec<bool>,
    /// Where the batch's pixels are.
    pub pixels: Batch,
    /// Where the running sample lies in each pixel; `None`: in the middle.
    pub sample: Option<Places>,
    /// How far from the middle it lies in the pixels of the batch.
    pub places: Vec<[f32; 2]>,
    pub locals: Vec<Slot>,
    /// Where the running call's locals begin.
    pub base: usize,
    pub loops: Vec<Loop>,
    pub frames: Vec<Frame>,
    /// The calls that led here, outermost first.
    pub calls: Vec<(u32, Span)>,
    /// The statement that runs, for faults that have no place of their own.
    pub at: Span,
    /// Values of [`ExprKind::Kept`].
    pub kept: Vec<Option<Value>>,
    /// Steps of the batch: no lane has taken more.
    steps: u32,
    /// Steps of each lane instead, in a batch whose own were too many.
    counts: Option<Vec<u32>>,
    /// In what is kept for the frame, which is the same for all lanes.
    keeping: bool,
    /// Evaluations and blocks inside of others.
    pub nesting: Nesting,
    /// How often steps were counted, to look for a cancellation now and then.
    polls: u32,
    /// Does somebody look on, the clock or the tracer?
    pub watched: bool,
    /// Measures statements, if that is wanted.
    pub clock: Option<Box<Clock>>,
    /// Tells what happens at the batch's one pixel, if that is wanted.
    pub tracer: Option<Box<Tracer>>,
    /// Collects what the batch prints.
    pub printer: Printer,
    /// Shorter ways for some statements; see [`super::plan`].
    pub plans: Plans,
    /// Are such taken?
    optimize: bool,
    /// The outer variables that are to be written.
    outputs: Vec<u32>,
    /// Whether the others need not be there when the batch is done.
    only_outputs: bool,
}

/// What a machine keeps from one run of a program to the next: memory, and the plans of its statements.
#[derive(Default)]
pub(super) struct Memory {
    globals: Vec<Slot>,
    pending: Vec<bool>,
    places: Vec<[f32; 2]>,
    locals: Vec<Slot>,
    loops: Vec<Loop>,
    frames: Vec<Frame>,
    calls: Vec<(u32, Span)>,
    kept: Vec<Option<Value>>,
    plans: Plans,
    outputs: Vec<u32>,
}

impl Memory {
    /// Forgets what depends on the values of the frame and on the outputs.
    pub fn forget_plans(&mut self) {
        self.kept.clear();
        self.globals.clear();
        self.plans = Plans::default();
    }
}

impl<'r> Machine<'r> {
    pub fn new(
        program: &'r Resolved,
        bound: &'r Bound<'r>,
        isa: Isa,
        limits: Limits,
        cancel: Option<&'r AtomicBool>,
        memory: Memory,
    ) -> Machine<'r> {
        let Memory {
            mut globals,
            mut pending,
            places,
            locals,
            loops,
            frames,
            calls,
            mut kept,
            plans,
            outputs,
        } = memory;
        globals.resize(program.globals.len(), Slot::EMPTY);
        pending.clear();
        pending.resize(program.globals.len(), false);
        kept.resize(program.kept, None);
        Machine {
            program,
            bound,
            isa,
            limits,
            cancel,
            n: 1,
            single: true,
            lanes_a_pixel: 1,
            globals,
            pending,
            pixels: Batch::Run(0, 0),
            sample: None,
            places,
            locals,
            base: 0,
            loops,
            frames,
            calls,
            at: Span::default(),
            kept,
            steps: 0,
            counts: None,
            keeping: false,
            nesting: Nesting::default(),
            polls: 0,
            watched: false,
            clock: None,
            tracer: None,
            printer: Printer::default(),
            plans,
            optimize: true,
            outputs,
            only_outputs: false,
        }
    }

    /// What the next run of the program may use again.
    pub fn into_memory(self) -> Memory {
        let Machine {
            mut globals,
            pending,
            places,
            mut locals,
            loops,
            frames,
            calls,
            kept,
            plans,
            outputs,
            ..
        } = self;
        // What differs from pixel to pixel goes back to where batches take it from. What is the same for the frame stays.
        for slot in &mut globals {
            if slot.value.as_ref().is_some_and(|value| !value.is_uniform()) {
                *slot = Slot::EMPTY;
            }
        }
        locals.clear();
        Memory { globals, pending, places, locals, loops, frames, calls, kept, plans, outputs }
    }

    /// Without shorter ways for statements.
    pub fn plain(&mut self) {
        self.optimize = false;
    }

    /// Of the outer variables only these are wanted when the batch is done.
    pub fn want(&mut self, outputs: impl Iterator<Item = u32>) {
        self.outputs.clear();
        self.outputs.extend(outputs);
        self.only_outputs = true;
    }

    /// Is the variable wanted when the batch is done?
    pub fn wanted(&self, place: Place) -> bool {
        match place {
            Place::Global(i) if self.only_outputs => self.outputs.contains(&i),
            _ => true,
        }
    }

    /// May statements be run by a plan? Not where each lane's steps are counted.
    pub fn plans_allowed(&self) -> bool {
        self.optimize && self.counts.is_none() && !self.keeping
    }

    /// May so many calls more be one inside of the other?
    pub fn room_for_calls(&self, calls: usize) -> bool {
        self.calls.len() + calls <= self.limits.depth as usize
    }

    /// How wide the batch is.
    pub fn width(&self) -> Width {
        Width { n: self.n, isa: self.isa }
    }

    /// Forgets the last batch. `count`: count each lane's steps by itself.
    pub fn reset(&mut self, pixels: usize, count: bool) {
        let n = pixels * self.lanes_a_pixel;
        self.n = n;
        self.single = pixels == 1;
        self.locals.clear();
        self.base = 0;
        self.loops.clear();
        self.frames.clear();
        self.calls.clear();
        self.steps = 0;
        self.keeping = false;
        self.printer.reset();
        self.counts = count.then(|| vec![0; n]);
    }

    /// Goes on with so many lanes, of whose counts of steps `pick` makes the new ones. Gives the old counts.
    pub fn set_width(&mut self, n: usize, pick: impl FnOnce(&[u32]) -> Vec<u32>) -> Option<Vec<u32>> {
        self.n = n;
        let old = self.counts.take();
        self.counts = old.as_deref().map(pick);
        old
    }

    /// Goes back to so many lanes and these counts. Gives the counts of the lanes until now.
    pub fn restore_width(&mut self, n: usize, counts: Option<Vec<u32>>) -> Option<Vec<u32>> {
        self.n = n;
        std::mem::replace(&mut self.counts, counts)
    }

    /// The steps of each lane, where they are counted.
    pub fn counts_mut(&mut self) -> Option<&mut Vec<u32>> {
        self.counts.as_mut()
    }

    /// Counts a round of a loop or a call for the active lanes.
    pub fn step(&mut self, mask: &Mask, span: Span) -> Result<()> {
        self.charge(1, mask, span)
    }

    /// Counts the steps that it takes to compute so many cells, if they are many.
    pub fn work(&mut self, cells: usize, uniform: bool, mask: &Mask, span: Span) -> Result<()> {
        if cells <= LARGE {
            return Ok(());
        }
        // A batch too wide for what it is about to compute is cut before, not after.
        if !uniform
            && self.pixels() > 1
            && live_bytes() + cells * self.n * size_of::<f32>() > self.limits.memory
        {
            return Err(self.halve());
        }
        self.charge((cells / CELLS_A_STEP) as u32, mask, span)
    }

    /// Counts so many steps.
    pub fn charge(&mut self, steps: u32, mask: &Mask, span: Span) -> Result<()> {
        self.polls = self.polls.wrapping_add(1);
        if let Some(cancel) = self.cancel
            && self.polls.is_multiple_of(POLL)
            && cancel.load(Ordering::Relaxed)
        {
            return Err(Fault::Cancelled);
        }
        let (n, limit) = (self.n, self.limits.steps);
        let over = match &mut self.counts {
            Some(counts) => {
                let mut over = None;
                for lane in mask.lanes(n) {
                    counts[lane] = counts[lane].saturating_add(steps);
                    if counts[lane] > limit && over.is_none() {
                        over = Some(lane);
                    }
                }
                over
            }
            None => {
                self.steps = self.steps.saturating_add(steps);
                if self.steps > LONG && n > NARROW && !self.keeping {
                    return Err(self.halve());
                }
                match self.steps > limit {
                    false => None,
                    // All lanes have taken the same way here. (One lane of a batch, gathered, has perhaps taken fewer.)
                    true if self.single || self.keeping => Some(self.first(mask)),
                    true => return Err(Fault::Count(self.first(mask))),
                }
            }
        };
        let Some(lane) = over else { return Ok(()) };
        let error = Diagnostic::error("limit", format!("the program took more than {limit} steps"), span)
            .hint("Does every loop end? Look whether its block changes what its condition tests.")
            .hint("Each round of a loop and each call is a step. A higher limit can be set (`--max-steps`).");
        Err(self.fault(error, lane))
    }

    /// Does something that a fault may leave in the middle of a call or a loop, and comes back from it in any case.
    pub fn guarded<T>(&mut self, f: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        let (base, at) = (self.base, self.at);
        let depths = (self.locals.len(), self.calls.len(), self.frames.len(), self.loops.len());
        let outcome = f(self);
        if outcome.is_err() {
            (self.base, self.at) = (base, at);
            self.locals.truncate(depths.0);
            self.calls.truncate(depths.1);
            self.frames.truncate(depths.2);
            self.loops.truncate(depths.3);
        }
        outcome
    }

    /// Computes what is kept for the frame, on steps of its own: it is not done again at every pixel, and must
    /// not count at the one that happens to come first.
    pub fn keep(&mut self, e: &'r Expr, mask: &Mask) -> Result<Value> {
        let steps = std::mem::replace(&mut self.steps, 0);
        let counts = self.counts.take();
        let keeping = std::mem::replace(&mut self.keeping, true);
        let value = self.eval(e, mask);
        self.steps = steps;
        self.counts = counts;
        self.keeping = keeping;
        value
    }

    /// An error at a lane, with the calls that led to it.
    pub fn fault(&self, mut error: Diagnostic, lane: usize) -> Fault {
        error.trace = self
            .calls
            .iter()
            .rev()
            .map(|(f, span)| (self.program.functions[*f as usize].name.clone(), *span))
            .collect();
        Fault::Error(Box::new(error), lane)
    }

    /// The first active lane, where errors of all lanes are reported.
    pub fn first(&self, mask: &Mask) -> usize {
        mask.first(self.n).unwrap_or(0)
    }

    /// The slot of a variable.
    pub fn slot(&mut self, place: Place) -> &mut Slot {
        match place {
            Place::Global(i) => {
                self.settle(i as usize);
                &mut self.globals[i as usize]
            }
            Place::Local(i) => &mut self.locals[self.base + i as usize],
        }
    }

    /// The slot of a variable, to look at.
    pub fn slot_of(&self, place: Place) -> &Slot {
        match place {
            Place::Global(i) => &self.globals[i as usize],
            Place::Local(i) => &self.locals[self.base + i as usize],
        }
    }

    /// The name of a variable.
    pub fn name(&self, place: Place) -> &str {
        match place {
            Place::Global(i) => &self.program.globals[i as usize].name,
            Place::Local(i) => {
                let function = self.calls.last().map_or(0, |(f, _)| *f);
                &self.program.functions[function as usize].locals[i as usize]
            }
        }
    }

    /// A variable's value, which every active lane must have.
    pub fn read(&mut self, place: Place, span: Span, mask: &Mask) -> Result<&Value> {
        let (n, width) = (self.n, self.width());
        if let Place::Global(i) = place {
            self.settle(i as usize);
        }
        let slot = match place {
            Place::Global(i) => &self.globals[i as usize],
            Place::Local(i) => &self.locals[self.base + i as usize],
        };
        if slot.value.is_none() || !mask.is_subset(&slot.defined, width) {
            let lane = mask.minus(&slot.defined, width).first(n).unwrap_or(0);
            return Err(self.no_value(place, span, lane));
        }
        let slot = match place {
            Place::Global(i) => &self.globals[i as usize],
            Place::Local(i) => &self.locals[self.base + i as usize],
        };
        // Just tested: it has one.
        slot.value.as_ref().ok_or(Fault::Cancelled)
    }

    fn no_value(&self, place: Place, span: Span, lane: usize) -> Fault {
        let name = self.name(place);
        let mut error = Diagnostic::error("value", format!("`{name}` has no value here"), span)
            .label(span, "read before it is assigned");
        error = match place {
            Place::Local(_) => {
                // An image may have more variables than the program reads.
                let outer = self.program.globals.iter().any(|g| g.name == name && !g.library)
                    || self.bound.has(name)
                    || names::USUAL_INPUTS.contains(&name);
                if outer {
                    error
                        .hint(format!(
                            "A function that assigns `{name}` has its own `{name}`, and never changes the outer one."
                        ))
                        .hint("Return the new value, or use another name inside the function.")
                } else {
                    error.hint(format!(
                        "Give `{name}` a value on every path to this line, for example `{name} = 0` above."
                    ))
                }
            }
            Place::Global(_) => error.hint(format!(
                "Give `{name}` a value on every path to this line, for example `{name} = 0` above."
            )),
        };
        if let Place::Global(_) = place {
            error = self.bound.missing_hints(name).into_iter().fold(error, Diagnostic::hint);
        }
        self.fault(error, lane)
    }

    /// Stores a value in the active lanes of a variable. It stays uniform only if no other lane has a value.
    pub fn store(&mut self, place: Place, value: Value, mask: &Mask) -> Result<()> {
        self.check_memory()?;
        let width = self.width();
        let slot = self.slot(place);
        if slot.value.is_none() || slot.defined.is_subset(mask, width) {
            *slot = Slot { value: Some(value), defined: mask.clone() };
            return Ok(());
        }
        if let Some(old) = slot.value.take() {
            slot.value = Some(blend(mask, &value, &old, width)?);
        }
        slot.defined = slot.defined.or(mask, width);
        Ok(())
    }

    /// Ends a program that holds too much. A batch is cut in half first.
    pub fn check_memory(&self) -> Result<()> {
        if live_bytes() <= self.limits.memory {
            return Ok(());
        }
        if self.pixels() > 1 {
            return Err(self.halve());
        }
        let megabytes = self.limits.memory >> 20;
        let message = format!("the program's variables take more than {megabytes} megabytes at this pixel");
        let error =
            Diagnostic::error("limit", message, self.at).hint("A higher limit can be set (`--max-memory`).");
        Err(self.fault(error, 0))
    }

    /// To be run in two halves.
    fn halve(&self) -> Fault {
        let pixels = self.pixels();
        Fault::Split(Mask::from_fn(self.n, |i| i % pixels < pixels / 2))
    }
}

/// The new value in the lanes of the mask, the old one in the rest. Their shapes must agree.
pub(super) fn blend(mask: &Mask, new: &Value, old: &Value, width: Width) -> Result<Value> {
    if new.shape != old.shape {
        return Err(Fault::Split(mask.clone()));
    }
    let planes = new.planes.iter().zip(&old.planes).map(|(new, old)| mask.select(new, old, width)).collect();
    Ok(Value { shape: new.shape.clone(), planes })
}
