//! How far interpolation may be off: the confidence measure of Lewis 1989, section 3.

// Loops over axes and lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::super::field::{ByTiles, Each, Jet, Pointwise, TILE, Tile, Tiled};
use super::super::kind::{Contract, Kind, Made, Smoothness};
use super::super::options::{Opt, Params};
use super::cells::locate;
use super::covariance::Covariance;
use super::neighbours;
use super::solved::Solved;
use super::weights::{Exact, Weights};
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
        1 => Arc::new(ByTiles::<_, 1>(Each(error))),
        2 => Arc::new(ByTiles::<_, 2>(Each(error))),
        3 => Arc::new(ByTiles::<_, 3>(Each(error))),
        _ => Arc::new(ByTiles::<_, 4>(Each(error))),
    })
}

fn any(dimensions: usize, points: usize, covariance: &Covariance) -> Made {
    Ok(match dimensions {
        1 => Arc::new(ByTiles(OfSum::<1, 2, 4>(Solved::new(points, covariance)?))),
        2 => Arc::new(ByTiles(OfSum::<2, 4, 16>(Solved::new(points, covariance)?))),
        _ => Arc::new(ByTiles(OfSum::<3, 8, 64>(Solved::new(points, covariance)?))),
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
    p: [&[f32; TILE]; D],
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

impl<const D: usize, const SIDE: usize, const COUNT: usize> Tiled<D> for OfSum<D, SIDE, COUNT> {
    type Scratch = [[f32; TILE]; COUNT];
    #[inline(always)]
    fn scratch(&self) -> Self::Scratch {
        [[0.0; TILE]; COUNT]
    }

    #[inline(always)]
    fn values(&self, weights: &mut Self::Scratch, tile: Tile<'_, D>, out: &mut [f32; TILE]) {
        let places = weigh(&self.0, tile.p, tile.work(), weights);
        let mut told = [0.0; TILE];
        self.0.sum(weights, &OWN, &places, tile.work(), &mut told);
        for i in 0..TILE {
            // Rounding must not make a variance negative.
            let error = 1.0 - told[i];
            out[i] = if error < 0.0 { 0.0 } else { error };
        }
    }

    #[inline(always)]
    fn slopes(&self, weights: &mut Self::Scratch, tile: Tile<'_, D>, out: &mut [[f32; TILE]; D]) {
        let places = weigh(&self.0, tile.p, tile.work(), weights);
        let mut slopes = [[0.0; TILE]; D];
        self.0.slopes(weights, &OWN, &places, tile.work(), &mut slopes);
        for k in 0..D {
            for i in 0..TILE {
                // Weights change too, but they are the best ones: d(cᵗC⁻¹c) = 2 aᵗ dc.
                out[k][i] = -2.0 * slopes[k][i];
            }
        }
    }
}
