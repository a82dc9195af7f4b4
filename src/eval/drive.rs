//! The pixels of a run: threads take stretches of them, and each stretch is written where it belongs.

use super::output::{self, Misfit};
use super::pixels::Pixels;
use super::print::Prints;
use super::profile::Profile;
use super::run::{Attempt, Failure, Job, MAX_THREADS, Progress, Report};
use super::shadow;
use super::target::{Stretch, Target, Targets};
use super::worker::{Parts, Stop, Worker};
use crate::clock::Instant;
use crate::diagnostic::Diagnostic;
use crate::image::{Image, Variable};
use crate::parallel;
use crate::shape::Shape;
use smallvec::SmallVec;
use std::borrow::Cow;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Pixels that a thread takes at a time.
pub(super) const CHUNK: usize = 4 * super::BATCH;

/// Pixels of a row that are worth a batch of their own; narrower windows are gathered from several rows.
const MIN_RUN: usize = 512;

/// What is known of a run beside its pixels.
pub(super) struct Outcome {
    pub not_finite: usize,
    pub threads: usize,
    pub time: Duration,
    pub prints: Prints,
    pub profile: Option<Profile>,
}

/// Why the pixels were not run to their end.
pub(super) enum Interruption {
    /// An output has another shape than the planes.
    Misfit(Misfit),
    Failure(Failure),
}

/// A value of a mutex, also after a panic elsewhere.
fn into_inner<T>(mutex: Mutex<T>) -> T {
    mutex.into_inner().unwrap_or_else(PoisonError::into_inner)
}

