//! Value-gradient noise: Peachey, "Value-Gradient Noise", the weighted sum.
//!
//! Value noise, which has low frequencies, and gradient noise, which has few but is 0 at all lattice points,
//! on one lattice. The numbers of a lattice point for the one are unrelated to those for the other.

// Loops over axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::direction::{LENGTH, along, direction};
use super::hash::more;
use super::kind::{Contract, Kind, Smoothness, Unfit};
use super::lattice::{Lattice, Wrap, lattice_field};
use super::options::{Opt, Params};
use super::tensor::{ByRows, Row, Rows, catmull_rom, catmull_rom_slopes};
use super::value;
use crate::lanes::array;

/// Value-gradient noise.
pub static KIND: Kind = Kind {
    name: "value_gradient",
    brief: "a sum of value noise and gradient noise",
    dimensions: 1..=4,
    options: &[Opt::Period, Opt::Weights],
    contract: Contract {
        // Half of those of `value` and half of those of `gradient`, which are reached in the middle of a
        // cell.
        bounds: &[[-1.0, 1.0], [-1.312, 1.312], [-1.627, 1.627], [-1.972, 1.972]],
        mean: 0.0,
        deviation: 0.252,
        lattice: "even in -½ … ½",
        smoothness: Smoothness::C1,
        cost: 4.7,
        source: "Peachey, \"Value-Gradient Noise\"",
        remarks: "With `weights = [1 0]` it is `value` of the same seed, with `[0 1]` a gradient noise, unrelated \
                  to `gradient` of that seed. By halves the value noise has 70 % of the energy; 34 % of the \
                  whole lies below 0.3 cycles a unit, 0.4 % above 1. Of four million points all were within \
                  ±1.02.",
    },
    make: |d, params| {
        let [value, gradient] = weights(params)?;
        lattice_field!(d, params, [1 2 3 4], |lattice| ByRows(ValueGradient { lattice, value, gradient }))
    },
};

struct ValueGradient<W, const D: usize> {
    lattice: Lattice<W, D>,
    /// The weight of value noise.
    value: f32,
    /// The weight of gradient noise.
    gradient: f32,
}

/// The weights that are given, or halves.
fn weights(params: &Params) -> Result<[f32; 2], Unfit> {
    const MOST: f32 = 1000.0;
    let Some(given) = params.vector(Opt::Weights) else { return Ok([0.5; 2]) };
    let weights: [f32; 2] = given.try_into().map_err(|_| {
        let message = format!(
            "weights needs two numbers, of the value noise and of the gradient noise, found {}",
            given.len()
        );
        Unfit::of(Opt::Weights, message)
    })?;
    match weights.iter().find(|w| !(-MOST..=MOST).contains(*w)) {
        None if weights == [0.0; 2] => Err(Unfit::of(Opt::Weights, "weights must not both be 0".to_string())),
        None => Ok(weights),
        Some(w) => Err(Unfit::of(Opt::Weights, format!("weights must be from -{MOST} to {MOST}, found {w}"))),
    }
}

/// What the gradient noise is multiplied by, as in `gradient`.
const STEEPNESS: f32 = 1.5 * (1_u32 << 31) as f32 / LENGTH;

/// The weight of a corner along an axis, `at` being 0 for the lower and 1 for the upper one, and its
/// derivative.
#[inline(always)]
fn corner_weight(t: f32, at: f32) -> (f32, f32) {
    let turn = at + at - 1.0;
    ((1.0 - at) + turn * (t * t * (3.0 - 2.0 * t)), turn * (6.0 * t * (1.0 - t)))
}

/// What the two corners in a row give to gradient noise.
#[inline(always)]
fn corners<const D: usize>(row: &Row<D>) -> f32 {
    let mut sum = 0.0;
    for corner in 0..2 {
        let (hash, at) = (row.hashes[1 + corner], corner as f32);
        let mut offset = [row.t[0] - at; D];
        for k in 1..D {
            offset[k] = row.t[k] - row.place[k];
        }
        sum += along(more(hash), offset) * corner_weight(row.t[0], at).0;
    }
    for k in 1..D {
        sum *= corner_weight(row.t[k], row.place[k]).0;
    }
    sum
}

