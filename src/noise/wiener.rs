//! Wiener interpolation: Lewis, "Algorithms for Solid Noise Synthesis", SIGGRAPH 89, section 3.
//!
//! Lattice points have random values η, uncorrelated. At a point p noise is the linear combination of the values of
//! its neighbours that has the least expected squared error, if they are correlated over distance by a covariance C:
//!
//! ```text
//! noise(p) = <ηᵗ C⁻¹, c(p)>        C: between the neighbours; c(p): between them and p
//! ```
//!
//! It passes through the values of lattice points. The covariance decides about the rest: how smooth it is, whether it
//! swings. As the values are uncorrelated, whatever was asked, noise has a covariance only near it (section 3.3).
//!
//! | file | what it is |
//! |---|---|
//! | `covariance` | the covariances over distance, and the options that name them |
//! | `solve`, `solved` | C⁻¹ |
//! | `cells` | points, cells, and the values about them |
//! | `weights`, `separable` | the gaussian, a product over axes: weights C⁻¹c axis by axis |
//! | `radial` | any other: ηᵗC⁻¹ once a cell |
//! | `error` | the expected squared error |
//!
//! Values are nearly gaussian: for jointly gaussian data this is the best of all interpolations, not of the linear ones
//! only, and it is distributed alike at lattice points and between, where it sums many values.

mod cells;
mod covariance;
mod error;
mod radial;
mod separable;
mod solve;
mod solved;
mod table;
#[cfg(test)]
mod tests;
mod weights;

pub use error::wiener_error;

use super::field::ByTiles;
use super::kind::{Contract, Kind, Made, Smoothness, Unfit};
use super::lattice::Lattice;
use super::options::{Opt, Params};
use cells::{Period, VALUE_DEVIATION};
use covariance::Covariance;
use radial::Radial;
use separable::Separable;
use solved::Solved;
use std::sync::Arc;
use weights::{Exact, Weights};

/// Wiener interpolation of random values.
pub static KIND: Kind = Kind {
    name: "wiener",
    brief: "random values at lattice points, interpolated with the least expected error for a covariance",
    dimensions: 1..=4,
    options: &[Opt::Period, Opt::Covariance, Opt::Width, Opt::Frequency, Opt::Knots, Opt::Neighbours],
    contract: Contract {
        // Values of lattice points are at most 3.465 of their deviations, and the sum of the weights' sizes at most
        // 1.2082 an axis, in the middle of a cell.
        bounds: &[[-1.172, 1.172], [-1.586, 1.586], [-2.147, 2.147], [-2.905, 2.905]],
        mean: 0.0,
        deviation: DEVIATION as f32,
        lattice: "random, nearly gaussian, in -1.22 … 1.22",
        // The value is continuous to the bit; the slope jumps by 7 % of its root mean square.
        smoothness: Smoothness::C0,
        cost: 6.0,
        source: "Lewis 1989, section 3",
        remarks: REMARKS,
    },
    make: |dimensions, params| {
        let covariance = Covariance::new(dimensions, params)?;
        match (covariance.is_product(), neighbours(params)?) {
            (true, 3) => product::<3>(dimensions, params, &covariance),
            (true, _) => product::<4>(dimensions, params, &covariance),
            (false, points) => any(dimensions, points, params, &covariance),
        }
    },
};

/// Measured in three dimensions, as is the cost, of scattered points. Neighbouring points in one cell share its values: along
/// a scan line of 1/100 unit a pixel the gaussian costs 1.4. Other covariances cost 18 there, and 23 if scattered.
const REMARKS: &str = "The deviation is ¼ for all options: the values of lattice points are scaled so. Of two million points all were \
within ±1.15. In plane sections 40 % of the energy lies below 0.3 cycles a unit, 58 % from there to 0.7, nothing above 1. \
The variance is 0.42 of the mean one in the middle of cells, and twice that at lattice points. `wiener_error(p)` is the \
expected squared error.

