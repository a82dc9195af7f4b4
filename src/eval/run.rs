//! A program on a whole image: batches, threads, and what comes out.

use super::bind::{Bound, Missing};
use super::grid::Grid;
use super::limits::Limits;
use super::output::{self, Chunk, Misfit, Output};
use super::pixels::Pixels;
use super::print::Prints;
use super::profile::Profile;
use super::samples::{Places, Resample, Sampling};
use super::shadow;
use super::worker::{Stop, Worker};
use crate::clock::Instant;
use crate::diagnostic::Diagnostic;
use crate::image::{Frame, Image, Matrix4, Variable};
use crate::lanes::Isa;
use crate::parallel;
use crate::resolve::Resolved;
use crate::shape::Shape;
use crate::value::PixelValue;
use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

/// Pixels that a thread takes at a time.
const CHUNK: usize = 4 * super::BATCH;

/// More threads than this are not started, whatever is asked for: they would only wait for each other.
pub const MAX_THREADS: usize = 256;

/// Bytes that textures may take, where nothing else is said: a gibibyte.
pub const TEXTURE_MEMORY: usize = 1 << 30;

/// Components of the largest output.
const MAX_PLANES: usize = 1024;

/// How many pixels are tried first, for the shapes of the outputs.
const SAMPLES: usize = 9;

/// How far a run has come.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Pixels done.
    pub done: usize,
    /// Pixels in all.
    pub total: usize,
}

/// How to run a program.
#[derive(Clone, Default)]
pub struct Options<'o> {
    /// The value of `frame`.
    pub frame: f32,
    /// The frame's number in the names of textures, where `frame` cannot hold it (whole numbers above 2^24); `None`: that
    /// of `frame`.
    pub frame_number: Option<i64>,
    /// Values for params and other variables, by name.
    pub set: Vec<(String, PixelValue)>,
    /// `pixelsize` at every pixel, instead of what `point` tells.
    pub pixelsize: Option<f32>,
    /// Spaces by name: the matrix from the world, the space of `point`, to each. Points are columns.
    pub spaces: Vec<(String, Matrix4)>,
    /// The position of the eye, instead of the origin of the camera's space.
    pub eye: Option<[f32; 3]>,
    /// Several samples of each pixel, whose mean is written; `None`: one in its middle. See docs/antialiasing.md.
    pub samples: Option<Sampling>,
    /// Where the image comes from something that can be asked again: what it is at the places of a sample. Other
    /// variables are continued from the pixel's middle by their derivatives.
    pub resample: Option<&'o Resample<'o>>,
    /// The variables to write; `None`: `color` (and `alpha`), or all that a program without colour assigns. Where the
    /// program gives a colour of three components and no alpha, the image's `alpha` is passed on.
    pub outputs: Option<Vec<String>>,
    /// Keep the image's `alpha` beside a `color` without one also if `outputs` are named. If they are not, it is kept.
    pub keep_alpha: bool,
    /// Threads; `None`: as many as rayon's current pool has.
    pub threads: Option<usize>,
    /// Lanes of a batch; `None`: [`super::BATCH`]. The result is the same for all.
    pub batch: Option<usize>,
    /// Run every so many columns and rows alone, for a coarse picture soon: its pixels are those of the whole one. 0 and
    /// 1: all.
    pub every: usize,
    /// The instruction set; `None`: the best that this machine has. The result is the same for all.
    pub isa: Option<Isa>,
    /// Walk the tree alone, without plans for straight stretches of it. The result is the same, and later there.
    pub no_optimize: bool,
    /// How many lines of `print` are kept for [`Report::prints`]: those of the first pixels.
    pub prints: usize,
    /// The columns of the picture whose pixels print; `None`: all.
    pub print_columns: Option<Range<i32>>,
    /// What a pixel may use up.
    pub limits: Limits,
    /// Bytes that textures may take, all together; `None`: [`TEXTURE_MEMORY`].
    pub texture_memory: Option<usize>,
    /// Set from another thread, it ends the run soon.
    pub cancel: Option<&'o AtomicBool>,
    /// Measure what each statement takes, for [`Report::profile`]. That takes some time itself.
    pub profile: bool,
    /// Called from any of the threads from time to time.
    pub progress: Option<&'o (dyn Fn(Progress) + Sync)>,
    /// Says what is known of a variable that the image does not have, as hints to the user.
    pub missing: Option<&'o Missing<'o>>,
    /// Why the camera could not be found from the points of the image, as a hint in errors about `eye`, `I` and the
    /// spaces of the camera.
    pub camera_hint: Option<&'o str>,
}

