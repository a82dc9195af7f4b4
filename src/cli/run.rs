//! `pse run`: a program at every pixel of an image.

mod args;
mod digest;
mod input;
mod memory;
mod plan;
mod profile;
mod resume;
mod stream;

pub(super) use args::{LimitArgs, RunArgs, bits, positive};
pub(super) use plan::{DEFAULT_SCENE, Plan, reading, scene, set, space};

use super::check::misspelt_outputs;
use super::failure::{Failure, print, show, style, warn, warn_rendered};
use super::frames::{self, Frame};
use super::interrupt::{self, CANCEL};
use super::output;
use super::prints::Shown;
use super::progress::Meter;
use super::region::Region;
use super::solid::{print_stats, warn_unseen};
use input::FrameInput;
use plan::Output;
use pse::image::Image;
use pse::internal::diagnostic::Diagnostic;
use pse::internal::eval::{BATCH, Places, Resample};
use pse::internal::program::{Error, Limits, Progress, RunOptions};
use resume::Hashes;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use stream::Outcome;

/// Runs the program on each frame.
pub(super) fn run(args: &RunArgs) -> Result<(), Failure> {
    let plan = Plan::new(args)?;
    let meter = Meter::new(&plan.name, args.progress, args.quiet, plan.frames.len());
    let mut work = Work {
        args,
        plan: &plan,
        meter: &meter,
        kept: None,
        hashes: Hashes::default(),
        prints: Shown::new(if args.quiet { 0 } else { args.print }),
        first: true,
        size: None,
        sizes_told: false,
    };
    let view = &args.images.view;
    let moves = view.mesh.as_deref().is_some_and(frames::is_sequence) && plan.frames.len() > 1;
    if moves && !args.quiet && (view.eye.is_none() || view.look_at.is_none() || view.fov.is_none()) {
        warn(
            "the default camera is different for each frame's mesh. Give --eye, --look-at and --fov for a fixed camera",
        );
    }
    let mut failed = Vec::new();
    let mut skipped = 0;
    for &frame in &plan.frames {
        match work.frame(frame) {
            Ok(Done::Run) => meter.frame(),
            Ok(Done::Skipped) => {
                meter.skip();
                skipped += 1;
            }
            Err(failure) => {
                let failure = work.with_frame(failure, frame);
                let go_on = args.keep_going && failure.is_of_frame();
                let Some(number) = frame.number.filter(|_| go_on) else {
                    meter.fail(&failure.message());
                    return Err(failure);
                };
                meter.frame();
                failure.report();
                warn(&format!("frame {number} failed; continuing with the next"));
                failed.push(number);
            }
        }
    }
    work.prints.end();
    let all = plan.frames.len();
    if skipped > 0 && !args.quiet {
        warn(&format!("skipped {skipped} of {all} frames: their files are complete"));
    }
    if failed.is_empty() {
        return Ok(());
    }
    let list = frames::ranges(&failed, "x");
    let failure = Failure::plain(format!("{} of {all} frames failed: {list}", failed.len()))
        .hint(format!("Run them again with --frames {list}."));
    meter.fail(&failure.message());
    Err(failure)
}

/// What became of a frame that did not fail.
enum Done {
    Run,
    /// Its files were there already.
    Skipped,
}

/// A run on its way from frame to frame.
struct Work<'a> {
    args: &'a RunArgs,
    plan: &'a Plan,
    meter: &'a Meter,
    /// The input, if it is the same for all frames.
    kept: Option<FrameInput>,
    hashes: Hashes,
    prints: Shown,
    /// Has no frame been run yet?
    first: bool,
    /// Columns and rows of the first frame.
    size: Option<[usize; 2]>,
    /// Has it been said that frames differ in size?
    sizes_told: bool,
}

