//! What is known of the images that a program is to run on, for messages about variables that they do not have.

use super::input::{ImageArgs, InputArg, Inputs, MapArg};
use super::run::scene;
use pse::internal::diagnostic::{Diagnostic, Span};
use pse::internal::eval::absent;
use pse::internal::resolve::tree::Resolved;
use pse::internal::resolve::{names, unknown};
use std::cell::OnceCell;
use std::sync::Arc;

/// What a program's images have.
pub(super) enum Known {
    /// Nothing is known: the usual variables of G-buffers are taken for granted.
    Usual,
    /// A scene, a mesh or an image in memory, and files beside it.
    Images {
        /// What the first is called, if there is one, and its variables.
        first: Option<(String, Vec<String>)>,
        /// The files.
        inputs: Arc<Inputs>,
    },
}

impl Known {
    /// Opens files.
    pub fn files(input: &[InputArg], map: &[MapArg]) -> Result<Known, super::failure::Failure> {
        Ok(Known::Images { first: None, inputs: Arc::new(Inputs::open(input, map, false, None)?) })
    }

    /// Opens what a run would read in a frame. What cannot be opened will be reported by the run; until then nothing is
    /// known of it.
    fn of_run(images: &ImageArgs, frame: Option<i64>) -> Known {
        let open = || {
            let inputs = Arc::new(Inputs::open(&images.input, &images.map, false, frame)?);
            let first = match scene(images)? {
                Some(seen) => {
                    let renderer = images.view.renderer(&seen, frame, true)?;
                    Some((seen.to_string(), renderer.names().map(String::from).collect()))
                }
                None => None,
            };
            Ok::<Known, super::failure::Failure>(Known::Images { first, inputs })
        };
        open().unwrap_or(Known::Usual)
    }

    /// The variables that can be read without a choice between channels.
    fn variables(&self) -> Vec<String> {
        match self {
            Known::Usual => Vec::new(),
            Known::Images { first, inputs } => {
                let first = first.iter().flat_map(|(_, names)| names.iter().cloned());
                first.chain(inputs.variables()).collect()
            }
        }
    }

    /// As [`Known::doubt`], but the run will find out where the camera is.
    pub fn doubt_before_run(&self, program: &Resolved, name: &str, span: Span) -> Option<Diagnostic> {
        if matches!(name, "eye" | "I") { None } else { self.doubt(program, name, span, None) }
    }

    /// Whether the images have the variable, as far as is known.
    pub fn has(&self, name: &str) -> bool {
        matches!(self, Known::Usual) || self.variables().iter().any(|v| v == name)
    }

    /// What is to be said of a variable that the program reads and does not assign, if anything. `camera`: why it is not
    /// known where the eye is.
    pub fn doubt(
        &self,
        program: &Resolved,
        name: &str,
        span: Span,
        camera: Option<&str>,
    ) -> Option<Diagnostic> {
        let Known::Images { first, inputs } = self else { return unknown::usual(program, name, span) };
        let has = self.variables();
        let found = || match first.iter().any(|(_, names)| names.iter().any(|v| v == name)) {
            true => Some(Ok(())),
            false => inputs.find(name),
        };
        if names::constant(name).is_some() || names::is_system(name) {
            return None;
        }
        match found() {
            Some(Ok(())) => None,
            Some(Err(ambiguous)) => {
                let error = Diagnostic::error("input", ambiguous.message, span);
                Some(ambiguous.hints.into_iter().fold(error, Diagnostic::hint))
            }
            None => {
                let missing = |name: &str| match first {
                    Some((what, names)) if !name.contains('.') => {
                        vec![format!("The {what} has {}.", names.join(", "))]
                    }
                    _ => inputs.missing(name),
                };
                Some(absent(program, name, span, &has, Some(&missing), camera))
            }
        }
    }
}

/// The images of a run, which are opened only if something is to be said of them.
pub(super) struct Lazy<'a> {
    images: &'a ImageArgs,
    frame: Option<i64>,
    known: OnceCell<Known>,
}

impl<'a> Lazy<'a> {
    /// Of these arguments, in a frame.
    pub fn new(images: &'a ImageArgs, frame: Option<i64>) -> Lazy<'a> {
        Lazy { images, frame, known: OnceCell::new() }
    }

    /// As [`Known::doubt`].
    pub fn doubt(&self, program: &Resolved, name: &str, span: Span) -> Option<Diagnostic> {
        let known = self.known.get_or_init(|| match self.images.input.iter().any(|i| i.path == "-") {
            // Standard input can be read but once.
            true => Known::Usual,
            false => Known::of_run(self.images, self.frame),
        });
        known.doubt_before_run(program, name, span)
    }
}
