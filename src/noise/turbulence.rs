//! Turbulence: the sum of the absolute noise of octaves, each half as large and twice as fine.
//!
//! Contract
//! - not negative, below twice the bound of the noise; in the form of 1992, that over the lowest frequency
//! - continuous, with creases where an octave is zero (the abs)
//! - each lane stops at its own octave, which depends on that lane only
//!
//! Sources: Perlin 1985, Appendix; Perlin 1992, section 3.6.1.

use super::Kind;
use super::gradient::Gradient;
use super::hash;
use super::lattice::{self, Cell, Planes};
use super::perlin1985::Perlin1985;
use crate::lanes::{Isa, Kernel};

/// No more octaves than this: the next would be of size 2^-24, below the last bit of a sum near 1.
pub const OCTAVES: u32 = 24;

/// The turbulence of 1985: Σ |noise(p / scale)| · scale for scale = 1, 1/2, 1/4 … while scale > `pixel_size`,
/// in each lane. Pixel sizes of 0 and below give all [`OCTAVES`], NaN none.
///
/// # Panics
/// If there are no coordinates or more than four, or if lengths differ.
pub fn turbulence(kind: Kind, isa: Isa, coords: &[&[f32]], pixel_size: &[f32], seed: u32, out: &mut [f32]) {
    by_kind(kind, isa, coords, Stop::Scale(pixel_size), seed, out);
}

/// The turbulence of 1992: Σ |noise(p · 2^k)| / f for f = low · 2^k, k = 0, 1 …, while f < `high`, in
/// each lane. As in the course notes, p itself is not multiplied by `low`; their offset of the point by 123.456
/// and of the result by -0.3 are left out. At most [`OCTAVES`]; none where `low` is not above 0.
///
/// # Panics
/// If there are no coordinates or more than four, or if lengths differ.
pub fn turbulence_1992(
    kind: Kind,
    isa: Isa,
    coords: &[&[f32]],
    [low, high]: [&[f32]; 2],
    seed: u32,
    out: &mut [f32],
) {
    by_kind(kind, isa, coords, Stop::Frequencies(low, high), seed, out);
}

/// Where a lane's octaves begin and end.
#[derive(Clone, Copy)]
enum Stop<'a> {
    Scale(&'a [f32]),
    Frequencies(&'a [f32], &'a [f32]),
}

fn by_kind(kind: Kind, isa: Isa, coords: &[&[f32]], stop: Stop, seed: u32, out: &mut [f32]) {
    match kind {
        Kind::Perlin1985 => by_dimension::<Perlin1985>(isa, coords, stop, seed, out),
        Kind::Gradient => by_dimension::<Gradient>(isa, coords, stop, seed, out),
    }
}

fn by_dimension<P: Planes>(isa: Isa, coords: &[&[f32]], stop: Stop, seed: u32, out: &mut [f32]) {
    let seed = hash::seed(seed);
    let planes = std::marker::PhantomData::<P>;
    match *coords {
        [x] => isa.run(Turbulence { p: [x], stop, seed, out, planes }),
        [x, y] => isa.run(Turbulence { p: [x, y], stop, seed, out, planes }),
        [x, y, z] => isa.run(Turbulence { p: [x, y, z], stop, seed, out, planes }),
        [x, y, z, w] => isa.run(Turbulence { p: [x, y, z, w], stop, seed, out, planes }),
        _ => panic!("turbulence of {} coordinates", coords.len()),
    }
}

struct Turbulence<'a, P, const D: usize> {
    p: [&'a [f32]; D],
    stop: Stop<'a>,
    seed: u32,
    out: &'a mut [f32],
    planes: std::marker::PhantomData<P>,
}

impl<P: Planes, const D: usize> Kernel for Turbulence<'_, P, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for (start, end) in lattice::tiles(self.out.len()) {
            let (p, work) = lattice::load(&self.p, start, end);
            // Both forms go on while low · frequency < high, frequency being 2^k: with scales it is
            // low = pixel size, high = 1, and both products by powers of 2 are exact.
            let [low, high, first] = self.limits(start, end);
            let mut sums = [0.0; lattice::TILE];
            let mut frequency = 1.0_f32;
            for _ in 0..OCTAVES {
                let any = (0..end - start).any(|i| low[i] * frequency < high[i]);
                if !any {
                    break;
                }
                let amplitude = 1.0 / frequency;
                for i in 0..work {
                    let noise =
                        Cell::<D>::new(std::array::from_fn(|k| p[k][i] * frequency), self.seed).value::<P>();
                    let sum = sums[i] + noise.abs() * (amplitude * first[i]);
                    sums[i] = if low[i] * frequency < high[i] { sum } else { sums[i] };
                }
                frequency *= 2.0;
            }
            self.out[start..end].copy_from_slice(&sums[..end - start]);
        }
    }
}

impl<P, const D: usize> Turbulence<'_, P, D> {
    /// For each lane of a tile: `low` and `high` of the condition, and the size of the first octave.
    /// Lanes that only fill up the tile have no octave.
    #[inline(always)]
    fn limits(&self, start: usize, end: usize) -> [[f32; lattice::TILE]; 3] {
        let n = end - start;
        let mut low = [1.0; lattice::TILE];
        let mut high = [0.0; lattice::TILE];
        let mut first = [1.0; lattice::TILE];
        match self.stop {
            Stop::Scale(sizes) => {
                low[..n].copy_from_slice(&sizes[start..end]);
                high[..n].fill(1.0);
            }
            Stop::Frequencies(lows, highs) => {
                high[..n].copy_from_slice(&highs[start..end]);
                for i in 0..n {
                    // A NaN is never below anything.
                    low[i] = if lows[start + i] > 0.0 { lows[start + i] } else { f32::NAN };
                    first[i] = 1.0 / lows[start + i];
                }
            }
        }
        [low, high, first]
    }
}
