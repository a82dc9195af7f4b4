//! What a run is to do, settled before any pixel is read.

use super::RunArgs;
use crate::cli::failure::Failure;
use crate::cli::frames::{Chosen, Frame};
use crate::cli::input::{ImageArgs, Wanted};
use crate::cli::known::Lazy;
use crate::cli::output::Distinct;
use crate::cli::progress::Style;
use crate::cli::scene::Seen;
use crate::cli::{frames, output, source, tiles};
use pse::image::{Content, Format, Matrix4, record};
use pse::internal::diagnostic::SourceId;
use pse::internal::eval::{MAX_THREADS, REACH};
use pse::internal::lanes::Isa;
use pse::internal::program::{Program, RunOptions};
use pse::internal::resolve::tree::Resolved;
use pse::internal::resolve::{names, unknown};
use pse::internal::shape::Shape;
use pse::internal::syntax;
use pse::internal::value::PixelValue;
use pse::solid::Isosurface;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// The scene for who names no image.
pub(in crate::cli) const DEFAULT_SCENE: &str = "donut";

/// A file to write.
pub(super) struct Output {
    /// Where.
    pub path: PathBuf,
    /// As its extension says.
    pub format: Format,
}

/// A run.
pub(in crate::cli) struct Plan {
    /// The program's name in messages.
    pub name: String,
    /// The program.
    pub program: Program,
    /// The variables to write, if they were named.
    pub vars: Option<Vec<String>>,
    /// The variable that pictures show instead of color.
    pub shown: Option<String>,
    /// The variables to read.
    pub wanted: Wanted,
    /// Is the input's alpha written beside a colour that has none?
    pub keep_alpha: bool,
    /// How many pixels about a region the program needs to know.
    pub around: usize,
    /// The scene or mesh that is looked at.
    pub scene: Option<Seen>,
    /// Was that scene chosen because there is no input?
    pub by_default: bool,
    /// At least one.
    pub frames: Vec<Frame>,
    /// What the user should know of their numbers.
    pub frame_notes: Vec<String>,
    /// The instruction set.
    pub isa: Isa,
    /// The names of the outputs, as given or by default.
    paths: Vec<PathBuf>,
    /// Whether they are by default.
    default_paths: bool,
}

