//! Lattice white noise: Lewis 1989, section 2.2.
//!
//! A random value for each unit cell, the same in all of it: what a hash of the coordinates without their
//! fractions gives. The other lattice noises are made of such numbers by interpolation.

use super::field::{Each, Jet, Pointwise};
use super::hash;
use super::kind::{Contract, Kind, Smoothness};
use super::lattice::{Lattice, Wrap, lattice_field};
use super::options::Opt;

/// Lattice white noise.
pub static KIND: Kind = Kind {
    name: "white",
    brief: "a random value for each unit cell, nothing between",
    dimensions: 1..=4,
    options: &[Opt::Period],
    contract: Contract {
        bounds: &[[-1.0, 1.0]; 4],
        mean: 0.0,
        // √⅓.
        deviation: 0.577,
        lattice: "even in -1 … 1",
        smoothness: Smoothness::Discontinuous,
        cost: 0.4,
        source: "Lewis 1989, section 2.2",
        remarks: "Its derivative is 0. It has energy at all frequencies, so pictures of it alias.",
    },
    make: |d, params| lattice_field!(d, params, [1 2 3 4], |lattice| Each(White { lattice })),
};

#[derive(Clone, Copy)]
struct White<W, const D: usize> {
    lattice: Lattice<W, D>,
}

/// 0 if all coordinates are numbers, else NaN.
#[inline(always)]
fn flat<const D: usize>(p: [f32; D]) -> f32 {
    p.iter().fold(0.0, |sum, x| sum + x * 0.0)
}

impl<W: Wrap<D>, const D: usize> Pointwise<D> for White<W, D> {
    #[inline(always)]
    fn value(&self, p: [f32; D]) -> f32 {
        const UNIT: f32 = 1.0 / (1_u32 << 31) as f32;
        let mut joined = 0;
        for (k, x) in p.iter().enumerate() {
            joined ^= self.lattice.key(k, x.floor());
        }
        hash::point(joined) as i32 as f32 * UNIT + flat(p)
    }

    #[inline(always)]
    fn jet(&self, p: [f32; D]) -> Jet<D> {
        Jet { value: self.value(p), gradient: [flat(p); D] }
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
        assert_eq!(pinned(&KIND, &Params::default()), [0xbf0e_fcb6, 0x3e97_7b4c, 0x3f7f_942c, 0xbf72_490c]);
    }

    #[test]
    fn it_is_one_value_a_cell_everywhere_level() {
        for d in 1..=4 {
            let p = points(d, 1000, 900.0);
            let values = noise(&KIND, &Params::seeded(5), &p);
            for (i, &found) in values.iter().enumerate() {
                let at: Vec<f64> = p.iter().map(|p| f64::from(p[i]).floor()).collect();
                assert_eq!(found, value_of(hash_at(5, &at)) as f32);
            }
            let slopes = derivative(&KIND, &Params::seeded(5), &p);
            assert!(slopes.iter().flatten().all(|&s| s == 0.0));
        }
    }

    #[test]
    fn values_are_even_and_neighbours_unrelated() {
        const N: usize = 1 << 17;
        let cells: Vec<Vec<f32>> =
            (0..3).map(|k| (0..N).map(|i| (i >> (6 * k) & 63) as f32 + 0.5).collect()).collect();
        let values = noise(&KIND, &Params::default(), &cells);
        let mut counts = [0; 16];
        values.iter().for_each(|v| counts[((v + 1.0) * 7.999_999) as usize] += 1);
        assert!(counts.iter().all(|&c: &i32| (c - (N / 16) as i32).abs() < 400), "{counts:?}");
        for shift in [1, 2, 3, 64, 65, 63, 4096, 4160] {
            let products = values.iter().zip(&values[shift..]).map(|(a, b)| f64::from(a * b));
            let correlation = products.sum::<f64>() * 3.0 / (N - shift) as f64;
            assert!(correlation.abs() < 0.012, "{shift}: {correlation}");
        }
    }
}
