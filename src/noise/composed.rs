//! Composed noise: Peachey, "Solid Texturing of Complex Surfaces", SIGGRAPH 85, as Lewis 1989, section 2.4,
//! tells of it and of Gardner's.
//!
//! A noise of all coordinates is put together from noises of one, by multiplication or addition. As it stands
//! that is a checkerboard, whose rows and columns run straight through. Gardner lets each axis displace the
//! phases along the others, and so does this:
//!
//! noise = Πk fk(pk + a Σ{j≠k} mjk(pj)), or the mean of the fk in place of their product.
//!
//! Every f is a value noise of one dimension; every m, of lower frequency, a cubic B-spline with random
//! coefficients; none is related to another. Displacements together have a deviation of 0.8 in any number of
//! dimensions, enough to undo what is common to neighbouring rows, and slopes of about 1, which keeps the
//! noise from becoming much finer than f.

// Loops over axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::field::{TILE, Tile, Tiled};
use super::hash::{self, more};
use super::kind::{Contract, Kind, Smoothness};
use super::lattice::{Lattice, Wrap, lattice_field};
use super::options::Opt;
use super::tensor::{catmull_rom, catmull_rom_slopes, dot};
use super::value::{SCALE, values};

/// Composed noise.
pub static KIND: Kind = Kind {
    name: "composed",
    brief: "noises of one coordinate multiplied or added, each displaced by the others",
    dimensions: 2..=4,
    options: &[Opt::Period, Opt::Composition],
    contract: Contract {
        // 1.25 for each factor, as for `value`. The mean is within 1.25.
        bounds: &[[-1.563, 1.563], [-1.954, 1.954], [-2.442, 2.442]],
        mean: 0.0,
        deviation: 0.143,
        lattice: "random, as anywhere else",
        smoothness: Smoothness::C1,
        cost: 4.0,
        source: "Peachey 1985, after Lewis 1989, section 2.4",
        remarks: "No correlation of it is intrinsically three-dimensional, and the axes show: it is here so \
                  that one can see what Lewis objects to. The product is quiet in some regions and violent \
                  in others; its deviation is 0.271, 0.143 and 0.075 in two, three and four dimensions. \
                  That of the sum, which is divided by the number of dimensions, is 0.368, 0.302 and 0.262; \
                  as each term knows its own axis best, the sum is correlated, by up to 0.4, with itself \
                  moved any distance along an axis.",
    },
    make: |d, params| {
        let sum = params.choice(Opt::Composition) == 1;
        lattice_field!(d, params, [2 3 4], |lattice| Composed { lattice, sum })
    },
};

struct Composed<W, const D: usize> {
    lattice: Lattice<W, D>,
    /// The mean rather than the product.
    sum: bool,
}

/// What random numbers in -1 … 1 are multiplied by to displace: the deviation of the B-spline being 0.4, and
/// there being one for each other axis, 2/√(D - 1). By the number of dimensions.
const DISPLACEMENT: [f32; 5] = [0.0, 0.0, 2.0, std::f32::consts::SQRT_2, 1.154_700_5];

/// Tells the numbers of the noises that are put together from those of what displaces them.
const TOGETHER: u32 = 0x68E3_1DA4;

/// The weights of four coefficients in a row in the cubic B-spline.
#[inline(always)]
fn b_spline(t: f32) -> [f32; 4] {
    const SIXTH: f32 = 1.0 / 6.0;
    const MOST: f32 = 2.0 / 3.0;
    let s = 1.0 - t;
    [SIXTH * s * s * s, MOST - t * t * (1.0 - 0.5 * t), MOST - s * s * (1.0 - 0.5 * s), SIXTH * t * t * t]
}

/// The derivatives of the weights.
#[inline(always)]
fn b_spline_slopes(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [-0.5 * s * s, t * (1.5 * t - 2.0), s * (2.0 - 1.5 * s), 0.5 * t * t]
}

/// What is known of the lanes of a tile.
struct Parts<const D: usize> {
    /// By how much each axis is displaced.
    displaced: [[f32; TILE]; D],
    /// The derivatives of that, by each coordinate.
    shear: [[[f32; TILE]; D]; D],
    /// The displaced noise along each axis.
    noise: [[f32; TILE]; D],
    /// Its derivative by the displaced coordinate.
    slope: [[f32; TILE]; D],
}

