//! One thread's share of a run: batches, cut where they have to be, and the first pixel in error.

use super::bind::Bound;
use super::fault::Fault;
use super::machine::{Machine, Memory};
use super::output::Misfit;
use super::pixels::Pixels;
use super::run::{Failure, Options};
use crate::diagnostic::Diagnostic;
use crate::resolve::Resolved;
use crate::value::Mask;

/// Why a worker stopped.
pub(super) enum Stop {
    Error(Box<Diagnostic>, usize),
    Misfit(Misfit),
    Cancelled,
}

impl Stop {
    pub fn failure(self, bound: &Bound<'_>) -> Failure {
        match self {
            Stop::Error(mut error, pixel) => {
                error.pixel = Some(bound.position(pixel));
                Failure::Program(vec![*error])
            }
            Stop::Misfit(_) | Stop::Cancelled => Failure::Cancelled,
        }
    }

    /// The pixel it stopped at.
    pub fn pixel(&self) -> usize {
        match self {
            Stop::Error(_, pixel) => *pixel,
            Stop::Misfit(misfit) => misfit.pixel,
            Stop::Cancelled => 0,
        }
    }
}

/// One thread's evaluation.
pub(super) struct Worker<'r> {
    pub machine: Machine<'r>,
    by_normal: bool,
    /// Memory for who gives it pixels.
    pub room: Room,
}

/// Memory for the stretches that a worker runs.
#[derive(Default)]
pub(super) struct Room {
    /// Planes of the outputs.
    pub planes: Vec<f32>,
    /// The pixels of a batch.
    pub list: Vec<usize>,
}

/// What a worker leaves to the next run of the same program.
#[derive(Default)]
pub(super) struct Parts {
    pub memory: Memory,
    pub room: Room,
}

/// Takes what a batch left in the machine.
pub(super) type Sink<'s> = dyn FnMut(&Machine<'_>, Pixels<'_>) -> Result<(), Misfit> + 's;

impl<'r> Worker<'r> {
    pub fn new(
        program: &'r Resolved,
        bound: &'r Bound<'r>,
        options: &Options<'r>,
        by_normal: bool,
        parts: Parts,
    ) -> Worker<'r> {
        let Parts { memory, room } = parts;
        let mut machine = Machine::new(program, bound, options.isa(), options.limits, options.cancel, memory);
        if options.no_optimize {
            machine.plain();
        }
        machine.printer.limit = options.prints;
        machine.printer.columns = options.print_columns.clone();
        if program.derivatives {
            machine.cast_shadows();
        }
        Worker { machine, by_normal, room }
    }

    /// What the next run may use again.
    pub fn into_parts(self) -> Parts {
        Parts { memory: self.machine.into_memory(), room: self.room }
    }

    fn batch(&mut self, pixels: Pixels<'_>, count: bool) -> Result<(), Fault> {
        let machine = &mut self.machine;
        machine.reset(pixels.len(), count);
        if let Some(clock) = &mut machine.clock {
            clock.start();
        }
        machine.load(pixels);
        if machine.tracer.is_some() {
            machine.trace_inputs();
        }
        let mut mask = Mask::All;
        let mut body = &machine.program.body[..];
        // Statements one after another that shadows have to run, or need not.
        for part in machine.program.shadowed.chunk_by(|a, b| a == b) {
            let (stmts, rest) = body.split_at(part.len());
            mask =
                if part[0] { machine.block(stmts, &mask)? } else { machine.without_shadows(stmts, &mask)? };
            body = rest;
        }
        mask = machine.block(body, &mask)?;
        if let Some(block) = machine.program.by_normal.as_ref().filter(|_| self.by_normal) {
            machine.block(block, &mask)?;
        }
        machine.settle_outputs();
        Ok(())
    }

    /// What stops a pixel before a lane: it may be wrong at a later place of the program.
    fn earlier(&mut self, pixels: Pixels<'_>, lane: usize) -> Option<Stop> {
        let before: Vec<usize> = (0..lane).map(|i| pixels.at(i)).collect();
        self.run(Pixels::List(&before), &mut |_, _| Ok(())).err()
    }

    /// Runs pixels, cut where they have to be, and gives each finished batch to the sink. An error is that of
    /// the first pixel that has one.
    pub fn run(&mut self, pixels: Pixels<'_>, sink: &mut Sink<'_>) -> Result<(), Stop> {
        if pixels.len() == 0 {
            return Ok(());
        }
        let mut outcome = self.batch(pixels, false);
        if let Err(Fault::Count(lane)) = outcome {
            // Mostly it is this one. Alone it is sooner tried than the batch is run again.
            let suspect = [pixels.at(lane)];
            if pixels.len() > 1
                && let Err(stop) = self.run(Pixels::List(&suspect), &mut |_, _| Ok(()))
            {
                return Err(self.earlier(pixels, lane).unwrap_or(stop));
            }
            outcome = self.batch(pixels, true);
        }
        match outcome {
            Ok(()) => sink(&self.machine, pixels).map_err(Stop::Misfit),
            Err(Fault::Cancelled | Fault::Count(_)) => Err(Stop::Cancelled),
            Err(Fault::Error(error, lane)) => {
                // A shadow's lane is told as its pixel's.
                let lane = lane % pixels.len();
                Err(self.earlier(pixels, lane).unwrap_or_else(|| Stop::Error(error, pixels.at(lane))))
            }
            Err(Fault::Split(mask)) => {
                let n = pixels.len();
                let pick = |on: bool| -> Vec<usize> {
                    (0..n).filter(|&i| mask.has(i) == on).map(|i| pixels.at(i)).collect()
                };
                let (one, other) = (pick(true), pick(false));
                if one.is_empty() || other.is_empty() {
                    let error =
                        Diagnostic::bare("internal", "internal error: a batch split left one half empty");
                    return Err(Stop::Error(Box::new(error), pixels.at(0)));
                }
                let Err(first) = self.run(Pixels::List(&one), sink) else {
                    return self.run(Pixels::List(&other), sink);
                };
                // Only an earlier pixel could still change which error is told.
                let before = other.partition_point(|&p| p < first.pixel());
                match self.run(Pixels::List(&other[..before]), &mut |_, _| Ok(())) {
                    Ok(()) => Err(first),
                    earlier => earlier,
                }
            }
        }
    }
}
