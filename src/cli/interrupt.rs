//! Interrupts: a run ends and cleans up behind it, so that no unfinished file is left.

use super::failure::INTERRUPTED;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by an interrupt, and by a request to end: what runs looks at it now and then.
pub(super) static CANCEL: AtomicBool = AtomicBool::new(false);

/// A file that would pass the user's limit becomes an error of the write, as on a full disk, and not the end of the
/// process with its unfinished files.
pub(super) fn survive_file_limits() {
    #[cfg(unix)]
    {
        use nix::sys::signal::{SigHandler, Signal, signal};
        // SAFETY: no handler is set that could run at a wrong moment; the signal is ignored.
        let _ = unsafe { signal(Signal::SIGXFSZ, SigHandler::SigIgn) };
    }
}

/// From now on an interrupt sets [`CANCEL`]. `twice_ends`: a second one ends the process as it is.
pub(super) fn watch(twice_ends: bool) {
    // Where there can be no handler, an interrupt ends the process, as ever.
    let _ = ctrlc::set_handler(move || {
        if CANCEL.swap(true, Ordering::Relaxed) && twice_ends {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
}
