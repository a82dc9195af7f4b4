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

/// What is decoded as a whole may become this many bytes of floats however short its file is: a picture of 4096 x 4096
/// pixels with alpha.
const WHOLE: u64 = 256 << 20;

/// And so many for each byte of the file. Photographs have less than 100; a single colour is packed more tightly, but
/// nobody needs 30 million pixels of it.
const WHOLE_RATIO: u64 = 1000;

/// Deflate packs at most 258 bytes into 2 bits (RFC 1951), so 1032 bytes into one.
const DEFLATE_RATIO: u64 = 1032;

/// Checks what an image that is decoded as a whole becomes, beside the length of its file.
pub(crate) fn check_decoded(
    file: &str,
    [width, height]: [u64; 2],
    channels: u64,
    file_bytes: u64,
) -> Result<(), ImageError> {
    let floats = width.saturating_mul(height).saturating_mul(channels).saturating_mul(4);
    match floats <= WHOLE.max(file_bytes.saturating_mul(WHOLE_RATIO)) {
        true => Ok(()),
        false => Err(ImageError::new(
            ErrorKind::TooLarge,
            format!(
                "`{file}` has {file_bytes} bytes, but would become {width} x {height} pixels in memory at once"
            ),
        )
        .hint("Save it as EXR, or as PNG without interlacing, which are read row by row.")),
    }
}

/// A texture's tiles may take this many bytes of the temporary folder however short its file is.
const TILES: u64 = 4 << 30;

/// And so many for each byte of the file.
const TILES_RATIO: u64 = 1000;

/// The memory that a texture may take, all levels together, by the length of its file.
pub(crate) fn texture_memory(file_bytes: u64) -> u64 {
    WHOLE.max(file_bytes.saturating_mul(WHOLE_RATIO))
}

/// Checks how much a texture that does not fit in memory takes in a temporary file.
pub(crate) fn check_tiles(name: &str, tile_bytes: u64, file_bytes: u64) -> Result<(), ImageError> {
    match tile_bytes <= TILES.max(file_bytes.saturating_mul(TILES_RATIO)) {
        true => Ok(()),
        false => Err(ImageError::new(
            ErrorKind::TooLarge,
            format!(
                "`{name}` has {file_bytes} bytes, but its tiles would take {} MB in a temporary file",
                tile_bytes >> 20
            ),
        )
        .hint("Use a smaller picture, or more memory for textures (--texture-memory).")),
    }
}

/// Whether a PNG file of so many bytes can hold rows of so many bits.
pub(crate) fn fits_deflate(row_bits: u64, height: u64, file_bytes: u64) -> bool {
    row_bits.div_ceil(8).saturating_mul(height) <= file_bytes.saturating_mul(DEFLATE_RATIO)
}

/// Is it believable that a file of `file_bytes` holds `pixel_bytes` of pixels?
pub(crate) fn check_size(
    file: &str,
    width: u64,
    height: u64,
    pixel_bytes: u64,
    file_bytes: u64,
) -> Result<(), ImageError> {
    check_bits(file, width, height, pixel_bytes.saturating_mul(8), file_bytes)
}

/// The same for pixels of so many bits.
pub(crate) fn check_bits(
    file: &str,
    width: u64,
    height: u64,
    pixel_bits: u64,
    file_bytes: u64,
) -> Result<(), ImageError> {
    let size = (u128::from(width) * u128::from(height)).checked_mul(pixel_bits.into());
    let limit = FREE.max(file_bytes.saturating_mul(RATIO)).min(isize::MAX as u64);
    match size {
        Some(bits) if bits.div_ceil(8) <= limit.into() => Ok(()),
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
