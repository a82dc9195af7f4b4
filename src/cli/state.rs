//! Where the command keeps what it remembers of its user from one time to the next.

use std::path::PathBuf;

/// The folder for it (XDG base directories, *state*), whether it exists or not; `None` where there is no home.
pub(super) fn folder() -> Option<PathBuf> {
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from);
    let home = || std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".local/state"));
    Some(state.filter(|path| path.is_absolute()).or_else(home)?.join("pse"))
}