impl Work<'_> {
    /// Names the frame and its files, where there are several.
    fn with_frame(&self, failure: Failure, frame: Frame) -> Failure {
        let Some(number) = frame.number.filter(|_| self.plan.frames.len() > 1) else { return failure };
        let files = self.plan.inputs_of_frame(self.args, frame);
        failure.context(match files.is_empty() {
            true => format!("This is frame {number}."),
            false => format!("This is frame {number}, which reads {}.", files.join(" and ")),
        })
    }

    fn frame(&mut self, frame: Frame) -> Result<Done, Failure> {
        let Work { args, plan, .. } = *self;
        // What cannot be written is said before the work.
        let outputs = plan.outputs(args, frame)?;
        let stamp = match args.resume {
            true => self.hashes.of_frame(args, plan, frame)?,
            false => None,
        };
        if stamp.as_ref().is_some_and(|stamp| resume::is_done(&outputs, stamp)) {
            return Ok(Done::Skipped);
        }
        let start = Instant::now();
        let moving = args.solid.iso.is_some() || args.images.paths().any(frames::is_sequence);
        let input = match self.kept.take() {
            Some(input) => input,
            None => {
                // What is run several times is read once.
                let keep = args.repeat.is_some() || plan.frames.len() > 1 && !moving && args.memory.is_none();
                FrameInput::open(args, plan, frame, keep)?
            }
        };
        // Now it is known what else is read: the program of a solid, the data of a mesh.
        outputs.iter().try_for_each(|output| output::check(&output.path).map(drop))?;
        let opened = start.elapsed();
        // From here on there are files to clean up. Before, where standard input may not end, an interrupt ends all.
        if self.first {
            interrupt::cancel_command();
        }
        let job = Job { args, plan, input: &input, outputs: &outputs, stamp: stamp.as_deref() };
        let mut outcome = job.compute(self.meter, frame, self.prints.wanted())?;
        outcome.stats.read += opened;
        outcome.stats.wall += opened;
        if std::mem::take(&mut self.first) && !args.quiet {
            self.tell_once(&outputs);
            input.inputs.notes(&plan.program).iter().for_each(|note| warn(note));
        }
        if !args.quiet {
            self.tell_size(&input, frame);
        }
        let number = frame.number.filter(|_| plan.frames.len() > 1);
        self.prints.frame(&outcome.prints, plan.program.sources(), number);
        job.tell(&outcome, number)?;
        self.kept = Some(input).filter(|_| !moving);
        Ok(Done::Run)
    }

    /// Says where the frames of a sequence begin to have another size.
    fn tell_size(&mut self, input: &FrameInput, frame: Frame) {
        let size = input.resolution();
        let [w, h] = *self.size.get_or_insert(size);
        if [w, h] == size || std::mem::replace(&mut self.sizes_told, true) {
            return;
        }
        let number = frame.number.map_or(String::new(), |number| format!(" {number}"));
        warn(&format!("frame{number} is {}x{}, but the first frame is {w}x{h}", size[0], size[1]));
    }

    /// Says what holds for all frames.
    fn tell_once(&self, outputs: &[Output]) {
        if self.plan.by_default {
            let scene = plan::DEFAULT_SCENE;
            warn(&format!("no input: using the scene {scene} (see pse scene --list, or give -i FILE)"));
        }
        self.plan.frame_notes.iter().for_each(|note| warn(note));
        // Who names what is written means it.
        let misspelt =
            if self.args.vars.is_some() { Vec::new() } else { misspelt_outputs(&self.plan.program) };
        if !misspelt.is_empty() {
            let sources = self.plan.program.sources().clone();
            let warnings = Error::new(misspelt, sources);
            warn_rendered(warnings.render(style()).trim_end());
        }
        if let Some(output) = outputs.iter().find(|o| self.args.resume && !o.format.holds_stamp()) {
            let shown = output::shown(&output.path);
            warn(&format!(
                "--resume: {shown} has no room for the hash of the run, so it is written every time; .exr and .png files have"
            ));
        }
    }
}

/// A frame, its input and its outputs.
struct Job<'a> {
    args: &'a RunArgs,
    plan: &'a Plan,
    input: &'a FrameInput,
    outputs: &'a [Output],
    /// The hash that goes into the outputs' headers.
    stamp: Option<&'a str>,
}

