//! Files that appear whole or not at all.

use super::error::{ErrorKind, ImageError};
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes `bytes` as the file `path`: to a temporary file beside it, which then takes its name.
///
/// Whoever looks sees the old file or the whole new one; after an error, or a kill, the old one is
/// untouched. A symbolic link keeps pointing where it does; a device or a pipe is written in place.
///
/// # Errors
/// If the directory does not exist, or the operating system refuses.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    let shown = path.display().to_string();
    let fail = |e: io::Error| ImageError::io("write", &shown, &e);
    let existing = fs::metadata(path).ok();
    if existing.as_ref().is_some_and(|about| about.is_dir()) {
        return Err(fail(io::ErrorKind::IsADirectory.into()));
    }
    if existing.as_ref().is_some_and(|about| !about.is_file()) {
        return fs::OpenOptions::new()
            .write(true)
            .open(path)
            .and_then(|mut f| f.write_all(bytes))
            .map_err(fail);
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
    if !directory.is_dir() {
        let message = format!("cannot write `{shown}`: there is no directory `{}`", directory.display());
        return Err(ImageError::new(ErrorKind::Io(io::ErrorKind::NotFound), message)
            .hint(format!("Make it first: mkdir -p '{}'.", directory.display())));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pse-").suffix(".tmp");
    // A temporary file is private by default; a picture is as open as any new file of the user.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.tempfile_in(directory).map_err(fail)?;
    let mut buffered = BufWriter::new(file);
    buffered.write_all(bytes).map_err(fail)?;
    let file = buffered.into_inner().map_err(|e| fail(e.into_error()))?;
    if let Some(about) = existing {
        // Where the permissions can't be kept, those of a new file do.
        let _ = file.as_file().set_permissions(about.permissions());
    }
    file.persist(&target).map_err(|e| fail(e.error))?;
    Ok(())
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
