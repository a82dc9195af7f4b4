//! Gardner's texturing function: "Simulation of Natural Scenes Using Textured Quadric Surfaces", SIGGRAPH 84,
//! and "Visual Simulation of Clouds", SIGGRAPH 85; as Lewis 1989, section 2.4, and Peachey, "Spectral
//! Synthesis", describe it.
//!
//! Only its constants are random. It is a product of series of sines, one for each axis x,
//!
//! Σ 2^((1-i)/2) sin(2π f_i x + φ_i + π/2 Σ sin(2π f_(i-1) y + φ_(i-1))),  i = 1 … 4,
//!
//! where the inner sum is over the other axes y, with their own f and φ. Without it this would be a product
//! of functions of a coordinate each, and look like a checkerboard; it bends the lines of each series by the
//! next lower waves of the others. From term to term frequencies about double: each is up to 12 % off, so
//! that none is a multiple of another, and the mean is 0. Of our own are these numbers, that also the first
//! term is bent, by waves of half its frequency, and that no offset is added to the series.
//!
//! - Angles are reduced in f64: up to 2^40 they are right to a thousandth of a turn. But from 2^22 on, f32
//!   is too coarse for the shortest waves, of 0.6 units, and neighbouring points are unrelated. From 2^57 on
//!   a coordinate's own angles count as 0.
//! - NaN and infinities give NaN.

// Loops over axes and lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::field::{Field, TILE, coordinates, load, tiles};
use super::kind::{Contract, Kind, Smoothness};
use super::{hash, related_seed};
use crate::lanes::{Isa, Kernel, array};
use crate::math::{cos_lanes, sin_lanes};
use std::array::from_fn;
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};
use std::sync::Arc;

/// Gardner's function, 1984.
pub static KIND: Kind = Kind {
    name: "gardner",
    brief: "products of series of sines, whose phases are coupled over the axes",
    dimensions: 2..=3,
    options: &[],
    contract: Contract {
        // If all sines are 1.
        bounds: &[[-1.89, 1.89], [-4.99, 4.99]],
        mean: 0.0,
        deviation: 0.27,
        lattice: "any",
        smoothness: Smoothness::Analytic,
        cost: 6.0,
        source: "Gardner 1984 and 1985; Lewis 1989, section 2.4; Peachey, \"Spectral Synthesis\"",
        remarks: "A pattern without chance. It never repeats exactly, but nearly: large features return \
            about every 10 units, and shifts by larger distances may give almost the same again. With \
            a seed of 0, shifts by 4, 16, 64, … 65536 are correlated by 0.12 at most; other seeds may \
            do worse. Its grain follows axes and diagonals. Lewis calls it deterministic in \
            conception; its spectrum, he finds, consists of lines, as of frequency modulation, more \
            than the series has and without a strict limit. In two dimensions 16 % of its energy are \
            below 0.3 cycles a unit, 47 % from there to 0.7; in three 18 % and 39 %. 0.6 % of points \
            are beyond ±1 in two dimensions, and 1.3 % in three, where a product of three makes few \
            spots stand out of much grey. From 2^22 on f32 is too coarse for its waves.",
    },
    make: |dimensions, params| {
        let seed = hash::seed(related_seed(params.seed, SALT));
        Ok(match dimensions {
            2 => Arc::new(Gardner::<2>::new(seed)),
            _ => Arc::new(Gardner::<3>::new(seed)),
        })
    },
};

/// Leads from a user's seed to the constants. Of 1200 tried, this gives a seed of 0 the least correlation
/// over shifts by 4, 16, 64 … 65536 along axes and diagonals: 0.12 at most, where 0.36 is common and 0.97
/// occurs.
const SALT: u32 = 0x4741_5511;

/// How many terms a series has.
const TERMS: usize = 4;
/// Cycles a unit of the first term, about: so most energy is about where `gradient` has it.
const FREQUENCY: f64 = 0.2;
/// How far frequencies are from doubling, at most.
const DETUNING: f64 = 0.12;
/// The amplitude of each term.
const SIZES: [f32; TERMS] = [1.0, FRAC_1_SQRT_2, 0.5, FRAC_1_SQRT_2 / 2.0];

/// A wave along an axis.
#[derive(Clone, Copy)]
struct Wave {
    /// In turns a unit.
    frequency: f64,
    /// In turns.
    phase: f64,
}

struct Gardner<const D: usize> {
    /// By axis, i from 0: the first only bends others, the last is only a term.
    waves: [[Wave; TERMS + 1]; D],
}

/// Something of each term, for the lanes of a tile.
type Terms<const D: usize> = [[[f32; TILE]; TERMS]; D];

