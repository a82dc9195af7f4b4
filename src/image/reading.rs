//! The files that this process has opened for reading, so that no output takes the place of one of them.
//!
//! A command turns the registry on with [`protect_inputs`]. Who opens an input passes the file through [`recorded`], and
//! [`NewFile`](super::NewFile) asks before it creates a file and again before the file takes its name. Embedders, who may
//! well read a file and write it again, never turn it on.

use super::error::{ErrorKind, ImageError};
use std::collections::HashMap;
use std::fs::{File, Metadata};
use std::io;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The purpose of an opened file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// The text of a program. `pse fmt` may save it again, but no output replaces it, even with `--force`.
    Program,
    /// An image, a mesh or its data.
    Data,
}

/// Whether the user may let an output replace an input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Force {
    /// The command has no option for it.
    #[default]
    NotOffered,
    /// The command has the option `--force`, and it is not given.
    Offered,
    /// `--force` is given.
    Given,
}

#[derive(Debug, Default)]
struct Registry {
    files: HashMap<Identity, (String, Content)>,
    /// The outputs that are finished, by the name that they were written under.
    written: HashMap<Identity, String>,
    force: Force,
}

/// `None`: nothing is recorded.
static REGISTRY: Mutex<Option<Registry>> = Mutex::new(None);

fn registry() -> MutexGuard<'static, Option<Registry>> {
    REGISTRY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Identifies a file under all of its names: links of both kinds, other paths, descriptors.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Identity {
    #[cfg(unix)]
    Inode(u64, u64),
    #[cfg(not(unix))]
    Path(std::path::PathBuf),
}

#[cfg(unix)]
fn identity(_: &Path, about: &Metadata) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    about.is_file().then(|| Identity::Inode(about.dev(), about.ino()))
}

#[cfg(not(unix))]
fn identity(path: &Path, about: &Metadata) -> Option<Identity> {
    let path = std::fs::canonicalize(path).ok()?;
    about.is_file().then_some(Identity::Path(path))
}

fn identity_of(path: &Path) -> Option<Identity> {
    identity(path, &std::fs::metadata(path).ok()?)
}

/// Starts recording opened files; outputs do not replace them.
pub fn protect_inputs() {
    registry().get_or_insert_default();
}

/// Sets whether the running command lets outputs replace inputs.
pub fn set_force(force: Force) {
    if let Some(registry) = &mut *registry() {
        registry.force = force;
    }
}

/// Records a file that was opened for reading. All code that opens an input must pass it through here.
pub fn recorded(path: &Path, content: Content, opened: io::Result<File>) -> io::Result<File> {
    let file = opened?;
    if registry().is_some() {
        // Of what was opened: the name may lead elsewhere by now.
        insert(identity(path, &file.metadata()?), path.display().to_string(), content);
    }
    Ok(file)
}

/// Records a file that is going to be read, if it exists.
pub fn record(path: &Path, content: Content) {
    if registry().is_some() {
        insert(identity_of(path), path.display().to_string(), content);
    }
}

/// Records the file that standard input comes from, if it is one.
pub fn record_standard_input(content: Content) {
    #[cfg(unix)]
    if registry().is_some() {
        use std::os::fd::AsFd;
        let about = io::stdin().as_fd().try_clone_to_owned().map(File::from).and_then(|file| file.metadata());
        let identity = about.ok().and_then(|about| identity(Path::new(""), &about));
        insert(identity, "standard input".into(), content);
    }
    #[cfg(not(unix))]
    let _ = content;
}

fn insert(identity: Option<Identity>, name: String, content: Content) {
    if let (Some(registry), Some(identity)) = (&mut *registry(), identity) {
        let known = registry.files.entry(identity).or_insert((name, content));
        // What is a program and an image at once is kept as a program.
        if content == Content::Program {
            known.1 = content;
        }
    }
}

/// Looks into a file without recording it: a frame that is already there is read to find out whether it is whole, and may
/// then be written again.
pub(super) fn unrecorded<T>(path: &Path, look: impl FnOnce() -> T) -> T {
    let identity = identity_of(path);
    let contains = |identity: &Option<Identity>| match (&*registry(), identity) {
        (Some(registry), Some(identity)) => registry.files.contains_key(identity),
        _ => false,
    };
    let before = contains(&identity);
    let result = look();
    if let (false, Some(registry), Some(identity)) = (before, &mut *registry(), &identity) {
        registry.files.remove(identity);
    }
    result
}

/// Refuses an output that would replace a file which was opened for reading, or another output; `shown` is what messages
/// call it, and `writes` what it holds.
///
/// # Errors
/// If it would.
pub(super) fn check_output(path: &Path, shown: &str, writes: Content) -> Result<(), ImageError> {
    check(identity_of(path), shown, writes)
}

/// The same for standard output, which may lead into a file.
///
/// # Errors
/// If that file was opened for reading.
pub(super) fn check_standard_output() -> Result<(), ImageError> {
    check(standard_output(), "standard output", Content::Data)
}

#[cfg(unix)]
fn standard_output() -> Option<Identity> {
    use std::os::fd::AsFd;
    let file = File::from(io::stdout().as_fd().try_clone_to_owned().ok()?);
    identity(Path::new(""), &file.metadata().ok()?)
}

#[cfg(not(unix))]
fn standard_output() -> Option<Identity> {
    None
}

/// Records a finished output: another one may not replace it under another name.
pub(super) fn record_output(path: &Path, shown: &str) {
    if let (Some(registry), Some(identity)) = (&mut *registry(), identity_of(path)) {
        registry.written.insert(identity, shown.to_string());
    }
}

fn check(identity: Option<Identity>, shown: &str, writes: Content) -> Result<(), ImageError> {
    let guard = registry();
    let (Some(registry), Some(identity)) = (guard.as_ref(), identity) else { return Ok(()) };
    if let Some(other) = registry.written.get(&identity).filter(|other| *other != shown) {
        let message = format!("the output `{shown}` is the same file as the output `{other}`");
        return Err(ImageError::new(ErrorKind::Io(io::ErrorKind::AlreadyExists), message)
            .hint("Write to another file."));
    }
    let Some((name, content)) = registry.files.get(&identity) else { return Ok(()) };
    let (what, may) = match content {
        Content::Program => ("program", writes == Content::Program),
        Content::Data => ("input", registry.force == Force::Given),
    };
    if may {
        return Ok(());
    }
    let message = format!("the output `{shown}` is the {what} `{name}`");
    let offered = *content == Content::Data && registry.force == Force::Offered;
    let hint = if offered { "Write to another file, or add --force." } else { "Write to another file." };
    Err(ImageError::new(ErrorKind::Io(io::ErrorKind::AlreadyExists), message).hint(hint))
}
