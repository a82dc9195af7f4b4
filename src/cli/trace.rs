//! `pse trace`: all that happens at one pixel.

mod json;
mod text;

use super::camera::CameraRequest;
use super::failure::{Failure, print_json, print_rendered, warn};
use super::frames::{Chosen, FrameArg, check_textures};
use super::input::{ImageArgs, Inputs};
use super::interrupt::{self, CANCEL};
use super::known::Lazy;
use super::run::{DEFAULT_SCENE, LimitArgs, reading, scene, set, space};
use super::source::{self, ProgramArgs};
use clap::Args;
use pse::image::Image;
use pse::internal::program::{Error, Program, RunOptions, Trace, TraceOptions};
use pse::internal::resolve::tree::Resolved;
use std::io::{self, IsTerminal};
use std::str::FromStr;

const EXAMPLES: &str = "\
Examples:
  pse trace marble.pse --pixel 320,200                   on the built-in donut
  pse trace marble.pse --pixel 320,200 -i gbuffer.exr --calls
  pse trace -e 'a = sqrt(-1)' -e 'a * white' --scene vase
  pse trace marble.pse --pixel 320,200 --json | jq '.[] | select(.event == \"assign\")'

Every value is exactly the one that pse run computes. See docs/trace.md for the columns and the JSON format.";

/// What to look at, and where.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct TraceArgs {
    #[command(flatten)]
    program: ProgramArgs,
    /// Column and row of the pixel, from 0,0 at the top left (default: the middle of the picture)
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pixel: Option<PixelArg>,
    /// Also trace inside the functions that are called
    #[arg(long, conflicts_with = "depth")]
    calls: bool,
    /// Also trace inside called functions, up to N calls deep
    #[arg(long, value_name = "N", default_value_t = 0)]
    depth: u32,
    /// Show at most N events; of a longer trace, the first and last N/2
    #[arg(long, value_name = "N", default_value_t = TraceOptions::default().limit)]
    limit: usize,
    /// Print the trace as JSON, an array of events
    #[arg(long)]
    json: bool,
    /// Set a param or an input variable to an expression: veins=6, tint='[1 0 0]'
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,

    #[command(flatten)]
    images: ImageArgs,
    /// Read pictures (PNG, JPEG, …) without sRGB conversion
    #[arg(long, help_heading = "Input")]
    raw: bool,
    /// The frame number (default: the one in the input's name or header)
    #[arg(long, value_name = "N", help_heading = "Input", allow_negative_numbers = true)]
    frame: Option<FrameArg>,
    #[command(flatten)]
    limits: LimitArgs,
}

/// A trace as `--json` prints it.
pub(super) fn to_json(trace: &Trace, program: &Program, name: &str, frame: f32) -> String {
    json::json(&text::About { trace, program, name, frame })
}

/// A pixel of the picture.
#[derive(Clone, Copy, Debug)]
struct PixelArg([i64; 2]);

impl FromStr for PixelArg {
    type Err = String;

    fn from_str(text: &str) -> Result<PixelArg, String> {
        let number = |t: &str| t.trim().parse::<i32>().ok().map(i64::from);
        let pixel = text.split_once(',').and_then(|(x, y)| Some([number(x)?, number(y)?]));
        pixel.map(PixelArg).ok_or("a pixel is a column and a row: 320,200".into())
    }
}

