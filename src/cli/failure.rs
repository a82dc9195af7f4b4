//! How a command fails: what it says, and with which exit status.

use pse::image::ImageError;
use pse::internal::diagnostic::{Diagnostic, Sources, Style};
use pse::internal::program::Error;
use pse::internal::visible::{visible, visible_json, visible_sentence};
use pse::scene::SceneError;
use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

/// The exit status of a command that was interrupted, as shells have it.
pub(super) const INTERRUPTED: u8 = 130;

/// Why a command did not do what was asked.
#[derive(Debug)]
pub(super) enum Failure {
    /// A program is wrong, or went wrong.
    Program(Box<Error>),
    /// A file or the like is wrong.
    Plain(Box<Diagnostic>),
    /// The arguments contradict each other, in a way that clap cannot see.
    Usage(Box<Diagnostic>),
    /// The user wanted no more of it.
    Interrupted,
    /// All is said already.
    Said,
    /// Nobody reads standard output any more, which is no fault.
    BrokenPipe,
}

impl Failure {
    /// A fault of a file or of the surroundings.
    pub fn plain(message: impl Into<String>) -> Failure {
        Failure::Plain(Box::new(Diagnostic::bare("file", message)))
    }

    /// A fault of the arguments.
    pub fn usage(message: impl Into<String>) -> Failure {
        Failure::Usage(Box::new(Diagnostic::bare("usage", message)))
    }

    /// Adds a way to mend it.
    pub fn hint(mut self, text: impl Into<String>) -> Failure {
        if let Failure::Plain(diagnostic) | Failure::Usage(diagnostic) = &mut self {
            diagnostic.hints.push(text.into());
        }
        self
    }

    /// Adds a fact about what was worked on, behind the remedies.
    pub fn context(mut self, text: String) -> Failure {
        match &mut self {
            Failure::Plain(diagnostic) | Failure::Usage(diagnostic) => diagnostic.hints.push(text),
            Failure::Program(error) => {
                error
                    .diagnostics
                    .last_mut()
                    .iter_mut()
                    .for_each(|diagnostic| diagnostic.hints.push(text.clone()));
            }
            Failure::Interrupted | Failure::Said | Failure::BrokenPipe => {}
        }
        self
    }

    /// Adds a way to mend the first fault of a program.
    pub fn hint_program(mut self, text: impl Into<String>) -> Failure {
        if let Failure::Program(error) = &mut self
            && let Some(first) = error.diagnostics.first_mut()
        {
            first.hints = vec![text.into()];
        }
        self
    }

    /// Is it the fault of what is worked on, so that it may go better with the next frame?
    pub fn is_of_frame(&self) -> bool {
        matches!(self, Failure::Program(_) | Failure::Plain(_))
    }

    /// What it says, without colours.
    pub fn message(&self) -> String {
        let text = match self {
            Failure::Program(error) => error.render(Style::PLAIN),
            Failure::Plain(diagnostic) | Failure::Usage(diagnostic) => {
                diagnostic.render(&Sources::default(), Style::PLAIN)
            }
            Failure::Interrupted => "interrupted".into(),
            Failure::Said | Failure::BrokenPipe => String::new(),
        };
        text.trim_end().to_string()
    }

    /// Says it on standard error.
    pub fn report(self) -> ExitCode {
        match self {
            Failure::Interrupted => {
                warn("interrupted; the unfinished output was not written");
                return ExitCode::from(INTERRUPTED);
            }
            Failure::Program(error) => warn_rendered(error.render(style()).trim_end()),
            Failure::Plain(diagnostic) => show(&diagnostic),
            Failure::Usage(diagnostic) => {
                show(&diagnostic);
                return ExitCode::from(2);
            }
            Failure::Said => {}
            Failure::BrokenPipe => return ExitCode::SUCCESS,
        }
        ExitCode::FAILURE
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        if error.cancelled { Failure::Interrupted } else { Failure::Program(Box::new(error)) }
    }
}

impl From<ImageError> for Failure {
    fn from(error: ImageError) -> Failure {
        match error.is_broken_pipe() {
            true => Failure::BrokenPipe,
            false => Failure::Plain(Box::new(error.into())),
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Failure {
        Failure::Plain(Box::new(error.diagnostic()))
    }
}

/// How messages look on this standard error.
pub(super) fn style() -> Style {
    let wanted = std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    let terminal = io::stderr().is_terminal();
    let columns = std::env::var("COLUMNS").ok().and_then(|c| c.parse().ok());
    let width = columns.filter(|_| terminal).unwrap_or(Style::PLAIN.width);
    Style { color: terminal && wanted, width: width.clamp(40, 120) }
}

/// A message without a place in a program.
pub(super) fn show(diagnostic: &Diagnostic) {
    warn_rendered(diagnostic.render(&Sources::default(), style()).trim_end());
}

/// A line on standard error, whose hidden characters are shown. If that is closed there is nobody to tell.
pub(super) fn warn(line: &str) {
    warn_rendered(&visible_sentence(line));
}

/// The same for rendered messages, in which the only hidden characters are those of colours.
pub(super) fn warn_rendered(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// A text for people on standard output, whose hidden characters are shown.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    print_rendered(&visible(text))
}

/// JSON on standard output, with escapes for what is hidden in its strings.
pub(super) fn print_json(text: &str) -> Result<(), Failure> {
    print_rendered(&visible_json(text))
}

/// A text for programs on standard output: as it is, unless that is a terminal.
pub(super) fn print_exact(text: &str) -> Result<(), Failure> {
    if io::stdout().is_terminal() { print(text) } else { print_rendered(text) }
}

/// A text on standard output in which the only hidden characters are those of colours.
pub(super) fn print_rendered(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|e| match e.kind() {
        io::ErrorKind::BrokenPipe => Failure::BrokenPipe,
        _ => Failure::plain(format!("cannot write standard output: {e}")),
    })
}

/// Why the operating system refused, in few words.
pub(super) fn why(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::IsADirectory => "it is a directory".into(),
        io::ErrorKind::InvalidData => "it is not UTF-8 text".into(),
        _ => error.to_string(),
    }
}
