//! Defences against files that lie: sizes are weighed against the file's length before memory is
//! asked for, and a decoder that panics becomes an error.

use super::error::{ErrorKind, ImageError};
use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

/// A file may claim this many bytes of pixels however short it is: flat images compress without limit.
const FREE: u64 = 256 << 20;

/// No honest G-buffer is packed more tightly (deflate ends at 1032 to 1, the wavelet coders go further).
const RATIO: u64 = 20_000;

/// Is it believable that a file of `file_bytes` holds `pixel_bytes` of pixels?
pub(crate) fn check_size(
    file: &str,
    width: u64,
    height: u64,
    pixel_bytes: u64,
    file_bytes: u64,
) -> Result<(), ImageError> {
    let size = width.checked_mul(height).and_then(|pixels| pixels.checked_mul(pixel_bytes));
    match size {
        Some(size) if size <= FREE.max(file_bytes.saturating_mul(RATIO)) && size <= isize::MAX as u64 => {
            Ok(())
        }
        _ => Err(ImageError::new(
            ErrorKind::TooLarge,
            format!("`{file}` claims {width} x {height} pixels, more than its {file_bytes} bytes can hold"),
        )),
    }
}

/// `count` zeros, or an error where memory does not suffice.
pub(crate) fn plane(file: &str, count: usize) -> Result<Vec<f32>, ImageError> {
    let mut plane = Vec::new();
    if plane.try_reserve_exact(count).is_err() {
        let message = format!("`{file}` does not fit in memory: a channel of it has {count} numbers");
        return Err(ImageError::new(ErrorKind::TooLarge, message));
    }
    plane.resize(count, 0.0);
    Ok(plane)
}

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs a decoder on bytes that may be hostile; `None` if it panics. The panic prints nothing.
pub(crate) fn contain<T>(decode: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    // The hook is the process's own; ours only keeps silent inside `contain`, and else does as before.
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |about| {
            if !QUIET.get() {
                before(about);
            }
        }));
    });
    let outer = QUIET.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(decode));
    QUIET.set(outer);
    result.ok()
}
