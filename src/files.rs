//! Opens files for reading. A path that a program or another file names may lead anywhere, so `regular` and
//! `Folders::open` take regular files only, and never wait; a path that the user gives may be a pipe (`given`).

use std::fmt;
use std::fs::{self, File, FileType};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Opens a regular file: no folder, FIFO, socket or device. It does not wait for anybody who might write.
///
/// # Errors
/// If the operating system refuses, or it is another kind of file.
pub fn regular(path: &Path) -> io::Result<File> {
    open_regular(path, 0)
}

/// The same, with further flags of the system's `open`.
fn open_regular(path: &Path, more: i32) -> io::Result<File> {
    // Opening a device can have effects of its own, so it is looked at before, too.
    check_kind(fs::metadata(path)?.file_type())?;
    let mut options = fs::OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use nix::libc::{O_NOCTTY, O_NONBLOCK};
        std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, O_NONBLOCK | O_NOCTTY | more);
    }
    #[cfg(not(unix))]
    let _ = more;
    let file = options.open(path)?;
    check_kind(file.metadata()?.file_type())?;
    Ok(file)
}

fn check_kind(kind: FileType) -> io::Result<()> {
    match special(kind) {
        _ if kind.is_file() => Ok(()),
        _ if kind.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        what => Err(io::Error::other(format!("it is {what}, not a regular file"))),
    }
}

/// What it is that is neither a regular file nor a folder.
fn special(kind: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
    }
    let _ = kind;
    "a device"
}

/// Opens what the user names: a regular file, or a pipe (`<(…)` of a shell is one), which may wait for its writer.
///
/// # Errors
/// If the operating system refuses, or it is a folder or a device.
pub fn given(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?.file_type();
    match kind.is_file() || kind.is_dir() || special(kind) == "a device" {
        true => regular(path),
        false => File::open(path),
    }
}

/// All bytes of a file, up to a limit.
///
/// # Errors
/// If reading fails, memory does not suffice, or there are more.
pub fn read_all(file: File, limit: u64) -> io::Result<Vec<u8>> {
    let expected = file.metadata().map_or(0, |about| about.len());
    let mut bytes = Vec::new();
    if expected > limit || bytes.try_reserve_exact(expected as usize).is_err() {
        return Err(too_long(limit.min(expected)));
    }
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(too_long(limit));
    }
    Ok(bytes)
}

fn too_long(limit: u64) -> io::Error {
    io::Error::other(format!("it is too large: more than {} MB", limit >> 20))
}

/// The folders in which a program may read files, and below.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Folders(Arc<[PathBuf]>);

impl Folders {
    /// These folders, as far as they exist. Links to folders stand for what they lead to.
    pub fn new<P: AsRef<Path>>(folders: impl IntoIterator<Item = P>) -> Folders {
        let here = |path: &Path| if path.as_os_str().is_empty() { PathBuf::from(".") } else { path.into() };
        folders.into_iter().filter_map(|folder| here(folder.as_ref()).canonicalize().ok()).collect()
    }

    /// The path without links, if it lies in one of the folders.
    ///
    /// # Errors
    /// If there is no such file, or links lead out of the folders.
    pub(crate) fn resolve(&self, path: &Path) -> io::Result<PathBuf> {
        let real = path.canonicalize()?;
        match self.0.iter().any(|folder| real.starts_with(folder)) {
            true => Ok(real),
            false => Err(io::Error::other(Outside(real))),
        }
    }

    /// Opens a regular file that lies in one of the folders, wherever links in its path lead: the path without links is
    /// compared with the folders, and that is what is opened.
    ///
    /// # Errors
    /// If the operating system refuses, the file lies elsewhere, or it is no regular file.
    pub fn open(&self, path: &Path) -> io::Result<File> {
        let real = self.resolve(path)?;
        #[cfg(unix)]
        let file = open_regular(&real, nix::libc::O_NOFOLLOW)?;
        #[cfg(not(unix))]
        let file = open_regular(&real, 0)?;
        // Somebody may have put a link into the place of a folder between both.
        match path.canonicalize()? == real && is_at(&file, &real)? {
            true => Ok(file),
            false => Err(io::Error::other("it was moved while being opened")),
        }
    }
}

impl FromIterator<PathBuf> for Folders {
    fn from_iter<I: IntoIterator<Item = PathBuf>>(folders: I) -> Folders {
        Folders(folders.into_iter().collect())
    }
}