impl Plan {
    /// Finds out all that can be wrong before the work begins.
    pub fn new(args: &RunArgs) -> Result<Plan, Failure> {
        let isa = match std::env::var("PSE_SIMD") {
            Ok(name) => Isa::from_name(&name).map_err(|e| Failure::usage(format!("PSE_SIMD: {e}")))?,
            Err(_) => Isa::detect(),
        };
        if args.program.is_stdin() && args.images.input.iter().any(|i| i.path == "-") {
            return Err(Failure::usage("the program and an image cannot both be standard input"));
        }
        if args.images.input.iter().filter(|i| i.path == "-").count() > 1 {
            return Err(Failure::usage("two images cannot both be standard input"));
        }
        output::force(args.force);
        let outputs: Vec<_> = args.output.iter().map(|path| path.to_string_lossy()).collect();
        let outputs = outputs.iter().map(|path| &**path);
        let chosen = Chosen::new(args.frames.as_ref(), args.frame, &args.images.frame_sources(), outputs)?;
        let frames = &chosen.frames;
        let paths = paths(args, frames.len());
        let still = |path: &&PathBuf| !frames::has_pattern(&path.to_string_lossy());
        if let Some(path) = paths.iter().find(still).filter(|_| frames.len() > 1) {
            let shown = output::shown(path);
            let failure = Failure::usage(format!("{} frames would all be written to {shown}", frames.len()));
            return Err(failure.hint("Put the frame number into the name: -o out.####.png."));
        }
        if let (Some(tile), Some(path)) =
            (args.tile, paths.iter().find(|path| !tiles::has_place(&path.to_string_lossy())))
        {
            let shown = output::shown(path);
            let failure = Failure::usage(format!("the tiles of {} would all be written to {shown}", tile.of));
            return Err(failure.hint("Put the tile number into the name: -o 'out.{tile}.exr'."));
        }
        super::resume::check(args)?;
        let piped = paths.iter().any(|p| p.as_os_str() == "-");
        if piped && (args.hash || args.progress == Style::Openjd) {
            let what = if args.hash { "a digest" } else { "progress" };
            return Err(Failure::usage(format!("an image and {what} cannot both go to standard output")));
        }
        let (name, text) = args.program.read()?;
        let images = Lazy::new(&args.images, frames.first().and_then(|frame| frame.number));
        let doubt = |program: &Resolved, name: &str, span| match args.solid.iso {
            Some(_) => unknown::usual(program, name, span),
            None => images.doubt(program, name, span),
        };
        let program = source::compile_for(&name, &text, &args.program.path, &doubt)?;
        frames.iter().try_for_each(|&frame| frames::check_textures(&program, frame))?;
        let vars = args.vars.as_ref().map(|v| v.iter().map(|v| v.trim().to_string()).collect::<Vec<_>>());
        let mut shown = None;
        for path in &paths {
            if Format::of(path)? != Format::Exr {
                let picture = path.display().to_string();
                shown = output::shown_variable(&program, vars.as_deref(), &picture)?;
            }
        }
        if let Some(threads) = args.threads {
            // Scenes and files use this pool too. It is built once; a second try changes nothing.
            let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.min(MAX_THREADS)).build_global();
        }
        // Mistakes in what is set are told before any file is read.
        values(args, frames.first().map_or(0.0, |frame| frame.value))?;
        let sampled = args.sampling().is_some();
        let (wanted, around) =
            reading(&program, vars.as_deref().unwrap_or_default(), args.images.pixelsize.is_some(), sampled);
        let frame_notes = chosen.notes(&program);
        let plan = Plan {
            keep_alpha: vars.is_none() && program.keeps_alpha(),
            wanted,
            around,
            scene: if args.solid.iso.is_some() { no_other(&args.images)? } else { scene(&args.images)? },
            by_default: args.images.is_empty() && args.solid.iso.is_none(),
            name,
            program,
            vars,
            shown,
            frame_notes,
            frames: chosen.frames,
            isa,
            paths,
            default_paths: args.output.is_empty(),
        };
        plan.record_inputs(args);
        Ok(plan)
    }

    /// Protects the inputs of all frames, also those that are not read yet, from the outputs of the frames before.
    fn record_inputs(&self, args: &RunArgs) {
        let several = args.images.paths().any(frames::is_sequence) || self.program.has_texture_sequence();
        let frames = if several { &self.frames[..] } else { &self.frames[..1] };
        for frame in frames {
            let images = args.images.paths().map(|path| frames::input(path, frame.number));
            images.chain(textures(&self.program, *frame)).for_each(|path| record(&path, Content::Data));
        }
    }

    /// The files of a frame that are no other frame's, for messages.
    pub(super) fn inputs_of_frame(&self, args: &RunArgs, frame: Frame) -> Vec<String> {
        let images = args.images.paths().filter(|path| frames::is_sequence(path));
        let images = images.map(|path| frames::input(path, frame.number));
        let sequences = self.program.resolved().textures.iter().filter(|(source, _)| source.is_sequence());
        let textures = sequences.filter_map(|(source, _)| source.path(frame).ok().flatten());
        images.chain(textures).map(|path| format!("`{}`", path.display())).collect()
    }

    /// The solid in a frame, if there is one.
    pub(super) fn solid(&self, args: &RunArgs, frame: Frame) -> Result<Option<Isosurface<'static>>, Failure> {
        let (set, _) = values(args, frame.value)?;
        let own =
            |set| args.solid.open(&args.images.view, &args.program.path, args.limits.limits(), set, frame);
        // What is set may be the solid's, or that of the program which paints it.
        match own(Vec::new())? {
            Some(solid) => {
                let known = names_of(solid.program());
                own(set.into_iter().filter(|(name, _)| known.contains(name.as_str())).collect())
            }
            None => Ok(None),
        }
    }

    /// What is set, without what the solid alone has.
    pub(super) fn own(
        &self,
        mut set: Vec<(String, PixelValue)>,
        solid: Option<&Isosurface<'_>>,
    ) -> Vec<(String, PixelValue)> {
        if let Some(solid) = solid {
            let (own, solids) = (names_of(&self.program), names_of(solid.program()));
            set.retain(|(name, _)| own.contains(name.as_str()) || !solids.contains(name.as_str()));
        }
        set
    }

    /// The files of a frame, each of which can be written and is no input.
    pub(super) fn outputs(&self, args: &RunArgs, frame: Frame) -> Result<Vec<Output>, Failure> {
        let name = |path: &Path| -> PathBuf {
            let fill = |number| frames::fill(&path.to_string_lossy(), number).into();
            frame.number.map_or_else(|| path.to_path_buf(), fill)
        };
        let of_tile = |path: PathBuf| match args.tile {
            Some(tile) => tiles::fill(&path.to_string_lossy(), tile.number).into(),
            None => path,
        };
        let mut outputs: Vec<Output> = Vec::new();
        let mut distinct = Distinct::default();
        for path in &self.paths {
            let path = of_tile(name(path));
            if args.mkdir {
                output::make_folder(&path)?;
            }
            let format = output::check(&path).map_err(|failure| output::or_mkdir(failure, &path))?;
            if self.default_paths {
                output::check_default(&path, args.force)?;
            }
            distinct.add(&path)?;
            outputs.push(Output { path, format });
        }
        Ok(outputs)
    }
}

