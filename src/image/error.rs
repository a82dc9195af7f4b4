//! What goes wrong with images: facts, a sentence, and how to mend it.

use crate::diagnostic::Diagnostic;
use std::fmt;

/// The kinds of fault, for programs to match on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The operating system could not open, read or write the file.
    Io(std::io::ErrorKind),
    /// The content has an unknown format, or the extension is that of an unknown format.
    UnknownFormat,
    /// The file is cut short or damaged.
    Damaged,
    /// The file changed while it was read.
    Changed,
    /// The file is legal but uses something that is not supported: deep data, subsampled channels, …
    Unsupported,
    /// The file's header claims more pixels than the file can hold, or than fit in memory.
    TooLarge,
    /// The file has no such variable or channel.
    Missing,
    /// Several groups of channels could be the variable.
    Ambiguous,
    /// An invalid `--map`.
    Mapping,
    /// The image cannot be written with these options.
    Unwritable,
}

/// An image could not be read, bound or written.
///
/// The message is one sentence that names the file; the hints are remedies.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageError {
    /// The kind of fault.
    pub kind: ErrorKind,
    /// The fact, in one sentence without a full stop that names the file.
    pub message: String,
    /// The remedies; each is a sentence.
    pub hints: Vec<String>,
}

impl ImageError {
    /// Creates an error without hints.
    pub fn new(kind: ErrorKind, message: impl Into<String>) -> ImageError {
        ImageError { kind, message: message.into(), hints: Vec::new() }
    }

    /// Adds a remedy.
    pub fn hint(mut self, text: impl Into<String>) -> ImageError {
        self.hints.push(text.into());
        self
    }

    /// The operating system refused: `doing` is "read", "write", ….
    pub(crate) fn io(doing: &str, file: &str, error: &std::io::Error) -> ImageError {
        if error.kind() == std::io::ErrorKind::UnexpectedEof {
            return ImageError::damaged(file, "it ends too early");
        }
        let why = match error.kind() {
            std::io::ErrorKind::NotFound => "there is no such file".into(),
            std::io::ErrorKind::PermissionDenied => "permission denied".into(),
            std::io::ErrorKind::IsADirectory => "it is a directory".into(),
            std::io::ErrorKind::StorageFull => "the disk is full".into(),
            std::io::ErrorKind::QuotaExceeded => "the disk quota is exceeded".into(),
            std::io::ErrorKind::FileTooLarge => "it would exceed the file size limit".into(),
            std::io::ErrorKind::ReadOnlyFilesystem => "the disk is read-only".into(),
            _ => error.to_string(),
        };
        ImageError::new(ErrorKind::Io(error.kind()), format!("cannot {doing} `{file}`: {why}"))
    }

    /// The file is cut short or broken.
    pub(crate) fn damaged(file: &str, why: impl fmt::Display) -> ImageError {
        ImageError::new(ErrorKind::Damaged, format!("`{file}` is damaged or incomplete: {why}"))
    }

    /// Whether writing stopped because the reader closed the pipe, which is not a failure.
    pub fn is_broken_pipe(&self) -> bool {
        self.kind == ErrorKind::Io(std::io::ErrorKind::BrokenPipe)
    }
}

/// The message alone; the hints are for whoever renders it.
impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for ImageError {}

impl From<ImageError> for Diagnostic {
    fn from(error: ImageError) -> Diagnostic {
        let mut diagnostic = Diagnostic::bare("image", error.message);
        diagnostic.hints = error.hints;
        diagnostic
    }
}
