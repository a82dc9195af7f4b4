//! Files that appear whole or not at all.

use super::error::{ErrorKind, ImageError};
use super::reading::{Content, check_output, check_standard_output, record_output};
use super::unfinished::Unfinished;
use crate::quote;
use std::fs;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, SpooledTempFile};

/// An output file that gets its name when it is finished. Until then, and after an error or a kill, the old file is
/// unchanged. Symbolic links keep their target. A device, a pipe, and `-` (standard output) receive everything at the
/// end.
pub struct NewFile {
    shown: String,
    place: Place,
    /// What it may not replace is asked again when it takes its name.
    content: Content,
}

enum Place {
    /// Beside the file whose name it will take.
    Beside { file: NamedTempFile, target: PathBuf, unfinished: Unfinished },
    /// Kept until the end, in memory or in a temporary file if it is large.
    Kept { bytes: SpooledTempFile, target: PathBuf },
}

/// Bytes that are kept in memory before they go to a temporary file.
pub(super) const KEPT: usize = 64 << 20;

/// The most links from a name to a file, as systems have it.
const MAX_LINKS: usize = 40;

/// Where temporary files go that may be large: where the user says, else where they do not take up memory.
pub(crate) fn temporary_folder() -> PathBuf {
    let lasting = Path::new("/var/tmp");
    match std::env::var_os("TMPDIR") {
        None if lasting.is_dir() => lasting.to_path_buf(),
        _ => std::env::temp_dir(),
    }
}

/// Checks whether a file can be written under this name, as far as this is known beforehand. A write-protected file
/// is not replaced, nor is a file that a command has opened for reading.
///
/// # Errors
/// If it cannot.
pub fn check_target(path: &Path) -> Result<(), ImageError> {
    target_of(path, Content::Data).map(drop)
}

/// The file whose name an output takes: links are followed, also one to a file that does not exist yet.
fn target_of(path: &Path, content: Content) -> Result<PathBuf, ImageError> {
    let shown = path.display();
    let fail = |e: io::Error| ImageError::io("write", &shown.to_string(), &e);
    check_output(path, &shown.to_string(), content)?;
    let about = match fs::metadata(path) {
        Ok(about) => Some(about),
        Err(e) if e.kind() == io::ErrorKind::NotFound => None,
        // A loop of links, a file where a folder should be. What else it is, creating the file tells.
        Err(e) if path.is_symlink() => return Err(fail(e)),
        Err(_) => None,
    };
    if about.as_ref().is_some_and(|about| about.is_dir()) {
        return Err(fail(io::ErrorKind::IsADirectory.into()));
    }
    if about.as_ref().is_some_and(|about| about.is_file() && about.permissions().readonly()) {
        let message = format!("cannot write `{shown}`: the file is write-protected");
        return Err(ImageError::new(ErrorKind::Io(io::ErrorKind::PermissionDenied), message)
            .hint("Allow writing (chmod u+w), or write to another file."));
    }
    let target = match about {
        Some(about) if about.is_file() && path.is_symlink() => fs::canonicalize(path).map_err(fail)?,
        Some(_) => path.to_path_buf(),
        None => end_of_links(path).map_err(fail)?,
    };
    if let Some(folder) = target.parent().filter(|p| !p.as_os_str().is_empty() && !p.is_dir()) {
        let message = format!("cannot write `{shown}`: there is no directory `{}`", folder.display());
        return Err(ImageError::new(ErrorKind::Io(io::ErrorKind::NotFound), message)
            .hint(format!("Create it first: mkdir -p {}.", quote::path(folder))));
    }
    Ok(target)
}

/// The name at the end of a chain of links, where there is no file yet.
fn end_of_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        match fs::read_link(&path) {
            Ok(next) => path = path.parent().unwrap_or(Path::new("")).join(next),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("too many levels of links"))
}

