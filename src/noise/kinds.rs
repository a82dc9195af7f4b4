//! The table of the kinds of noise.

use super::kind::Kind;
use super::{
    cellular, composed, fourier, gabor, gardner, gradient, hermite, improved, lattice_convolution, midpoint,
    perlin1985, simplex, sparse_convolution, value, value_gradient, white, wiener,
};

/// Every kind, the default first, in the order of the documentation.
pub static KINDS: &[&Kind] = &[
    &perlin1985::KIND,
    &gradient::KIND,
    &improved::KIND,
    &simplex::KIND,
    &value::KIND,
    &value_gradient::KIND,
    &hermite::KIND,
    &lattice_convolution::KIND,
    &sparse_convolution::KIND,
    &gabor::KIND,
    &wiener::KIND,
    &cellular::KIND,
    &white::KIND,
    &gardner::KIND,
    &composed::KIND,
    &fourier::KIND,
    &midpoint::KIND,
];
