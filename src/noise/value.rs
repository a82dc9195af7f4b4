//! Value noise: Peachey, "Value Noise".
//!
//! Each lattice point has a random value. Through the values goes the Catmull-Rom spline, along each axis in
//! turn, which makes the noise a weighted sum of the 4^D values about a point.

use super::kind::{Contract, Kind, Smoothness};
use super::lattice::{Lattice, Wrap, lattice_field};
use super::options::Opt;
use super::tensor::{ByRows, Row, Rows, catmull_rom, catmull_rom_slopes};

/// Value noise.
pub static KIND: Kind = Kind {
    name: "value",
    brief: "random values at lattice points, Catmull-Rom spline",
    dimensions: 1..=4,
    options: &[Opt::Period],
    contract: Contract {
        // The sum of the sizes of the weights, the most in the middle: 1.25 for each axis.
        bounds: &[[-1.25, 1.25], [-1.563, 1.563], [-1.954, 1.954], [-2.442, 2.442]],
        mean: 0.0,
        deviation: 0.424,
        lattice: "even in -1 … 1",
        smoothness: Smoothness::C1,
        cost: 3.0,
        source: "Peachey, \"Value Noise\"",
        remarks: "The noise for those who want low frequencies: 41 % of its energy lies below 0.3 cycles a \
                  unit, and 0.01 % above 1. It passes through its random values; its second derivative \
                  jumps from cell to cell. Its deviation is 0.58 at lattice points and 0.3 in the middle of \
                  cells. Of four million points all were within ±1.3.",
    },
    make: |d, params| lattice_field!(d, params, [1 2 3 4], |lattice| ByRows(Value { lattice })),
};

struct Value<W, const D: usize> {
    lattice: Lattice<W, D>,
}

/// The random values of lattice points, even in -2^31 … 2^31: their bits serve as integers.
#[inline(always)]
pub(super) fn values(hashes: [u32; 4]) -> [f32; 4] {
    let [a, b, c, d] = hashes;
    [a as i32 as f32, b as i32 as f32, c as i32 as f32, d as i32 as f32]
}

/// What makes them ±1.
pub(super) const SCALE: f32 = 1.0 / (1_u32 << 31) as f32;

impl<W: Wrap<D>, const D: usize> Rows<D> for Value<W, D> {
    type Wrap = W;
    const SCALE: f32 = SCALE;

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
        row.weigh(values(row.hashes))
    }

    #[inline(always)]
    fn derivative<const CORNERS: bool>(&self, row: &Row<D>) -> [f32; D] {
        row.weigh_slopes(values(row.hashes))
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
        assert_eq!(pinned(&KIND, &Params::default()), [0x3ded_bb53, 0x3ee0_32be, 0x3f02_7bd8, 0x3e37_0c67]);
    }

    #[test]
    fn it_is_what_the_formula_says() {
        is_sum_over_lattice(&KIND, &Params::seeded(9), |hash, offset| {
            value_of(hash) * offset.iter().map(|&x| catmull_rom(x)).product::<f64>()
        });
    }

    #[test]
    fn it_passes_through_its_values() {
        for d in 1..=4 {
            let p: Vec<Vec<f32>> =
                points(d, 100, 9e5).iter().map(|p| p.iter().map(|x| x.floor()).collect()).collect();
            for (i, &found) in noise(&KIND, &Params::seeded(5), &p).iter().enumerate() {
                let at: Vec<f64> = p.iter().map(|p| f64::from(p[i])).collect();
                assert_eq!(found, value_of(hash_at(5, &at)) as f32);
            }
        }
    }
}
