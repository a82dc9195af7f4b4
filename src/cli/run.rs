//! `pse run`: a program at every pixel of an image.

mod args;
mod input;
mod memory;
mod plan;
mod profile;
mod stream;

pub(super) use args::{LimitArgs, RunArgs};
pub(super) use plan::{DEFAULT_SCENE, frame, reading, scene, set, space};

use super::failure::{Failure, show, warn};
use super::interrupt::{self, CANCEL};
use super::output;
use super::prints::Shown;
use super::progress::Bar;
use super::region::Region;
use crate::diagnostic::Diagnostic;
use crate::eval::{BATCH, Places, Resample};
use crate::image::Image;
use crate::program::{Limits, Progress, RunOptions};
use input::FrameInput;
use plan::{Output, Plan};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use stream::Outcome;

/// Runs the program on each frame.
pub(super) fn run(args: &RunArgs) -> Result<(), Failure> {
    let plan = Plan::new(args)?;
    let moving = args.input.iter().any(|i| super::frames::has_pattern(&i.path));
    // What is run several times is read once.
    let keep = args.repeat.is_some() || plan.frames.len() > 1 && !moving && args.memory.is_none();
    let mut kept: Option<FrameInput> = None;
    let mut prints = Shown::new(if args.quiet { 0 } else { args.print });
    for &frame in &plan.frames {
        // What cannot be written is said before the work.
        let outputs = plan.outputs(args, frame.number)?;
        let start = Instant::now();
        let first = kept.is_none();
        let input = match kept.take().filter(|_| !moving) {
            Some(input) => input,
            None => FrameInput::open(args, &plan, frame.number, keep)?,
        };
        let opened = start.elapsed();
        // From here on there are files to clean up. Before, where standard input may not end, an interrupt ends all.
        if first {
            interrupt::watch(true);
        }
        let mut outcome = compute(args, &plan, &input, &outputs, frame.value, prints.wanted())?;
        outcome.stats.read += opened;
        outcome.stats.wall += opened;
        if plan.by_default && first && !args.quiet {
            let scene = plan::DEFAULT_SCENE;
            warn(&format!("no input: this is the scene {scene} (see pse scene --list, or give -i FILE)"));
        }
        let number = frame.number.filter(|_| plan.frames.len() > 1);
        prints.frame(&outcome.prints, plan.program.sources(), number);
        tell(args, &plan, &input, &outputs, &outcome)?;
        kept = Some(input);
    }
    prints.end();
    Ok(())
}

/// Runs a frame, and shows how far it has come.
fn compute(
    args: &RunArgs,
    plan: &Plan,
    input: &FrameInput,
    outputs: &[Output],
    frame: f32,
    prints: usize,
) -> Result<Outcome, Failure> {
    let bar = Bar::new(&plan.name, args.quiet);
    let about = input.about()?;
    let done = AtomicUsize::new(0);
    let progress = |p: Progress| {
        let done = done.load(Ordering::Relaxed) + p.done;
        bar.update(Progress { done, total: about.width * about.height });
    };
    let inputs = Arc::clone(&input.inputs);
    let scene = plan.scene.as_ref().map(|name| format!("The scene {name} has {}.", input.names));
    let missing = move |name: &str| match &scene {
        Some(scene) if !name.contains('.') => vec![scene.clone()],
        _ => inputs.missing(name),
    };
    let resample = |image: &Image<'_>, places: &Places| input.resample(image, places);
    // What is set may depend on the frame.
    let (set, spaces) = plan::values(args, frame)?;
    let threads = args.threads.unwrap_or_else(rayon::current_num_threads);
    let (textures, values) = memory::shares(args, threads);
    let options = RunOptions {
        samples: args.sampling(),
        resample: plan.scene.is_some().then_some(&resample as &Resample<'_>),
        frame,
        set,
        pixelsize: args.pixelsize,
        spaces,
        outputs: plan.vars.clone(),
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
    };
    let outcome = stream::run(args, plan, input, outputs, &options, &done);
    bar.clear();
    let mut outcome = outcome?;
    outcome.stats.samples = args.samples.unwrap_or(1);
    outcome.stats.batch = args.batch.unwrap_or(BATCH);
    outcome.stats.isa = plan.isa.name();
    Ok(outcome)
}

/// Says what was done.
fn tell(
    args: &RunArgs,
    plan: &Plan,
    input: &FrameInput,
    outputs: &[Output],
    outcome: &Outcome,
) -> Result<(), Failure> {
    let stats = &outcome.stats;
    if !args.quiet {
        if outcome.by_normal {
            let note = Diagnostic::bare("normal", "the program assigns no color")
                .hint("The picture shows the surface in white by the normal that the program gave it.")
                .warning();
            show(&note);
        }
        let about = input.about()?;
        let region = match args.region {
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
    if args.stats {
        stats.print();
    }
    if let Some(profile) = &outcome.profile {
        profile::print(profile, plan.program.sources(), stats.pixels);
    }
    if let Some(n) = args.repeat {
        warn(&format!("{}: {:.2} ns/pixel, the median of {n} runs", plan.name, stats.per_pixel()));
    }
    Ok(())
}
