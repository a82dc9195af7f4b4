//! What the noises of impulses share: points scattered over space, each of which adds a kernel to its surroundings.
//!
//! The points are a Poisson process: in a cell of the integer lattice their number has Poisson's distribution,
//! and they lie evenly in it; all of this comes from the cell's hash, so no two cells have the same.
//! Noise at p is the sum of the kernel at p − point, times the point's size, over the points that can reach p.
//! With sizes unrelated to each other and of mean 0 this is white noise convolved with the kernel (Lewis 1989,
//! section 4): its mean is 0, its variance is density · E\[size²] · ∫ kernel² (Campbell's theorem), and its
//! spectrum is the kernel's.
//!
//! - From ±2^23 cells on every f32 is an integer, and so a corner of its cell; from ±2^24 on some of the cells
//!   about a point are the same.
//! - NaN and infinities give NaN.

mod kernels;
mod sum;
mod tile;
mod waves;

pub(super) use kernels::{
    Bell, CatmullRom, Curve, GAUSSIAN_RADIUS, Gabor, Profile, STEPS, integral, mean_cosine,
};
pub(super) use waves::Waves;

use super::field::{Field, TILE, coordinates, tiles};
use super::hash;
use super::kind::Unfit;
use super::lattice::{Endless, Lattice, Periodic};
use super::options::{Opt, Params};
use crate::lanes::Isa;
use std::sync::Arc;
use sum::{Add, Sums};
use tile::{BLOCK, GROUP, Tile};

/// Offsets from impulses are in these parts of a cell's side.
pub(super) const UNIT: f32 = 1.0 / (1_u64 << 32) as f32;
/// Sizes of impulses are in these parts.
const SIZE: f32 = 1.0 / (1_u32 << 31) as f32;

/// The most cells from a point's own to one whose impulses reach it.
const REACH: usize = 3;
/// The least and the most impulses that a cell may have on average.
pub(super) const LEAST: f64 = 0.01;
pub(super) const CROWD: f64 = 64.0;
/// The most that any cell has.
const MOST: usize = 128;

/// How impulses lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// The side of a cell is 2^`octave` units.
    pub octave: i32,
    /// How many units a kernel reaches.
    pub radius: f64,
    /// How many impulses a unit has on average.
    pub density: f64,
    /// What the sum is multiplied by.
    pub scale: f64,
}

impl Layout {
    /// The side of a cell.
    pub(super) fn side(&self) -> f64 {
        libm::exp2(f64::from(self.octave))
    }

    /// How many cells the kernel reaches.
    fn reach(&self) -> usize {
        (self.radius / self.side()).ceil() as usize
    }

    /// Whether it can be summed.
    pub(super) fn fits(&self, dimensions: usize) -> bool {
        let mean = self.density * libm::pow(self.side(), dimensions as f64);
        (1..=REACH).contains(&self.reach()) && (LEAST..=CROWD).contains(&mean)
    }
}

/// The k-th impulse of a cell.
#[derive(Clone, Copy)]
struct Slot<const D: usize> {
    /// There is one if the cell's hash, as a signed number, is above this.
    above: i32,
    /// By what the hash is multiplied to give its coordinates: the products are even in the cell, from its middle.
    place: [u32; D],
    /// Likewise its size and another random word.
    size: u32,
    word: u32,
}

/// A cell near a point's own: where it is among the coordinates -reach … reach.
type Near<const D: usize> = [u8; D];

/// Where impulses are.
struct Lookout<const D: usize> {
    lattice: Lattice<Endless, D>,
    periodic: Option<Lattice<Periodic<D>, D>>,
    /// Cells a unit.
    cells: f32,
    reach: usize,
    /// The cells that can have impulses that reach a point of the one in the middle.
    near: Vec<Near<D>>,
    /// The middles of those cells, as seen from the lower corner of that one, block by block.
    middles: Vec<[[f32; BLOCK]; D]>,
    /// The impulses of a cell: those for which every lane looks, so many, and those for which it first asks.
    slots: Vec<Slot<D>>,
    always: usize,
    /// The square of the distance, in [`UNIT`]s, beyond which impulses surely add nothing.
    far: f32,
    /// The waves about them.
    waves: Option<Waves<D>>,
}

impl<const D: usize> Lookout<D> {
    /// A block of the cells that are near.
    #[inline(always)]
    fn block(&self, block: usize) -> &[Near<D>] {
        let near = &self.near[block * BLOCK..];
        &near[..near.len().min(BLOCK)]
    }
}

/// A noise of impulses.
struct Impulses<const D: usize> {
    profile: Box<dyn Profile>,
    lookout: Lookout<D>,
    /// What sums are multiplied by.
    scale: f32,
}

