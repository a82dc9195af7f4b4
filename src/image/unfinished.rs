//! Files and folders in the making, which are removed when the process is asked to end.
//!
//! Each has a temporary name, `.pse-…`, until it is whole. Destructors remove those of a command that ends by itself. A
//! signal that ends the process from another thread removes the others here.

use std::collections::HashSet;
use std::fs;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

static UNFINISHED: Mutex<Option<HashSet<PathBuf>>> = Mutex::new(None);

/// While this is locked, files take their names, which an ending process waits for.
static COMMIT: Mutex<()> = Mutex::new(());

fn unfinished() -> MutexGuard<'static, Option<HashSet<PathBuf>>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary path, removed by [`end_process`] until it is dropped.
#[derive(Debug)]
pub struct Unfinished(PathBuf);

impl Unfinished {
    /// Creates the file or folder. No signal can come between its creation and its registration.
    pub fn create<T, E>(
        create: impl FnOnce() -> Result<T, E>,
        path: impl FnOnce(&T) -> PathBuf,
    ) -> Result<(T, Unfinished), E> {
        let mut all = unfinished();
        let made = create()?;
        // A process may change its folder; what is removed in the end must be what was made.
        let path = path(&made);
        let path = std::path::absolute(&path).unwrap_or(path);
        all.get_or_insert_default().insert(path.clone());
        Ok((made, Unfinished(path)))
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if let Some(all) = &mut *unfinished() {
            all.remove(&self.0);
        }
    }
}

/// Runs steps that belong together, quick ones: a signal ends the process before or after them.
pub fn commit<T>(steps: impl FnOnce() -> T) -> T {
    let _guard = COMMIT.lock().unwrap_or_else(PoisonError::into_inner);
    steps()
}

/// Removes everything unfinished and ends the process.
pub fn end_process(status: i32) -> ! {
    let _commit = COMMIT.lock().unwrap_or_else(PoisonError::into_inner);
    // The lock is held to the end: nothing new begins.
    let all = unfinished();
    for path in all.iter().flatten() {
        // Where it cannot be removed, nobody is left to be told.
        let _ = match path.is_dir() {
            true => fs::remove_dir_all(path),
            false => fs::remove_file(path),
        };
    }
    std::process::exit(status)
}
