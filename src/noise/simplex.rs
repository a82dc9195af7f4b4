//! Simplex noise: Perlin, "Noise hardware", SIGGRAPH course notes on real-time shading, 2001; the geometry as
//! S. Gustavson explains it, "Simplex noise demystified", 2005.
//!
//! Space is cut into cubes, each of them along its main diagonal into simplices, and all is squeezed along
//! that diagonal until the simplices are as regular as they get (triangles are, tetrahedra nearly). Each
//! corner has a random gradient g and gives the noise a surflet (½ - r²)⁴ (g · r), where r is the way from
//! the corner to the point and r² < ½. That far are a corner's simplices' opposite faces: a point meets only
//! the surflets of its own simplex's corners, and none breaks off at a face.
//!
//! Squeezing maps a point s to p = s - G Σs, and s = p + F Σp undoes it, where R = √(D + 1), F = (R - 1) / D
//! and G = F / R. Far out, F Σp would have lost its digits. So the point is cut into whole numbers b and a
//! rest, and F Σb into a whole number W and a rest h; in three dimensions F = ⅓ and h is exact, in others it
//! comes from f64. The cube then is b + W + c, where c is the floor of small numbers, and as seen from its
//! lowest corner the point is (p - b) - c + h / R + G Σc, where all large numbers have dropped out.
//!
//! In one and two dimensions gradients are the first components of those in three, so some are short.
//!
//! - Where Σb is ±2^24 or beyond, noise is 0.
//! - NaN and infinities give NaN.

// Loops over axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::direction::{LENGTH, along, direction};
use super::field::{ByTiles, Each, Jet, Pointwise};
use super::hash;
use super::kind::{Contract, Kind, Smoothness};
use super::lattice::{Endless, Lattice};
use super::related_seed;
use crate::lanes::array;
use std::sync::Arc;

/// Simplex noise, 2001.
pub static KIND: Kind = Kind {
    name: "simplex",
    brief: "random gradients at the corners of simplices, each with a surflet of its own",
    dimensions: 1..=4,
    options: &[],
    contract: Contract {
        // By `SCALES`: what comes out if all gradients point along r.
        bounds: &[[-1.0, 1.0]; 4],
        mean: 0.0,
        deviation: 0.388,
        lattice: "any: its lattice is another, skewed one; the origin belongs to both, and there it is 0",
        smoothness: Smoothness::C3,
        cost: 1.3,
        source: "Perlin 2001, \"Noise hardware\"; Gustavson 2005",
        remarks: "Its frequencies are about 1.9 times those of `gradient`: in three dimensions 22 % of its \
            energy are below 0.6 cycles a unit, 57 % from there to 1.25. Fewer coordinates are not a section \
            of the noise of more. The standard deviation is 0.32, 0.44, 0.388 and 0.253 in 1, 2, 3 and 4 \
            dimensions. In four dimensions, planes along two axes vary in contrast.",
    },
    make: |dimensions, params| {
        let seed = related_seed(params.seed, SALT);
        Ok(match dimensions {
            1 => Arc::new(ByTiles::<_, 1>(Each(Simplex(Lattice::new(seed, Endless))))),
            2 => Arc::new(ByTiles::<_, 2>(Each(Simplex(Lattice::new(seed, Endless))))),
            3 => Arc::new(ByTiles::<_, 3>(Each(Simplex(Lattice::new(seed, Endless))))),
            _ => Arc::new(ByTiles::<_, 4>(Each(Simplex(Lattice::new(seed, Endless))))),
        })
    },
};

/// So that it has not the hashes of the other kinds of that seed.
const SALT: u32 = 0x5349_4D50;

/// For each number of dimensions, what noise is multiplied by: 1 over the greatest sum of (½ - r²)⁴ |r| over
/// the corners (found by search), less 0.03 % as directions are not quite of length 1.
const SCALES: [f32; 4] = [71.49, 99.17, 107.62, 108.53];

/// √(D + 1) for each number of dimensions.
const ROOTS: [f64; 4] = [std::f64::consts::SQRT_2, 1.732_050_807_568_877_2, 2.0, 2.236_067_977_499_79];

/// Simplex noise of a seed.
#[derive(Clone, Copy)]
struct Simplex<const D: usize>(Lattice<Endless, D>);