/// What is reckoned for a tile. It is filled in place, over and over: copies would take as long as the sines.
struct Tile<const D: usize> {
    /// The angle of each wave by itself, within half a turn.
    angles: [[[f32; TILE]; TERMS + 1]; D],
    /// Sines, or cosines, of the waves that phases are from.
    phases: Terms<D>,
    /// The angle of each term, with the phases that it has from the other axes.
    coupled: Terms<D>,
    /// Sines and cosines of those.
    sines: Terms<D>,
    cosines: Terms<D>,
}

impl<const D: usize> Gardner<D> {
    /// What the product is multiplied by, which makes the standard deviation the same.
    const SCALE: f32 = if D == 2 { 0.288 } else { 0.297 };

    fn new(seed: u32) -> Gardner<D> {
        let wave = |k: usize, i: usize| {
            let random = hash::mix(seed ^ hash::mix((k * 16 + i) as u32 + 1));
            // In -1 … 1 and in 0 … 1.
            let detuning = f64::from(hash::mix(random) as i32) / f64::from(1_u32 << 31);
            let phase = f64::from(random) / f64::from(1_u32 << 31) / 2.0;
            let octave = f64::from(1_u32 << i) / 2.0;
            Wave { frequency: FREQUENCY * octave * (1.0 + DETUNING * detuning), phase }
        };
        Gardner { waves: from_fn(|k| from_fn(|i| wave(k, i))) }
    }
}

impl<const D: usize> Field for Gardner<D> {
    fn noise(&self, isa: Isa, p: &[&[f32]], out: &mut [f32]) {
        let p = coordinates(p);
        let mut tile = Tile::none();
        for (start, end) in tiles(out.len()) {
            tile.load(isa, &self.waves, &p, start, end);
            let values = isa.run(Product { sines: &tile.sines, scale: Self::SCALE });
            out[start..end].copy_from_slice(&values[..end - start]);
        }
    }

    fn derivative(&self, isa: Isa, p: &[&[f32]], out: &mut [&mut [f32]]) {
        assert_eq!(out.len(), D, "derivatives of {D} coordinates");
        let p = coordinates(p);
        let mut tile = Tile::none();
        for (start, end) in tiles(p[0].len()) {
            tile.load(isa, &self.waves, &p, start, end);
            tile.load_cosines(isa);
            let slopes = isa.run(Slopes { waves: &self.waves, tile: &tile, scale: Self::SCALE });
            for (out, slopes) in out.iter_mut().zip(&slopes) {
                out[start..end].copy_from_slice(&slopes[..end - start]);
            }
        }
    }
}

impl<const D: usize> Tile<D> {
    fn none() -> Tile<D> {
        let none = [[[0.0; TILE]; TERMS]; D];
        let angles = [[[0.0; TILE]; TERMS + 1]; D];
        Tile { angles, phases: none, coupled: none, sines: none, cosines: none }
    }

    /// Reckons all but cosines.
    fn load(&mut self, isa: Isa, waves: &[[Wave; TERMS + 1]; D], p: &[&[f32]; D], start: usize, end: usize) {
        isa.run(Angles { waves, p, start, end, angles: &mut self.angles });
        for k in 0..D {
            let angles = self.angles[k][..TERMS].as_flattened();
            sin_lanes(isa, angles, self.phases[k].as_flattened_mut());
        }
        isa.run(Coupled { angles: &self.angles, phases: &self.phases, coupled: &mut self.coupled });
        for k in 0..D {
            sin_lanes(isa, self.coupled[k].as_flattened(), self.sines[k].as_flattened_mut());
        }
    }

    /// Reckons cosines in the end.
    fn load_cosines(&mut self, isa: Isa) {
        for k in 0..D {
            let angles = self.angles[k][..TERMS].as_flattened();
            cos_lanes(isa, angles, self.phases[k].as_flattened_mut());
            cos_lanes(isa, self.coupled[k].as_flattened(), self.cosines[k].as_flattened_mut());
        }
    }
}

/// The angles of all waves by themselves.
struct Angles<'a, const D: usize> {
    waves: &'a [[Wave; TERMS + 1]; D],
    p: &'a [&'a [f32]; D],
    start: usize,
    end: usize,
    angles: &'a mut [[[f32; TILE]; TERMS + 1]; D],
}

