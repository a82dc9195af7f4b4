//! Where an image's bytes come from: a file, or what standard input held, read to its end first: in memory, or in a
//! temporary file if it is much.

use super::atomic::{KEPT, temporary_folder};
use super::error::{ErrorKind, ImageError};
use super::reading::{Content, record_standard_input, recorded};
use crate::files::{self, Folders};
use crate::quote;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

/// The source of an image. Cheap to clone.
#[derive(Clone, Debug)]
pub enum Input {
    /// A file, opened for each pass over it.
    Path(PathBuf),
    /// A file that a program names: a regular file inside these folders, after following links.
    Confined {
        /// The file.
        path: PathBuf,
        /// Where it may lie.
        folders: Folders,
    },
    /// Bytes in memory.
    Bytes {
        /// The name in messages.
        name: String,
        /// The whole file.
        bytes: Arc<[u8]>,
    },
    /// Bytes in a temporary file without a name.
    Spooled {
        /// The name in messages.
        name: String,
        /// The file, whose position is nobody's own.
        file: Arc<Mutex<File>>,
        /// How many they are.
        length: u64,
    },
}

/// The most bytes of a pipe that are kept in a temporary file.
const MAX_SPOOLED: u64 = 32 << 30;

/// What tells a file from another one that has taken its place, or has been written to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stamp {
    length: u64,
    modified: Option<SystemTime>,
    #[cfg(unix)]
    inode: (u64, u64),
}

/// A reader that can go back.
pub(crate) trait ReadSeek: Read + Seek + Send {}
impl<T: Read + Seek + Send> ReadSeek for T {}

impl Input {
    /// Creates the input for a path, or for standard input with `-`.
    ///
    /// # Errors
    /// If standard input cannot be read.
    pub fn from_argument(argument: &Path) -> Result<Input, ImageError> {
        match argument.as_os_str() == "-" {
            true => {
                record_standard_input(Content::Data);
                Input::from_reader("standard input", io::stdin().lock())
            }
            false => Ok(Input::Path(argument.to_path_buf())),
        }
    }

    /// Reads `reader` to its end.
    ///
    /// # Errors
    /// If reading fails, or there is no end: what is longer than 64 MB has to begin as an image does, and 32 GB are the
    /// limit.
    pub fn from_reader(name: &str, reader: impl Read) -> Result<Input, ImageError> {
        Input::spooled(name, reader, KEPT, MAX_SPOOLED)
    }

    /// The same, with so many bytes in memory, and so many altogether.
    fn spooled(name: &str, mut reader: impl Read, kept: usize, limit: u64) -> Result<Input, ImageError> {
        let read = |e: io::Error| ImageError::io("read", name, &e);
        let mut bytes = Vec::new();
        reader.by_ref().take(kept as u64).read_to_end(&mut bytes).map_err(read)?;
        if bytes.len() < kept {
            return Ok(Input::Bytes { name: name.to_string(), bytes: bytes.into() });
        }
        if !begins_as_image(name, &bytes) {
            let message = format!("`{name}` is not an image in a format that pse reads");
            return Err(ImageError::new(ErrorKind::UnknownFormat, message));
        }
        let keep = |e: io::Error| {
            ImageError::io("write", "a temporary file for standard input", &e)
                .hint("Set another folder with `TMPDIR`.")
        };
        let mut file = tempfile::tempfile_in(temporary_folder()).map_err(keep)?;
        let mut length = 0;
        while !bytes.is_empty() {
            file.write_all(&bytes).map_err(keep)?;
            length += bytes.len() as u64;
            if length > limit {
                let message =
                    format!("`{name}` is too long: at most {} MB are read from a pipe", limit >> 20);
                return Err(ImageError::new(ErrorKind::TooLarge, message)
                    .hint("Write it to a file, and give the file with -i."));
            }
            bytes.clear();
            reader.by_ref().take(1 << 20).read_to_end(&mut bytes).map_err(read)?;
        }
        Ok(Input::Spooled { name: name.to_string(), file: Arc::new(Mutex::new(file)), length })
    }

    /// Creates an input from bytes in memory.
    pub fn from_bytes(name: &str, bytes: impl Into<Arc<[u8]>>) -> Input {
        Input::Bytes { name: name.to_string(), bytes: bytes.into() }
    }

    /// The name in messages.
    pub fn name(&self) -> String {
        match self {
            Input::Path(path) | Input::Confined { path, .. } => path.display().to_string(),
            Input::Bytes { name, .. } | Input::Spooled { name, .. } => name.clone(),
        }
    }

