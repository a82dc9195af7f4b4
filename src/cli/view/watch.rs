//! Watching files: their folders are watched, because editors write a new file and then rename it.

use super::session::Session;
use crate::cli::failure::warn;
use notify::{Config, Event, EventKind, PollWatcher, RecommendedWatcher, RecursiveMode, Watcher as _};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A save is over when nothing more has happened for so long.
const QUIET: Duration = Duration::from_millis(8);

/// How often is looked where the system does not tell of changes.
const LOOK: Duration = Duration::from_millis(500);

/// Watches some files, and tells the session of their changes.
pub(super) struct Watcher {
    watcher: Option<Box<dyn notify::Watcher + Send>>,
    folders: BTreeSet<PathBuf>,
    files: Arc<Mutex<BTreeSet<PathBuf>>>,
}

/// The path from the root, also of a file that does not exist.
fn whole(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    path.file_name().map_or_else(|| folder.clone(), |name| folder.join(name))
}

impl Watcher {
    /// A watcher without files.
    pub fn new(session: Arc<Session>) -> Watcher {
        let files = Arc::new(Mutex::new(BTreeSet::new()));
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
        let watcher = watcher.map_err(|error| {
            warn(&format!("cannot watch files ({error}): changes by other programs are not seen"));
        });
        let known = Arc::clone(&files);
        // It ends with the watcher, which holds the other end of the channel.
        std::thread::spawn(move || tell(&session, &receiver, &known));
        Watcher { watcher: watcher.ok(), folders: BTreeSet::new(), files }
    }

    /// From now on these files are watched, too.
    pub fn watch(&mut self, files: &[PathBuf]) {
        let Some(watcher) = &mut self.watcher else { return };
        let mut known = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        for file in files {
            let file = whole(file);
            let folder = file.parent().unwrap_or(Path::new("/")).to_path_buf();
            // A folder that is not there cannot be watched, and has no file.
            if !self.folders.contains(&folder) && watcher.watch(&folder, RecursiveMode::NonRecursive).is_ok()
            {
                self.folders.insert(folder);
            }
            known.insert(file);
        }
    }
}

/// Gathers what changes at about the same time.
fn tell(session: &Session, events: &Receiver<Vec<PathBuf>>, known: &Mutex<BTreeSet<PathBuf>>) {
    while let Ok(first) = events.recv() {
        let mut changed: BTreeSet<PathBuf> = first.into_iter().collect();
        while let Ok(more) = events.recv_timeout(QUIET) {
            changed.extend(more);
        }
        let own: Vec<PathBuf> = {
            let known = known.lock().unwrap_or_else(PoisonError::into_inner);
            changed.into_iter().map(|path| whole(&path)).filter(|path| known.contains(path)).collect()
        };
        if !own.is_empty() {
            session.files_changed(&own);
        }
    }
}