/// A point within its simplex.
#[derive(Clone, Copy)]
struct Cell<const D: usize> {
    /// Hashes of the lower and the upper side of the cube, by axis; those of the first axis with the seed.
    keys: [[u32; 2]; D],
    /// The point as seen from the lowest corner of the cube, after squeezing.
    offset: [f32; D],
    /// What the sum of surflets is multiplied by.
    scale: f32,
    /// How many of the offset's components are smaller than this; of equal ones the first counts as the
    /// larger.
    rank: [i32; D],
}

impl<const D: usize> Cell<D> {
    const SCALE: f32 = SCALES[D - 1] / LENGTH;
    const ROOT: f64 = ROOTS[D - 1];
    /// What skewing adds to each coordinate is F times their sum.
    const F: f64 = (Self::ROOT - 1.0) / D as f64;
    /// What squeezing takes off is G times the sum.
    const G: f32 = (Self::F / Self::ROOT) as f32;

    /// Finds the simplex of a point.
    #[inline(always)]
    fn new(p: [f32; D], lattice: &Lattice<Endless, D>) -> Cell<D> {
        let (mut low, mut rest) = ([0.0; D], [0.0; D]);
        let (mut whole, mut part) = (0.0, 0.0);
        for k in 0..D {
            low[k] = p[k].floor();
            rest[k] = p[k] - low[k];
            whole += low[k];
            part += rest[k];
        }
        let near = whole.abs() < (1 << 24) as f32;
        let (steps, left) = Self::skewed(if near { whole } else { 0.0 });
        let shift = left + part * Self::F as f32;
        let mut corner = [0.0; D];
        let mut sum = 0.0;
        for k in 0..D {
            corner[k] = (rest[k] + shift).floor();
            sum += corner[k];
        }
        let squeeze = left * (1.0 / Self::ROOT) as f32 + sum * Self::G;
        let scale = if near { Self::SCALE } else { 0.0 };
        let mut cell = Cell { keys: [[0; 2]; D], offset: [0.0; D], scale, rank: [0; D] };
        for k in 0..D {
            let at = low[k] + (steps + corner[k]);
            cell.keys[k] = [lattice.key(k, at), lattice.key(k, at + 1.0)];
            cell.offset[k] = rest[k] - corner[k] + squeeze;
        }
        for k in 0..D {
            for j in 0..k {
                let first = cell.offset[j] >= cell.offset[k];
                cell.rank[j] += i32::from(first);
                cell.rank[k] += i32::from(!first);
            }
        }
        cell
    }

    /// F times a whole number: its whole part, and the rest (about; a number next to 0 … 1 does as well).
    #[inline(always)]
    fn skewed(whole: f32) -> (f32, f32) {
        if D == 3 {
            let third = (whole * (1.0 / 3.0)).floor();
            return (third, (whole - third * 3.0) * (1.0 / 3.0));
        }
        let product = f64::from(whole) * Self::F;
        let floor = product.floor();
        (floor as f32, (product - floor) as f32)
    }

    /// Hash and offset of a corner, so many steps from the cube's lowest: the first step is along the axis
    /// where the offset is largest, and so on, to the cube's highest corner after D.
    #[inline(always)]
    fn corner(&self, steps: usize) -> (u32, [f32; D]) {
        let mut joined = 0;
        let mut offset = [0.0; D];
        for k in 0..D {
            // (No rank is as high as D, nor any below 0, which the compiler need not find out.)
            let up = steps > 0 && (steps == D || self.rank[k] >= (D - steps) as i32);
            joined ^= if up { self.keys[k][1] } else { self.keys[k][0] };
            let back = if up { 1.0 - steps as f32 * Self::G } else { 0.0 - steps as f32 * Self::G };
            offset[k] = self.offset[k] - back;
        }
        (hash::point(joined), offset)
    }

    #[inline(always)]
    fn surflet(&self, steps: usize) -> f32 {
        let (hash, offset) = self.corner(steps);
        let t = fade(offset);
        (t * t) * (t * t) * along(hash, offset)
    }

    #[inline(always)]
    fn surflet_jet(&self, steps: usize) -> Jet<D> {
        let (hash, offset) = self.corner(steps);
        let t = fade(offset);
        let along = along(hash, offset);
        let fourth = (t * t) * (t * t);
        let turn = -8.0 * (t * t * t) * along;
        let mut gradient = direction::<D>(hash);
        for k in 0..D {
            gradient[k] = gradient[k] * fourth + offset[k] * turn;
        }
        Jet { value: fourth * along, gradient }
    }
}

