//! A program on a whole image: batches, threads, and what comes out.

use super::bind::{Bound, Missing};
use super::grid::{Grid, Window};
use super::input::Inputs;
use super::limits::Limits;
use super::output::{self, Misfit, Output};
use super::pixels::Pixels;
use super::print::Prints;
use super::profile::Profile;
use super::samples::{Places, Resample, Sampling};
use super::worker::{Parts, Worker};
use crate::diagnostic::Diagnostic;
use crate::image::{Frame, Image, Matrix4};
use crate::lanes::Isa;
use crate::resolve::Resolved;
use crate::shape::Shape;
use crate::value::PixelValue;
use std::collections::HashMap;
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

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

/// Threads of a host, on which a program is to run.
pub trait Executor: Sync {
    /// Calls `work` once on each thread that is to take part, at the same time or not, and returns when all calls have.
    fn run(&self, work: &(dyn Fn() + Sync));
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
    /// Images instead of those that the program looks things up in, by the name that it gives them.
    pub textures: Vec<(String, Arc<Image<'static>>)>,
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
    /// Threads; `None`: as many as rayon's current pool has. One thread is the caller's own; no other is started.
    pub threads: Option<usize>,
    /// Runs the work on the host's own threads, instead of [`Options::threads`].
    pub executor: Option<&'o dyn Executor>,
    /// Lanes of a batch; `None`: [`super::BATCH`]. The result is the same for all.
    pub batch: Option<usize>,
    /// Run these columns and rows of the image alone; `None`: all that it holds. What is written has the window's size.
    pub window: Option<Window>,
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
    /// Called from any of the threads from time to time; `ControlFlow::Break` ends the run as a cancellation.
    pub progress: Option<&'o (dyn Fn(Progress) -> ControlFlow<()> + Sync)>,
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

    /// Whether no thread but the caller's takes part: others might not be wanted, or are the host's.
    pub(super) fn on_one_thread(&self) -> bool {
        self.threads == Some(1) || self.executor.is_some()
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
#[non_exhaustive]
pub struct Report {
    /// The output variables. Empty where the run wrote into a host's buffers.
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
    /// The image, if it is one: who samples it anew asks for it.
    pub image: Option<&'r Image<'r>>,
    /// The pixels of it that are run.
    pub window: Window,
    pub options: &'r Options<'r>,
    pub outputs: Vec<Output>,
    pub by_normal: bool,
    /// The sample that runs, if not in the middle.
    pub places: Option<Places>,
}

impl<'r> Job<'r> {
    /// Finds the outputs. `rows`: those that are run, of the columns that the options ask for.
    pub fn new(
        program: &'r Resolved,
        bound: &'r Bound<'r>,
        rows: Range<usize>,
        options: &'r Options<'r>,
    ) -> Result<Job<'r>, Failure> {
        let inputs = &bound.inputs;
        let window = window(inputs, rows, options)?;
        let names = options.outputs.clone().unwrap_or_else(|| output::default_names(program));
        let mut by_normal = false;
        let mut outputs: Vec<Output> = Vec::new();
        let mut errors = Vec::new();
        for name in names {
            if outputs.iter().any(|o| o.name == name) {
                continue;
            }
            let slot = program.slot(&name);
            let assigned = slot.filter(|&i| program.globals[i as usize].assigned.is_some());
            let shown = slot.filter(|_| name == "color" && assigned.is_none() && program.by_normal.is_some());
            by_normal |= shown.is_some();
            let input = inputs.find(&name);
            let framed = slot.filter(|&i| program.globals[i as usize].framed.is_some());
            let slot = assigned.or(shown).or(framed);
            if slot.is_none() && input.is_none() {
                errors.push(output::missing(program, &name));
                continue;
            }
            let shape = match (slot, input) {
                (None, Some(input)) => inputs.get(input).shape.clone(),
                _ => Output::written(&name, &Shape::Scalar),
            };
            let input = input.filter(|_| slot.is_none());
            outputs.push(Output { name, slot, input, shape, seen: None, kept: false });
        }
        if let Some(alpha) = output::kept_alpha(program, inputs, options)
            && outputs.iter().any(|o| o.name == "color")
            && outputs.iter().all(|o| o.name != "alpha")
        {
            let (name, shape) = ("alpha".to_string(), Shape::Scalar);
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
            Ok(Job { program, bound, image: None, window, options, outputs, by_normal, places: None })
        } else {
            Err(Failure::Program(errors))
        }
    }

    /// A run whose outputs are known from one before.
    pub fn of_outputs(
        program: &'r Resolved,
        bound: &'r Bound<'r>,
        rows: Range<usize>,
        options: &'r Options<'r>,
        outputs: Vec<Output>,
        by_normal: bool,
    ) -> Result<Job<'r>, Failure> {
        let window = window(&bound.inputs, rows, options)?;
        Ok(Job { program, bound, image: None, window, options, outputs, by_normal, places: None })
    }

    /// Which pixels are run.
    pub fn grid(&self) -> Grid {
        Grid::new(self.bound.inputs.width, self.window.clone(), self.options.every)
    }

    /// How many pixels are run.
    pub fn total(&self) -> usize {
        self.grid().count()
    }

    pub fn worker(&self, parts: Parts) -> Worker<'r> {
        let mut worker = Worker::new(self.program, self.bound, self.options, self.by_normal, parts);
        worker.machine.sample = self.places;
        if self.places.is_some_and(|places| places.sample > 0) {
            worker.machine.printer.limit = 0;
        }
        worker.machine.want(self.outputs.iter().filter_map(|output| output.slot));
        worker
    }

    /// Learns the outputs' shapes from a few pixels. What goes wrong there will go wrong again.
    pub fn sample(&mut self) {
        let total = self.total();
        let mut worker = self.worker(Parts::default());
        for k in 0..SAMPLES.min(total) {
            let pixel = self.grid().pixel(k * (total - 1) / (SAMPLES - 1).max(1));
            let mut found: Vec<Option<Shape>> = Vec::new();
            let list = [pixel];
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
    pub fn check_outputs(&self) -> Result<(), Failure> {
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
}

/// The pixels that are run, if the image holds them.
fn window(inputs: &Inputs<'_>, rows: Range<usize>, options: &Options<'_>) -> Result<Window, Failure> {
    let (columns, rows) = match &options.window {
        None => (0..inputs.width, rows),
        Some(window) => {
            (window.columns.clone(), rows.start.max(window.rows.start)..rows.end.min(window.rows.end))
        }
    };
    let wrong = |what: &str, range: &Range<usize>, count: usize| {
        let message = format!("the image has no {what} {} to {}: it holds {count}", range.start, range.end);
        Failure::Program(vec![Diagnostic::bare("input", message)])
    };
    if columns.start > columns.end || columns.end > inputs.width {
        return Err(wrong("columns", &columns, inputs.width));
    }
    if rows.end > inputs.height {
        return Err(wrong("rows", &rows, inputs.height));
    }
    // Rows outside of the window are none.
    Ok(Window { columns, rows: rows.start.min(rows.end)..rows.end })
}
