//! Built-in scenes and solids: `pse scene`, and the options that choose a view of one.

use super::failure::{Failure, print, warn};
use super::frames::{self, Chosen, Frame, FrameArg, FrameSource};
use super::input::Finder;
use super::interrupt;
use super::model::{self, MIDDLE, Recenter, Up};
use super::output;
use super::progress::{Meter, Style};
use super::region::bands;
use super::run::set;
use super::solid::{SolidArgs, print_stats, warn_unseen};
use clap::Args;
use pse::image::{Format, WriteOptions, Writer, check_target};
use pse::internal::program::{Limits, Progress};
use pse::mesh;
use pse::scene::{self, Options, Renderer, parse_point, parse_size};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// A view of a scene.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "View of a scene")]
pub(super) struct ViewArgs {
    /// Use a mesh as input instead of a built-in scene: an .obj, .ply, .glb or .gltf file, or the built-in head
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<String>,
    /// The up axis in the mesh file. The mesh is rotated so that z is up
    #[arg(long, value_enum, value_name = "AXIS", requires = "mesh")]
    pub up: Option<Up>,
    /// Move the mesh's middle, or the given point, to the origin. Far from the origin, point loses precision
    #[arg(
        long, value_name = "X,Y,Z", requires = "mesh", value_parser = Recenter::parse,
        num_args = 0..=1, require_equals = true, default_missing_value = MIDDLE
    )]
    pub recenter: Option<Recenter>,
    /// Width and height of the picture in pixels (default: 640x480)
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<Size>,
    /// Position of the eye, with z up; for an image, in the space of point
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub eye: Option<Point>,
    /// The point at the centre of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub look_at: Option<Point>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEGREES")]
    pub fov: Option<f64>,
    /// Scale the whole scene by this factor; noise on a larger scene looks finer
    #[arg(long, value_name = "FACTOR")]
    pub scale: Option<f64>,
}

/// Columns and rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size(pub [usize; 2]);

/// A point in space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point(pub [f64; 3]);

fn size(text: &str) -> Result<Size, String> {
    parse_size(text).map(Size).map_err(|e| e.hint())
}

fn point(text: &str) -> Result<Point, String> {
    parse_point(text).map(Point).map_err(|e| e.hint())
}

impl ViewArgs {
    /// Checks that nothing is given that an image cannot have.
    pub fn check_for_image(&self) -> Result<(), Failure> {
        let ViewArgs { size, eye, look_at, fov, scale, mesh: _, up: _, recenter: _ } = self;
        if size.is_some() || scale.is_some() {
            return Err(Failure::usage("--size and --scale need a --scene or a --mesh")
                .hint("The size and the points of an image are fixed."));
        }
        if eye.is_none() && (look_at.is_some() || fov.is_some()) || look_at.is_none() && fov.is_some() {
            let (has, misses) = match (look_at, eye) {
                (Some(_), _) => ("--look-at", "--eye"),
                (None, Some(_)) => ("--fov", "--look-at"),
                (None, None) => ("--fov", "--eye and --look-at"),
            };
            return Err(Failure::usage(format!("for an image, {has} needs {misses}")).hint("--eye 3,-8,5 gives the position of the eye. With --look-at the program has the space \"camera\", with \
                       --fov also \"screen\"."));
        }
        Ok(())
    }

    /// The view, as scenes and solids take it.
    pub fn options(&self) -> Options {
        let default = Options::default();
        let [width, height] = self.size.map_or([default.width, default.height], |s| s.0);
        Options {
            width,
            height,
            eye: self.eye.map(|p| p.0),
            look_at: self.look_at.map(|p| p.0),
            fov: self.fov,
            scale: self.scale.unwrap_or(default.scale),
        }
    }

    /// What is seen in this view, in a frame.
    pub fn renderer(&self, seen: &Seen, frame: Option<i64>, quiet: bool) -> Result<Renderer, Failure> {
        let options = self.options();
        Ok(match seen {
            Seen::Scene(name) => Renderer::new(name, &options)?,
            Seen::Mesh(path) => {
                let path = frames::input(path, frame);
                let model = model::load(&path, self.up.unwrap_or_default(), self.recenter, quiet)?;
                Renderer::of_model(&model, &options)?
            }
        })
    }
}