/// The derivative of that.
#[inline(always)]
fn corners_derivative<const D: usize>(row: &Row<D>) -> [f32; D] {
    let mut sum = [0.0; D];
    for corner in 0..2 {
        let (hash, at) = (row.hashes[1 + corner], corner as f32);
        let (mut offset, mut weight, mut slope) = ([0.0; D], [0.0; D], [0.0; D]);
        for k in 0..D {
            let at = if k == 0 { at } else { row.place[k] };
            offset[k] = row.t[k] - at;
            (weight[k], slope[k]) = corner_weight(row.t[k], at);
        }
        let (height, direction) = (along(more(hash), offset), direction::<D>(more(hash)));
        for k in 0..D {
            let mut part = height * slope[k] + direction[k] * weight[k];
            for axis in 0..D {
                part *= if axis == k { 1.0 } else { weight[axis] };
            }
            sum[k] += part;
        }
    }
    sum
}

impl<W: Wrap<D>, const D: usize> Rows<D> for ValueGradient<W, D> {
    type Wrap = W;
    const SCALE: f32 = value::SCALE;
    const CORNERS: bool = true;

    #[inline(always)]
    fn lattice(&self) -> &Lattice<W, D> {
        &self.lattice
    }

    #[inline(always)]
    fn factors(t: f32) -> [f32; 4] {
        catmull_rom(t)
    }

    #[inline(always)]
    fn slopes(t: f32) -> [f32; 4] {
        catmull_rom_slopes(t)
    }

    #[inline(always)]
    fn part<const CORNERS: bool>(&self, row: &Row<D>) -> f32 {
        let value = row.weigh(value::values(row.hashes)) * self.value;
        if CORNERS { value + corners(row) * (STEEPNESS * self.gradient) } else { value }
    }

    #[inline(always)]
    fn derivative<const CORNERS: bool>(&self, row: &Row<D>) -> [f32; D] {
        let slopes = row.weigh_slopes(value::values(row.hashes));
        let value: [f32; D] = array(|k| slopes[k] * self.value);
        if !CORNERS {
            return value;
        }
        let gradient = corners_derivative(row);
        array(|k| value[k] + gradient[k] * (STEEPNESS * self.gradient))
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::*;
    use super::{KIND, more};
    use crate::noise::{Kind, Opt, Params};

    #[test]
    fn as_usual() {
        usual(&KIND, &Params::seeded(3));
        usual(&KIND, &Params::seeded(4).with(Opt::Weights, &[-0.25, 2.0]));
        assert_eq!(pinned(&KIND, &Params::default()), [0xbdaa_7f50, 0x3e05_b32b, 0x3e5f_7623, 0xba2c_f0af]);
    }

    #[test]
    fn it_is_what_the_formula_says() {
        for [value, gradient] in [[0.5, 0.5], [0.0, 1.0], [1.0, -0.75]] {
            let params = Params::seeded(9);
            let given = params.clone().with(Opt::Weights, &[value as f32, gradient as f32]);
            is_sum_over_lattice(&KIND, if value == 0.5 { &params } else { &given }, |hash, offset| {
                let g = gradient_of(more(hash), offset.len());
                let height: f64 = g.iter().zip(offset).map(|(g, x)| g * x).sum();
                let product = |kernel: fn(f64) -> f64| offset.iter().map(|&x| kernel(x)).product::<f64>();
                value * value_of(hash) * product(catmull_rom) + gradient * 1.5 * height * product(cubic)
            });
        }
    }

    #[test]
    fn with_one_weight_it_is_value_noise() {
        let params = Params::seeded(8);
        let p = points(3, 300, 90.0);
        let value = Kind::from_name("value").unwrap();
        assert_eq!(
            noise(&KIND, &params.clone().with(Opt::Weights, &[1.0, 0.0]), &p),
            noise(value, &params, &p)
        );
    }

    #[test]
    fn weights_are_two_numbers() {
        let message = |weights: &[f32]| {
            let unfit = KIND.field(2, &Params::default().with(Opt::Weights, weights)).err().unwrap();
            assert_eq!(unfit.option, Some(Opt::Weights));
            unfit.message
        };
        assert!(message(&[1.0]).contains("two numbers"));
        assert!(message(&[1.0, 2.0, 3.0]).contains("found 3"));
        assert!(message(&[1.0, f32::INFINITY]).contains("found inf"));
        assert!(message(&[f32::NAN, 1.0]).contains("found NaN"));
    }
}