/// ½ - r², and 0 beyond.
#[inline(always)]
fn fade<const D: usize>(offset: [f32; D]) -> f32 {
    let mut t = 0.5;
    for k in 0..D {
        t -= offset[k] * offset[k];
    }
    if t > 0.0 { t } else { 0.0 }
}

#[inline(always)]
fn add<const D: usize>(mut a: Jet<D>, b: Jet<D>) -> Jet<D> {
    a.value += b.value;
    for k in 0..D {
        a.gradient[k] += b.gradient[k];
    }
    a
}

impl<const D: usize> Pointwise<D> for Simplex<D> {
    // Straight code rather than loops over corners, as in `lattice`.

    #[inline(always)]
    fn value(&self, p: [f32; D]) -> f32 {
        let cell = Cell::new(p, &self.0);
        let mut sum = cell.surflet(0) + cell.surflet(1);
        if D > 1 {
            sum += cell.surflet(2);
        }
        if D > 2 {
            sum += cell.surflet(3);
        }
        if D > 3 {
            sum += cell.surflet(4);
        }
        sum * cell.scale
    }

    #[inline(always)]
    fn jet(&self, p: [f32; D]) -> Jet<D> {
        let cell = Cell::new(p, &self.0);
        let mut sum = add(cell.surflet_jet(0), cell.surflet_jet(1));
        if D > 1 {
            sum = add(sum, cell.surflet_jet(2));
        }
        if D > 2 {
            sum = add(sum, cell.surflet_jet(3));
        }
        if D > 3 {
            sum = add(sum, cell.surflet_jet(4));
        }
        Jet { value: sum.value * cell.scale, gradient: array(|k| sum.gradient[k] * cell.scale) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Isa;
    use crate::noise::{Opt, Params};

    fn noise(isa: Isa, p: &[Vec<f32>]) -> Vec<f32> {
        let mut out = vec![0.0; p[0].len()];
        let field = KIND.field(p.len(), &Params::seeded(5)).unwrap();
        field.noise(isa, &p.iter().map(Vec::as_slice).collect::<Vec<_>>(), &mut out);
        out
    }

    fn slopes(isa: Isa, p: &[Vec<f32>]) -> Vec<Vec<f32>> {
        let mut out = vec![vec![0.0; p[0].len()]; p.len()];
        let mut planes: Vec<&mut [f32]> = out.iter_mut().map(Vec::as_mut_slice).collect();
        let field = KIND.field(p.len(), &Params::seeded(5)).unwrap();
        field.derivative(isa, &p.iter().map(Vec::as_slice).collect::<Vec<_>>(), &mut planes);
        out
    }

    /// Points about `far` from the origin, all of whose digits fit.
    fn points(d: usize, n: usize, far: f32) -> Vec<Vec<f32>> {
        let random = |i: usize| hash::mix(i as u32 + 77) as i32 as f32 / (1_u32 << 31) as f32;
        let one =
            |i: usize| if random(i + n * d) < 0.0 { random(i) * 40.0 - far } else { random(i) * 40.0 + far };
        (0..d).map(|k| (0..n).map(|i| one(k * n + i)).collect()).collect()
    }

    /// Noise and its derivative in f64, from all corners far about.
    fn reference<const D: usize>(p: [f32; D]) -> (f64, [f64; D]) {
        let lattice = Lattice::<Endless, D>::new(related_seed(5, SALT), Endless);
        let root = ((D + 1) as f64).sqrt();
        let f = (root - 1.0) / D as f64;
        let p = p.map(f64::from);
        let skew = p.iter().sum::<f64>() * f;
        let (mut value, mut slope) = (0.0, [0.0; D]);
        for corner in 0..5_usize.pow(D as u32) {
            let (mut left, mut at, mut joined) = (corner, [0.0; D], 0);
            for k in 0..D {
                at[k] = (p[k] + skew).floor() + (left % 5) as f64 - 2.0;
                left /= 5;
                joined ^= lattice.key(k, at[k] as f32);
            }
            let squeeze = at.iter().sum::<f64>() * f / root;
            let r: [f64; D] = std::array::from_fn(|k| p[k] - (at[k] - squeeze));
            let t = (0.5 - r.iter().map(|r| r * r).sum::<f64>()).max(0.0);
            let g = direction::<D>(hash::point(joined)).map(|g| f64::from(g / LENGTH));
            let along: f64 = r.iter().zip(g).map(|(r, g)| r * g).sum();
            value += t * t * t * t * along;
            for k in 0..D {
                slope[k] += t * t * t * t * g[k] - 8.0 * t * t * t * along * r[k];
            }
        }
        let scale = f64::from(SCALES[D - 1]);
        (value * scale, slope.map(|s| s * scale))
    }

    fn is_the_reference<const D: usize>() {
        for far in [0.0, 3e3, 1e6, 4e6] {
            let p = points(D, 400, far);
            let (values, slopes) = (noise(Isa::detect(), &p), slopes(Isa::detect(), &p));
            for i in 0..400 {
                let (value, slope) = reference::<D>(std::array::from_fn(|k| p[k][i]));
                assert!((f64::from(values[i]) - value).abs() < 3e-6, "{D}-D at {far}: {} {value}", values[i]);
                for k in 0..D {
                    assert!((f64::from(slopes[k][i]) - slope[k]).abs() < 3e-5);
                }
            }
        }
    }

    #[test]
    fn no_surflet_is_missed_and_no_digit_lost_far_out() {
        is_the_reference::<1>();
        is_the_reference::<2>();
        is_the_reference::<3>();
        is_the_reference::<4>();
    }

    #[test]
    fn corners_are_zero_with_gradients_of_one_length() {
        // In three dimensions G = 1/6, so corners whose coordinates add up to multiples of 6 are whole
        // numbers.
        let at = |i: usize| [(i % 19) as f32 - 9.0, (i / 19) as f32 - 9.0];
        let third = |i: usize| 6.0 * (i % 5) as f32 - at(i)[0] - at(i)[1];
        let squeezed = |k: usize| {
            (0..361).map(|i| [at(i)[0], at(i)[1], third(i)][k] - (i % 5) as f32).collect::<Vec<f32>>()
        };
        let p = [squeezed(0), squeezed(1), squeezed(2)];
        assert!(noise(Isa::detect(), &p).iter().all(|&n| n == 0.0));
        let g = slopes(Isa::detect(), &p);
        for i in 0..361 {
            let length = (g[0][i] * g[0][i] + g[1][i] * g[1][i] + g[2][i] * g[2][i]).sqrt();
            assert!((length * 16.0 / SCALES[2] - 1.0).abs() < 3e-4, "{length}");
        }
    }

    #[test]
    fn awkward_points() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for k in 0..4 {
                let mut p = vec![vec![0.3]; 4];
                p[k][0] = bad;
                assert!(noise(Isa::detect(), &p[..=k])[0].is_nan());
                assert!(slopes(Isa::detect(), &p[..=k])[k][0].is_nan());
            }
        }
        for huge in [16_777_216.0, -16_777_216.0, 1e20, f32::MAX] {
            for d in 1..=4 {
                assert_eq!(noise(Isa::detect(), &vec![vec![huge]; d]), [0.0]);
                assert_eq!(slopes(Isa::detect(), &vec![vec![huge]; d]), vec![[0.0]; d]);
            }
        }
        let unfit = KIND.field(3, &Params::default().with(Opt::Period, &[4.0])).err().unwrap();
        assert_eq!(unfit.message, "`simplex` noise takes no period");
    }

    #[test]
    fn the_same_bits_always() {
        let p = [0.5, 1.25, -2.75, 100.125];
        let bits: Vec<u32> = (1..=4)
            .map(|d| {
                noise(Isa::baseline(), &p[..d].iter().map(|&x| vec![x]).collect::<Vec<_>>())[0].to_bits()
            })
            .collect();
        assert_eq!(bits, [0xbeee_7d7d, 0xbe44_5917, 0xbf41_aa88, 0x3ede_74f5], "{bits:x?}");
        for d in 1..=4 {
            let p = points(d, 203, 1e4);
            for n in [1, 7, 64, 65, 203] {
                let cut: Vec<Vec<f32>> = p.iter().map(|p| p[203 - n..].to_vec()).collect();
                assert_eq!(noise(Isa::baseline(), &cut), noise(Isa::detect(), &p)[203 - n..]);
                for (k, slope) in slopes(Isa::baseline(), &cut).iter().enumerate() {
                    assert_eq!(slope, &slopes(Isa::detect(), &p)[k][203 - n..]);
                }
            }
        }
    }
}
