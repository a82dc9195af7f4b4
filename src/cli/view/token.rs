//! The token of the page's address: who does not know it gets nothing. It stays the same for a user, so that a page finds a
//! server that was started again at the same port.

use crate::cli::failure::Failure;
use std::fs;
use std::io::Write;
use std::path::Path;

/// Bytes of a token.
const BYTES: usize = 16;

/// The user's token, made at the first time.
pub(super) fn token() -> Result<String, Failure> {
    let path = crate::cli::state::folder().map(|folder| folder.join("view-token"));
    if let Some(token) = path.as_deref().and_then(kept) {
        return Ok(token);
    }
    let token = random()?;
    if let Some(path) = path {
        // If it cannot be kept, the next one is another.
        let _ = keep(&path, &token);
    }
    Ok(token)
}

/// A token that nobody can guess.
pub(super) fn random() -> Result<String, Failure> {
    let mut bytes = [0; BYTES];
    getrandom::fill(&mut bytes)
        .map_err(|error| Failure::plain(format!("the system gives no random numbers: {error}")))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// The token in a file that only the user could have written.
fn kept(path: &Path) -> Option<String> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        if fs::metadata(path).ok()?.permissions().mode() & 0o077 != 0 {
            return None;
        }
    }
    let file = pse::internal::files::regular(path).ok()?;
    let token = String::from_utf8(pse::internal::files::read_all(file, 2 * BYTES as u64).ok()?).ok()?;
    let whole = token.len() == 2 * BYTES && token.bytes().all(|b| b.is_ascii_hexdigit());
    whole.then_some(token)
}

fn keep(path: &Path, token: &str) -> std::io::Result<()> {
    // Whatever stands there is no token, or one that others may have read.
    let _ = fs::remove_file(path);
    fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
    let mut options = fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)?.write_all(token.as_bytes())
}
