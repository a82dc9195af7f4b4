//! Improved noise: Perlin, "Improving Noise", SIGGRAPH 2002.
//!
//! It is gradient noise with weights of the fifth degree, 6t⁵ - 15t⁴ + 10t³, whose second derivatives too are
//! 0 at the ends: those of the noise are continuous from cell to cell, so that what is lit by its derivative
//! shows no lattice. (With cubic weights they jump at the faces.) What the paper changes in the gradients is
//! not taken over, as the remarks say.

use super::kind::{Contract, Kind, Smoothness};
use super::lattice::lattice_field;
use super::linear::{Linear, Planes};
use super::options::Opt;

/// Improved noise, 2002.
pub static KIND: Kind = Kind {
    name: "improved",
    brief: "random gradients at lattice points, weights of the fifth degree",
    dimensions: 1..=4,
    options: &[Opt::Period],
    contract: Contract {
        // 1.2 times the sum of the offsets from the middle of a cell to its corners, in four dimensions times √¾.
        bounds: &[[-0.6, 0.6], [-1.2, 1.2], [-1.8, 1.8], [-2.0785, 2.0785]],
        mean: 0.0,
        deviation: 0.229,
        lattice: "0",
        smoothness: Smoothness::C2,
        cost: 1.2,
        source: "Perlin 2002, \"Improving Noise\"",
        remarks: "The paper also takes the middles of a cube's edges for gradients, twelve of them: that \
                  spares multiplications, and keeps gradients off the axes. Here they are even in \
                  a cube, as for `gradient`, so that all directions have the same energy. Twice the energy of \
                  `gradient`, 2.7 %, lies above one cycle a unit: the price of steeper weights. Of four \
                  million points all were within ±1.03.",
    },
    make: |d, params| lattice_field!(d, params, [1 2 3 4], |lattice| Linear::<Improved, _, _>::new(lattice)),
};

#[derive(Clone, Copy, Debug)]
struct Improved;

impl Planes for Improved {
    const SCALE: f32 = 1.2;
    const VALUE: f32 = 0.0;

    #[inline(always)]
    fn weight(t: f32) -> (f32, f32) {
        let s = t * (1.0 - t);
        (t * t * t * (10.0 + t * (6.0 * t - 15.0)), 30.0 * s * s)
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
        assert_eq!(pinned(&KIND, &Params::default()), [0xbdd4_6978, 0xbee1_3b42, 0x3e31_8417, 0x3dfe_3ce0]);
    }

    #[test]
    fn it_is_what_the_formula_says() {
        let weight = |x: f64| {
            let t = 1.0 - x.abs();
            if t > 0.0 { t * t * t * (10.0 - 15.0 * t + 6.0 * t * t) } else { 0.0 }
        };
        is_sum_over_planes(&KIND, &Params::seeded(9), |_, gradient, offset| {
            let height: f64 = gradient.iter().zip(offset).map(|(g, x)| g * x).sum();
            1.2 * height * offset.iter().map(|&x| weight(x)).product::<f64>()
        });
    }

    #[test]
    fn lattice_points_are_zero_and_level_in_the_second_derivative() {
        let p =
            points(3, 500, 900.0).iter().map(|p| p.iter().map(|x| x.floor()).collect()).collect::<Vec<_>>();
        assert!(noise(&KIND, &Params::default(), &p).iter().all(|&n| n == 0.0));
        // Over a cell face the slope changes as fast on one side as on the other.
        let face = points(3, 500, 90.0);
        let slope = |step: f32| {
            let x = face[0].iter().map(|x| x.floor() + step).collect();
            derivative(&KIND, &Params::default(), &[x, face[1].clone(), face[2].clone()])
        };
        const H: f32 = 1.0 / 512.0;
        let (before, at, after) = (slope(-H), slope(0.0), slope(H));
        for i in 0..500 {
            let (left, right) = ((at[0][i] - before[0][i]) / H, (after[0][i] - at[0][i]) / H);
            // The third derivative is below 90, over a step.
            assert!((left - right).abs() < 90.0 * H, "{left} {right}");
        }
    }
}