- `covariance`: `gaussian`, of `width` 0.25 to 2 (0.5 if not given), or `oscillatory`, a gaussian of `width` (0.7) times the \
  mean of waves of `frequency` (0.75) in all directions, which is the covariance of a band of frequencies: 65 % of the energy in \
  plane sections lies from 0.5 to 1. But that is finer than the lattice, and such noise gathers about its points: there \
  the variance is 6 times the mean one, in the middle of cells 0.08. Or `knots`, its values at equal steps of distance from 0 \
  to 2; beyond, the last one holds. Only their ratios count. In four dimensions there is the gaussian only.
- The values are uncorrelated, so the covariance is but near that asked for: the gaussian's within 0.10 of the variance (0.25 at \
  width 0.25, 0.17 at 0.6, 0.36 at 0.8), that of `oscillatory` noise within 0.13. `oscillatory` and `knots` are refused if they \
  leave lattice points so alike that C is hardly positive definite.
- The values of lattice points are kept exactly; by `oscillatory` and `knots` within 1e-5.
- `neighbours`: 4, those about the cell, or 3, those about the nearest lattice point, at about half the cost. They change \
  from cell to cell. The gaussian of 4 is continuous there, its slope jumps by 7 % of its rms (0.2 % at width 0.35, 16 % at 0.6, \
  45 % at 1). `oscillatory` noise of 4 jumps by 1 % of the deviation (rms; at most 6 %), that of knots \
  `[1 0.6 0.13 0.02 0]` by 0.3 % (1.4 %). With 3 cells end half-way between lattice points, and the gaussian jumps by 10 % (48 %), \
  `oscillatory` noise by 6 % (33 %), that of those knots by 8 % (36 %): the cells can be seen.";

/// The standard deviation, whatever the options: a gaussian noise is then within ±1 nearly always.
const DEVIATION: f64 = 0.25;

/// How many neighbours along each axis.
fn neighbours(params: &Params) -> Result<usize, Unfit> {
    match params.vector(Opt::Neighbours) {
        None | Some([4.0]) => Ok(4),
        Some([3.0]) => Ok(3),
        Some([found]) => Err(Unfit::of(Opt::Neighbours, format!("neighbours must be 3 or 4, found {found}"))),
        Some(found) => Err(Unfit::of(
            Opt::Neighbours,
            format!("neighbours is a number, 3 or 4, found a vector of {}", found.len()),
        )),
    }
}

/// What values are multiplied by, if of values of variance 1 noise would have this one.
fn unit(variance: f64) -> f32 {
    (DEVIATION / (VALUE_DEVIATION * variance.sqrt())) as f32
}

/// The lattice that the parameters tell of.
fn lattice<const D: usize>(params: &Params) -> Result<Lattice<Period<D>, D>, Unfit> {
    Ok(Lattice::new(params.seed, Period(params.period::<D>()?)))
}

/// The field of a covariance that is a product over axes.
fn product<const N: usize>(dimensions: usize, params: &Params, covariance: &Covariance) -> Made {
    fn of<const D: usize, const ROWS: usize, const N: usize>(params: &Params, exact: &Exact<'_>) -> Made {
        let unit = unit((0..D).map(|_| exact.variance()).product());
        Ok(Arc::new(ByTiles(Separable::<D, ROWS, N> {
            lattice: lattice(params)?,
            weights: Weights::new::<N>(exact),
            unit,
        })))
    }
    let exact = Exact::new(covariance, N);
    match dimensions {
        1 => of::<1, 1, N>(params, &exact),
        2 => of::<2, 4, N>(params, &exact),
        3 => of::<3, 16, N>(params, &exact),
        _ => of::<4, 64, N>(params, &exact),
    }
}

/// The field of any covariance.
fn any(dimensions: usize, points: usize, params: &Params, covariance: &Covariance) -> Made {
    fn of<const D: usize, const SIDE: usize, const COUNT: usize>(
        points: usize,
        params: &Params,
        covariance: &Covariance,
    ) -> Made {
        let solved = Solved::<D, SIDE, COUNT>::new(points, covariance)?;
        Ok(Arc::new(ByTiles(Radial { lattice: lattice(params)?, unit: unit(solved.variance), solved })))
    }
    match dimensions {
        1 => of::<1, 2, 4>(points, params, covariance),
        2 => of::<2, 4, 16>(points, params, covariance),
        _ => of::<3, 8, 64>(points, params, covariance),
    }
}
