//! `pse check`: what is wrong with programs, without running them.

use super::camera::CameraRequest;
use super::failure::{Failure, style, warn, warn_rendered};
use super::input::{InputArg, Inputs, MapArg};
use super::known::Known;
use super::scene::ViewArgs;
use super::source;
use clap::Args;
use pse::image::Image;
use pse::internal::diagnostic::{Diagnostic, Severity};
use pse::internal::eval::no_eye;
use pse::internal::program::{Error, Program};
use pse::internal::resolve::tree::Resolved;
use pse::internal::resolve::{names, unknown};
use pse::internal::syntax::MAX_ERRORS;
use pse::internal::vocabulary;
use pse::scene::{self, Options};
use std::path::PathBuf;
use std::sync::Arc;

/// Which programs, and what they are to fit.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pse check *.pse\n  pse check marble.pse -i gbuffer.exr\n  \
                        pse check bubble.pse --scene bubble\n\n\
                        Without an image, programs may read the usual variables of G-buffers (point, normal, \
                        surface, …).")]
pub(super) struct CheckArgs {
    /// The programs; - reads standard input
    #[arg(required = true, value_name = "PROGRAM")]
    programs: Vec<PathBuf>,
    /// An image whose variables the programs may read
    #[arg(short, long, value_name = "FILE|NAME=FILE", conflicts_with = "scene")]
    input: Vec<InputArg>,
    /// A built-in scene whose variables the programs may read
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Read a variable from the channels named here
    #[arg(long, value_name = "NAME=CHANNELS", requires = "input")]
    map: Vec<MapArg>,
    /// Also look for imported files and textures in this folder
    #[arg(long, value_name = "DIR")]
    path: Vec<PathBuf>,
    /// Also report the programs that have no mistakes
    #[arg(short, long)]
    verbose: bool,
}

/// Checks each of the programs.
pub(super) fn check(args: &CheckArgs) -> Result<(), Failure> {
    let known = match &args.scene {
        Some(name) => {
            let options = Options { width: 2, height: 2, ..Options::default() };
            let image = scene::render(name, &options)?;
            let has = image.variables.iter().map(|v| v.name.clone()).collect();
            let inputs = Arc::new(Inputs::none());
            Known::Images { first: Some((format!("scene {name}"), has)), inputs }
        }
        None if args.input.is_empty() => Known::Usual,
        None => Known::files(&args.input, &args.map)?,
    };
    let mut good = true;
    for path in &args.programs {
        if let Err(failure) = one(path, &args.path, &known) {
            failure.report();
            good = false;
        }
    }
    if !good {
        return Err(Failure::Said);
    }
    if args.verbose {
        let n = args.programs.len();
        warn(&format!("{n} program{} checked", if n == 1 { "" } else { "s" }));
    }
    Ok(())
}

fn one(path: &std::path::Path, folders: &[PathBuf], known: &Known) -> Result<(), Failure> {
    let (name, text) = source::read(path)?;
    let doubt = |program: &Resolved, name: &str, span| known.doubt_before_run(program, name, span);
    let program = source::compile_for(&name, &text, folders, &doubt)?;
    let diagnostics = doubts(&program, known);
    if diagnostics.is_empty() {
        return Ok(());
    }
    let bad = diagnostics.iter().any(|d| d.severity == Severity::Error);
    let error = Error::new(diagnostics, program.sources().clone());
    if bad {
        return Err(error.into());
    }
    warn_rendered(error.render(style()).trim_end());
    Ok(())
}

/// What is to be said of a program that could be compiled, if nothing is known of its images.
pub(super) fn without_images(program: &Program) -> Vec<Diagnostic> {
    doubts(program, &Known::Usual)
}

/// What is to be said of a program that could be compiled.
fn doubts(program: &Program, known: &Known) -> Vec<Diagnostic> {
    let mut diagnostics = inputs(program, known);
    diagnostics.extend(misspelt_outputs(program));
    diagnostics
}

/// Variables that are assigned and never read, and look like one that is written (`colour`) or are it in another language
/// (`fragColor`).
pub(super) fn misspelt_outputs(program: &Program) -> Vec<Diagnostic> {
    let globals = program.resolved().globals.iter().filter(|g| !g.library && g.read.is_none());
    let gives = |name: &str| program.assigned().any(|assigned| assigned == name);
    globals
        .filter_map(|global| {
            let name = global.name.as_str();
            let written = ["color", "alpha", "normal"];
            if written.contains(&name) {
                return None;
            }
            let foreign = vocabulary::output(name).filter(|output| !gives(output));
            let near = foreign.or_else(|| names::nearest(name, written))?;
            let message = format!("`{name}` is assigned and never read");
            let warning = Diagnostic::error("name", message, global.assigned?).warning();
            Some(warning.hint(match foreign {
                Some(output) => format!(
                    "The output is called `{output}` here. To write `{name}` itself, add `--vars \
                    {name}`."
                ),
                None => format!("Did you mean `{near}`? If not, `--vars {name}` writes it."),
            }))
        })
        .take(MAX_ERRORS)
        .collect()
}

/// Why a program does not know the camera of its inputs; `None` if it does, or does not read it.
fn no_camera(program: &Program, inputs: &Inputs) -> Option<String> {
    let metadata = inputs.list.first().map(|opened| opened.file.metadata().clone()).unwrap_or_default();
    let request = CameraRequest {
        program,
        view: Some(&ViewArgs::default()),
        inputs,
        about: &Image { metadata, ..Image::default() },
        variables: &inputs.variables(),
        set: &[],
        spaces: &[],
    };
    match request.find() {
        Ok(camera) => camera.hint().map(String::from),
        Err(failure) => Some(failure.message()),
    }
}

/// What is to be said of the names that a program reads and does not assign, of the first of them.
fn inputs(program: &Program, known: &Known) -> Vec<Diagnostic> {
    // Why the camera is not known, if it is not.
    let camera = match known {
        Known::Images { first: None, inputs } => no_camera(program, inputs),
        _ => None,
    };
    let program = program.resolved();
    let doubt = |(name, span)| match name {
        // `--space` may define it for the run.
        "eye" => camera.as_deref().map(|why| no_eye(span, Some(why)).warning()),
        // It is made of the points and the eye.
        "I" if camera.is_none() && known.has("point") => None,
        _ => known.doubt(program, name, span, camera.as_deref()),
    };
    unknown::unassigned(program).filter_map(doubt).take(MAX_ERRORS).collect()
}
