//! Interrupts: a run ends and cleans up behind it, so that no unfinished file is left.

use super::failure::INTERRUPTED;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by an interrupt, and by a request to end: what runs looks at it now and then.
pub(super) static CANCEL: AtomicBool = AtomicBool::new(false);

/// From now on an interrupt sets [`CANCEL`]. `twice_ends`: a second one ends the process as it is.
pub(super) fn watch(twice_ends: bool) {
    // Where there can be no handler, an interrupt ends the process, as ever.
    let _ = ctrlc::set_handler(move || {
        if CANCEL.swap(true, Ordering::Relaxed) && twice_ends {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
}