impl Options<'_> {
    /// The frame in the names of files.
    pub(super) fn file_frame(&self) -> Frame {
        let frame = Frame::from(self.frame);
        Frame { number: self.frame_number.or(frame.number), ..frame }
    }

    pub(super) fn isa(&self) -> Isa {
        self.isa.unwrap_or_else(Isa::detect)
    }

    /// The values that are set, by name; of several the last.
    pub(super) fn set_values(&self) -> HashMap<&str, &PixelValue> {
        self.set.iter().map(|(name, value)| (name.as_str(), value)).collect()
    }
}

/// Why there is no result.
#[derive(Clone, Debug)]
pub enum Failure {
    /// The program does not fit the image, or went wrong at a pixel: the first in reading order that did.
    Program(Vec<Diagnostic>),
    /// [`Options::cancel`] was set.
    Cancelled,
}

/// What came out.
#[derive(Clone, Debug)]
pub struct Report {
    /// The output variables.
    pub image: Image<'static>,
    /// Pixels in which some output is NaN or infinite.
    pub not_finite: usize,
    /// The program gave no colour, but changed `normal`: `color` shows the surface by that normal.
    pub by_normal: bool,
    /// Threads that ran.
    pub threads: usize,
    /// How long they were at work, on an average.
    pub time: Duration,
    /// What runs once a frame printed.
    pub frame_prints: Prints,
    /// What the pixels printed, in the order of the pixels; with several samples of each, the first one.
    pub prints: Prints,
    /// What each statement took, if [`Options::profile`] was set.
    pub profile: Option<Profile>,
}

pub(super) enum Attempt {
    Done(Box<Report>),
    Again(Misfit),
}

/// A program bound to an image, whose pixels are to be run.
#[derive(Clone)]
pub(super) struct Job<'r> {
    pub program: &'r Resolved,
    pub bound: &'r Bound<'r>,
    pub image: &'r Image<'r>,
    /// The rows of it that are run.
    pub rows: Range<usize>,
    pub options: &'r Options<'r>,
    pub outputs: Vec<Output<'r>>,
    pub by_normal: bool,
    /// The sample that runs, if not in the middle.
    pub places: Option<Places>,
}