/// What identifies the file of an output.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct TargetKey(Key);

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Key {
    /// Its place, through links, relative paths and `..`.
    Place(PathBuf),
    /// Its number in the file system, if it exists.
    #[cfg(unix)]
    Inode(u64, u64),
}

/// The keys of an output: two outputs that have one in common would be one file, whether it exists or not. Standard output is
/// `-`.
pub fn target_keys(path: &Path) -> Vec<TargetKey> {
    if path.as_os_str() == "-" {
        return vec![TargetKey(Key::Place(path.to_path_buf()))];
    }
    let end = end_of_links(path).unwrap_or_else(|_| path.to_path_buf());
    let folder = end.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
    let place = Key::Place(folder.join(end.file_name().unwrap_or_default()));
    #[cfg(unix)]
    let number = fs::metadata(path).ok().map(|about| {
        use std::os::unix::fs::MetadataExt;
        Key::Inode(about.dev(), about.ino())
    });
    #[cfg(not(unix))]
    let number = fs::canonicalize(path).ok().map(Key::Place);
    std::iter::once(place).chain(number).map(TargetKey).collect()
}

impl NewFile {
    /// Creates the file `path`.
    ///
    /// # Errors
    /// If the directory does not exist, the operating system refuses, or a command has opened the file for reading.
    pub fn create(path: &Path) -> Result<NewFile, ImageError> {
        NewFile::create_with(path, Content::Data)
    }

