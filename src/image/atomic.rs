//! Files that appear whole or not at all.

use super::error::{ErrorKind, ImageError};
use std::fs;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, SpooledTempFile};

/// A file in the making. It takes its name when it is finished; until then whoever looks sees the old file, and after
/// an error, or a kill, the old one is untouched. A symbolic link keeps pointing where it does. A device or a pipe, and
/// `-`, standard output, gets everything at the end.
pub struct NewFile {
    shown: String,
    place: Place,
}

enum Place {
    /// Beside the file whose name it will take; that file's permissions, if it exists.
    Beside { file: NamedTempFile, target: PathBuf, permissions: Option<fs::Permissions> },
    /// Kept until the end, in memory or in a temporary file if it is large.
    Kept { bytes: SpooledTempFile, target: PathBuf },
}

/// Bytes that are kept in memory before they go to a temporary file.
pub(super) const KEPT: usize = 64 << 20;

/// Where temporary files go that may be large: where the user says, else where they do not take up memory.
pub(crate) fn temporary_folder() -> PathBuf {
    let lasting = Path::new("/var/tmp");
    match std::env::var_os("TMPDIR") {
        None if lasting.is_dir() => lasting.to_path_buf(),
        _ => std::env::temp_dir(),
    }
}

/// Finds out whether a file can take this name, as far as that can be told beforehand. A file that may not be changed
/// is not replaced by another one either.
///
/// # Errors
/// If it cannot.
pub fn check_target(path: &Path) -> Result<(), ImageError> {
    let shown = path.display();
    let about = fs::metadata(path).ok();
    if about.as_ref().is_some_and(|about| about.is_dir()) {
        return Err(ImageError::io("write", &shown.to_string(), &io::ErrorKind::IsADirectory.into()));
    }
    if about.is_some_and(|about| about.is_file() && about.permissions().readonly()) {
        let message = format!("cannot write `{shown}`: the file is there and may not be changed");
        return Err(ImageError::new(ErrorKind::Io(io::ErrorKind::PermissionDenied), message)
            .hint("Allow it (chmod u+w), or write to another file."));
    }
    if let Some(folder) = path.parent().filter(|p| !p.as_os_str().is_empty() && !p.is_dir()) {
        let folder = folder.display();
        let message = format!("cannot write `{shown}`: there is no directory `{folder}`");
        return Err(ImageError::new(ErrorKind::Io(io::ErrorKind::NotFound), message)
            .hint(format!("Make it first: mkdir -p '{folder}'.")));
    }
    Ok(())
}

impl NewFile {
    /// Begins the file `path`.
    ///
    /// # Errors
    /// If the directory does not exist, or the operating system refuses.
    pub fn create(path: &Path) -> Result<NewFile, ImageError> {
        let standard_output = path.as_os_str() == "-";
        let shown = match standard_output {
            true => "standard output".to_string(),
            false => path.display().to_string(),
        };
        let fail = |e: io::Error| ImageError::io("write", &shown, &e);
        if !standard_output {
            check_target(path)?;
        }
        let existing = if standard_output { None } else { fs::metadata(path).ok() };
        if standard_output || existing.as_ref().is_some_and(|about| !about.is_file()) {
            let place = Place::Kept {
                bytes: SpooledTempFile::new_in(KEPT, temporary_folder()),
                target: path.to_path_buf(),
            };
            return Ok(NewFile { shown, place });
        }
        let target: PathBuf = match fs::symlink_metadata(path) {
            Ok(about) if about.file_type().is_symlink() && existing.is_some() => {
                fs::canonicalize(path).map_err(fail)?
            }
            _ => path.to_path_buf(),
        };
        let directory = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".pse-").suffix(".tmp");
        // A temporary file is private by default; a picture is as open as any new file of the user.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = builder.tempfile_in(directory).map_err(fail)?;
        let permissions = existing.map(|about| about.permissions());
        Ok(NewFile { shown, place: Place::Beside { file, target, permissions } })
    }

    /// What messages call it.
    pub fn name(&self) -> &str {
        &self.shown
    }

    /// The file is whole: it appears.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn finish(self) -> Result<(), ImageError> {
        let fail = |e: io::Error| ImageError::io("write", &self.shown, &e);
        match self.place {
            Place::Beside { file, target, permissions } => {
                if let Some(permissions) = permissions {
                    // Where the permissions can't be kept, those of a new file do.
                    let _ = file.as_file().set_permissions(permissions);
                }
                file.persist(&target).map_err(|e| fail(e.error))?;
            }
            Place::Kept { mut bytes, target } => {
                bytes.rewind().map_err(fail)?;
                if target.as_os_str() == "-" {
                    let mut out = io::stdout().lock();
                    io::copy(&mut bytes, &mut out).and_then(|_| out.flush()).map_err(fail)?;
                } else {
                    let file = fs::OpenOptions::new().write(true).open(&target);
                    file.and_then(|mut file| io::copy(&mut bytes, &mut file)).map_err(fail)?;
                }
            }
        }
        Ok(())
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.place {
            Place::Beside { file, .. } => file.write(bytes),
            Place::Kept { bytes: kept, .. } => kept.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.place {
            Place::Beside { file, .. } => file.flush(),
            Place::Kept { bytes, .. } => bytes.flush(),
        }
    }
}

impl Seek for NewFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match &mut self.place {
            Place::Beside { file, .. } => file.seek(to),
            Place::Kept { bytes, .. } => bytes.seek(to),
        }
    }
}

/// Writes `bytes` as the file `path`, which appears whole or not at all; see [`NewFile`].
///
/// # Errors
/// If the directory does not exist, or the operating system refuses.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    let mut file = NewFile::create(path)?;
    file.write_all(bytes).map_err(|e| ImageError::io("write", file.name(), &e))?;
    file.finish()
}

/// Do both paths lead to the same existing file (through links, relative paths, `..`)?
pub fn same_file(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    if let (Ok(a), Ok(b)) = (fs::metadata(a), fs::metadata(b)) {
        use std::os::unix::fs::MetadataExt;
        return (a.dev(), a.ino()) == (b.dev(), b.ino());
    }
    matches!((fs::canonicalize(a), fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.bin");
        write_file(&path, b"one").unwrap();
        write_file(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "no temporary file stays");
    }

    #[test]
    fn a_failure_leaves_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let error = write_file(&dir.path().join("no/such/a.bin"), b"x").unwrap_err();
        assert!(error.message.contains("there is no directory"), "{error}");
        let error = write_file(dir.path(), b"x").unwrap_err();
        assert!(error.message.contains("directory"), "{error}");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn permissions_and_links() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.bin");
        let plain = dir.path().join("plain");
        fs::write(&plain, b"").unwrap();
        write_file(&path, b"one").unwrap();
        let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&path), mode(&plain), "the user's umask decides");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        let link = dir.path().join("link");
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write_file(&link, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(mode(&path), 0o640, "a file keeps its permissions");
        assert!(same_file(&path, &link));
        assert!(!same_file(&path, &plain));
        assert!(!same_file(&path, &dir.path().join("none")));
    }
}
