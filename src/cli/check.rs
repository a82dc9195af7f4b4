//! `pse check`: what is wrong with programs, without running them.

use super::camera::CameraRequest;
use super::failure::{Failure, style, warn};
use super::input::{InputArg, Inputs, MapArg};
use super::scene::ViewArgs;
use super::source;
use crate::diagnostic::{Diagnostic, Severity};
use crate::eval::no_eye;
use crate::image::Image;
use crate::program::{Error, Program};
use crate::resolve::{is_standard_function, names, no_variable};
use crate::scene::{self, Options};
use clap::Args;
use std::path::PathBuf;

/// Which programs, and what they are to fit.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pse check *.pse\n  pse check marble.pse -i gbuffer.exr\n  \
                        pse check bubble.pse --scene bubble\n\n\
                        Without an image the usual variables of G-buffers (point, normal, surface, …) are taken \
                        for granted.")]
pub(super) struct CheckArgs {
    /// The programs; - is standard input
    #[arg(required = true, value_name = "PROGRAM")]
    programs: Vec<PathBuf>,
    /// The images whose variables they may read
    #[arg(short, long, value_name = "FILE|NAME=FILE", conflicts_with = "scene")]
    input: Vec<InputArg>,
    /// The built-in scene whose variables they may read
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Read a variable from other channels than the names suggest
    #[arg(long, value_name = "NAME=CHANNELS", requires = "input")]
    map: Vec<MapArg>,
    /// Look for imported files and for textures in this folder too
    #[arg(long, value_name = "DIR")]
    path: Vec<PathBuf>,
    /// Say so if all is well
    #[arg(short, long)]
    verbose: bool,
}

/// What the image of a program has.
enum Known {
    /// Nothing is known of it.
    Usual,
    /// Exactly these variables.
    Scene(Vec<String>),
    /// What these files have.
    Files(Inputs),
}

/// Checks each of the programs.
pub(super) fn check(args: &CheckArgs) -> Result<(), Failure> {
    let known = match &args.scene {
        Some(name) => {
            let options = Options { width: 2, height: 2, ..Options::default() };
            let image = scene::render(name, &options)?;
            Known::Scene(image.variables.iter().map(|v| v.name.clone()).collect())
        }
        None if args.input.is_empty() => Known::Usual,
        None => Known::Files(Inputs::open(&args.input, &args.map, false, None)?),
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
    let program = source::compile(&name, &text, folders)?;
    let diagnostics = doubts(&program, known);
    if diagnostics.is_empty() {
        return Ok(());
    }
    let bad = diagnostics.iter().any(|d| d.severity == Severity::Error);
    let error = Error { diagnostics, sources: program.sources().clone(), cancelled: false };
    if bad {
        return Err(error.into());
    }
    warn(error.render(style()).trim_end());
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

/// Variables that are assigned and never read, and look like one that is written: `colour`.
fn misspelt_outputs(program: &Program) -> Vec<Diagnostic> {
    let globals = program.resolved().globals.iter().filter(|g| !g.library && g.read.is_none());
    globals
        .filter_map(|global| {
            let name = global.name.as_str();
            let written = ["color", "alpha", "normal"];
            if written.contains(&name) {
                return None;
            }
            let near = names::nearest(name, written)?;
            let message = format!("`{name}` is assigned and never read");
            let warning = Diagnostic::error("name", message, global.assigned?).warning();
            Some(warning.hint(format!("Did you mean `{near}`? If not, `--vars {name}` writes it.")))
        })
        .collect()
}

/// Is it known that the image has the variable?
fn has(known: &Known, name: &str) -> bool {
    match known {
        Known::Usual => true,
        Known::Scene(has) => has.iter().any(|v| v == name),
        Known::Files(inputs) => matches!(inputs.find(name), Some(Ok(()))),
    }
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

/// What is to be said of the names that a program reads and does not assign.
fn inputs(program: &Program, known: &Known) -> Vec<Diagnostic> {
    let mut list = Vec::new();
    // Why the camera is not known, if it is not.
    let camera = match known {
        Known::Usual | Known::Scene(_) => None,
        Known::Files(inputs) => no_camera(program, inputs),
    };
    for name in program.inputs() {
        let global = program.resolved().globals.iter().find(|g| g.name == name && !g.library);
        let Some(span) = global.and_then(|g| g.read) else { continue };
        match name {
            // A run may be told by `--space`.
            "eye" if camera.is_some() => list.push(no_eye(span, camera.as_deref()).warning()),
            // It is made of the points and the eye.
            "I" if camera.is_none() && has(known, "point") => continue,
            _ => {}
        }
        if names::constant(name).is_some() || names::is_system(name) {
            continue;
        }
        let own = program.assigned().chain(program.resolved().params.iter().map(|p| p.name.as_str()));
        let fixed = names::CONSTANTS.iter().map(|c| c.name).chain(names::SYSTEM.iter().map(|s| s.0));
        let absent = |d: &str| Diagnostic::error("input", d.to_string(), span);
        match known {
            Known::Usual if names::USUAL_INPUTS.contains(&name) || name.contains('.') => {}
            Known::Usual => {
                if is_standard_function(name) {
                    list.push(no_variable(name, span, false));
                    continue;
                }
                let usual = names::USUAL_INPUTS.iter().copied();
                if let Some(near) = names::nearest(name, own.chain(usual)) {
                    let error = Diagnostic::error("name", format!("there is no variable `{name}`"), span);
                    list.push(error.hint(format!("Did you mean `{near}`?")));
                    continue;
                }
                // An image may well have a `flame`, however much it looks like `frame`.
                let warning =
                    Diagnostic::error("name", format!("nothing in the program assigns `{name}`"), span)
                        .hint("It runs on images that have a variable of that name.")
                        .warning();
                list.push(match names::nearest(name, fixed) {
                    Some(near) => warning.hint(format!("Or did you mean `{near}`?")),
                    None => warning,
                });
            }
            Known::Scene(has) if has.iter().any(|v| v == name) => {}
            Known::Scene(has) => {
                let error = absent(&format!("the scene has no variable `{name}`"));
                let near = names::nearest(name, own.chain(fixed).chain(has.iter().map(String::as_str)));
                let error = match near {
                    Some(near) => error.hint(format!("Did you mean `{near}`?")),
                    None => error,
                };
                list.push(error.hint(format!("It has {}.", has.join(", "))));
            }
            Known::Files(inputs) => {
                let (message, hints) = match inputs.find(name) {
                    None => (format!("the input has no variable `{name}`"), inputs.missing(name)),
                    Some(Ok(())) => continue,
                    Some(Err(ambiguous)) => (ambiguous.message, ambiguous.hints),
                };
                let hints = hints.into_iter().chain(camera.clone().filter(|_| name == "I"));
                list.push(hints.fold(absent(&message), Diagnostic::hint));
            }
        }
    }
    list
}
