//! Watching files: their folders are watched, because editors write a new file and then rename it. Where a path leads
//! through links, so are the folders of these, and the file's own.

use super::session::Session;
use crate::cli::failure::warn;
use notify::{Config, Event, EventKind, PollWatcher, RecommendedWatcher, RecursiveMode, Watcher as _};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ffi::OsString;
use std::path::{Component, Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

/// A save is over when nothing more has happened for so long.
const QUIET: Duration = Duration::from_millis(8);

/// How often is looked where the system does not tell of changes.
const LOOK: Duration = Duration::from_millis(500);

/// Links on the way to a file, as systems count them.
const MAX_LINKS: usize = 40;

/// The places on the way to a file, each with its folder free of links: those of the links, and last the file's own,
/// which need not exist.
fn steps(path: &Path) -> Vec<PathBuf> {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let parts =
        |path: &Path| path.components().map(|part| part.as_os_str().into()).collect::<Vec<OsString>>();
    let mut rest: VecDeque<OsString> = parts(&whole).into();
    let (mut at, mut links) = (PathBuf::new(), Vec::new());
    while let Some(part) = rest.pop_front() {
        match Path::new(&part).components().next() {
            Some(Component::ParentDir) => drop(at.pop()),
            Some(Component::Normal(name)) => {
                let next = at.join(name);
                match std::fs::read_link(&next) {
                    Ok(target) if links.len() < MAX_LINKS => {
                        links.push(next);
                        parts(&target).into_iter().rev().for_each(|part| rest.push_front(part));
                    }
                    _ => at = next,
                }
            }
            // A root takes the place of all that was there.
            _ => at.push(part),
        }
    }
    links.push(at);
    links
}

/// Watches some files, and tells the session of their changes.
pub(super) struct Watcher(Option<Arc<Mutex<Watched>>>);

/// What is watched.
struct Watched {
    watcher: Box<dyn notify::Watcher + Send>,
    folders: BTreeSet<PathBuf>,
    /// The files as they were named, and all places on the way to each.
    files: BTreeMap<PathBuf, Vec<PathBuf>>,
}

impl Watched {
    /// Watches the folders of all places on the way to the files, which may be others than the last time.
    fn refresh(&mut self) {
        for (file, places) in &mut self.files {
            *places = steps(file);
            for place in places {
                let folder = place.parent().unwrap_or(Path::new("/"));
                // A folder that is not there cannot be watched, and has no file.
                if !self.folders.contains(folder)
                    && self.watcher.watch(folder, RecursiveMode::NonRecursive).is_ok()
                {
                    self.folders.insert(folder.to_path_buf());
                }
            }
        }
    }

    /// The files on the way to which something has changed.
    fn affected(&self, changed: &BTreeSet<PathBuf>) -> BTreeSet<PathBuf> {
        let hit = |place: &PathBuf| changed.iter().any(|path| place.starts_with(path));
        let files = self.files.iter().filter(|(_, places)| places.iter().any(hit));
        files.map(|(file, _)| file.clone()).collect()
    }

    /// The files that have changed, where links led before and where they lead now.
    fn changed(&mut self, changed: &BTreeSet<PathBuf>) -> Vec<PathBuf> {
        let mut files = self.affected(changed);
        // A folder that was moved is not the one that is watched.
        self.folders.retain(|folder| !changed.iter().any(|path| folder.starts_with(path)));
        self.refresh();
        files.extend(self.affected(changed));
        files.into_iter().collect()
    }
}

fn lock(watched: &Mutex<Watched>) -> MutexGuard<'_, Watched> {
    watched.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Watcher {
    /// A watcher without files.
    pub fn new(session: Arc<Session>) -> Watcher {
        let (sender, receiver) = channel();
        let hear = move |event: notify::Result<Event>| {
            // Reading a file is no change of it.
            if let Ok(event) = event
                && !matches!(event.kind, EventKind::Access(_))
            {
                // The session ends first.
                let _ = sender.send(event.paths);
            }
        };
        let polling = hear.clone();
        let watcher: notify::Result<Box<dyn notify::Watcher + Send>> =
            match RecommendedWatcher::new(hear, Config::default()) {
                Ok(watcher) => Ok(Box::new(watcher)),
                Err(_) => PollWatcher::new(polling, Config::default().with_poll_interval(LOOK))
                    .map(|watcher| -> Box<dyn notify::Watcher + Send> { Box::new(watcher) }),
            };
        let watcher = match watcher {
            Ok(watcher) => watcher,
            Err(error) => {
                warn(&format!("cannot watch files ({error}): changes by other programs are not noticed"));
                return Watcher(None);
            }
        };
        let watched = Watched { watcher, folders: BTreeSet::new(), files: BTreeMap::new() };
        let watched = Arc::new(Mutex::new(watched));
        // It ends with the watcher, which holds the other end of the channel.
        let weak = Arc::downgrade(&watched);
        std::thread::spawn(move || tell(&session, &receiver, &weak));
        Watcher(Some(watched))
    }

    /// From now on these files are watched, too.
    pub fn watch(&mut self, files: &[PathBuf]) {
        if let Some(watched) = &self.0 {
            let mut watched = lock(watched);
            watched.files.extend(files.iter().map(|file| (file.clone(), Vec::new())));
            watched.refresh();
        }
    }
}

/// Gathers what changes at about the same time.
fn tell(session: &Session, events: &Receiver<Vec<PathBuf>>, watched: &Weak<Mutex<Watched>>) {
    while let Ok(first) = events.recv() {
        let mut changed: BTreeSet<PathBuf> = first.into_iter().collect();
        while let Ok(more) = events.recv_timeout(QUIET) {
            changed.extend(more);
        }
        let Some(watched) = watched.upgrade() else { return };
        let files = lock(&watched).changed(&changed);
        if !files.is_empty() {
            session.files_changed(&files);
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::symlink;

    #[test]
    fn all_links_on_the_way_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        fs::create_dir_all(root.join("far/deep")).unwrap();
        fs::write(root.join("far/file"), "").unwrap();
        for (link, target) in [
            ("one", "two"),
            ("two", "far/three"),
            ("far/three", "file"),
            ("folder", "far/deep"),
            ("up", "folder/../file"),
            ("round", "round"),
        ] {
            symlink(target, root.join(link)).unwrap();
        }
        symlink(root.join("far/file"), root.join("whole")).unwrap();
        let found = |name: &str| -> Vec<String> {
            let steps = steps(&root.join(name));
            steps.iter().map(|step| step.strip_prefix(&root).unwrap().display().to_string()).collect()
        };
        assert_eq!(found("one"), ["one", "two", "far/three", "far/file"]);
        assert_eq!(found("whole"), ["whole", "far/file"]);
        assert_eq!(found("folder/new"), ["folder", "far/deep/new"]);
        assert_eq!(found("up"), ["up", "folder", "far/file"]);
        assert_eq!(found("far/./deep/../file"), ["far/file"]);
        assert_eq!(found("none/file"), ["none/file"]);
        assert_eq!(found("round").len(), MAX_LINKS + 1);
    }
}
