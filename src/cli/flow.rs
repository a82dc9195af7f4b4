//! `pse flow`: points that a program's `velocity(p)` carries along, drawn as lines or written as points.

use super::camera;
use super::failure::{Failure, warn};
use super::frames::{self, Chosen, Frame, FrameArg, Frames};
use super::input::{ImageArgs, Inputs, Wanted};
use super::interrupt::{self, CANCEL};
use super::output;
use super::progress::{Meter, Style};
use super::run::{LimitArgs, positive, scene, set, space};
use super::solid::{Bounds, bounds};
use super::source::ProgramArgs;
use clap::Args;
use pse::Disk;
use pse::flow::{self, Flow, Pen, Trajectories};
use pse::gbuffer::Projection;
use pse::image::{Content, Format, Image, Metadata, NewFile, WriteOptions, record, write};
use pse::internal::program::RunOptions;
use std::io::{BufWriter, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  pse flow fur.pse --scene donut --every 3 -o fur.png       hair on the visible surface
  pse flow smoke.pse --grid 24x24x1 --steps 200             from a grid, into smoke.png
  pse flow fireball.pse --ball 4000 --frames 1-24 -o fire.####.png
  pse flow fur.pse -i gbuffer.exr -o fur.exr                a G-buffer of the lines, for pse run
  pse flow smoke.pse --ball 500 -o smoke.ply                points and edges, for other programs

The program defines velocity(p), and optionally color(p, age, along, line): age is 0 at the seed and 1 at the end of a \
line, along is the unit vector along the line, and line is its number. See docs/flow.md.";

/// What flows, from where, and where to.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct FlowArgs {
    #[command(flatten)]
    program: ProgramArgs,
    /// Set a param to an expression: speed=2, wind='[1 0 0]'
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,

    /// Place seeds on a grid of cells in the box: 20x20x20, or 40x40x1 for one layer
    #[arg(long, value_name = "NXxNYxNZ", value_parser = cells, help_heading = "Seeds", conflicts_with = "ball")]
    grid: Option<Cells>,
    /// Two corners of the box for the grid
    #[arg(long = "box", value_name = "X,Y,Z,X,Y,Z", value_parser = bounds, help_heading = "Seeds", requires = "grid",
          allow_hyphen_values = true, default_value = "-1,-1,-1,1,1,1")]
    bounds: Bounds,
    /// Spread N seeds over a ball around the origin (default without other seeds: 2000)
    #[arg(long, value_name = "N", help_heading = "Seeds")]
    ball: Option<usize>,
    /// The radius of the ball
    #[arg(long, value_name = "R", default_value_t = 1.0, help_heading = "Seeds")]
    radius: f64,
    /// Place a seed in every Nth column and row of the image of -i or --scene
    #[arg(long, value_name = "N", value_parser = positive, default_value_t = 4, help_heading = "Seeds")]
    every: usize,

    /// Time step along a line; negative goes backward
    #[arg(
        long,
        value_name = "TIME",
        default_value_t = 0.02,
        help_heading = "Lines",
        allow_negative_numbers = true
    )]
    step: f64,
    /// Number of steps of each line
    #[arg(long, value_name = "N", value_parser = positive, default_value_t = 50, help_heading = "Lines")]
    steps: usize,
    /// Line width in pixels; below 1 the line is fainter
    #[arg(long, value_name = "PIXELS", default_value_t = 1.0, help_heading = "Lines")]
    width: f64,

    #[command(flatten)]
    images: ImageArgs,
    /// The frame number (default: the one in the input's name or header)
    #[arg(
        long,
        value_name = "N",
        help_heading = "Frames",
        conflicts_with = "frames",
        allow_negative_numbers = true
    )]
    frame: Option<FrameArg>,
    /// Run several frames: 1-24, -3-3, 1,5,9 or 1-20x2. In file names, ####, @@@@, %d or %04d stands for the frame
    /// number
    #[arg(long, value_name = "LIST", help_heading = "Frames", allow_hyphen_values = true)]
    frames: Option<Frames>,
    /// How to report progress
    #[arg(long, value_enum, default_value_t, value_name = "STYLE", help_heading = "Frames")]
    progress: Style,

    /// A file to write; repeat for several: a picture, an .exr with point, along, depth, age, line, color and alpha,
    /// or a .ply of points and edges (default: PROGRAM.png)
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    output: Vec<PathBuf>,
    /// Let an output replace an input, and a default output replace a file that pse did not write
    #[arg(long, help_heading = "Output")]
    force: bool,
    /// Print errors only
    #[arg(short, long, help_heading = "Output")]
    quiet: bool,
    /// Print the number of lines, the time taken, and the divergence of the velocity
    #[arg(long, help_heading = "Output")]
    stats: bool,
    #[command(flatten)]
    limits: LimitArgs,
}

