//! Lattice convolution noise: Peachey, "Lattice Convolution Noise".
//!
//! Each lattice point has a random value, the size of an impulse; noise is their sum, each times a filter of
//! its distance r. The filter is the Catmull-Rom spline, taken as a radius:
//!
//! | r | filter | |
//! |---|---|---|
//! | 0 … 1 | 1 - 5/2 r² + 3/2 r³ | = (1 - r)(1 + r - 3/2 r²) |
//! | 1 … 2 | 2 - 4r + 5/2 r² - 1/2 r³ | = (1 - r)(2 - r)²/2 |
//! | 2 … | 0 | |
//!
//! It is not a product of functions of the coordinates, so that the axes don't show as in a tensor product.

use super::kind::{Contract, Kind, Smoothness};
use super::lattice::{Lattice, Wrap, lattice_field};
use super::options::Opt;
use super::tensor::{ByRows, Row, Rows, dot};
use super::value;
use crate::lanes::array;

/// Lattice convolution noise.
pub static KIND: Kind = Kind {
    name: "lattice_convolution",
    brief: "random values at lattice points, spread by a radial Catmull-Rom filter",
    dimensions: 1..=4,
    options: &[Opt::Period],
    contract: Contract {
        // The sum of the sizes of the weights, its maximum over a cell found numerically.
        bounds: &[[-1.25, 1.25], [-1.53, 1.53], [-2.283, 2.283], [-3.79, 3.79]],
        mean: 0.0,
        deviation: 0.426,
        lattice: "even in -1 … 1, and a little of the neighbours'",
        smoothness: Smoothness::C1,
        cost: 6.0,
        source: "Peachey, \"Lattice Convolution Noise\"",
        remarks: "The filter's second derivative jumps at the distances 1 and 2 and is continuous at 0. \
                  Peachey reads the filter from a table; here it is computed exactly. In three dimensions \
                  its integral is 0, so that low frequencies are few, 27 % below 0.3 cycles a unit, and \
                  none at 0; 0.05 % lies above 1. The noise looks the same in all directions but not at all \
                  places: its deviation is 0.6 at lattice points and 0.2 in the middle of cells. Of four \
                  million points all were within ±1.6. In one dimension it is `value`, but for rounding.",
    },
    make: |d, params| lattice_field!(d, params, [1 2 3 4], |lattice| ByRows(Convolution { lattice })),
};

struct Convolution<W, const D: usize> {
    lattice: Lattice<W, D>,
}

/// The filter.
#[inline(always)]
fn filter(r: f32) -> f32 {
    // (Comparisons so that NaN is not lost.)
    let rest = if r > 2.0 { 0.0 } else { 2.0 - r };
    (1.0 - r) * if r < 1.0 { 1.0 + r * (1.0 - 1.5 * r) } else { 0.5 * rest * rest }
}

/// The derivative of the filter, divided by r: times an offset, the derivative along that axis.
#[inline(always)]
fn slope_by_distance(r: f32) -> f32 {
    let rest = if r > 2.0 { 0.0 } else { 2.0 - r };
    // Outside of 1 the derivative is (2 - r)(3r - 4)/2.
    if r < 1.0 { 4.5 * r - 5.0 } else { rest * (1.5 - 2.0 / r) }
}

impl<W, const D: usize> Convolution<W, D> {
    /// The distances of the points of a row.
    #[inline(always)]
    fn distances(row: &Row<D>) -> [f32; 4] {
        let line = (1..D).fold(0.0, |sum, k| sum + row.line_factors[k]);
        array(|i| (row.factors[i] + line).sqrt())
    }
}

impl<W: Wrap<D>, const D: usize> Rows<D> for Convolution<W, D> {
    type Wrap = W;
    const SCALE: f32 = value::SCALE;

    #[inline(always)]
    fn lattice(&self) -> &Lattice<W, D> {
        &self.lattice
    }

    /// Distances squared.
    #[inline(always)]
    fn factors(t: f32) -> [f32; 4] {
        {
            let slopes = Self::slopes(t);
            array(|i| slopes[i] * slopes[i])
        }
    }

    /// Offsets.
    #[inline(always)]
    fn slopes(t: f32) -> [f32; 4] {
        [t + 1.0, t, t - 1.0, t - 2.0]
    }

    #[inline(always)]
    fn part<const CORNERS: bool>(&self, row: &Row<D>) -> f32 {
        dot(value::values(row.hashes), {
            let r = Self::distances(row);
            array(|i| filter(r[i]))
        })
    }

    #[inline(always)]
    fn derivative<const CORNERS: bool>(&self, row: &Row<D>) -> [f32; D] {
        let (values, r) = (value::values(row.hashes), Self::distances(row));
        let pulls: [f32; 4] = array(|i| values[i] * slope_by_distance(r[i]));
        let all = (pulls[0] + pulls[1]) + (pulls[2] + pulls[3]);
        let mut gradient = array(|k| row.line_slopes[k] * all);
        gradient[0] = dot(pulls, row.slopes);
        gradient
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::*;
    use super::KIND;
    use crate::noise::Params;

    #[test]
    fn as_usual() {
        usual(&KIND, &Params::seeded(3));
        assert_eq!(pinned(&KIND, &Params::default()), [0x3ded_bb53, 0x3ee9_1a50, 0x3ef7_901c, 0xbe14_34da]);
    }

    #[test]
    fn it_is_what_the_formula_says() {
        is_sum_over_lattice(&KIND, &Params::seeded(9), |hash, offset| {
            value_of(hash) * catmull_rom(offset.iter().map(|x| x * x).sum::<f64>().sqrt())
        });
    }

    #[test]
    fn all_lattice_points_within_reach_are_counted() {
        // A move over a cell's face changes which 4^D they are.
        let p = points(3, 2000, 50.0);
        for k in 0..3 {
            let at = |step: f32| {
                let mut p = p.clone();
                p[k].iter_mut().for_each(|x| *x = x.floor() + step);
                noise(&KIND, &Params::default(), &p)
            };
            assert!(at(-1e-5).iter().zip(at(1e-5)).all(|(a, b)| (a - b).abs() < 1.2e-4));
        }
    }
}
