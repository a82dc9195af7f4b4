//! The address that `--open` gives to the browser. Others can read a browser's command line, so it holds no lasting token,
//! but one that is good once and soon.

use super::token;
use crate::cli::failure::{Failure, warn};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long a browser may take to start.
const VALID: Duration = Duration::from_secs(60);

/// The tokens that lead to the page once.
#[derive(Default)]
pub(super) struct Opening(Mutex<Option<OneTime>>);

struct OneTime {
    token: String,
    until: Instant,
    used: bool,
}

impl Opening {
    /// A new token.
    pub fn token(&self) -> Result<String, Failure> {
        let token = token::random()?;
        let one_time = OneTime { token: token.clone(), until: Instant::now() + VALID, used: false };
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(one_time);
        Ok(token)
    }

    /// Whether this is the token, which then has been used.
    pub fn redeem(&self, token: &str) -> bool {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(one_time) = kept.as_mut().filter(|one_time| one_time.token == token) else { return false };
        if one_time.used {
            // The browser or somebody else was first.
            warn(
                "the address of --open was requested twice. If the page did not open, another user of this machine has the address: stop pse view, and delete the file view-token (docs/view.md)",
            );
            return false;
        }
        one_time.used = true;
        Instant::now() < one_time.until
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_good_once() {
        let opening = Opening::default();
        assert!(!opening.redeem(""));
        let token = opening.token().unwrap();
        assert!(!opening.redeem("") && !opening.redeem(&token[1..]));
        assert!(opening.redeem(&token));
        assert!(!opening.redeem(&token));
        assert_ne!(opening.token().unwrap(), token);
    }
}