/// Cells of a grid along the axes.
#[derive(Clone, Copy, Debug)]
struct Cells([usize; 3]);

fn cells(text: &str) -> Result<Cells, String> {
    let numbers: Option<Vec<usize>> =
        text.split('x').map(|t| t.trim().parse().ok().filter(|n| *n > 0)).collect();
    let cells = numbers.and_then(|n| <[usize; 3]>::try_from(n).ok());
    cells.map(Cells).ok_or("a grid is three whole numbers: 20x20x20, or 40x40x1 for one layer".into())
}

/// What a frame begins with.
struct Start {
    seeds: Vec<[f32; 3]>,
    /// The camera, or why it is not known.
    projection: Result<Projection, String>,
    /// What was seen, whose surfaces hide lines.
    image: Option<Image<'static>>,
}

/// Follows and draws, frame by frame.
pub(super) fn flow(args: &FlowArgs) -> Result<(), Failure> {
    interrupt::cancel_command();
    output::force(args.force);
    let given: Vec<_> = args.output.iter().map(|path| path.to_string_lossy()).collect();
    let given = given.iter().map(|path| &**path);
    let chosen = Chosen::new(args.frames.as_ref(), args.frame, &args.images.frame_sources(), given)?;
    let frames = &chosen.frames;
    let outputs = outputs(args)?;
    check(args)?;
    let (name, text) = args.program.read()?;
    let flow = Flow::compile(&Disk { path: args.program.path.clone() }, &name, &text)?;
    for &frame in frames {
        flow.programs().try_for_each(|program| frames::check_textures(program, frame))?;
    }
    // Either program may be the one that reads the frame.
    let notes = flow.programs().map(|program| chosen.notes(program)).find(|notes| !notes.is_empty());
    notes.iter().flatten().filter(|_| !args.quiet).for_each(|note| warn(note));
    let meter = Meter::new(&name, args.progress, args.quiet, frames.len());
    for (i, &frame) in frames.iter().enumerate() {
        if let Err(failure) = draw(args, &flow, &outputs, frame, &meter, args.stats && i == 0) {
            meter.fail(&failure.message());
            return Err(failure);
        }
        meter.frame();
    }
    Ok(())
}

/// One frame.
fn draw(
    args: &FlowArgs,
    flow: &Flow,
    outputs: &[PathBuf],
    frame: Frame,
    meter: &Meter,
    stats: bool,
) -> Result<(), Failure> {
    let begun = Instant::now();
    let named = |path: &PathBuf| match frame.number {
        Some(number) => frames::fill(&path.to_string_lossy(), number).into(),
        None => path.clone(),
    };
    let targets: Vec<PathBuf> = outputs.iter().map(named).collect();
    // What is read later counts too.
    let inputs = args.images.paths().map(|path| frames::input(path, frame.number));
    inputs.for_each(|path| record(&path, Content::Data));
    flow.files(frame).iter().for_each(|path| record(path, Content::Data));
    let mut distinct = output::Distinct::default();
    for path in &targets {
        check_output(path)?;
        if args.output.is_empty() {
            output::check_default(path, args.force)?;
        }
        distinct.add(path)?;
    }
    let start = start(args, frame)?;
    targets.iter().try_for_each(|path| check_output(path))?;
    let tell = |progress| {
        meter.update(progress);
        ControlFlow::Continue(())
    };
    let options = RunOptions {
        frame: frame.value,
        frame_number: frame.number,
        set: args.set.iter().map(|text| set(text, frame.value)).collect::<Result<_, _>>()?,
        spaces: args.images.space.iter().map(|text| space(text, frame.value)).collect::<Result<_, _>>()?,
        pixelsize: Some(args.images.pixelsize.unwrap_or_else(|| extent(&start.seeds).1 as f32 / 512.0)),
        limits: args.limits.limits(),
        texture_memory: Some(args.limits.textures()),
        cancel: Some(&CANCEL),
        progress: Some(&tell),
        ..RunOptions::default()
    };
    let lines = flow.trajectories(&start.seeds, args.step, args.steps, &options)?;
    let colors = flow.colors(&lines, &options)?;
    for path in &targets {
        save(args, path, &lines, colors.as_deref(), &start)?;
        if !args.quiet {
            warn(&format!("wrote {} ({} lines)", output::shown(path), lines.lines()));
        }
    }
    if stats { told(flow, &lines, &options, begun) } else { Ok(()) }
}