/// The names of the files to write.
fn paths(args: &RunArgs, frames: usize) -> Vec<PathBuf> {
    if !args.output.is_empty() || args.repeat.is_some() || args.hash {
        return args.output.clone();
    }
    let stem = args.program.stem();
    let frame = if frames > 1 { ".####" } else { "" };
    // Tiles are joined, which pictures with whole numbers are too late for.
    let ending = if args.tile.is_some() { ".{tile}.exr" } else { ".png" };
    vec![format!("{stem}{frame}{ending}").into()]
}

/// The names that the program knows.
fn names_of(program: &Program) -> HashSet<&str> {
    let program = program.resolved();
    let globals = program.globals.iter().filter(|global| !global.library).map(|global| global.name.as_str());
    globals.chain(program.params.iter().map(|param| param.name.as_str())).collect()
}

/// Beside a solid there is no other input without a name.
fn no_other(images: &ImageArgs) -> Result<Option<Seen>, Failure> {
    let other = images.scene.is_some() || images.view.mesh.is_some();
    match other || images.input.iter().any(|i| i.name.is_none()) {
        true => {
            let message = "--iso cannot be combined with a scene, a mesh or an image without a name";
            Err(Failure::usage(message).hint("Remove one of them, or name the image: -i bg=FILE."))
        }
        false => Ok(None),
    }
}

/// The scene or mesh to run on, if any.
pub(in crate::cli) fn scene(images: &ImageArgs) -> Result<Option<Seen>, Failure> {
    let ImageArgs { scene: name, input, view, .. } = images;
    if name.is_some() && view.mesh.is_some() {
        return Err(Failure::usage("--scene and --mesh cannot be combined").hint("Remove one of them."));
    }
    let option = if view.mesh.is_some() { "--mesh" } else { "--scene" };
    if (name.is_some() || view.mesh.is_some()) && input.iter().any(|i| i.name.is_none()) {
        return Err(Failure::usage(format!("{option} and an image without a name cannot be combined"))
            .hint("Remove one of them, or name the image: -i bg=FILE."));
    }
    if let Some(name) = name {
        pse::scene::find(name)?;
        return Ok(Some(Seen::Scene(name.clone())));
    }
    if let Some(mesh) = &view.mesh {
        return Ok(Some(Seen::Mesh(mesh.clone())));
    }
    if !input.is_empty() {
        return view.check_for_image().map(|()| None);
    }
    Ok(Some(Seen::Scene(DEFAULT_SCENE.into())))
}

/// The files that the program looks up in a frame.
pub(super) fn textures(program: &Program, frame: Frame) -> impl Iterator<Item = PathBuf> {
    program.resolved().textures.iter().filter_map(move |(source, _)| source.path(frame).ok().flatten())
}

/// Does it read how large a pixel is?
fn reads_size(program: &Program) -> bool {
    let near = |name: &str| matches!(name, "pixelsize" | "pixel_freq");
    program.resolved().globals.iter().any(|g| g.read.is_some() && near(&g.name))
}

/// What to read for a program: which variables, and how many pixels about each. `sized`: the size of a pixel is given;
/// `sampled`: each is sampled at several places.
pub(in crate::cli) fn reading(
    program: &Program,
    vars: &[String],
    sized: bool,
    sampled: bool,
) -> (Wanted, usize) {
    let sizes = reads_size(program) && !sized;
    let near = sizes || program.resolved().derivatives || sampled;
    // Points and surfaces tell to which neighbours a surface goes on; `I` is the direction to a point.
    let incident = program.inputs().any(|name| name == "I");
    let mut names = wanted(program, vars);
    let mut aids = Vec::new();
    let look = |name: &str, list: &mut Vec<String>| list.push(name.to_string());
    match names.iter().any(|n| n == "point") {
        false if sizes || incident => look("point", &mut names),
        false if near => look("point", &mut aids),
        _ => {}
    }
    if near && !names.iter().any(|n| n == "surface") {
        look("surface", &mut aids);
    }
    (Wanted { names, aids }, if near { REACH } else { 0 })
}

/// The variables of an image that the program may see.
fn wanted(program: &Program, vars: &[String]) -> Vec<String> {
    let program = program.resolved();
    let exposed = program.exposed();
    let globals = || program.globals.iter().zip(&exposed).filter(|(g, _)| !g.library && g.framed.is_none());
    // What is always assigned before it is read is never the image's.
    let hidden: HashSet<&str> = globals().filter(|(_, e)| !**e).map(|(g, _)| g.name.as_str()).collect();
    let own = globals().map(|(g, _)| g.name.as_str());
    let mut seen = HashSet::new();
    own.chain(vars.iter().map(String::as_str))
        .filter(|name| !hidden.contains(name) && seen.insert(*name))
        .map(String::from)
        .collect()
}