impl<W: Wrap<D>, const D: usize> Composed<W, D> {
    /// The hashes of four whole numbers on an axis, the second being `low`.
    #[inline(always)]
    fn hashes(&self, axis: usize, low: f32, salt: u32) -> [u32; 4] {
        // The seed is in the keys of the first axis.
        let salt = if axis == 0 { salt } else { salt ^ self.lattice.key(0, 0.0) };
        let hash = |x: f32| hash::point(self.lattice.key(axis, x) ^ salt);
        [hash(low - 1.0), hash(low), hash(low + 1.0), hash(low + 2.0)]
    }

    /// What the whole is multiplied by.
    #[inline(always)]
    fn scale(&self) -> f32 {
        if self.sum { 1.0 / D as f32 } else { 1.0 }
    }

    /// Finds the parts, of which the noise is put together; the slopes only for the derivative.
    #[inline(always)]
    fn parts<const SLOPES: bool>(&self, p: [&[f32; TILE]; D], work: usize) -> Parts<D> {
        let zero = [[0.0; TILE]; D];
        let mut parts = Parts { displaced: zero, shear: [zero; D], noise: zero, slope: zero };
        const { assert!(D < DISPLACEMENT.len()) };
        let mut low = zero;
        // Axis by axis as code, not as loops: what differs between axes is then known to the compiler.
        self.displace::<SLOPES>(0, &mut parts, &mut low, p, work);
        self.displace::<SLOPES>(1, &mut parts, &mut low, p, work);
        if D > 2 {
            self.displace::<SLOPES>(2, &mut parts, &mut low, p, work);
        }
        if D > 3 {
            self.displace::<SLOPES>(3, &mut parts, &mut low, p, work);
        }
        self.along::<SLOPES>(0, &mut parts, &low, p, work);
        self.along::<SLOPES>(1, &mut parts, &low, p, work);
        if D > 2 {
            self.along::<SLOPES>(2, &mut parts, &low, p, work);
        }
        if D > 3 {
            self.along::<SLOPES>(3, &mut parts, &low, p, work);
        }
        parts
    }

    /// Adds by how much the noise along axis j displaces the others.
    #[inline(always)]
    fn displace<const SLOPES: bool>(
        &self,
        j: usize,
        parts: &mut Parts<D>,
        low: &mut [[f32; TILE]; D],
        p: [&[f32; TILE]; D],
        work: usize,
    ) {
        let scale = SCALE * DISPLACEMENT[D];
        // Four arrays, as whole vectors are loaded from them.
        let (mut a, mut b, mut c, mut d) = ([0; TILE], [0; TILE], [0; TILE], [0; TILE]);
        for i in 0..work {
            low[j][i] = p[j][i].floor();
            [a[i], b[i], c[i], d[i]] = self.hashes(j, low[j][i], 0);
        }
        for k in 0..D {
            if k == j {
                continue;
            }
            for i in 0..work {
                let (t, values) = (p[j][i] - low[j][i], values([a[i], b[i], c[i], d[i]]));
                parts.displaced[k][i] += dot(values, b_spline(t)) * scale;
                if SLOPES {
                    parts.shear[k][j][i] = dot(values, b_spline_slopes(t)) * scale;
                }
                [a[i], b[i], c[i], d[i]] = [more(a[i]), more(b[i]), more(c[i]), more(d[i])];
            }
        }
    }

    /// The displaced noise along axis k.
    #[inline(always)]
    fn along<const SLOPES: bool>(
        &self,
        k: usize,
        parts: &mut Parts<D>,
        low: &[[f32; TILE]; D],
        p: [&[f32; TILE]; D],
        work: usize,
    ) {
        for i in 0..work {
            // The cell and the place in it are displaced apart: their sum would have fewer digits.
            let t = (p[k][i] - low[k][i]) + parts.displaced[k][i];
            let cells = t.floor();
            let values = values(self.hashes(k, low[k][i] + cells, TOGETHER));
            parts.noise[k][i] = dot(values, catmull_rom(t - cells)) * SCALE;
            if SLOPES {
                parts.slope[k][i] = dot(values, catmull_rom_slopes(t - cells)) * SCALE;
            }
        }
    }
}

impl<W: Wrap<D>, const D: usize> Tiled<D> for Composed<W, D> {
    type Scratch = ();
    #[inline(always)]
    fn scratch(&self) {}

    #[inline(always)]
    fn values(&self, (): &mut (), tile: Tile<'_, D>, out: &mut [f32; TILE]) {
        let noise = self.parts::<false>(tile.p, tile.work()).noise;
        let mut all = noise[0];
        for k in 1..D {
            for i in 0..TILE {
                all[i] = if self.sum { all[i] + noise[k][i] } else { all[i] * noise[k][i] };
            }
        }
        let scale = self.scale();
        for i in 0..TILE {
            out[i] = all[i] * scale;
        }
    }