/// Numbers that lead nowhere are told before the work.
fn check(args: &FlowArgs) -> Result<(), Failure> {
    let refuse = |what: &str, number: f64, hint: &str| {
        Err(Failure::usage(format!("{what} of {number} is not possible")).hint(hint.to_string()))
    };
    if !(args.step.is_finite() && args.step != 0.0) {
        return refuse("a step", args.step, "Give a time like 0.02; a negative time goes backward.");
    }
    if !(args.width > 0.0 && args.width <= 100.0) {
        return refuse("a width", args.width, "Give a number of pixels, for example from 0.1 to 100.");
    }
    if !(args.radius > 0.0 && args.radius <= 1e6) {
        return refuse("a radius", args.radius, "Give a radius above 0 and at most 1000000.");
    }
    if args.images.pixelsize.is_some_and(|size| size.is_nan() || size <= 0.0) {
        return Err(Failure::usage("--pixelsize must be more than 0"));
    }
    let cells = args.grid.map(|grid| grid.0.iter().fold(1usize, |n, &k| n.saturating_mul(k)));
    let seeds = cells.or(args.ball).unwrap_or(1);
    if seeds == 0 {
        return Err(Failure::usage("there are no seeds").hint("Give more than 0: --ball 2000."));
    }
    if seeds.saturating_mul(args.steps + 1) > flow::MAX_POINTS {
        let message = format!("{seeds} lines of {} steps are too many points", args.steps);
        return Err(Failure::usage(message).hint(format!("The limit is {} in all.", flow::MAX_POINTS)));
    }
    let [width, height] = args.images.view.size.map_or([1, 1], |s| s.0);
    if width.checked_mul(height).is_none_or(|n| n == 0 || n > MAX_PIXELS) {
        let message = format!("a picture of {width}x{height} cannot be drawn");
        return Err(Failure::usage(message)
            .hint(format!("Lines are drawn in memory. Give a size of 1 to {MAX_PIXELS} pixels.")));
    }
    let piped = args.output.iter().filter(|path| path.as_os_str() == "-").count();
    if piped > 1 || piped == 1 && args.progress == Style::Openjd {
        return Err(Failure::usage("two outputs cannot both go to standard output"));
    }
    Ok(())
}

/// The most pixels of a picture: some 4 gigabytes of planes.
const MAX_PIXELS: usize = 1 << 26;

/// Checks that a file can be written, and takes the place of nothing that is read.
fn check_output(path: &Path) -> Result<(), Failure> {
    if is_ply(path) {
        return Ok(pse::image::check_target(path)?);
    }
    let known = Format::of(path).is_ok();
    output::check(path).map(drop).map_err(|f| if known { f } else { f.hint("Write points as .ply.") })
}

/// The files to write, each of which can be written.
fn outputs(args: &FlowArgs) -> Result<Vec<PathBuf>, Failure> {
    let several = args.frames.as_ref().is_some_and(|f| f.0.len() > 1);
    let mut outputs = args.output.clone();
    if outputs.is_empty() {
        outputs.push(format!("{}{}.png", args.program.stem(), if several { ".####" } else { "" }).into());
    }
    for path in &outputs {
        let name = path.to_string_lossy();
        if several && !frames::has_pattern(&name) {
            let failure = Failure::usage(format!("several frames would all be written to {name}"));
            return Err(failure.hint("Put the frame number into the name: -o out.####.png."));
        }
        check_output(path)?;
    }
    Ok(outputs)
}

fn is_ply(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ply"))
}

