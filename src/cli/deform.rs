//! `pse deform`: a program at every vertex of a mesh.

use super::failure::{Failure, warn};
use super::frames::{self, Chosen, FrameArg, FrameSource, Frames};
use super::interrupt::{self, CANCEL};
use super::model::{self, MIDDLE, Recenter};
use super::output;
use super::prints::Shown;
use super::progress::{Meter, Style};
use super::run::{LimitArgs, set};
use super::source::{self, ProgramArgs};
use clap::Args;
use pse::image::check_target;
use pse::internal::program::RunOptions;
use pse::mesh::{Deform, Format};
use std::path::{Path, PathBuf};

/// Which mesh, what to do with it, and where to.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pse deform teapot.obj wobble.pse -o teapot2.obj\n  \
                        pse deform head examples/heads.pse --set who=7 -o seven.glb\n  \
                        pse deform head examples/heads.pse --frames 1-24 -o head.####.obj\n  \
                        pse deform scan.ply -e 'point += 0.1 * normal * Noise(4 * point)' -o rough.ply\n\n\
                        The program reads point, normal and uv of each vertex, and assigns point. Faces, uv and surfaces stay \
                        the same. Normals are recomputed; creases stay creases. The mesh is not rotated: if y was up, it \
                        still is.")]
pub(super) struct DeformArgs {
    /// The mesh: an .obj, .ply, .glb or .gltf file, or the built-in head
    #[arg(value_name = "MESH")]
    mesh: String,
    #[command(flatten)]
    program: ProgramArgs,
    /// The file to write: .obj, .ply or .glb
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Set a param to an expression: who=7
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// The frame number (default: the one in the mesh's file name)
    #[arg(long, value_name = "N", conflicts_with = "frames", allow_negative_numbers = true)]
    frame: Option<FrameArg>,
    /// Run several frames: 1-24, -3-3, 1,5,9 or 1-20x2. In file names, ####, @@@@, %d or %04d stands for the frame
    /// number
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<Frames>,
    /// The size of the finest noise detail (default: the mean edge length)
    #[arg(long, value_name = "SIZE")]
    pixelsize: Option<f32>,
    /// Give the program points relative to the mesh's middle, or to the given point, and move the result back. For
    /// meshes far from the origin, where point loses precision
    #[arg(
        long, value_name = "X,Y,Z", value_parser = Recenter::parse,
        num_args = 0..=1, require_equals = true, default_missing_value = MIDDLE
    )]
    recenter: Option<Recenter>,
    /// Show at most N lines of the program's print output, from the first vertices; 0 shows none
    #[arg(long, value_name = "N", default_value_t = 10)]
    print: usize,
    /// Let the output replace the input
    #[arg(long)]
    force: bool,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    limits: LimitArgs,
}

/// Moves the vertices in each frame.
pub(super) fn deform(args: &DeformArgs) -> Result<(), Failure> {
    output::force(args.force);
    let pattern = args.output.to_string_lossy();
    let mesh = FrameSource { path: &args.mesh, named: false };
    let chosen = Chosen::new(args.frames.as_ref(), args.frame, &[mesh], std::iter::once(&*pattern))?;
    let list = &chosen.frames;
    if list.len() > 1 && !frames::has_pattern(&pattern) {
        return Err(Failure::usage(format!("{} frames would all be written to {pattern}", list.len()))
            .hint("Put the frame number into the name: -o head.####.obj."));
    }
    Format::to_write(&args.output)?;
    let (name, text) = args.program.read()?;
    let program = source::compile(&name, &text, &args.program.path)?;
    if !program.assigned().any(|name| name == "point") {
        return Err(Failure::plain(format!("{name} does not assign `point`, so no vertex would move")).hint(
            "Assign the new position of each vertex, for example: point += 0.1 * normal * Noise(4 * point).",
        ));
    }
    if program.resolved().derivatives {
        let failure = Failure::plain(format!("{name} uses derivatives between pixels"));
        return Err(failure.hint(
            "Vertices have no neighbouring pixels. Remove the derivatives, and give image look-ups a `width`.",
        ));
    }
    list.iter().try_for_each(|&frame| frames::check_textures(&program, frame))?;
    if !args.quiet {
        chosen.notes(&program).iter().for_each(|note| warn(note));
    }
    let meter = Meter::new(&name, Style::Bar, args.quiet, list.len());
    let mut kept: Option<(PathBuf, Deform)> = None;
    let mut shown = Shown::new(if args.quiet { 0 } else { args.print });
    for (i, frame) in list.iter().enumerate() {
        let input = frames::input(&args.mesh, frame.number);
        let target: PathBuf = frame.number.map_or(pattern.to_string(), |n| frames::fill(&pattern, n)).into();
        check_target(&target)?;
        let deform = match kept.take() {
            Some((path, deform)) if path == input => deform,
            _ => read(args, &input)?,
        };
        // Now it is known what else the mesh is made of.
        check_target(&target)?;
        if i == 0 {
            interrupt::cancel_command();
        }
        let missing = |_: &str| {
            let image = deform.image();
            let names: Vec<&str> = image.variables.iter().map(|v| v.name.as_str()).collect();
            vec![format!("A vertex of this mesh has {}.", names.join(", "))]
        };
        let options = RunOptions {
            frame: frame.value,
            frame_number: frame.number,
            set: args.set.iter().map(|text| set(text, frame.value)).collect::<Result<_, _>>()?,
            outputs: Some(vec!["point".into()]),
            pixelsize: Some(args.pixelsize.unwrap_or_else(|| deform.spacing())),
            prints: shown.wanted(),
            limits: args.limits.limits(),
            texture_memory: Some(args.limits.textures()),
            cancel: Some(&CANCEL),
            missing: Some(&missing),
            ..RunOptions::default()
        };
        let report = program.run(&deform.image(), &options)?;
        shown.frame(&report.frame_prints, program.sources(), frame.number);
        shown.frame(&report.prints, program.sources(), frame.number);
        let moved = deform.moved(&report.image).map_err(Failure::Plain)?;
        moved.write(&target)?;
        meter.frame();
        if !args.quiet {
            let (points, faces) = (moved.points.len(), moved.faces.len());
            warn(&format!("wrote {} ({points} vertices, {faces} faces)", output::shown(&target)));
        }
        kept = Some((input, deform));
    }
    shown.end();
    Ok(())
}

/// The mesh of a file, ready to be moved.
fn read(args: &DeformArgs, input: &Path) -> Result<Deform, Failure> {
    let mesh = model::read(input, args.quiet)?;
    if mesh.points.is_empty() {
        let message = format!("`{}` has no vertices, so there is nothing to move", input.display());
        return Err(Failure::plain(message).hint("Give a mesh with polygons."));
    }
    Ok(match args.recenter {
        Some(recenter) => {
            let origin = recenter.origin(&mesh);
            Deform::around(mesh, origin)
        }
        None => {
            if !args.quiet {
                model::warn_coarse(input, &mesh);
            }
            Deform::new(mesh)
        }
    })
}