impl<const D: usize> Kernel for Angles<'_, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let mut padded = [[0.0; TILE]; D];
        let p = load(self.p, (self.start, self.end), &mut padded).p;
        for k in 0..D {
            for (wave, angles) in self.waves[k].iter().zip(&mut self.angles[k]) {
                for lane in 0..TILE {
                    let turns = f64::from(p[k][lane]) * wave.frequency + wave.phase;
                    angles[lane] = (turns - (turns + 0.5).floor()) as f32 * TAU;
                }
            }
        }
    }
}

/// Adds to each term's angle the phases that it has from the other axes.
struct Coupled<'a, const D: usize> {
    angles: &'a [[[f32; TILE]; TERMS + 1]; D],
    phases: &'a Terms<D>,
    coupled: &'a mut Terms<D>,
}

impl<const D: usize> Kernel for Coupled<'_, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for k in 0..D {
            for i in 0..TERMS {
                let mut phase = [0.0; TILE];
                for other in (0..D).filter(|&other| other != k) {
                    for lane in 0..TILE {
                        phase[lane] += self.phases[other][i][lane];
                    }
                }
                for lane in 0..TILE {
                    self.coupled[k][i][lane] = self.angles[k][i + 1][lane] + FRAC_PI_2 * phase[lane];
                }
            }
        }
    }
}

/// The series of an axis.
#[inline(always)]
fn series(waves: &[[f32; TILE]; TERMS]) -> [f32; TILE] {
    let mut sum = [0.0; TILE];
    for i in 0..TERMS {
        for lane in 0..TILE {
            sum[lane] += SIZES[i] * waves[i][lane];
        }
    }
    sum
}

/// The product of the series.
struct Product<'a, const D: usize> {
    sines: &'a Terms<D>,
    scale: f32,
}

impl<const D: usize> Kernel for Product<'_, D> {
    type Output = [f32; TILE];
    #[inline(always)]
    fn run(self) -> [f32; TILE] {
        let mut product = [self.scale; TILE];
        for k in 0..D {
            let sum = series(&self.sines[k]);
            for lane in 0..TILE {
                product[lane] *= sum[lane];
            }
        }
        product
    }
}

/// The derivative of the product.
struct Slopes<'a, const D: usize> {
    waves: &'a [[Wave; TERMS + 1]; D],
    tile: &'a Tile<D>,
    scale: f32,
}