    #[inline(always)]
    fn slopes(&self, (): &mut (), tile: Tile<'_, D>, out: &mut [[f32; TILE]; D]) {
        let Parts { shear, noise, mut slope, .. } = self.parts::<true>(tile.p, tile.work());
        // The derivative by each displaced coordinate.
        for k in 0..D {
            for j in 0..D {
                for i in 0..TILE {
                    slope[k][i] *= if j == k || self.sum { 1.0 } else { noise[j][i] };
                }
            }
        }
        let scale = self.scale();
        for j in 0..D {
            let mut all = slope[j];
            for k in 0..D {
                if k != j {
                    for i in 0..TILE {
                        all[i] += slope[k][i] * shear[k][j][i];
                    }
                }
            }
            for i in 0..TILE {
                out[j][i] = all[i] * scale;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::*;
    use super::*;
    use crate::noise::Params;

    fn sum(seed: u32) -> Params {
        Params::seeded(seed).with_choice(Opt::Composition, "sum")
    }

    #[test]
    fn as_usual() {
        usual(&KIND, &Params::seeded(3));
        usual(&KIND, &sum(3));
        assert_eq!(pinned(&KIND, &Params::default()), [0x3f36_c549, 0x3dcc_4a38, 0xbb38_74cf]);
    }

    /// The noise in f64.
    fn known(p: &[f64], seed: u32, sum: bool) -> f64 {
        let lattice = Lattice::<_, 4>::new(seed, super::super::lattice::Endless);
        let salted = |axis: usize, x: f64, salt: u32| {
            let seed = lattice.key(0, 0.0);
            hash::point(if axis == 0 { 0 } else { seed } ^ lattice.key(axis, x as f32) ^ salt)
        };
        let line = |x: f64, kernel: &dyn Fn(f64) -> f64, value: &dyn Fn(f64) -> f64| -> f64 {
            (-1..=2).map(|i| x.floor() + f64::from(i)).map(|c| kernel(x - c) * value(c)).sum()
        };
        let b_spline = |x: f64| {
            let (r, far) = (x.abs(), 2.0 - x.abs());
            if r < 1.0 { (4.0 - 6.0 * r * r + 3.0 * r * r * r) / 6.0 } else { far * far * far / 6.0 }
        };
        let d = p.len();
        let factors = (0..d).map(|k| {
            let displaced = (0..d).filter(|&j| j != k).map(|j| {
                // The numbers of an axis for each of the others in turn.
                let turn = (0..k).filter(|&k| k != j).count();
                let value = |c: f64| value_of((0..turn).fold(salted(j, c, 0), |h, _| more(h)));
                2.0 / ((d - 1) as f64).sqrt() * line(p[j], &b_spline, &value)
            });
            let value = |c: f64| value_of(salted(k, c, TOGETHER));
            line(p[k] + displaced.sum::<f64>(), &super::super::checks::catmull_rom, &value)
        });
        if sum { factors.sum::<f64>() / d as f64 } else { factors.product() }
    }

    #[test]
    fn it_is_what_the_formula_says() {
        is(&KIND, &Params::seeded(9), |p| known(p, 9, false));
        is(&KIND, &sum(9), |p| known(p, 9, true));
    }

    #[test]
    fn far_away_no_digits_are_lost() {
        // The displacement is found from the fractions, and whole steps there are as here.
        let p = [vec![1e6 + 0.25], vec![-1e6 + 0.5], vec![3e5 + 0.125]];
        let exact = known(&[1e6 + 0.25, -1e6 + 0.5, 3e5 + 0.125], 0, false);
        assert!((f64::from(noise(&KIND, &Params::default(), &p)[0]) - exact).abs() < 5e-6);
    }

    #[test]
    fn it_is_no_checkerboard() {
        // Were it separable, the determinant of four corners of a rectangle would be 0.
        let p = points(2, 500, 90.0);
        let at = |dx: f32, dy: f32| {
            let moved = |p: &[f32], d: f32| p.iter().map(|x| x + d).collect::<Vec<_>>();
            noise(&KIND, &Params::default(), &[moved(&p[0], dx), moved(&p[1], dy)])
        };
        let (a, b, c, d) = (at(0.0, 0.0), at(1.5, 0.0), at(0.0, 2.5), at(1.5, 2.5));
        let (mut crossed, mut straight) = (0.0, 0.0);
        for i in 0..500 {
            crossed += (a[i] * d[i] - b[i] * c[i]).abs();
            straight += (a[i] * d[i]).abs() + (b[i] * c[i]).abs();
        }
        assert!(crossed > 0.6 * straight, "{crossed} of {straight}");
    }
}
