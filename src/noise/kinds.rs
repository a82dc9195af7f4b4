//! The table of the kinds of noise.

use super::kind::Kind;
use super::{
    composed, gradient, hermite, improved, lattice_convolution, perlin1985, value, value_gradient, white,
};

/// Every kind, the default first, in the order of the documentation.
pub static KINDS: &[&Kind] = &[
    &perlin1985::KIND,
    &gradient::KIND,
    &improved::KIND,
    &value::KIND,
    &value_gradient::KIND,
    &hermite::KIND,
    &lattice_convolution::KIND,
    &white::KIND,
    &composed::KIND,
];