impl<const D: usize> Kernel for Slopes<'_, D> {
    type Output = [[f32; TILE]; D];
    #[inline(always)]
    fn run(self) -> [[f32; TILE]; D] {
        let Slopes { waves, tile, scale } = self;
        let mut slopes = [[0.0; TILE]; D];
        let series: [_; D] = array(|k| series(&tile.sines[k]));
        for k in 0..D {
            let mut others = [scale; TILE];
            for other in (0..D).filter(|&other| other != k) {
                for lane in 0..TILE {
                    others[lane] *= series[other][lane];
                }
            }
            for i in 0..TERMS {
                // The term's angle changes along its own axis by its frequency, and along the others by its
                // phase.
                let own = waves[k][i + 1].frequency as f32 * TAU;
                let phase: [f32; D] = array(|k| waves[k][i].frequency as f32 * (TAU * FRAC_PI_2));
                for lane in 0..TILE {
                    let term = SIZES[i] * tile.cosines[k][i][lane] * others[lane];
                    for axis in 0..D {
                        let change = if axis == k { own } else { phase[axis] * tile.phases[axis][i][lane] };
                        slopes[axis][lane] += term * change;
                    }
                }
            }
        }
        slopes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Opt, Params};
    use std::f64::consts::PI;

    fn noise(isa: Isa, p: &[Vec<f32>]) -> Vec<f32> {
        let mut out = vec![0.0; p[0].len()];
        let field = KIND.field(p.len(), &Params::seeded(3)).unwrap();
        field.noise(isa, &p.iter().map(Vec::as_slice).collect::<Vec<_>>(), &mut out);
        out
    }

    fn slopes(isa: Isa, p: &[Vec<f32>]) -> Vec<Vec<f32>> {
        let mut out = vec![vec![0.0; p[0].len()]; p.len()];
        let mut planes: Vec<&mut [f32]> = out.iter_mut().map(Vec::as_mut_slice).collect();
        let field = KIND.field(p.len(), &Params::seeded(3)).unwrap();
        field.derivative(isa, &p.iter().map(Vec::as_slice).collect::<Vec<_>>(), &mut planes);
        out
    }

    fn points(d: usize, n: usize, size: f32) -> Vec<Vec<f32>> {
        let random = |i: usize| hash::mix(i as u32 + 5) as i32 as f32 / (1_u32 << 31) as f32;
        (0..d).map(|k| (0..n).map(|i| random(k * n + i) * size).collect()).collect()
    }

    /// The formula, in f64.
    fn reference<const D: usize>(p: [f64; D]) -> f64 {
        let waves = Gardner::<D>::new(hash::seed(related_seed(3, SALT))).waves;
        let angle = |k: usize, i: usize| 2.0 * PI * (waves[k][i].frequency * p[k] + waves[k][i].phase);
        let phase = |k: usize, i: usize| -> f64 {
            (0..D).filter(|&other| other != k).map(|other| libm::sin(angle(other, i)) * PI / 2.0).sum()
        };
        let term = |k: usize, i: usize| libm::sin(angle(k, i + 1) + phase(k, i)) * f64::from(SIZES[i]);
        (0..D).map(|k| (0..TERMS).map(|i| term(k, i)).sum::<f64>()).product::<f64>()
            * f64::from(Gardner::<D>::SCALE)
    }

    fn is_the_formula<const D: usize>() {
        for size in [3.0, 1e4, 4e6] {
            let p = points(D, 500, size);
            let (values, slopes) = (noise(Isa::detect(), &p), slopes(Isa::detect(), &p));
            for i in 0..500 {
                let at: [f64; D] = from_fn(|k| f64::from(p[k][i]));
                let known = reference(at);
                assert!(
                    (f64::from(values[i]) - known).abs() < 1e-5,
                    "{D}-D at {at:?}: {} {known}",
                    values[i]
                );
                for k in 0..D {
                    let moved = |h: f64| reference::<D>(from_fn(|j| at[j] + if j == k { h } else { 0.0 }));
                    let known = (moved(1e-4) - moved(-1e-4)) / 2e-4;
                    assert!((f64::from(slopes[k][i]) - known).abs() < 2e-4, "{D}-D at {at:?} along {k}");
                }
            }
        }
    }

    #[test]
    fn it_is_the_formula_near_and_far() {
        is_the_formula::<2>();
        is_the_formula::<3>();
    }

    #[test]
    fn no_wave_is_a_multiple_of_another() {
        for seed in 0..100 {
            let waves = Gardner::<3>::new(seed).waves;
            let all: Vec<f64> = waves.iter().flatten().map(|wave| wave.frequency).collect();
            for (i, a) in all.iter().enumerate() {
                for b in &all[..i] {
                    let ratio = (a / b).max(b / a);
                    assert!((ratio - ratio.round()).abs() > 1e-7, "seed {seed}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn awkward_points() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for k in 0..3 {
                let mut p = vec![vec![0.3]; 3];
                p[k][0] = bad;
                assert!(noise(Isa::detect(), &p)[0].is_nan());
                assert!(slopes(Isa::detect(), &p).iter().all(|s| s[0].is_nan()));
            }
        }
        for huge in [1e18, -1e30, f32::MAX] {
            assert_eq!(noise(Isa::detect(), &vec![vec![huge]; 3]), [0.0]);
            assert!(noise(Isa::detect(), &[vec![huge], vec![0.3]])[0].abs() <= 1.89);
            assert!(slopes(Isa::detect(), &[vec![huge], vec![0.3]])[1][0].is_finite());
        }
        let unfit = |d: usize, params: Params| KIND.field(d, &params).err().unwrap().message;
        assert_eq!(unfit(2, Params::default().with(Opt::Period, &[4.0])), "`gardner` noise takes no period");
        assert_eq!(unfit(1, Params::default()), "`gardner` is a noise of 2 to 3 coordinates, found 1");
    }

    #[test]
    fn the_same_bits_always() {
        let p = [0.5, 1.25, -2.75];
        let one = |d: usize| noise(Isa::baseline(), &p[..d].iter().map(|&x| vec![x]).collect::<Vec<_>>())[0];
        assert_eq!(
            [2, 3].map(|d| one(d).to_bits()),
            [0x3f86_2382, 0xbf71_9db8],
            "{:x?}",
            [2, 3].map(|d| one(d).to_bits())
        );
        for d in 2..=3 {
            let p = points(d, 203, 1e4);
            let (whole, whole_slopes) = (noise(Isa::detect(), &p), slopes(Isa::detect(), &p));
            for n in [1, 7, 64, 65, 203] {
                let cut: Vec<Vec<f32>> = p.iter().map(|p| p[203 - n..].to_vec()).collect();
                assert_eq!(noise(Isa::baseline(), &cut), whole[203 - n..]);
                for (k, slope) in slopes(Isa::baseline(), &cut).iter().enumerate() {
                    assert_eq!(slope, &whole_slopes[k][203 - n..]);
                }
            }
        }
    }
}