/// Whether this path leads to the open file.
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    let (open, there) = (file.metadata()?, fs::symlink_metadata(path)?);
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        Ok((open.dev(), open.ino()) == (there.dev(), there.ino()))
    }
    #[cfg(not(unix))]
    Ok(open.len() == there.len() && open.modified().ok() == there.modified().ok())
}

/// The folder to allow, if this error says that a file lies outside of the folders.
pub(crate) fn outside(error: &io::Error) -> Option<&Path> {
    let Outside(path) = error.get_ref()?.downcast_ref()?;
    path.parent()
}

/// A file that lies elsewhere.
#[derive(Debug)]
struct Outside(PathBuf);

impl fmt::Display for Outside {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "links lead to `{}`, outside the folders that may be read", self.0.display())
    }
}

impl std::error::Error for Outside {}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use nix::libc;
    use std::ffi::CString;
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::fs::symlink;
    use std::os::unix::net::UnixListener;

    fn fifo(path: &Path) {
        let name = CString::new(path.as_os_str().as_bytes()).unwrap();
        // SAFETY: the name ends with a zero.
        assert_eq!(unsafe { libc::mkfifo(name.as_ptr(), 0o600) }, 0);
    }

    #[test]
    fn only_regular_files_are_opened_and_nothing_waits() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("file"), "text").unwrap();
        fifo(&path("fifo"));
        let _socket = UnixListener::bind(path("socket")).unwrap();
        for (link, target) in
            [("to_file", "file"), ("to_fifo", "fifo"), ("to_zero", "/dev/zero"), ("loop", "loop")]
        {
            symlink(target, path(link)).unwrap();
        }
        assert_eq!(read_all(regular(&path("to_file")).unwrap(), 4).unwrap(), b"text");
        assert!(read_all(regular(&path("file")).unwrap(), 3).unwrap_err().to_string().contains("too large"));
        for (name, why) in [
            ("fifo", "it is a pipe, not a regular file"),
            ("to_fifo", "it is a pipe, not a regular file"),
            ("socket", "it is a socket, not a regular file"),
            ("to_zero", "it is a device, not a regular file"),
        ] {
            assert_eq!(regular(&path(name)).unwrap_err().to_string(), why);
        }
        assert_eq!(regular(folder.path()).unwrap_err().kind(), io::ErrorKind::IsADirectory);
        assert!(regular(&path("loop")).is_err());
        assert!(given(&path("to_zero")).unwrap_err().to_string().contains("device"));
        assert!(given(&path("file")).is_ok());
    }

    #[test]
    fn links_count_by_where_they_lead() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["own/sub", "other/deep", "own2"] {
            fs::create_dir_all(path(name)).unwrap();
        }
        for name in ["own/a", "own/sub/b", "other/deep/secret", "other/secret", "own2/c"] {
            fs::write(path(name), "").unwrap();
        }
        for (link, target) in [
            ("own/in", "sub/b"),
            ("own/file_out", "../other/secret"),
            ("own/folder_out", "../other/deep"),
            ("own/chain", "in"),
            ("own/chain_out", "file_out"),
            ("own/near", "../own2/c"),
            ("own/there_and_back", "../other/back"),
            ("other/back", "../own/a"),
            ("root", "own"),
        ] {
            symlink(target, path(link)).unwrap();
        }
        let own = Folders::new([path("root"), path("none")]);
        for good in
            ["own/a", "root/a", "own/in", "own/chain", "own/sub/../a", "own/there_and_back", "other/back"]
        {
            assert!(own.open(&path(good)).is_ok(), "{good}");
        }
        for bad in [
            "own/file_out",
            "own/chain_out",
            "own/folder_out/secret",
            "own/folder_out/../secret",
            "own/near",
            "own/../other/secret",
        ] {
            let why = own.open(&path(bad)).unwrap_err();
            let lies = outside(&why).unwrap_or_else(|| panic!("{bad}: {why}"));
            assert!(
                lies.starts_with(path("other").canonicalize().unwrap()) || lies.ends_with("own2"),
                "{why}"
            );
        }
        assert!(Folders::new([path("own"), path("other")]).open(&path("own/folder_out/secret")).is_ok());
        assert_eq!(own.open(&path("own/none")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
