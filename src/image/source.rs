//! Where an image's bytes come from: a file, or bytes in memory (standard input is read to its end first).

use super::error::ImageError;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where to read an image from. Cheap to clone.
#[derive(Clone, Debug)]
pub enum Input {
    /// A file, opened anew for each pass over it.
    Path(PathBuf),
    /// Bytes in memory.
    Bytes {
        /// What messages call it.
        name: String,
        /// The whole file.
        bytes: Arc<[u8]>,
    },
}

/// A reader that can go back.
pub(crate) trait ReadSeek: Read + Seek + Send {}
impl<T: Read + Seek + Send> ReadSeek for T {}

impl Input {
    /// A path, or standard input for `-`.
    ///
    /// # Errors
    /// If standard input cannot be read.
    pub fn from_argument(argument: &Path) -> Result<Input, ImageError> {
        match argument.as_os_str() == "-" {
            true => Input::from_reader("standard input", io::stdin().lock()),
            false => Ok(Input::Path(argument.to_path_buf())),
        }
    }

    /// All that `reader` gives until its end.
    ///
    /// # Errors
    /// If reading fails.
    pub fn from_reader(name: &str, mut reader: impl Read) -> Result<Input, ImageError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).map_err(|e| ImageError::io("read", name, &e))?;
        Ok(Input::Bytes { name: name.to_string(), bytes: bytes.into() })
    }

    /// Bytes that are already in memory.
    pub fn from_bytes(name: &str, bytes: impl Into<Arc<[u8]>>) -> Input {
        Input::Bytes { name: name.to_string(), bytes: bytes.into() }
    }

    /// What messages call it.
    pub fn name(&self) -> String {
        match self {
            Input::Path(path) => path.display().to_string(),
            Input::Bytes { name, .. } => name.clone(),
        }
    }

    /// The extension in lower case; empty if there is none.
    pub(crate) fn extension(&self) -> String {
        let name = self.name();
        Path::new(&name).extension().map_or(String::new(), |e| e.to_string_lossy().to_lowercase())
    }

    /// A reader from the start, and the number of bytes there.
    pub(crate) fn open(&self) -> Result<(Box<dyn ReadSeek>, u64), ImageError> {
        match self {
            Input::Bytes { bytes, .. } => Ok((Box::new(Cursor::new(Arc::clone(bytes))), bytes.len() as u64)),
            Input::Path(path) => {
                let fail = |e: io::Error| ImageError::io("read", &self.name(), &e);
                let file = File::open(path).map_err(fail)?;
                let about = file.metadata().map_err(fail)?;
                if about.is_dir() {
                    return Err(fail(io::ErrorKind::IsADirectory.into()));
                }
                Ok((Box::new(BufReader::with_capacity(1 << 17, file)), about.len()))
            }
        }
    }

    /// The same input, able to go back: a pipe or a device is read into memory.
    pub(crate) fn seekable(self) -> Result<Input, ImageError> {
        if let Input::Path(path) = &self {
            let special = std::fs::metadata(path).is_ok_and(|about| !about.is_file() && !about.is_dir());
            if special {
                let name = self.name();
                let file = File::open(path).map_err(|e| ImageError::io("read", &name, &e))?;
                return Input::from_reader(&name, file);
            }
        }
        Ok(self)
    }
}