/// Tells what happens at the pixel.
pub(super) fn trace(args: &TraceArgs) -> Result<(), Failure> {
    interrupt::cancel_command();
    if args.program.is_stdin() && args.images.input.iter().any(|i| i.path == "-") {
        return Err(Failure::usage("the program and an image cannot both be standard input"));
    }
    let chosen = Chosen::new(None, args.frame, &args.images.frame_sources(), std::iter::empty())?;
    let frame = chosen.frames[0];
    let (name, text) = args.program.read()?;
    let images = Lazy::new(&args.images, frame.number);
    let doubt = |program: &Resolved, name: &str, span| images.doubt(program, name, span);
    let program = source::compile_for(&name, &text, &args.program.path, &doubt)?;
    check_textures(&program, frame)?;
    let set = args.set.iter().map(|text| set(text, frame.value)).collect::<Result<Vec<_>, _>>()?;
    let spaces =
        args.images.space.iter().map(|text| space(text, frame.value)).collect::<Result<Vec<_>, _>>()?;
    let scene = scene(&args.images)?;
    let inputs = Inputs::open(&args.images.input, &args.images.map, args.raw, frame.number)?;
    let renderer =
        scene.as_ref().map(|seen| args.images.view.renderer(seen, frame.number, false)).transpose()?;
    let (wanted, around) = reading(&program, &[], args.images.pixelsize.is_some(), false);
    let mut reader = inputs.reader(renderer.as_ref(), &wanted, true)?;
    let [column, row] = place(args.pixel, reader.about())?;
    let variables: Vec<String> = reader.names().map(String::from).collect();
    let own: Vec<String> = reader.names().filter(|n| !n.contains('.')).map(str::to_string).collect();
    let known = scene.as_ref().map(|seen| format!("The {seen} has {}.", own.join(", ")));
    // The rows about it tell derivatives and sizes, as in a run.
    let rows = row.saturating_sub(around)..(row + around + 1).min(reader.about().height);
    let top = rows.start;
    let image = reader.read(rows)?;
    let camera = CameraRequest {
        program: &program,
        view: args.images.view_of_image(),
        inputs: &inputs,
        about: reader.about(),
        variables: &variables,
        set: &set,
        spaces: &spaces,
    };
    let camera = camera.find()?;
    camera.report();
    drop(reader);
    let missing = |name: &str| match &known {
        Some(known) if !name.contains('.') => vec![known.clone()],
        _ => inputs.missing(name),
    };
    let options = RunOptions {
        frame: frame.value,
        frame_number: frame.number,
        set,
        pixelsize: args.images.pixelsize,
        spaces,
        limits: args.limits.limits(),
        texture_memory: Some(args.limits.textures()),
        cancel: Some(&CANCEL),
        missing: Some(&missing),
        ..RunOptions::default()
    };
    let options = camera.options(options);
    let depth = if args.calls { u32::MAX } else { args.depth };
    let wanted = TraceOptions { depth, limit: args.limit };
    let trace = program.trace(&image, column, row - top, &options, &wanted)?;
    chosen.notes(&program).iter().chain(&inputs.notes(&program)).for_each(|note| warn(note));
    if args.images.is_empty() {
        warn(&format!("no input: using the scene {DEFAULT_SCENE} (see pse scene --list, or give -i FILE)"));
    }
    let about = text::About { trace: &trace, program: &program, name: &name, frame: frame.value };
    if args.json {
        print_json(&json::json(&about))?;
    } else {
        let color = std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
        print_rendered(&text::text(&about, args.limit, color && io::stdout().is_terminal()))?;
    }
    match trace.error {
        None => Ok(()),
        Some(error) => {
            let sources = program.sources().clone();
            Err(Error::new(vec![error], sources).into())
        }
    }
}

/// Column and row of the pixel in what the image holds.
fn place(pixel: Option<PixelArg>, about: &Image<'_>) -> Result<[usize; 2], Failure> {
    let (width, height) = (about.width, about.height);
    let Some(PixelArg([column, row])) = pixel else { return Ok([width / 2, height / 2]) };
    let [x, y] = about.metadata.origin.map(i64::from);
    let (inside_x, inside_y) = (column - x, row - y);
    if !(0..width as i64).contains(&inside_x) || !(0..height as i64).contains(&inside_y) {
        let last = [x + width as i64 - 1, y + height as i64 - 1];
        let failure = Failure::usage(format!("there is no pixel {column},{row}"));
        return Err(failure.hint(format!("The pixels go from {x},{y} to {},{}.", last[0], last[1])));
    }
    Ok([inside_x as usize, inside_y as usize])
}