/// Makes the field of a kernel for points of D coordinates.
///
/// # Panics
/// If the layout does not fit.
pub(super) fn field<const D: usize>(
    profile: Box<dyn Profile>,
    waves: Option<Waves<D>>,
    layout: &Layout,
    params: &Params,
) -> Result<Arc<dyn Field>, Unfit> {
    assert!(layout.fits(D), "{layout:?}");
    let (side, reach) = (layout.side(), layout.reach());
    let span = 2 * reach + 1;
    let all = (0..span.pow(D as u32))
        .map(|i| -> Near<D> { std::array::from_fn(|k| (i / span.pow(k as u32) % span) as u8) });
    // The distance from one cell to another must be less than the radius.
    let near = all.filter(|near| {
        let gap = near.map(|at| side * usize::from(at).abs_diff(reach).saturating_sub(1) as f64);
        gap.iter().map(|x| x * x).sum::<f64>() < layout.radius * layout.radius
    });
    let near: Vec<Near<D>> = near.collect();
    let middle = |at: u8| (f32::from(at) - reach as f32 + 0.5) * (1.0 / UNIT);
    let middles = near.chunks(BLOCK).map(|block| -> [[f32; BLOCK]; D] {
        std::array::from_fn(|k| {
            std::array::from_fn(|cell| block.get(cell).map_or(0.0, |near| middle(near[k])))
        })
    });
    let mean = layout.density * libm::pow(side, D as f64);
    let slots = slots(mean);
    let lookout = Lookout {
        lattice: Lattice::new(params.seed, Endless),
        periodic: params
            .period::<D>()?
            .map(|period| Lattice::new(params.seed, Periodic(period.map(|p| (f64::from(p) / side) as f32)))),
        cells: (1.0 / side) as f32,
        reach,
        middles: middles.collect(),
        near,
        always: always_looked_for(mean).min(slots.len()),
        slots,
        far: (libm::pow(layout.radius / side / f64::from(UNIT), 2.0) * 1.0001) as f32,
        waves,
    };
    let scale = (layout.scale * f64::from(SIZE)) as f32;
    Ok(Arc::new(Impulses { profile, lookout, scale }))
}

/// The impulses that a cell may have.
fn slots<const D: usize>(mean: f64) -> Vec<Slot<D>> {
    // Of the numbers even in -2^31 … 2^31 as many are above the k-th bound as of Poisson's above k.
    let (mut share, mut most) = (libm::exp(-mean), 0.0);
    let mut slots = vec![];
    for k in 0..MOST as u32 {
        most += share;
        share *= mean / f64::from(k + 1);
        let above = (most * 4_294_967_296.0 - 2_147_483_648.0).floor();
        if above >= f64::from(i32::MAX) {
            break;
        }
        let factor = |i: u32| hash::mix(8 * k + i + 1) | 1;
        slots.push(Slot {
            above: above as i32,
            place: std::array::from_fn(|i| factor(i as u32)),
            size: factor(4),
            word: factor(5),
        });
    }
    slots
}

/// How many of a cell's impulses it is best to look for without asking whether there are any.
fn always_looked_for(mean: f64) -> usize {
    if let Ok(k) = std::env::var("FIRST") {
        return k.parse().unwrap();
    }
    // One that is asked for, if any lane of a group has it, costs so many times more.
    const DEARER: f64 = 1.8;
    let (mut share, mut most) = (libm::exp(-mean), 0.0);
    let mut asked = [0.0; MOST];
    for (k, asked) in asked.iter_mut().enumerate() {
        most += share;
        share *= mean / (k + 1) as f64;
        *asked = DEARER * (1.0 - libm::pow(most.min(1.0), GROUP as f64));
    }
    let cost = |k: usize| k as f64 + asked[k..].iter().sum::<f64>();
    (0..MOST).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(0)
}

impl<const D: usize> Impulses<D> {
    /// The sums of all lanes, times `scale`.
    fn sum<const N: usize, const SLOPE: bool, const WAVES: bool>(
        &self,
        isa: Isa,
        scale: f32,
        p: &[&[f32]],
        out: [&mut [f32]; N],
    ) {
        let (noise, profile, p) = (&self.lookout, &*self.profile, &coordinates::<D>(p));
        let mut tile = Tile::new();
        for (start, end) in tiles(p[0].len()) {
            tile::locate(isa, noise, &mut tile, p, start, end);
            let mut sums: Sums<N> = [[0.0; TILE + GROUP]; N];
            for block in 0..noise.middles.len() {
                tile::look_up(isa, noise, &mut tile, block);
                let (tile, sums) = (&tile, &mut sums);
                isa.run(Add::<_, _, SLOPE, WAVES> { isa, noise, profile, tile, block, sums });
            }
            for n in 0..N {
                for (i, out) in out[n][start..end].iter_mut().enumerate() {
                    *out = sums[n][i] * scale + tile.poison[i];
                }
            }
        }
    }
}

impl<const D: usize> Field for Impulses<D> {
    fn noise(&self, isa: Isa, p: &[&[f32]], out: &mut [f32]) {
        if self.lookout.waves.is_none() {
            self.sum::<1, false, false>(isa, self.scale, p, [out]);
        } else {
            self.sum::<1, false, true>(isa, self.scale, p, [out]);
        }
    }

    fn derivative(&self, isa: Isa, p: &[&[f32]], out: &mut [&mut [f32]]) {
        assert_eq!(out.len(), D, "derivatives of {D} coordinates");
        let mut planes = out.iter_mut();
        let out: [&mut [f32]; D] = std::array::from_fn(|_| &mut **planes.next().expect("counted"));
        let scale = self.scale * self.lookout.cells;
        if self.lookout.waves.is_none() {
            self.sum::<D, true, false>(isa, scale, p, out);
        } else {
            self.sum::<D, true, true>(isa, scale, p, out);
        }
    }
}

/// The direction that is given, of length 1.
pub(super) fn direction<const D: usize>(params: &Params) -> Result<Option<[f64; D]>, Unfit> {
    let Some(given) = params.vector(Opt::Direction) else { return Ok(None) };
    let direction: [f32; D] = given.try_into().map_err(|_| {
        let message = format!(
            "direction needs a number for each of the point's {D} coordinates, found {}",
            given.len()
        );
        Unfit::of(Opt::Direction, message)
    })?;
    let length = direction.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() {
        Ok(Some(direction.map(|x| f64::from(x) / length)))
    } else {
        Err(Unfit::of(Opt::Direction, format!("direction must have a length, found {direction:?}")))
    }
}