/// Where the lines begin, and who looks at them.
fn start(args: &FlowArgs, frame: Frame) -> Result<Start, Failure> {
    let view = &args.images.view;
    let seeds = match (args.grid, args.ball) {
        (Some(Cells(cells)), _) => {
            let Bounds([low, high]) = args.bounds;
            Some(flow::grid(cells, low, high))
        }
        (None, Some(count)) => Some(flow::ball(count, args.radius)),
        (None, None) => None,
    };
    let sees = !args.images.is_empty();
    if !sees {
        let seeds = seeds.unwrap_or_else(|| flow::ball(2000, args.radius));
        // What the seeds are in, and half as much about it: lines leave it, and the camera stays where it is in all frames.
        let (middle, radius) = extent(&seeds);
        let fov = view.fov.unwrap_or(30.0);
        let distance = 1.5 * radius.max(1e-6) / libm::sin(fov.to_radians() / 2.0).abs().max(1e-3);
        let look_at = view.look_at.map_or(middle, |p| p.0);
        let from = [look_at[0], look_at[1] - 0.94 * distance, look_at[2] + 0.34 * distance];
        let size = view.size.map_or([640, 480], |s| s.0);
        let projection = Projection::looking(view.eye.map_or(from, |p| p.0), look_at, fov, size)?;
        return Ok(Start { seeds, projection: Ok(projection), image: None });
    }
    let inputs = Inputs::open(&args.images.input, &args.images.map, false, frame.number)?;
    let renderer = scene(&args.images)?.map(|seen| view.renderer(&seen, frame.number, false)).transpose()?;
    let wanted = Wanted { names: vec!["point".into()], aids: vec!["surface".into(), "depth".into()] };
    let mut reader = inputs.reader(renderer.as_ref(), &wanted, false)?;
    let rows = 0..reader.about().height;
    let image = reader.read(rows)?;
    drop(reader);
    if seeds.is_none() && image.variable("point").is_none() {
        let failure = Failure::plain("the input has no variable `point`, which the seeds need");
        return Err(failure.hint("Name its channels with --map point=CHANNELS, or use --grid or --ball."));
    }
    let seeds = seeds.unwrap_or_else(|| flow::visible(&image, args.every));
    if seeds.is_empty() {
        return Err(Failure::plain("no pixel shows a surface, so there are no seeds"));
    }
    let screen =
        args.images.space.iter().map(|text| space(text, frame.value)).collect::<Result<Vec<_>, _>>()?;
    let screen = screen.iter().rev().find(|(name, _)| name == "screen");
    let projection = match (screen, args.images.view_of_image()) {
        (Some((_, matrix)), _) => Projection::new(matrix, image.resolution())
            .ok_or_else(|| "`--space screen` is not the matrix of a perspective camera.".into()),
        (None, None) => Projection::of(&image).map_err(|error| error.to_string()),
        (None, Some(view)) => camera::projection(&inputs, view, &image, args.quiet)?,
    };
    Ok(Start { seeds, projection, image: Some(image) })
}

/// The middle of what points lie in, and how far from there the farthest may be.
fn extent(points: &[[f32; 3]]) -> ([f64; 3], f64) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for i in 0..3 {
            low[i] = low[i].min(f64::from(point[i]));
            high[i] = high[i].max(f64::from(point[i]));
        }
    }
    let middle = [0, 1, 2].map(|i| (low[i] + high[i]) / 2.0);
    let square: f64 = (0..3).map(|i| (high[i] - middle[i]) * (high[i] - middle[i])).sum();
    (middle, square.sqrt())
}

/// Writes one file.
fn save(
    args: &FlowArgs,
    path: &Path,
    lines: &Trajectories,
    colors: Option<&[[f32; 4]]>,
    start: &Start,
) -> Result<(), Failure> {
    if is_ply(path) {
        let mut file = NewFile::create(path)?;
        let mut out = BufWriter::new(&mut file);
        let written = flow::to_ply(lines, colors, &mut out).and_then(|()| out.flush());
        written.map_err(|e| Failure::plain(format!("cannot write `{}`: {e}", path.display())))?;
        drop(out);
        return Ok(file.finish()?);
    }
    let projection = start.projection.as_ref().map_err(|reason| {
        Failure::plain("the camera of the input is unknown")
            .hint("EXR files store it in the attribute worldToNDC; this input has none.")
            .hint(reason)
            .hint("Give --eye, --look-at and --fov, or the matrix from world to screen (0 to 1) with --space screen='…'. Or write points: -o lines.ply.")
    })?;
    let pen = Pen { width: args.width };
    let mut image = flow::draw(lines, colors, projection, &pen, start.image.as_ref());
    match &start.image {
        // The lines fill the whole picture, whatever part of it the image holds.
        Some(seen) => image.metadata = Metadata { origin: [0, 0], resolution: None, ..seen.metadata.clone() },
        None => projection.note(&mut image.metadata),
    }
    if Format::of(path)? != Format::Exr {
        // A picture is opaque, and black where there is nothing.
        image.variables.retain(|v| v.name == "color");
    }
    Ok(write(path, &image, &WriteOptions::default())?)
}

/// What `--stats` tells.
fn told(flow: &Flow, lines: &Trajectories, options: &RunOptions<'_>, begun: Instant) -> Result<(), Failure> {
    let time = begun.elapsed().as_secs_f64();
    let count = lines.points.len();
    warn(&format!("{} lines of {} steps: {count} points in {time:.2} s", lines.lines(), lines.steps));
    let some: Vec<[f32; 3]> = lines.points.iter().step_by((count / 10_000).max(1)).copied().collect();
    let distance = extent(&some).1.max(1e-3) * 1e-3;
    let measured = flow.divergence(&some, distance, options)?;
    warn(&format!(
        "divergence {:.2e}, which is {:.2e} of the velocity's derivatives, at {} of the points, by differences over {:.1e}",
        measured.divergence,
        measured.share(),
        measured.points,
        2.0 * distance,
    ));
    Ok(())
}
