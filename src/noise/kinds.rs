//! The table of the kinds of noise.

use super::kind::Kind;
use super::{gradient, perlin1985, wiener};

/// Every kind, the default first, in the order of the documentation.
pub static KINDS: &[&Kind] = &[&perlin1985::KIND, &gradient::KIND, &wiener::KIND];
