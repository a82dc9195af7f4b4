//! Where imported programs and textures come from: the disk for the command, memory for tests and embedders.

#[cfg(feature = "exr")]
mod disk;

#[cfg(feature = "exr")]
pub use disk::{Disk, absolute, clean, read_text};

use crate::texture::Origin;
use std::collections::HashMap;

/// Finds the files that `import` names, and the images that `texture` and its like name.
///
/// ```
/// use pse::Origin;
/// use pse::{Compiler, Host, Image, RunOptions, Shape, Variable};
/// use std::sync::Arc;
///
/// /// One image in memory.
/// struct Ramp(Arc<Image<'static>>);
///
/// impl Host for Ramp {
///     fn import(&self, _: &str, _: &str) -> Result<(String, String), String> {
///         Err("this program can import no files".into())
///     }
///
///     fn image(&self, _: &str, name: &str) -> Result<Origin, String> {
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
    /// The text of the file that `path` names in a program called `importing`, and the name under which
    /// messages show it. `Err` says where it was looked for, as a sentence.
    fn import(&self, importing: &str, path: &str) -> Result<(String, String), String>;

    /// Where imports are looked for, as a sentence, for who misses one.
    fn hint(&self) -> Option<String> {
        None
    }

    /// The image that `name` means in a program called `program`. `Err` says where it was looked for, as a
    /// sentence.
    fn image(&self, program: &str, name: &str) -> Result<Origin, String> {
        let _ = (program, name);
        Err("this program can read no images".into())
    }

    /// Names of images that such a program could read instead of `name`, for who has misspelt one.
    fn images(&self, program: &str, name: &str) -> Vec<String> {
        let _ = (program, name);
        Vec::new()
    }

    /// Where images are looked for, as a sentence, for who misses one.
    fn image_hint(&self) -> Option<String> {
        None
    }
}

/// No files: every import is an error.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Host for NoFiles {
    fn import(&self, _: &str, _: &str) -> Result<(String, String), String> {
        Err("this program can import no files".into())
    }
}

/// Files in memory, by name.
#[derive(Clone, Debug, Default)]
pub struct Memory(pub HashMap<String, String>);

impl Host for Memory {
    fn import(&self, _: &str, path: &str) -> Result<(String, String), String> {
        match self.0.get(path) {
            Some(text) => Ok((path.to_string(), text.clone())),
            None => Err("there is no file of that name".into()),
        }
    }

    fn hint(&self) -> Option<String> {
        let mut names: Vec<&str> = self.0.keys().map(String::as_str).collect();
        names.sort_unstable();
        (!names.is_empty()).then(|| format!("The files are {}.", names.join(", ")))
    }
}
