//! Hermite noise: Ward, "A Recursive Implementation of the Perlin Noise Function", Graphics Gems II, 1991, as
//! Peachey describes it in "Value-Gradient Noise".
//!
//! Each lattice point has a random value and a random gradient. Along each axis in turn goes the cubic that
//! has the values of its two ends and, for slopes there, the gradients' components along the axis; the other
//! components go from end to end with the weights 3t² - 2t³.
//!
//! Those are also the weights of the ends' values in the cubic, h₀₁ = 3t² - 2t³ and h₀₀ = 1 - h₀₁. So in what
//! comes out each corner c has the product Wc of its weights along all axes, and its slope along an axis has
//! that product with h₁₀ = t(1-t)² in place of h₀₀, or h₁₁ = t²(t-1) in place of h₀₁:
//!
//! noise = Σc Wc (valuec + gradientc · uc), where along each axis u is h₁₀/h₀₀ = t/(1+2t) at the lower corner
//! and h₁₁/h₀₁ = (t-1)/(3-2t) at the upper one.
//!
//! That does not depend on the order of the axes. It is Perlin's noise of 1985 but for the offsets u, which
//! are t and t - 1 there.

use super::kind::{Contract, Kind, Smoothness};
use super::lattice::lattice_field;
use super::linear::{Linear, Planes};
use super::options::Opt;

/// Hermite noise.
pub static KIND: Kind = Kind {
    name: "hermite",
    brief: "random values and gradients at lattice points, Hermite spline",
    dimensions: 1..=4,
    options: &[Opt::Period],
    contract: Contract {
        // 1, and the sum of the components of u in the middle of a cell, ¼ each, in four dimensions times √¾.
        bounds: &[[-1.25, 1.25], [-1.5, 1.5], [-1.75, 1.75], [-1.8661, 1.8661]],
        mean: 0.0,
        deviation: 0.384,
        lattice: "even in -1 … 1",
        smoothness: Smoothness::C1,
        cost: 1.4,
        source: "Ward 1991; Peachey, \"Value-Gradient Noise\"",
        remarks: "Its spectrum rises evenly from 0 to its peak near 0.28 cycles a unit and falls evenly to \
                  nothing at 1 (0.35 % lies above): low, and too wide to add up octaves neatly. Components \
                  of the gradients across an axis are not interpolated linearly, which would make the slope \
                  jump from cell to cell. Of four million points all were within ±1.22.",
    },
    make: |d, params| lattice_field!(d, params, [1 2 3 4], |lattice| Linear::<Hermite, _, _>::new(lattice)),
};

#[derive(Clone, Copy, Debug)]
struct Hermite;

impl Planes for Hermite {
    const SCALE: f32 = 1.0;
    /// As much as a component of a gradient.
    const VALUE: f32 = 1.0;
    const STRETCHES: bool = true;

    #[inline(always)]
    fn offsets(t: f32) -> [f32; 2] {
        [t / (1.0 + 2.0 * t), (t - 1.0) / (3.0 - 2.0 * t)]
    }

    #[inline(always)]
    fn stretches(t: f32) -> [f32; 2] {
        let (lower, upper) = (1.0 / (1.0 + 2.0 * t), 1.0 / (3.0 - 2.0 * t));
        [lower * lower, upper * upper]
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
        assert_eq!(pinned(&KIND, &Params::default()), [0x3dab_6990, 0xbe45_31e1, 0x3e63_1d75, 0xbd11_a99e]);
    }

    #[test]
    fn it_is_what_the_formula_says() {
        // The cubic whose slope is 1 at a lattice point, and value and slope 0 at its neighbours.
        let slope = |x: f64| if x.abs() < 1.0 { x * (1.0 - x.abs()) * (1.0 - x.abs()) } else { 0.0 };
        is_sum_over_planes(&KIND, &Params::seeded(9), |value, gradient, offset| {
            let product = |axis: usize| -> f64 {
                let along = |k: usize| if k == axis { slope(offset[k]) } else { cubic(offset[k]) };
                (0..offset.len()).map(along).product()
            };
            let sloping: f64 = gradient.iter().enumerate().map(|(k, g)| g * product(k)).sum();
            value * product(usize::MAX) + sloping
        });
    }

    #[test]
    fn lattice_points_have_their_values_and_gradients() {
        let p =
            points(3, 100, 900.0).iter().map(|p| p.iter().map(|x| x.floor()).collect()).collect::<Vec<_>>();
        let (values, slopes) =
            (noise(&KIND, &Params::seeded(5), &p), derivative(&KIND, &Params::seeded(5), &p));
        for i in 0..100 {
            let (value, gradient) = plane_at(5, &[0, 1, 2].map(|k: usize| f64::from(p[k][i])));
            assert!((f64::from(values[i]) - value).abs() < 1e-6);
            for (slope, known) in slopes.iter().zip(gradient) {
                assert!((f64::from(slope[i]) - known).abs() < 1e-6);
            }
        }
    }
}
