//! How far interpolation may be off: the confidence measure of Lewis 1989, section 3.

// Loops over axes and lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::super::field::{Each, Field, Jet, Pointwise, TILE, coordinates, load, tiles};
use super::super::kind::{Contract, Kind, Made, Smoothness};
use super::super::options::{Opt, Params};
use super::cells::locate;
use super::covariance::Covariance;
use super::neighbours;
use super::solved::Solved;
use super::weights::{Exact, Weights};
use crate::lanes::{Isa, Kernel};
use std::sync::Arc;

/// The expected squared error of `wiener` noise with the same options as an estimate of a noise that really has the
/// covariance, relative to its variance: 1 - cᵗC⁻¹c. It is 0 at lattice points (within 1e-6; for the gaussian covariance exactly),
/// below 1, and the same in every cell.
///
/// # Errors
/// As the noise's; there is neither seed nor period.
pub fn wiener_error(dimensions: usize, params: &Params) -> Made {
    ERROR.field(dimensions, params)
}

/// Not one of the kinds, but made and kept like those.
static ERROR: Kind = Kind {
    name: "wiener_error",
    brief: "the expected squared error of wiener noise",
    dimensions: 1..=4,
    options: &[Opt::Covariance, Opt::Width, Opt::Frequency, Opt::Knots, Opt::Neighbours],
    contract: Contract {
        bounds: &[[0.0, 1.0]; 4],
        mean: 0.0,
        deviation: 0.0,
        lattice: "0",
        smoothness: Smoothness::C0,
        cost: 1.0,
        source: "Lewis 1989, section 3",
        remarks: "",
    },
    make: |dimensions, params| {
        let covariance = Covariance::new(dimensions, params)?;
        let points = neighbours(params)?;
        if covariance.is_product() {
            product(dimensions, points, &covariance)
        } else {
            any(dimensions, points, &covariance)
        }
    },
};

fn product(dimensions: usize, points: usize, covariance: &Covariance) -> Made {
    let exact = Exact::new(covariance, points);
    let weights = if points == 3 { Weights::new::<3>(&exact) } else { Weights::new::<4>(&exact) };
    let error = OfProduct { weights, nearest: points == 3 };
    Ok(match dimensions {
        1 => Arc::new(Each::<_, 1>(error)),
        2 => Arc::new(Each::<_, 2>(error)),
        3 => Arc::new(Each::<_, 3>(error)),
        _ => Arc::new(Each::<_, 4>(error)),
    })
}

fn any(dimensions: usize, points: usize, covariance: &Covariance) -> Made {
    Ok(match dimensions {
        1 => Arc::new(OfSum::<1, 2, 4>(Solved::new(points, covariance)?)),
        2 => Arc::new(OfSum::<2, 4, 16>(Solved::new(points, covariance)?)),
        _ => Arc::new(OfSum::<3, 8, 64>(Solved::new(points, covariance)?)),
    })
}

/// The error of a covariance that is a product over axes: so is what is known of the variance, 1 less the error.
struct OfProduct {
    weights: Weights,
    nearest: bool,
}

impl<const D: usize> Pointwise<D> for OfProduct {
    #[inline(always)]
    fn value(&self, p: [f32; D]) -> f32 {
        self.jet(p).value
    }

    #[inline(always)]
    fn jet(&self, p: [f32; D]) -> Jet<D> {
        let mut jet = Jet { value: 0.0, gradient: [0.0; D] };
        for axis in 0..D {
            let (_, t) = locate(self.nearest, p[axis]);
            let (error, slope) = self.weights.error(self.nearest, t);
            // Like 1 - (1 - a)(1 - b), but no digits are lost where errors are small.
            for k in 0..axis {
                jet.gradient[k] *= 1.0 - error;
            }
            jet.gradient[axis] = slope * (1.0 - jet.value);
            jet.value += error * (1.0 - jet.value);
        }
        jet
    }
}

/// The error of any covariance.
struct OfSum<const D: usize, const SIDE: usize, const COUNT: usize>(Solved<D, SIDE, COUNT>);

impl<const D: usize, const SIDE: usize, const COUNT: usize> Field for OfSum<D, SIDE, COUNT> {
    fn noise(&self, isa: Isa, p: &[&[f32]], out: &mut [f32]) {
        isa.run(Values { solved: &self.0, p: coordinates(p), out });
    }

    fn derivative(&self, isa: Isa, p: &[&[f32]], out: &mut [&mut [f32]]) {
        assert_eq!(out.len(), D, "derivatives of {D} coordinates");
        // Seldom asked for, so compiled once: the bits are the same for every instruction set.
        let _ = isa;
        Derivatives { solved: &self.0, p: coordinates(p), out }.run();
    }
}

/// Each lane has weights of its own.
const OWN: [u32; TILE] = {
    let mut own = [0; TILE];
    let mut i = 0;
    while i < TILE {
        own[i] = i as u32;
        i += 1;
    }
    own
};

/// The places of points in their cells, and the weights there.
#[inline(always)]
fn weigh<const D: usize, const SIDE: usize, const COUNT: usize>(
    solved: &Solved<D, SIDE, COUNT>,
    p: &[[f32; TILE]; D],
    work: usize,
    weights: &mut [[f32; TILE]; COUNT],
) -> [[f32; TILE]; D] {
    let mut places = [[0.0; TILE]; D];
    for axis in 0..D {
        for i in 0..work.min(TILE) {
            places[axis][i] = locate(solved.points == 3, p[axis][i]).1;
        }
    }
    solved.covariances(&places, work, weights);
    solved.solve(weights, work);
    places
}

struct Values<'a, const D: usize, const SIDE: usize, const COUNT: usize> {
    solved: &'a Solved<D, SIDE, COUNT>,
    p: [&'a [f32]; D],
    out: &'a mut [f32],
}

impl<const D: usize, const SIDE: usize, const COUNT: usize> Kernel for Values<'_, D, SIDE, COUNT> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let mut weights = [[0.0; TILE]; COUNT];
        for (start, end) in tiles(self.out.len()) {
            let (p, work) = load(&self.p, start, end);
            let places = weigh(self.solved, &p, work, &mut weights);
            let mut told = [0.0; TILE];
            self.solved.sum(&weights, &OWN, &places, work, &mut told);
            for (out, told) in self.out[start..end].iter_mut().zip(told) {
                // Rounding must not make a variance negative.
                let error = 1.0 - told;
                *out = if error < 0.0 { 0.0 } else { error };
            }
        }
    }
}

struct Derivatives<'a, 'b, const D: usize, const SIDE: usize, const COUNT: usize> {
    solved: &'a Solved<D, SIDE, COUNT>,
    p: [&'a [f32]; D],
    out: &'a mut [&'b mut [f32]],
}

impl<const D: usize, const SIDE: usize, const COUNT: usize> Kernel for Derivatives<'_, '_, D, SIDE, COUNT> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let mut weights = [[0.0; TILE]; COUNT];
        for (start, end) in tiles(self.p[0].len()) {
            let (p, work) = load(&self.p, start, end);
            let places = weigh(self.solved, &p, work, &mut weights);
            let mut slopes = [[0.0; TILE]; D];
            self.solved.slopes(&weights, &OWN, &places, work, &mut slopes);
            for (out, slopes) in self.out.iter_mut().zip(&slopes) {
                for (out, slope) in out[start..end].iter_mut().zip(slopes) {
                    // Weights change too, but they are the best ones: d(cᵗC⁻¹c) = 2 aᵗ dc.
                    *out = -2.0 * slope;
                }
            }
        }
    }
}
