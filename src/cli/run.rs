//! `pse run`: a program at every pixel of an image.

mod args;
mod plan;
mod profile;

pub(super) use args::RunArgs;

use super::failure::{Failure, show, warn};
use super::input::Inputs;
use super::output;
use super::progress::Bar;
use super::region::Region;
use super::stats::Stats;
use crate::diagnostic::Diagnostic;
use crate::eval::BATCH;
use crate::image::{Format, Image};
use crate::program::{Report, RunOptions};
use plan::{Output, Plan};
use std::sync::Arc;
use std::time::Instant;

/// Runs the program on each frame.
pub(super) fn run(args: &RunArgs) -> Result<(), Failure> {
    let plan = Plan::new(args)?;
    let moving = args.input.iter().any(|i| super::frames::has_pattern(&i.path));
    let mut kept: Option<Loaded> = None;
    for &frame in &plan.frames {
        // What cannot be written is said before the work.
        let outputs = plan.outputs(args, frame.number)?;
        let start = Instant::now();
        // Files that are the same for all frames are read once.
        let first = kept.is_none();
        let loaded = match kept.take().filter(|_| !moving) {
            Some(loaded) => loaded,
            None => Loaded::new(args, &plan, frame.number)?,
        };
        let read = start.elapsed();
        let (report, mut stats) = compute(args, &plan, &loaded, frame.value)?;
        stats.read = read;
        let start = Instant::now();
        for output in &outputs {
            write(args, &plan, output, &report.image)?;
        }
        stats.write = start.elapsed();
        if plan.by_default && first && !args.quiet {
            let scene = plan::DEFAULT_SCENE;
            warn(&format!("no input: this is the scene {scene} (see pse scene --list, or give -i FILE)"));
        }
        tell(args, &plan, &outputs, &report, &stats);
        kept = Some(loaded);
    }
    Ok(())
}

/// A frame's input.
struct Loaded {
    inputs: Arc<Inputs>,
    image: Image<'static>,
    /// Are there pixels about the region, to be cut off in the end?
    cut: bool,
}

impl Loaded {
    fn new(args: &RunArgs, plan: &Plan, frame: Option<i64>) -> Result<Loaded, Failure> {
        let inputs = Inputs::open(&args.input, &args.map, args.raw, frame)?;
        let base = match &plan.scene {
            Some(name) => Some(args.view.render(name)?),
            None => None,
        };
        let mut image = inputs.load(base, &plan.wanted)?;
        if let Some(region) = args.region {
            image = region.cut(&image, plan.around)?;
        }
        Ok(Loaded { inputs: Arc::new(inputs), image, cut: args.region.is_some() && plan.around > 0 })
    }

    /// The variables that were read, but for those of named images.
    fn names(&self) -> String {
        let names = self.image.variables.iter().map(|v| v.name.as_str());
        names.filter(|n| !n.contains('.')).collect::<Vec<_>>().join(", ")
    }
}

/// Runs it in memory, as often as was asked for.
fn compute(args: &RunArgs, plan: &Plan, loaded: &Loaded, frame: f32) -> Result<(Report, Stats), Failure> {
    let bar = Bar::new(&plan.name, args.quiet);
    let progress = |p| bar.update(p);
    let inputs = Arc::clone(&loaded.inputs);
    let scene = plan.scene.as_ref().map(|name| format!("The scene {name} has {}.", loaded.names()));
    let missing = move |name: &str| match &scene {
        Some(scene) if !name.contains('.') => vec![scene.clone()],
        _ => inputs.missing(name),
    };
    let options = RunOptions {
        frame,
        set: plan.set.clone(),
        pixelsize: args.pixelsize,
        outputs: plan.vars.clone(),
        threads: args.threads,
        batch: args.batch,
        isa: Some(plan.isa),
        no_optimize: args.no_optimize,
        profile: args.profile,
        limits: args.limits.limits(),
        texture_memory: Some(args.limits.textures()),
        cancel: None,
        progress: Some(&progress),
        missing: Some(&missing),
    };
    let mut runs = Vec::new();
    let mut last = None;
    for _ in 0..args.repeat.unwrap_or(1) {
        let start = Instant::now();
        let outcome = plan.program.run(&loaded.image, &options);
        runs.push(start.elapsed());
        bar.clear();
        last = Some(outcome?);
    }
    let Some(mut report) = last else { return Err(Failure::usage("--repeat 0 runs nothing")) };
    let pixels = loaded.image.width * loaded.image.height;
    if let Some(region) = args.region.filter(|_| loaded.cut) {
        report.image = region.cut(&report.image, 0)?;
        report.not_finite = not_finite(&report.image);
    }
    let stats = Stats {
        runs,
        pixels,
        not_finite: report.not_finite,
        threads: report.threads,
        batch: args.batch.unwrap_or(BATCH),
        isa: plan.isa.name(),
        ..Stats::default()
    };
    Ok((report, stats))
}

/// Pixels with a number that is none.
fn not_finite(image: &Image<'_>) -> usize {
    let planes = || image.variables.iter().flat_map(|v| &v.planes);
    (0..image.width * image.height).filter(|&i| planes().any(|p| !p[i].is_finite())).count()
}

fn write(args: &RunArgs, plan: &Plan, output: &Output, image: &Image<'_>) -> Result<(), Failure> {
    let options = args.write_options();
    match &plan.shown {
        Some(name) if output.format != Format::Exr => {
            output::write(&output.path, &output::picture(image, name)?, &options)
        }
        _ => output::write(&output.path, image, &options),
    }
}

/// Says what was done.
fn tell(args: &RunArgs, plan: &Plan, outputs: &[Output], report: &Report, stats: &Stats) {
    if !args.quiet {
        if report.by_normal {
            let note = Diagnostic::bare("normal", "the program assigns no color")
                .hint("The picture shows the surface in white by the normal that the program gave it.")
                .warning();
            show(&note);
        }
        let image = &report.image;
        let region = match args.region {
            Some(_) => format!(" at {}", Region::held(image)),
            None => String::new(),
        };
        for output in outputs {
            warn(&format!(
                "wrote {} ({}x{}{region}) in {:.3} s, {:.1} Mpixels/s",
                output::shown(&output.path),
                image.width,
                image.height,
                (stats.read + stats.run() + stats.write).as_secs_f64(),
                stats.rate(),
            ));
        }
        if report.not_finite > 0 {
            let n = report.not_finite;
            let (s, hold) = if n == 1 { ("", "holds") } else { ("s", "hold") };
            warn(&format!("{n} pixel{s} {hold} NaN or infinity"));
        }
    }
    if args.stats {
        stats.print();
    }
    if let Some(profile) = &report.profile {
        profile::print(profile, plan.program.sources(), stats.pixels);
    }
    if let Some(n) = args.repeat {
        warn(&format!("{}: {:.2} ns/pixel, the median of {n} runs", plan.name, stats.per_pixel()));
    }
}