/// Values that are set, and where spaces are.
pub(super) type Values = (Vec<(String, PixelValue)>, Vec<(String, Matrix4)>);

/// What is set for a frame, and where named spaces are in it.
pub(super) fn values(args: &RunArgs, frame: f32) -> Result<Values, Failure> {
    let set = args.set.iter().map(|text| set(text, frame)).collect::<Result<_, _>>()?;
    let spaces = args.images.space.iter().map(|text| space(text, frame)).collect::<Result<_, _>>()?;
    Ok((set, spaces))
}

/// `name=expression`: the name, and what the expression gives.
pub(in crate::cli) fn set(text: &str, frame: f32) -> Result<(String, PixelValue), Failure> {
    named_value("--set", text, frame, "Write it as --set veins=6, or --set tint='[1 0.8 0.6]'.")
}

/// `name=matrix`: the name, and the matrix of four rows.
pub(in crate::cli) fn space(text: &str, frame: f32) -> Result<(String, Matrix4), Failure> {
    let form = "Write it as --space object='inverse(translation([0 0 1]))', the matrix from the world to it.";
    let (name, value) = named_value("--space", text, frame, form)?;
    let rows = Shape::vector_of(&[Shape::Vector(4), Shape::Vector(4), Shape::Vector(4), Shape::Vector(4)]);
    let (cells, rest) = value.cells().as_chunks::<4>();
    match cells.try_into() {
        Ok(matrix) if rest.is_empty() && *value.shape() == rows => Ok((name, matrix)),
        _ => {
            let message =
                format!("--space {name}: a space is a matrix of 4 rows of 4, found {}", value.shape());
            Err(Failure::usage(message).hint(form))
        }
    }
}

/// `name=expression` after an option: the name, and what the expression gives.
fn named_value(option: &str, text: &str, frame: f32, form: &str) -> Result<(String, PixelValue), Failure> {
    let Some((name, expression)) = text.split_once('=') else {
        return Err(Failure::usage(format!("{option} {text} has no =")).hint(form));
    };
    let (name, expression) = (name.trim(), expression.trim());
    let title = format!("{option} {name}");
    if let Some((length, color)) =
        syntax::web_color(expression).filter(|(length, _)| *length == expression.len())
    {
        let failure = Failure::usage(format!("{title}: `{}` is a hexadecimal colour", &expression[..length]));
        return Err(failure.hint(format!("Write {option} {name}='{color}'.")));
    }
    let program =
        source::compile(&title, expression, &[]).map_err(|failure| match in_brackets(expression) {
            Some(vector) => failure.hint_program(format!("Write {option} {name}='{vector}'.")),
            None => failure,
        })?;
    // Only then is the value that of `color`, whatever the names in it.
    if syntax::parse_expression(SourceId::default(), expression).is_none() {
        return Err(Failure::usage(format!("{title}: `{expression}` is not a value")).hint(form));
    }
    let of_pixel = |name: &&str| {
        names::USUAL_INPUTS.contains(name) || names::is_system(name) && *name != "frame" || name.contains('.')
    };
    if let Some(read) = program.inputs().find(of_pixel) {
        let failure =
            Failure::usage(format!("{option} cannot read pixels, and `{read}` comes from the image"));
        return Err(
            failure.hint("Its value is the same for the whole frame. Use numbers, constants and `frame`.")
        );
    }
    let missing = |_: &str| {
        vec![format!("The value of {option} is the same for the whole frame and cannot read pixels.")]
    };
    let options = RunOptions { frame, missing: Some(&missing), ..RunOptions::default() };
    let values = program.eval_pixel(&[], &options)?;
    let value = values.into_iter().find(|(name, _)| name == "color").map(|(_, value)| value);
    let value =
        value.ok_or_else(|| Failure::usage(format!("{option} {name}: the value is missing")).hint(form))?;
    Ok((name.to_string(), value))
}

/// Numbers with commas between, as a vector of the language; `None` if that is not what the text is.
fn in_brackets(text: &str) -> Option<String> {
    let inner = text.trim_matches(|c| matches!(c, '[' | ']' | '(' | ')' | '{' | '}'));
    let elements: Vec<&str> = inner.split([',', ' ']).map(str::trim).filter(|e| !e.is_empty()).collect();
    let vector = format!("[{}]", elements.join(" "));
    // `sin 3` is a call without its brackets.
    let is_vector = elements.len() > 1 && elements.iter().all(|element| element.parse::<f32>().is_ok());
    is_vector.then_some(vector)
}