/// What is looked at.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Seen {
    /// The built-in scene of that name.
    Scene(String),
    /// The mesh of that file, in whose name there may be a place for the frame's number.
    Mesh(String),
}

impl fmt::Display for Seen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Seen::Scene(name) => write!(f, "scene {name}"),
            Seen::Mesh(path) => write!(f, "mesh {path}"),
        }
    }
}

/// Which scene, and where to.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pse scene --list\n  pse scene vase -o vase.exr --size 480x640\n  \
                        pse scene floor -o floor.exr --eye 3,-8,5 --look-at 0,0,0.5 --fov 35\n  \
                        pse scene ocean -o - | pse run waves.pse -i - -o waves.png\n  \
                        pse scene --mesh teapot.glb -o teapot.exr --eye 3,-8,4\n  \
                        pse scene --iso coral.pse -o coral.exr --eye 2,-6,3\n  \
                        pse scene --iso coral.pse -o coral.ply --resolution 256")]
pub(super) struct SceneArgs {
    /// The scene (without it, --mesh or --iso: list the scenes)
    #[arg(conflicts_with_all = ["mesh", "iso"])]
    name: Option<String>,
    /// List the scenes
    #[arg(long, conflicts_with_all = ["name", "mesh", "iso"])]
    list: bool,
    /// The file to write; - writes standard output (default: NAME.exr). For a solid also a mesh, with y up: .obj,
    /// .ply or .glb
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The frame number, for a solid and in file names (default: the one in the mesh's file name)
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<FrameArg>,
    /// Let the output replace an input, and a default output replace a file that pse did not write
    #[arg(long)]
    force: bool,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    solid: SolidArgs,
    #[command(flatten)]
    making: MakingArgs,
}

/// How a solid is made.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Solid")]
struct MakingArgs {
    /// For a mesh of a solid: cells along the longest side of the box
    #[arg(long, value_name = "N", requires = "iso", default_value_t = 128)]
    resolution: usize,
    /// Set a param of the solid's program: size=6
    #[arg(long, value_name = "NAME=VALUE", requires = "iso")]
    set: Vec<String>,
    /// Also look for files that the solid's program imports in this folder
    #[arg(long, value_name = "DIR", requires = "iso")]
    path: Vec<PathBuf>,
    /// Print statistics of the search for the surface
    #[arg(long, requires = "iso")]
    stats: bool,
}

/// Writes a scene's or a mesh's G-buffer, or lists the scenes.
pub(super) fn scene(args: &SceneArgs) -> Result<(), Failure> {
    output::force(args.force);
    if let Some(file) = &args.solid.iso {
        return solid(args, file);
    }
    let (seen, name) = match (&args.name, &args.view.mesh) {
        (Some(name), _) => (Seen::Scene(name.clone()), name.clone()),
        (None, Some(mesh)) => {
            let stem = Path::new(mesh).file_stem().unwrap_or_default().to_string_lossy().into_owned();
            (Seen::Mesh(mesh.clone()), stem)
        }
        (None, None) => {
            let width = scene::scenes().iter().map(|s| s.name.len()).max().unwrap_or(0);
            let lines = scene::scenes().iter().map(|s| format!("{:width$}  {}\n", s.name, s.brief));
            return print(&lines.collect::<String>());
        }
    };
    if let Seen::Scene(name) = &seen {
        scene::find(name)?;
    }
    let (frame, path) = args.frame_and_output(&name)?;
    output::check(&path)?;
    let renderer = args.view.renderer(&seen, frame.number, args.quiet)?;
    // Now it is known what the mesh is made of.
    output::check(&path)?;
    let [width, height] = renderer.size();
    write(args, &name, &path, Finder::Scene(&renderer), bands(width, 0..height))?;
    let surfaces = renderer.surfaces();
    if surfaces.len() > 1 && !args.quiet {
        let list: Vec<String> = (1..).zip(surfaces).map(|(i, name)| format!("{i} {name}")).collect();
        warn(&format!("surface: {}", list.join(", ")));
    }
    Ok(())
}

impl SceneArgs {
    /// The frame, and the file to write: `name` with the extension .exr if none is given.
    fn frame_and_output(&self, name: &str) -> Result<(Frame, PathBuf), Failure> {
        let path = self.output.clone().unwrap_or_else(|| format!("{name}.exr").into());
        let text = path.to_string_lossy();
        let mesh = self.view.mesh.as_deref().map(|path| FrameSource { path, named: false });
        let chosen = Chosen::new(None, self.frame, mesh.as_slice(), std::iter::once(&*text))?;
        let frame = chosen.frames[0];
        let path = frame.number.map_or_else(|| path.clone(), |number| frames::fill(&text, number).into());
        if self.output.is_none() {
            output::check_default(&path, self.force)?;
        }
        Ok((frame, path))
    }
}

/// Writes the G-buffer of a solid, or a mesh of it.
fn solid(args: &SceneArgs, file: &Path) -> Result<(), Failure> {
    let SceneArgs { solid, view, making, .. } = args;
    if view.mesh.is_some() {
        return Err(Failure::usage("--iso and --mesh cannot be combined").hint("Remove one of them."));
    }
    let stem = file.file_stem().filter(|_| file.as_os_str() != "-");
    let name = stem.map_or("solid".into(), |s| s.to_string_lossy().into_owned());
    let (frame, path) = args.frame_and_output(&name)?;
    let meshed = mesh::Format::of(&path).is_some();
    match meshed {
        true => {
            mesh::Format::to_write(&path)?;
            check_target(&path)?;
            if solid.soft {
                return Err(Failure::usage("a volume has no surface, so it cannot be written as a mesh")
                    .hint("Remove --soft, or write an .exr file."));
            }
        }
        false => {
            let meshes = "Write the solid's mesh as .obj, .ply or .glb, or its G-buffer as .exr.";
            let known = Format::of(&path).is_ok();
            output::check(&path).map_err(|f| if known { f } else { f.hint(meshes) })?;
        }
    }
    let set = making.set.iter().map(|text| set(text, frame.value)).collect::<Result<_, _>>()?;
    interrupt::cancel_command();
    let found = solid.open(view, &making.path, Limits::default(), set, frame)?;
    let Some(found) = found else { return Ok(()) };
    // Now it is known what the solid is made of.
    check_target(&path)?;
    if meshed {
        let meter = Meter::new(&name, Style::Bar, args.quiet, 1);
        let mut mesh = found.mesh(making.resolution, &|progress| meter.update(progress))?;
        meter.frame();
        if mesh.faces.is_empty() {
            return Err(Failure::plain("the box contains no surface")
                .hint("Check that the density crosses the --level inside the --box."));
        }
        // As other programs, and --mesh, take it to be.
        mesh.z_up_to_y_up();
        mesh.write(&path)?;
        if !args.quiet {
            let (points, faces) = (mesh.points.len(), mesh.faces.len());
            warn(&format!("wrote {} ({points} points, {faces} triangles)", output::shown(&path)));
        }
    } else {
        let [width, height] = found.size();
        // Enough rays to go on together, and few enough to tell how far all has come.
        let rows =
            (0..height).step_by(BAND.div_ceil(width)).map(|top| top..height.min(top + BAND.div_ceil(width)));
        write(args, &name, &path, Finder::Solid(&found), rows)?;
        if !args.quiet {
            warn_unseen(&found.stats(), solid);
        }
    }
    if making.stats {
        print_stats(&found.stats());
    }
    Ok(())
}

/// Rays that go on together, about.
const BAND: usize = 1 << 16;

/// Writes what is seen, band after band.
fn write(
    args: &SceneArgs,
    name: &str,
    path: &Path,
    seen: Finder<'_>,
    bands: impl Iterator<Item = Range<usize>>,
) -> Result<(), Failure> {
    let [width, height] = seen.size();
    let mut writer = Writer::create(path, height, &WriteOptions::default())?;
    let meter = Meter::new(name, Style::Bar, args.quiet, 1);
    interrupt::cancel_command();
    for rows in bands {
        let done = rows.end * width;
        writer.rows(&seen.rows(rows)?)?;
        meter.update(Progress { done, total: width * height });
        if interrupt::CANCEL.load(Ordering::Relaxed) {
            return Err(Failure::Interrupted);
        }
    }
    writer.finish()?;
    meter.frame();
    if !args.quiet {
        warn(&format!("wrote {} ({width}x{height})", output::shown(path)));
    }
    Ok(())
}