    fn create_with(path: &Path, content: Content) -> Result<NewFile, ImageError> {
        if path.as_os_str() == "-" {
            check_standard_output()?;
            return Ok(NewFile::kept("standard output".into(), path, content));
        }
        let shown = path.display().to_string();
        let target = target_of(path, content)?;
        if fs::metadata(path).is_ok_and(|about| !about.is_file()) {
            return Ok(NewFile::kept(shown, path, content));
        }
        let directory = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".pse-").suffix(".tmp");
        // A temporary file is private by default; a picture is as open as any new file of the user.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let made = Unfinished::create(|| builder.tempfile_in(directory), |file| file.path().to_path_buf());
        let (file, unfinished) = made.map_err(|e| ImageError::io("write", &shown, &e))?;
        Ok(NewFile { shown, place: Place::Beside { file, target, unfinished }, content })
    }

    fn kept(shown: String, path: &Path, content: Content) -> NewFile {
        let bytes = SpooledTempFile::new_in(KEPT, temporary_folder());
        NewFile { shown, place: Place::Kept { bytes, target: path.to_path_buf() }, content }
    }

    /// The name in messages.
    pub fn name(&self) -> &str {
        &self.shown
    }

    /// Completes the file, which then appears under its name.
    ///
    /// # Errors
    /// If the operating system refuses, or a command has opened the file for reading in the meantime.
    pub fn finish(self) -> Result<(), ImageError> {
        let fail = |e: io::Error| ImageError::io("write", &self.shown, &e);
        match self.place {
            Place::Beside { file, target, unfinished } => {
                check_output(&target, &self.shown, self.content)?;
                if let Ok(existing) = fs::metadata(&target) {
                    take_over(file.as_file(), &existing);
                }
                file.persist(&target).map_err(|e| fail(e.error))?;
                record_output(&target, &self.shown);
                drop(unfinished);
            }
            Place::Kept { mut bytes, target } => {
                bytes.rewind().map_err(fail)?;
                if target.as_os_str() == "-" {
                    check_standard_output()?;
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

/// Gives a new file the owner, the group and the permissions of the one that it replaces, as far as the system allows it.
/// As with every change of a file's content, it does not run under its owner's or its group's name any more.
#[cfg(unix)]
fn take_over(file: &fs::File, existing: &fs::Metadata) {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let Ok(own) = file.metadata() else { return };
    // Each by itself: a user may give a file to another group of theirs, but not to another user.
    if own.gid() != existing.gid() {
        let _ = fchown(file, None, Some(existing.gid()));
    }
    if own.uid() != existing.uid() {
        let _ = fchown(file, Some(existing.uid()), None);
    }
    let mut mode = existing.mode() & 0o777;
    if file.metadata().is_ok_and(|now| now.gid() != existing.gid()) {
        // What its group was allowed is not for another group.
        mode &= 0o707 | (mode & 0o007) << 3;
    }
    let _ = file.set_permissions(fs::Permissions::from_mode(mode));
}

#[cfg(not(unix))]
fn take_over(file: &fs::File, existing: &fs::Metadata) {
    let _ = file.set_permissions(existing.permissions());
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

/// Writes the text of a program to the file `path`, which appears complete or not at all; see [`NewFile`]. It can
/// replace a program that was read, because it saves that program's new text.
///
/// # Errors
/// If the directory does not exist, the operating system refuses, or a command has opened the file as an image or a mesh.
pub fn write_program(path: &Path, text: &str) -> Result<(), ImageError> {
    write_with(path, text.as_bytes(), Content::Program)
}

/// Writes `bytes` to the file `path`, which appears complete or not at all; see [`NewFile`].
///
/// # Errors
/// If the directory does not exist, the operating system refuses, or a command has opened the file for reading.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    write_with(path, bytes, Content::Data)
}

fn write_with(path: &Path, bytes: &[u8], content: Content) -> Result<(), ImageError> {
    let mut file = NewFile::create_with(path, content)?;
    file.write_all(bytes).map_err(|e| ImageError::io("write", file.name(), &e))?;
    file.finish()
}

/// Whether both paths lead to the same existing file (through links, relative paths, `..`).
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

    fn same_target(a: &Path, b: &Path) -> bool {
        let keys = target_keys(b);
        target_keys(a).iter().any(|key| keys.contains(key))
    }

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

    #[cfg(unix)]
    #[test]
    fn links_to_no_file_yet() {
        let dir = tempfile::tempdir().unwrap();
        let path = |name: &str| dir.path().join(name);
        fs::create_dir(path("far")).unwrap();
        let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, path(name)).unwrap();
        link("far/b", "a");
        link("c", "far/b");
        write_file(&path("a"), b"one").unwrap();
        assert_eq!(fs::read(path("far/c")).unwrap(), b"one");
        assert!(path("a").is_symlink() && path("far/b").is_symlink(), "links stay");
        link("none/c", "broken");
        let error = write_file(&path("broken"), b"x").unwrap_err();
        assert!(error.message.contains("there is no directory") && error.message.contains("none"), "{error}");
        link("round", "round");
        assert!(write_file(&path("round"), b"x").is_err());
        assert!(path("round").is_symlink());
    }

    #[cfg(unix)]
    #[test]
    fn replaced_files_keep_their_owner_and_no_privileges() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.bin");
        fs::write(&path, b"one").unwrap();
        // Only root may give files away; others keep their own.
        let given = chown(&path, Some(12345), Some(54321)).is_ok();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o6755)).unwrap();
        write_file(&path, b"two").unwrap();
        let about = fs::metadata(&path).unwrap();
        assert_eq!(about.mode() & 0o7777, 0o755);
        assert!(!given || (about.uid(), about.gid()) == (12345, 54321));
    }

    #[test]
    fn outputs_that_are_one_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = |name: &str| dir.path().join(name);
        fs::create_dir(path("d")).unwrap();
        for (a, b) in [("z.png", "./z.png"), ("z.png", "d/../z.png"), ("none/z", "none/z")] {
            assert!(same_target(&path(a), &path(b)), "{a} {b}");
        }
        assert!(!same_target(&path("z.png"), &path("d/z.png")));
        assert!(same_target(Path::new("z.png"), &std::env::current_dir().unwrap().join("z.png")));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("z.png", path("link")).unwrap();
            std::os::unix::fs::symlink("d", path("e")).unwrap();
            assert!(same_target(&path("link"), &path("z.png")), "no file yet");
            assert!(same_target(&path("d/a"), &path("e/a")));
        }
    }
}
