//! What goes wrong with images: facts, a sentence, and how to mend it.

use crate::diagnostic::Diagnostic;
use std::fmt;

/// The kinds of fault, for embedders to match on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The operating system could not open, read or write the file.
    Io(std::io::ErrorKind),
    /// The content is of no format that is read here, or the extension of none that is written.
    UnknownFormat,
    /// The file is cut short or damaged.
    Damaged,
    /// Somebody has written to the file while it was read.
    Changed,
    /// The file is legal but uses something that is not supported: deep data, subsampled channels, …
    Unsupported,
    /// The file's header claims more pixels than the file can hold, or than fit in memory.
    TooLarge,
    /// The file has no such variable or channel.
    Missing,
    /// Several groups of channels could be the variable.
    Ambiguous,
    /// A `--map` that can't be understood.
    Mapping,
    /// The image can't be written as asked.
    Unwritable,
}

/// An image could not be read, bound or written.
///
/// Its text is one sentence that names the file; the hints tell what to do.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageError {
    /// What kind of fault.
    pub kind: ErrorKind,
    /// One sentence without a full stop: what is wrong, and with which file.
    pub message: String,
    /// How to mend it; each a sentence.
    pub hints: Vec<String>,
}

impl ImageError {
    /// A fault with no hints yet.
    pub fn new(kind: ErrorKind, message: impl Into<String>) -> ImageError {
        ImageError { kind, message: message.into(), hints: Vec::new() }
    }

    /// Adds a way to mend it.
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
            std::io::ErrorKind::QuotaExceeded => "there is no more room for this user".into(),
            std::io::ErrorKind::FileTooLarge => "it would be larger than files may be here".into(),
            std::io::ErrorKind::ReadOnlyFilesystem => "nothing can be changed on that disk".into(),
            _ => error.to_string(),
        };
        ImageError::new(ErrorKind::Io(error.kind()), format!("cannot {doing} `{file}`: {why}"))
    }

    /// The file is cut short or broken.
    pub(crate) fn damaged(file: &str, why: impl fmt::Display) -> ImageError {
        ImageError::new(ErrorKind::Damaged, format!("`{file}` is damaged or incomplete: {why}"))
    }

    /// Did writing stop because nobody reads any more? For a pipe that is no failure.
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