impl<'r> Job<'r> {
    pub fn new(
        program: &'r Resolved,
        bound: &'r Bound<'r>,
        image: &'r Image<'r>,
        rows: Range<usize>,
        options: &'r Options<'r>,
    ) -> Result<Job<'r>, Failure> {
        let names = options.outputs.clone().unwrap_or_else(|| output::default_names(program));
        let mut by_normal = false;
        let mut outputs: Vec<Output<'r>> = Vec::new();
        let mut errors = Vec::new();
        for name in names {
            if outputs.iter().any(|o| o.name == name) {
                continue;
            }
            let slot = program.slot(&name);
            let assigned = slot.filter(|&i| program.globals[i as usize].assigned.is_some());
            let shown = slot.filter(|_| name == "color" && assigned.is_none() && program.by_normal.is_some());
            by_normal |= shown.is_some();
            let input = image.variable(&name);
            let framed = slot.filter(|&i| program.globals[i as usize].framed.is_some());
            let slot = assigned.or(shown).or(framed);
            if slot.is_none() && input.is_none() {
                errors.push(output::missing(program, &name));
                continue;
            }
            let shape = match (slot, input) {
                (None, Some(input)) => input.shape.clone(),
                _ => Output::written(&name, &Shape::Scalar),
            };
            let input = input.filter(|_| slot.is_none());
            outputs.push(Output { name, slot, input, shape, seen: None, kept: false });
        }
        if let Some(alpha) = output::kept_alpha(program, image, options)
            && outputs.iter().any(|o| o.name == "color")
            && outputs.iter().all(|o| o.name != "alpha")
        {
            let (name, shape) = (alpha.name.clone(), alpha.shape.clone());
            outputs.push(Output { name, slot: None, input: Some(alpha), shape, seen: None, kept: true });
        }
        if outputs.is_empty() && errors.is_empty() {
            let error = Diagnostic::bare("output", "the program has no output").hint(
                "Assign to `color`, as in `color = white * Noise(8 * point)`, or end with an expression alone.",
            );
            let has = |name: &str| program.functions.iter().any(|f| f.name == name);
            errors.push(match (has("velocity"), has("density")) {
                (true, _) => error.hint("Its function `velocity` is for `pse flow`."),
                (_, true) => error.hint("Its function `density` is for `pse scene --iso`, or `--iso` together with a program for the colours."),
                _ => error,
            });
        }
        if errors.is_empty() {
            Ok(Job { program, bound, image, rows, options, outputs, by_normal, places: None })
        } else {
            Err(Failure::Program(errors))
        }
    }

    /// Which pixels are run.
    fn grid(&self) -> Grid {
        Grid::new(self.image.width, self.rows.clone(), self.options.every)
    }

    /// How many pixels are run.
    fn total(&self) -> usize {
        self.grid().count()
    }

    fn worker(&self) -> Worker<'r> {
        let mut worker = Worker::new(self.program, self.bound, self.options, self.by_normal);
        worker.machine.sample = self.places;
        if self.places.is_some_and(|places| places.sample > 0) {
            worker.machine.printer.limit = 0;
        }
        worker.machine.want(self.outputs.iter().filter_map(|output| output.slot).collect());
        worker
    }

    /// Learns the outputs' shapes from a few pixels. What goes wrong there will go wrong again.
    pub fn sample(&mut self) {
        let total = self.total();
        let mut worker = self.worker();
        for k in 0..SAMPLES.min(total) {
            let pixel = self.grid().pixel(k * (total - 1) / (SAMPLES - 1).max(1));
            let mut found: Vec<Option<Shape>> = Vec::new();
            let list = [pixel as u32];
            let outcome = worker.run(Pixels::List(&list), &mut |machine, _| {
                found = self
                    .outputs
                    .iter()
                    .map(|o| {
                        o.slot.and_then(|i| Some(machine.globals[i as usize].value.as_ref()?.shape.clone()))
                    })
                    .collect();
                Ok(())
            });
            if outcome.is_err() {
                continue;
            }
            for (output, shape) in self.outputs.iter_mut().zip(found) {
                if let Some(shape) = shape
                    && output.color_has(&shape)
                    && let Some(joined) = output.join(&shape)
                {
                    if joined != output.shape || output.seen.is_none() {
                        output.seen = Some(self.bound.position(pixel));
                    }
                    output.shape = joined;
                }
            }
        }
    }

    /// Makes room for a pixel's shape, or says why there is none.
    pub fn widen(&mut self, misfit: Misfit) -> Result<(), Failure> {
        let output = &mut self.outputs[misfit.output];
        let joined = output.join(&misfit.shape).filter(|_| output.color_has(&misfit.shape));
        if let Some(joined) = joined.filter(|j| *j != output.shape) {
            output.shape = joined;
            output.seen = Some(self.bound.position(misfit.pixel));
            return Ok(());
        }
        let mut error = output::misfits(self.program, output, &misfit.shape);
        error.pixel = Some(self.bound.position(misfit.pixel));
        Err(Failure::Program(vec![error]))
    }

    /// A picture of thousands of planes is nobody's wish, and fills the memory.
    fn check_outputs(&self) -> Result<(), Failure> {
        match self.outputs.iter().find(|o| o.shape.cells() > MAX_PLANES) {
            None => Ok(()),
            Some(output) => {
                let (name, n) = (&output.name, output.shape.cells());
                let error = Diagnostic::bare(
                    "output",
                    format!("`{name}` has {n} components, too many to write"),
                )
                .hint(format!(
                    "An output has at most {MAX_PLANES}. Choose the variables to write (`--vars color`)."
                ));
                Err(Failure::Program(vec![error]))
            }
        }
    }

    /// Runs the whole image with the shapes known so far.
    pub fn attempt(&self) -> Result<Attempt, Failure> {
        self.check_outputs()?;
        let (grid, total) = (self.grid(), self.total());
        let mut planes: Vec<Vec<Vec<f32>>> = self
            .outputs
            .iter()
            .map(|o| {
                let cells = if o.slot.is_some() { o.shape.cells() } else { 0 };
                (0..cells).map(|_| vec![0.0; total]).collect()
            })
            .collect();
        let chunks = Mutex::new(output::chunks(&mut planes, CHUNK, total).into_iter());
        let end = AtomicUsize::new(usize::MAX);
        let stopped: Mutex<Option<Stop>> = Mutex::new(None);
        let done = AtomicUsize::new(0);
        let not_finite = AtomicUsize::new(0);
        let profile = Mutex::new(Profile::new());
        let prints = Mutex::new(Prints::default());
        let busy = Mutex::new(Duration::ZERO);
        let work = || {
            let begin = Instant::now();
            let mut worker = self.worker();
            let mut printed = Prints::default();
            if self.options.profile {
                worker.machine.measure();
            }
            loop {
                let next = match chunks.lock() {
                    Ok(mut chunks) => chunks.next(),
                    Err(_) => None,
                };
                let Some(mut chunk) = next.filter(|c| grid.pixel(c.start) < end.load(Ordering::Relaxed))
                else {
                    break;
                };
                if let Err(stop) = self.chunk(&mut worker, &mut chunk, &mut printed) {
                    end.fetch_min(stop.pixel(), Ordering::Relaxed);
                    if let Ok(mut stopped) = stopped.lock()
                        && stopped.as_ref().is_none_or(|s| stop.pixel() < s.pixel())
                    {
                        *stopped = Some(stop);
                    }
                    continue;
                }
                not_finite.fetch_add(output::not_finite(&chunk.planes, chunk.len), Ordering::Relaxed);
                let done = done.fetch_add(chunk.len, Ordering::Relaxed) + chunk.len;
                if let Some(progress) = self.options.progress {
                    let count = self.options.sampling().map_or(1, |s| s.count as usize);
                    let before = self.places.map_or(0, |p| p.sample as usize) * total;
                    progress(Progress { done: (before + done) / count, total });
                }
            }
            if let Ok(mut all) = prints.lock() {
                all.add(&printed, self.options.prints);
            }
            if let Ok(mut all) = profile.lock() {
                for (statement, spent) in worker.machine.profile() {
                    all.entry(statement).or_default().add(&spent);
                }
            }
            if let Ok(mut busy) = busy.lock() {
                *busy += begin.elapsed();
            }
        };
        let threads = self.in_threads(&work)?;
        drop(chunks);
        match stopped.into_inner().unwrap_or_else(|e| e.into_inner()) {
            None => {}
            Some(Stop::Misfit(misfit)) => return Ok(Attempt::Again(misfit)),
            Some(stop) => return Err(stop.failure(self.bound)),
        }
        let image = self.finish(planes);
        let not_finite = not_finite.into_inner();
        let profile = self.options.profile.then(|| profile.into_inner().unwrap_or_else(|e| e.into_inner()));
        let time = busy.into_inner().unwrap_or_else(|e| e.into_inner()) / threads as u32;
        let by_normal = self.by_normal;
        let prints = prints.into_inner().unwrap_or_else(|e| e.into_inner());
        let frame_prints = self.bound.prints.clone();
        let report = Report { image, not_finite, by_normal, threads, time, frame_prints, prints, profile };
        Ok(Attempt::Done(Box::new(report)))
    }

    /// Runs `work` on every thread that was asked for, and says how many those are.
    fn in_threads(&self, work: &(impl Fn() + Sync)) -> Result<usize, Failure> {
        // A thread without a chunk has nothing to do.
        let useful = self.total().div_ceil(CHUNK).max(1);
        let threads = self.options.threads.unwrap_or_else(parallel::current_num_threads);
        let threads = threads.clamp(1, useful.min(MAX_THREADS));
        parallel::on_threads(threads, work).map_err(|e| {
            let error = Diagnostic::bare("threads", format!("cannot start {threads} threads: {e}"));
            Failure::Program(vec![error.hint("Use fewer threads.")])
        })?;
        Ok(threads)
    }

    fn chunk(&self, worker: &mut Worker<'r>, chunk: &mut Chunk<'_>, prints: &mut Prints) -> Result<(), Stop> {
        let lanes = if self.program.derivatives { shadow::LANES } else { 1 };
        let batch = (self.options.batch.unwrap_or(super::BATCH) / lanes).max(1);
        let grid = self.grid();
        let Chunk { start, len, planes } = chunk;
        let (start, end) = (*start, *start + *len);
        let mut first = start;
        while first < end {
            if self.options.cancel.is_some_and(|c| c.load(Ordering::Relaxed)) {
                return Err(Stop::Cancelled);
            }
            let n = batch.min(end - first);
            if grid.all() {
                worker.run(Pixels::Run(grid.pixel(first), n), &mut |machine, pixels| {
                    machine.printer.give(prints);
                    output::write(&self.outputs, machine, pixels, grid.pixel(start), planes)
                })?;
            } else {
                let list: Vec<u32> = (first..first + n).map(|number| grid.pixel(number) as u32).collect();
                worker.run(Pixels::List(&list), &mut |machine, pixels| {
                    machine.printer.give(prints);
                    let numbers: Vec<u32> =
                        (0..pixels.len()).map(|lane| grid.number(pixels.at(lane)) as u32).collect();
                    let written =
                        output::write(&self.outputs, machine, Pixels::List(&numbers), start, planes);
                    written.map_err(|misfit| Misfit { pixel: grid.pixel(misfit.pixel), ..misfit })
                })?;
            }
            first += n;
        }
        Ok(())
    }

    fn finish(&self, planes: Vec<Vec<Vec<f32>>>) -> Image<'static> {
        let grid = self.grid();
        let [width, height] = grid.size();
        // A colour of four components has brought its own alpha.
        let opaque = |o: &Output<'_>| o.name != "color" || o.shape != Shape::Vector(4);
        let alone = self.outputs.iter().all(opaque);
        let variables = self
            .outputs
            .iter()
            .zip(planes)
            .filter(|(output, _)| alone || !output.kept)
            .map(|(output, planes)| {
                let taken = |plane: &[f32]| (0..grid.count()).map(|i| plane[grid.pixel(i)]).collect();
                let planes = match output.input {
                    Some(input) => input.planes.iter().map(|p| Cow::Owned(taken(p))).collect(),
                    None => planes.into_iter().map(Cow::Owned).collect(),
                };
                Variable { name: output.name.clone(), shape: output.shape.clone(), planes }
            })
            .collect();
        let mut metadata = self.image.metadata.clone();
        if self.rows != (0..self.image.height) {
            metadata.resolution = Some(self.image.resolution());
            metadata.origin[1] += self.rows.start as i32;
        }
        Image { width, height, variables, metadata }
    }
}
