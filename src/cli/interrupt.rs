//! Interrupts and requests to end (INT, TERM, HUP): no unfinished file is left behind, whatever the command does.

use super::failure::{INTERRUPTED, warn};
use pse::image::end_process;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::time::Duration;

/// Set by an interrupt, and by a request to end: what runs looks at it now and then.
pub(super) static CANCEL: AtomicBool = AtomicBool::new(false);

/// How long a command may take to end by itself. One that waits for somebody (a pipe that nobody reads) never would.
const PATIENCE: Duration = Duration::from_secs(2);

/// What a signal does.
static ACTION: AtomicU8 = AtomicU8::new(END);

/// It removes unfinished files and ends the process.
const END: u8 = 0;

/// It sets [`CANCEL`]; the command ends by itself.
const CANCEL_COMMAND: u8 = 1;

/// It sets [`CANCEL`], which ends what runs in a session.
const CANCEL_ANSWER: u8 = 2;

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

/// From now on, signals remove unfinished files and end the process. What was ignored from outside (`nohup`) stays ignored.
pub(super) fn listen() {
    #[cfg(unix)]
    let ignored = {
        use nix::sys::signal::{SigHandler, Signal, signal};
        let all = [Signal::SIGINT, Signal::SIGTERM, Signal::SIGHUP];
        // SAFETY: no handler is set that could run at a wrong moment.
        let ignore = |s: Signal| unsafe { signal(s, SigHandler::SigIgn) };
        all.into_iter().filter(|s| matches!(ignore(*s), Ok(SigHandler::SigIgn))).collect::<Vec<_>>()
    };
    // Where there can be no handler, a signal ends the process as it is.
    let _ = ctrlc::set_handler(act);
    #[cfg(unix)]
    for signal in ignored {
        use nix::sys::signal::SigHandler;
        // SAFETY: as above.
        let _ = unsafe { nix::sys::signal::signal(signal, SigHandler::SigIgn) };
    }
}

/// Runs in a thread of its own for each signal.
fn act() {
    match ACTION.load(Ordering::Relaxed) {
        CANCEL_COMMAND if !CANCEL.swap(true, Ordering::Relaxed) => {
            std::thread::spawn(|| {
                std::thread::sleep(PATIENCE);
                warn("interrupted; the unfinished output was not written");
                end_process(i32::from(INTERRUPTED));
            });
        }
        CANCEL_ANSWER => CANCEL.store(true, Ordering::Relaxed),
        _ => end_process(i32::from(INTERRUPTED)),
    }
}

/// From now on the command looks at [`CANCEL`] and ends by itself. One that does not within two seconds is ended, and so is
/// one that gets a second signal.
pub(super) fn cancel_command() {
    ACTION.store(CANCEL_COMMAND, Ordering::Relaxed);
}

/// From now on an interrupt ends the answer of a session, which goes on. Requests to end still end the process.
pub(super) fn cancel_answer() {
    ACTION.store(CANCEL_ANSWER, Ordering::Relaxed);
    #[cfg(unix)]
    {
        use nix::sys::signal::{SigHandler, Signal, signal};
        for s in [Signal::SIGTERM, Signal::SIGHUP] {
            // SAFETY: the default action is no handler that could run at a wrong moment.
            let _ = unsafe { signal(s, SigHandler::SigDfl) };
        }
    }
}
