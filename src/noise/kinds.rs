//! The table of the kinds of noise.

use super::kind::Kind;
use super::{cellular, gardner, gradient, perlin1985, simplex};

/// Every kind, the default first, in the order of the documentation.
pub static KINDS: &[&Kind] =
    &[&perlin1985::KIND, &gradient::KIND, &simplex::KIND, &cellular::KIND, &gardner::KIND];