    /// The path, if the input is a file.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Input::Path(path) | Input::Confined { path, .. } => Some(path),
            Input::Bytes { .. } | Input::Spooled { .. } => None,
        }
    }

    /// Another file in the place of this one, such as another frame of a sequence.
    pub(crate) fn with_path(&self, path: PathBuf) -> Input {
        match self {
            Input::Confined { folders, .. } => Input::Confined { path, folders: folders.clone() },
            _ => Input::Path(path),
        }
    }

    /// Whether both are the same bytes in memory.
    pub(crate) fn same_bytes(&self, other: &Input) -> bool {
        match (self, other) {
            (Input::Bytes { bytes: a, .. }, Input::Bytes { bytes: b, .. }) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }

    #[cfg(feature = "raster")]
    /// The extension in lower case; empty if there is none.
    pub(crate) fn extension(&self) -> String {
        let name = self.name();
        Path::new(&name).extension().map_or(String::new(), |e| e.to_string_lossy().to_lowercase())
    }

    /// The file as it is now; `None` for bytes in memory, and where there is no file.
    pub(crate) fn stamp(&self) -> Option<Stamp> {
        let about = std::fs::metadata(self.path()?).ok()?;
        #[cfg(unix)]
        use std::os::unix::fs::MetadataExt;
        Some(Stamp {
            length: about.len(),
            modified: about.modified().ok(),
            #[cfg(unix)]
            inode: (about.dev(), about.ino()),
        })
    }

    /// A reader from the start, and the number of bytes there.
    pub(crate) fn open(&self) -> Result<(Box<dyn ReadSeek>, u64), ImageError> {
        match self {
            Input::Bytes { bytes, .. } => Ok((Box::new(Cursor::new(Arc::clone(bytes))), bytes.len() as u64)),
            Input::Spooled { file, length, .. } => {
                let spool = Spool { file: Arc::clone(file), at: 0, length: *length };
                Ok((Box::new(BufReader::with_capacity(1 << 17, spool)), *length))
            }
            Input::Path(path) | Input::Confined { path, .. } => {
                let fail = |e: io::Error| {
                    let error = ImageError::io("read", &self.name(), &e);
                    match files::outside(&e) {
                        Some(folder) => {
                            error.hint(format!("Allow its folder: --path {}", quote::path(folder)))
                        }
                        None => error,
                    }
                };
                let file = match self {
                    Input::Confined { folders, .. } => folders.open(path),
                    _ => files::regular(path),
                };
                let file = recorded(path, Content::Data, file).map_err(fail)?;
                let length = file.metadata().map_err(fail)?.len();
                Ok((Box::new(BufReader::with_capacity(1 << 17, file)), length))
            }
        }
    }

    /// The same input, able to go back: a pipe that the user names is read to its end. A device has none.
    pub fn seekable(self) -> Result<Input, ImageError> {
        if let Input::Path(path) = &self {
            let special = std::fs::metadata(path).is_ok_and(|about| !about.is_file() && !about.is_dir());
            if special {
                let name = self.name();
                let file = recorded(path, Content::Data, files::given(path));
                let file = file.map_err(|e| ImageError::io("read", &name, &e))?;
                return Input::from_reader(&name, file);
            }
        }
        Ok(self)
    }
}

/// Whether these first bytes are those of an image, as far as that can be told: TGA files have no mark there.
fn begins_as_image(name: &str, bytes: &[u8]) -> bool {
    bytes.starts_with(&super::read_exr::MAGIC) || begins_as_raster(name, bytes)
}

/// The same of all formats but OpenEXR.
#[cfg(feature = "raster")]
fn begins_as_raster(name: &str, bytes: &[u8]) -> bool {
    let tga = Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("tga"));
    tga || super::tiff::is_tiff(bytes)
        || super::hdr::is_hdr(&bytes[..bytes.len().min(super::hdr::LONGEST_HEADER as usize)])
        || ::image::guess_format(bytes).is_ok()
}

#[cfg(not(feature = "raster"))]
fn begins_as_raster(_: &str, _: &[u8]) -> bool {
    false
}

/// A reader of a temporary file that others read too.
struct Spool {
    file: Arc<Mutex<File>>,
    at: u64,
    length: u64,
}

impl Read for Spool {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(self.at))?;
        let count = file.read(bytes)?;
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for Spool {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
            SeekFrom::End(by) => self.length.checked_add_signed(by),
        };
        self.at = at.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn much_goes_into_a_temporary_file() {
        let length = KEPT as u64 + (3 << 20) + 7;
        let bytes = |at: u64| (at.wrapping_mul(0x9e37_79b9) >> 24) as u8;
        let mut block: Vec<u8> = (0..1 << 16).map(bytes).collect();
        block[..4].copy_from_slice(&super::super::read_exr::MAGIC);
        let endless = block.iter().cycle().copied().take(length as usize);
        let input = Input::from_reader("a", Feed(endless)).unwrap();
        assert!(matches!(input, Input::Spooled { .. }));
        let (mut reader, found) = input.open().unwrap();
        let (mut other, _) = input.open().unwrap();
        assert_eq!(found, length);
        for at in [0, 5, KEPT as u64 - 3, length - 4] {
            let mut four = [0; 4];
            for reader in [&mut reader, &mut other] {
                reader.seek(SeekFrom::Start(at)).unwrap();
                reader.read_exact(&mut four).unwrap();
                assert_eq!(four, [0, 1, 2, 3].map(|i| block[(at + i) as usize % block.len()]), "{at}");
            }
        }
        assert_eq!(reader.read(&mut [0; 9]).unwrap(), 0, "the end");
        assert!(reader.seek(SeekFrom::Current(-1 - length as i64)).is_err());
    }

    #[test]
    fn pipes_without_an_end_are_refused() {
        let error = Input::spooled("a", io::repeat(0), 1 << 10, 1 << 20).unwrap_err();
        assert_eq!(error.kind, ErrorKind::UnknownFormat);
        let exr = || Cursor::new(super::super::read_exr::MAGIC).chain(io::repeat(0));
        let error = Input::spooled("a", exr(), 1 << 10, 1 << 20).unwrap_err();
        assert_eq!(error.message, "`a` is too long: at most 1 MB are read from a pipe");
        let length = (1 << 20) - 5;
        assert!(matches!(
            Input::spooled("a", exr().take(length), 1 << 10, 1 << 20),
            Ok(Input::Spooled { .. })
        ));
    }

    /// Bytes as they come out of a pipe.
    struct Feed<I>(I);

    impl<I: Iterator<Item = u8>> Read for Feed<I> {
        fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
            let most = bytes.len().min(1 << 16);
            Ok(bytes[..most].iter_mut().zip(&mut self.0).map(|(to, from)| *to = from).count())
        }
    }
}
