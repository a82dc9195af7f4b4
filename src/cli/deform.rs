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
                        The program reads point, normal and uv of each vertex, and assigns point. Faces, uv and surfaces stay; \
                        normals are made anew, with creases where there were some. Nothing is turned: y is up if it was.")]
pub(super) struct DeformArgs {
    /// The mesh: .obj, .ply, .glb or .gltf; or head, which is built in
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
    /// The number of the frame; that in the name of the mesh if not given
    #[arg(long, value_name = "N", conflicts_with = "frames", allow_negative_numbers = true)]
    frame: Option<FrameArg>,
    /// Several frames: 1-24, -3-3, 1,5,9 or 1-20x2. Names of files may hold the number as ####, @@@@, %d or %04d
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<Frames>,
    /// How fine a detail of noise may be, instead of the mean length of the edges
    #[arg(long, value_name = "SIZE")]
    pixelsize: Option<f32>,
    /// Let the program see points relative to the mesh's middle, or to the point given; they are put back from there. For meshes
    /// far from the origin, where `point` has few digits
    #[arg(
        long, value_name = "X,Y,Z", value_parser = Recenter::parse,
        num_args = 0..=1, require_equals = true, default_missing_value = MIDDLE
    )]
    recenter: Option<Recenter>,
    /// Show so many lines of what the program prints, those of the first vertices; 0 shows none
    #[arg(long, value_name = "N", default_value_t = 10)]
    print: usize,
    /// Let the output replace the input
    #[arg(long)]
    force: bool,
    /// Say nothing but errors
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
        return Err(Failure::usage(format!("{} frames cannot all be written to {pattern}", list.len()))
            .hint("Give a place for the frame's number: -o head.####.obj."));
    }
    Format::to_write(&args.output)?;
    let (name, text) = args.program.read()?;
    let program = source::compile(&name, &text, &args.program.path)?;
    if !program.assigned().any(|name| name == "point") {
        return Err(Failure::plain(format!("{name} assigns no point, so nothing would move")).hint(
            "A deformation says where each vertex goes, for example: point += 0.1 * normal * Noise(4 * point).",
        ));
    }
    if program.resolved().derivatives {
        let failure = Failure::plain(format!("{name} asks how things change from pixel to pixel"));
        return Err(failure.hint(
            "Vertices have no such neighbours: leave out derivatives, and give look-ups in images a width.",
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
        let message = format!("there is no vertex in `{}`, so nothing would move", input.display());
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