impl Job<'_> {
    /// Runs the whole image with the shapes known so far.
    pub fn attempt(&self, parts: &Mutex<Vec<Parts>>) -> Result<Attempt, Failure> {
        self.check_outputs()?;
        let total = self.total();
        let count: usize = self.outputs.iter().map(|o| o.shape.cells()).sum();
        let mut planes: Vec<Vec<f32>> = (0..count).map(|_| vec![0.0; total]).collect();
        let targets = planes.iter_mut().enumerate().map(|(i, plane)| Target::plane(i, plane)).collect();
        match self.drive(Targets::new(self.grid().size(), targets), parts) {
            Ok(outcome) => Ok(Attempt::Done(Box::new(self.report(self.image_of(planes), outcome)))),
            Err(Interruption::Misfit(misfit)) => Ok(Attempt::Again(misfit)),
            Err(Interruption::Failure(failure)) => Err(failure),
        }
    }

    /// Runs all pixels, and writes them to the targets.
    pub fn drive(&self, targets: Targets<'_>, parts: &Mutex<Vec<Parts>>) -> Result<Outcome, Interruption> {
        let (grid, total) = (self.grid(), self.total());
        let targets = Mutex::new(targets);
        let end = AtomicUsize::new(usize::MAX);
        let stopped: Mutex<Option<Stop>> = Mutex::new(None);
        let broken = AtomicBool::new(false);
        let (done, not_finite) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let profile = Mutex::new(Profile::new());
        let prints = Mutex::new(Prints::default());
        let (busy, workers) = (Mutex::new(Duration::ZERO), AtomicUsize::new(0));
        let work = || {
            let begin = Instant::now();
            let own = parts.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default();
            let mut worker = self.worker(own);
            let mut printed = Prints::default();
            if self.options.profile {
                worker.machine.measure();
            }
            loop {
                let next = match targets.lock() {
                    Ok(mut targets) => targets.next(CHUNK),
                    Err(_) => None,
                };
                let reached = |stretch: &Stretch<'_>| grid.pixel(stretch.start) < end.load(Ordering::Relaxed);
                let Some(mut stretch) = next.filter(reached) else { break };
                match self.stretch(&mut worker, &mut stretch, &mut printed) {
                    Ok(odd) => {
                        not_finite.fetch_add(odd, Ordering::Relaxed);
                    }
                    Err(stop) => {
                        end.fetch_min(stop.pixel(), Ordering::Relaxed);
                        if let Ok(mut stopped) = stopped.lock()
                            && stopped.as_ref().is_none_or(|s| stop.pixel() < s.pixel())
                        {
                            *stopped = Some(stop);
                        }
                        continue;
                    }
                }
                let done = done.fetch_add(stretch.len, Ordering::Relaxed) + stretch.len;
                if let Some(progress) = self.options.progress {
                    let count = self.options.sampling().map_or(1, |s| s.count as usize);
                    let before = self.places.map_or(0, |p| p.sample as usize) * total;
                    if let ControlFlow::Break(()) =
                        progress(Progress { done: (before + done) / count, total })
                    {
                        broken.store(true, Ordering::Relaxed);
                        end.store(0, Ordering::Relaxed);
                    }
                }
            }
            if let Ok(mut all) = prints.lock() {
                all.add(&printed, self.options.prints);
            }
            if self.options.profile
                && let Ok(mut all) = profile.lock()
            {
                for (statement, spent) in worker.machine.profile() {
                    all.entry(statement).or_default().add(&spent);
                }
            }
            parts.lock().unwrap_or_else(PoisonError::into_inner).push(worker.into_parts());
            workers.fetch_add(1, Ordering::Relaxed);
            if let Ok(mut busy) = busy.lock() {
                *busy += begin.elapsed();
            }
        };
        self.in_threads(&work).map_err(Interruption::Failure)?;
        if broken.into_inner() {
            return Err(Interruption::Failure(Failure::Cancelled));
        }
        match into_inner(stopped) {
            None => {}
            Some(Stop::Misfit(misfit)) => return Err(Interruption::Misfit(misfit)),
            Some(stop) => return Err(Interruption::Failure(stop.failure(self.bound))),
        }
        let threads = workers.into_inner().max(1);
        Ok(Outcome {
            not_finite: not_finite.into_inner(),
            threads,
            time: into_inner(busy) / u32::try_from(threads).unwrap_or(u32::MAX),
            prints: into_inner(prints),
            profile: self.options.profile.then(|| into_inner(profile)),
        })
    }

    /// Runs `work` on every thread that was asked for.
    fn in_threads(&self, work: &(impl Fn() + Sync)) -> Result<(), Failure> {
        if let Some(executor) = self.options.executor {
            executor.run(work);
            return Ok(());
        }
        // A thread without a stretch has nothing to do.
        let useful = self.total().div_ceil(CHUNK).max(1);
        let threads = self.options.threads.unwrap_or_else(parallel::current_num_threads);
        let threads = threads.clamp(1, useful.min(MAX_THREADS));
        parallel::on_threads(threads, work).map_err(|e| {
            let error = Diagnostic::bare("threads", format!("cannot start {threads} threads: {e}"));
            Failure::Program(vec![error.hint("Ask for fewer threads.")])
        })
    }

    /// Runs a stretch of the pixels and writes it: how many of them are not finite.
    fn stretch(
        &self,
        worker: &mut Worker<'_>,
        stretch: &mut Stretch<'_>,
        prints: &mut Prints,
    ) -> Result<usize, Stop> {
        let count: usize = self.outputs.iter().map(|o| o.shape.cells()).sum();
        let len = stretch.len;
        let mut pieces = stretch.pieces.iter().enumerate();
        // Planes of their own, in their order, are written without a copy.
        if stretch.pieces.len() == count && pieces.all(|(i, piece)| piece.plane(len) == Some(i)) {
            let mut planes: SmallVec<[&mut [f32]; 16]> =
                stretch.pieces.iter_mut().map(|piece| &mut piece.data[..len]).collect();
            return self.planes(worker, stretch.start, len, &mut planes, prints);
        }
        let mut room = std::mem::take(&mut worker.room.planes);
        // Behind the planes of the outputs one of ones, for the alpha of an opaque colour.
        room.resize(room.len().max((count + 1) * len), 0.0);
        let mut planes: SmallVec<[&mut [f32]; 16]> = room.chunks_exact_mut(len).take(count + 1).collect();
        planes[count].fill(1.0);
        let odd = self.planes(worker, stretch.start, len, &mut planes[..count], prints);
        if odd.is_ok() {
            stretch.pieces.iter_mut().for_each(|piece| piece.write(&planes));
        }
        drop(planes);
        worker.room.planes = room;
        odd
    }

    fn planes(
        &self,
        worker: &mut Worker<'_>,
        start: usize,
        len: usize,
        planes: &mut [&mut [f32]],
        prints: &mut Prints,
    ) -> Result<usize, Stop> {
        let lanes = if self.program.derivatives { shadow::LANES } else { 1 };
        let batch = (self.options.batch.unwrap_or(super::BATCH) / lanes).max(1);
        let grid = self.grid();
        let (mut first, end) = (start, start + len);
        while first < end {
            if self.options.cancel.is_some_and(|c| c.load(Ordering::Relaxed)) {
                return Err(Stop::Cancelled);
            }
            let rest = batch.min(end - first);
            let run = grid.run(first).min(rest);
            let mut list = std::mem::take(&mut worker.room.list);
            let (pixels, n) = match run == rest || run >= MIN_RUN {
                true => (Pixels::Run(grid.pixel(first), run), run),
                false => {
                    list.clear();
                    list.extend((first..first + rest).map(|number| grid.pixel(number)));
                    (Pixels::List(&list), rest)
                }
            };
            let outcome = worker.run(pixels, &mut |machine, pixels| {
                machine.printer.give(prints);
                let written = match pixels {
                    Pixels::Run(pixel, n) => {
                        let numbers = Pixels::Run(grid.number(pixel), n);
                        output::write(&self.outputs, machine, numbers, start, planes)
                    }
                    Pixels::List(list) => {
                        let numbers: SmallVec<[usize; 64]> = list.iter().map(|&p| grid.number(p)).collect();
                        output::write(&self.outputs, machine, Pixels::List(&numbers), start, planes)
                    }
                };
                written.map_err(|misfit| Misfit { pixel: grid.pixel(misfit.pixel), ..misfit })
            });
            worker.room.list = list;
            outcome?;
            first += n;
        }
        self.pass_through(start, len, planes);
        let mut at = 0;
        let mut odd: SmallVec<[&[f32]; 16]> = SmallVec::new();
        for output in &self.outputs {
            let cells = output.shape.cells();
            if output.slot.is_some() {
                odd.extend(planes[at..at + cells].iter().map(|plane| &**plane));
            }
            at += cells;
        }
        Ok(output::not_finite(&odd, len))
    }

    /// Copies the variables of the input that are outputs as they are.
    fn pass_through(&self, start: usize, len: usize, planes: &mut [&mut [f32]]) {
        let grid = self.grid();
        let mut at = 0;
        for output in &self.outputs {
            let cells = output.shape.cells();
            if let Some(input) = output.input {
                let variable = self.bound.inputs.get(input);
                for (plane, samples) in planes[at..at + cells].iter_mut().zip(variable.planes()) {
                    let mut done = 0;
                    while done < len {
                        let run = grid.run(start + done).min(len - done);
                        samples.copy(grid.pixel(start + done), &mut plane[done..done + run]);
                        done += run;
                    }
                }
            }
            at += cells;
        }
    }

    /// The image of the outputs, with these planes.
    fn image_of(&self, planes: Vec<Vec<f32>>) -> Image<'static> {
        let inputs = &self.bound.inputs;
        let [width, height] = self.grid().size();
        // A colour of four components has brought its own alpha.
        let opaque = |name: &str, shape: &Shape| name != "color" || *shape != Shape::Vector(4);
        let alone = self.outputs.iter().all(|o| opaque(&o.name, &o.shape));
        let mut planes = planes.into_iter().map(Cow::Owned);
        let mut variables = Vec::new();
        for output in &self.outputs {
            let planes: Vec<Cow<'static, [f32]>> = planes.by_ref().take(output.shape.cells()).collect();
            if alone || !output.kept {
                variables.push(Variable { name: output.name.clone(), shape: output.shape.clone(), planes });
            }
        }
        let mut metadata = inputs.metadata.clone();
        if self.window.rows != (0..inputs.height) || self.window.columns != (0..inputs.width) {
            metadata.resolution = Some(inputs.resolution());
            metadata.origin[0] += self.window.columns.start as i32;
            metadata.origin[1] += self.window.rows.start as i32;
        }
        Image { width, height, variables, metadata }
    }

    /// The report of a run that made this image.
    pub fn report(&self, image: Image<'static>, outcome: Outcome) -> Report {
        let Outcome { not_finite, threads, time, prints, profile } = outcome;
        Report {
            image,
            not_finite,
            by_normal: self.by_normal,
            threads,
            time,
            frame_prints: self.bound.prints.clone(),
            prints,
            profile,
        }
    }
}