impl Job<'_> {
    /// Runs the frame, and tells how far it has come.
    fn compute(&self, meter: &Meter, frame: Frame, prints: usize) -> Result<Outcome, Failure> {
        let Job { args, plan, input, outputs, stamp } = *self;
        let about = input.about()?;
        let done = AtomicUsize::new(0);
        let progress = |p: Progress| {
            let done = done.load(Ordering::Relaxed) + p.done;
            meter.update(Progress { done, total: about.width * about.height });
            ControlFlow::Continue(())
        };
        let inputs = Arc::clone(&input.inputs);
        let name = plan.scene.as_ref().map(|seen| seen.to_string());
        let name = name.or(args.solid.iso.as_ref().map(|_| "solid".into()));
        let scene = name.map(|name| format!("The {name} has {}.", input.names));
        let missing = move |name: &str| match &scene {
            Some(scene) if !name.contains('.') => vec![scene.clone()],
            _ => inputs.missing(name),
        };
        let resample = |image: &Image<'_>, places: &Places| Ok(input.resample(image, places)?);
        // What is set may depend on the frame.
        let (set, spaces) = plan::values(args, frame.value)?;
        let set = plan.own(set, input.solid());
        let threads = args.threads.unwrap_or_else(rayon::current_num_threads);
        let (textures, values) = memory::shares(args, threads);
        let options = RunOptions {
            samples: args.sampling(),
            resample: input.is_seen().then_some(&resample as &Resample<'_>),
            frame: frame.value,
            frame_number: frame.number,
            set,
            pixelsize: args.images.pixelsize,
            spaces,
            // Scenes have no alpha that would be the picture's.
            outputs: plan.vars.clone().or_else(|| input.is_seen().then(|| plan.program.default_outputs())),
            keep_alpha: false,
            threads: args.threads,
            batch: args.batch,
            every: 1,
            isa: Some(plan.isa),
            no_optimize: args.no_optimize,
            profile: args.profile,
            limits: Limits { memory: values, ..args.limits.limits() },
            prints,
            print_columns: Some(about.metadata.origin[0]..about.metadata.origin[0] + about.width as i32),
            texture_memory: Some(textures),
            cancel: Some(&CANCEL),
            progress: Some(&progress),
            missing: Some(&missing),
            ..RunOptions::default()
        };
        let camera = input.camera(args, plan, frame.value)?;
        if !args.quiet {
            camera.report();
        }
        let options = camera.options(options);
        let mut outcome = stream::run(args, plan, input, outputs, stamp, &options, &done)?;
        outcome.stats.samples = args.samples.unwrap_or(1);
        outcome.stats.batch = args.batch.unwrap_or(BATCH);
        outcome.stats.isa = plan.isa.name();
        Ok(outcome)
    }

    /// Says what was done.
    fn tell(&self, outcome: &Outcome, frame: Option<i64>) -> Result<(), Failure> {
        let Job { args, plan, input, outputs, .. } = *self;
        if let Some(digest) = &outcome.digest {
            let frame = frame.map_or(String::new(), |n| format!(" frame {n}"));
            print(&format!("{digest}  {}{frame}\n", plan.name))?;
        }
        let stats = &outcome.stats;
        if !args.quiet {
            if outcome.by_normal {
                let note = Diagnostic::bare("normal", "the program assigns no color")
                    .hint("The picture shows a white surface, shaded with the program's normal.")
                    .warning();
                show(&note);
            }
            let about = input.about()?;
            let region = match input.region {
                Some(_) => format!(" at {}", Region::held(&about)),
                None => String::new(),
            };
            for output in outputs {
                warn(&format!(
                    "wrote {} ({}x{}{region}) in {:.3} s, {:.1} Mpixels/s",
                    output::shown(&output.path),
                    about.width,
                    about.height,
                    stats.wall.as_secs_f64(),
                    stats.rate(),
                ));
            }
            if stats.not_finite > 0 {
                let n = stats.not_finite;
                let (s, hold) = if n == 1 { ("", "holds") } else { ("s", "hold") };
                warn(&format!("{n} pixel{s} {hold} NaN or infinity"));
            }
        }
        if let Some(stats) = input.solid_stats().filter(|_| !args.quiet) {
            warn_unseen(&stats, &args.solid);
        }
        if args.stats {
            stats.print();
            input.solid_stats().iter().for_each(print_stats);
        }
        if let Some(profile) = &outcome.profile {
            profile::print(profile, plan.program.sources(), stats.pixels);
        }
        if let Some(n) = args.repeat {
            warn(&format!("{}: {:.2} ns/pixel, the median of {n} runs", plan.name, stats.per_pixel()));
        }
        Ok(())
    }
}
