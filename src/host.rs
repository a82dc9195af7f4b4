//! Where imported programs and textures come from: the disk for the command, memory for tests and embedders.

#[cfg(feature = "exr")]
mod disk;

#[cfg(feature = "exr")]
pub use disk::{Disk, absolute, clean, read_text};

use crate::texture::Origin;
use std::collections::HashMap;
use std::fmt;

/// Why a host cannot give what a program asks for: a sentence without a full stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HostError {
    message: String,
}

impl HostError {
    /// The error with this sentence.
    pub fn new(message: impl Into<String>) -> HostError {
        HostError { message: message.into() }
    }

    /// The sentence.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl fmt::Display for HostError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for HostError {}

impl From<String> for HostError {
    fn from(message: String) -> HostError {
        HostError { message }
    }
}

impl From<&str> for HostError {
    fn from(message: &str) -> HostError {
        HostError { message: message.into() }
    }
}

/// Finds the files that `import` names, and the images that `texture` and `environment` name.
///
/// ```
/// use pse::Origin;
/// use pse::{Compiler, Host, HostError, Image, RunOptions, Shape, Variable};
/// use std::sync::Arc;
///
/// /// One image in memory.
/// struct Ramp(Arc<Image<'static>>);
///
/// impl Host for Ramp {
///     fn import(&self, _: &str, _: &str) -> Result<(String, String), HostError> {
///         Err("this program cannot import files".into())
///     }
///
///     fn image(&self, _: &str, name: &str) -> Result<Origin, HostError> {
///         if name == "ramp" { Ok(Origin::Image(self.0.clone())) } else { Err("there is only `ramp`".into()) }
///     }
/// }
///
/// let grey = Variable::new("grey", Shape::Scalar, [vec![0.0, 1.0]])?;
/// let host = Ramp(Arc::new(Image::new(2, 1, [grey])?));
/// let program = Compiler::new().host(&host).compile("program", "a = texture(\"ramp\", 0.5, 0.5)")?;
/// let values = program.eval_pixel(&[], &RunOptions::default())?;
/// assert_eq!(values, [("a".to_string(), 0.5.into())]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Host: Send + Sync {
    /// Returns the text of the file that `path` names in a program called `importing`, and its name in messages.
    /// `Err` is a sentence that says where the file was searched.
    fn import(&self, importing: &str, path: &str) -> Result<(String, String), HostError>;

    /// A sentence that says where imports are searched, as a hint for a missing one.
    fn hint(&self) -> Option<String> {
        None
    }

    /// Returns the image that `name` means in a program called `program`. `Err` is a sentence that says where the
    /// image was searched.
    fn image(&self, program: &str, name: &str) -> Result<Origin, HostError> {
        let _ = (program, name);
        Err("this program cannot read images".into())
    }

    /// Names of images that the program could read instead of `name`, as suggestions for a misspelt one.
    fn images(&self, program: &str, name: &str) -> Vec<String> {
        let _ = (program, name);
        Vec::new()
    }

    /// A sentence that says where images are searched, as a hint for a missing one.
    fn image_hint(&self) -> Option<String> {
        None
    }
}

/// A host without files: every import is an error.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Host for NoFiles {
    fn import(&self, _: &str, _: &str) -> Result<(String, String), HostError> {
        Err("this program cannot import files".into())
    }
}

/// Files in memory, by name.
#[derive(Clone, Debug, Default)]
pub struct Memory(pub HashMap<String, String>);

impl Host for Memory {
    fn import(&self, _: &str, path: &str) -> Result<(String, String), HostError> {
        match self.0.get(path) {
            Some(text) => Ok((path.to_string(), text.clone())),
            None => Err("there is no file with this name".into()),
        }
    }

    fn hint(&self) -> Option<String> {
        let mut names: Vec<&str> = self.0.keys().map(String::as_str).collect();
        names.sort_unstable();
        (!names.is_empty()).then(|| format!("The files are {}.", names.join(", ")))
    }
}
