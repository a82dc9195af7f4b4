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
    Bell, CatmullRom, Curve, GAUSSIAN_RADIUS, Gabor, Profile, Radial, STEPS, integral, mean_cosine,
};
pub(super) use waves::Waves;

use super::field::{Field, coordinates, tiles};
use super::hash;
use super::kind::Unfit;
use super::lattice::{Endless, Lattice, Periodic};
use super::options::{Opt, Params};
use crate::lanes::Isa;
use std::sync::Arc;
use sum::{Add, Called, Fused, Part, Sums};
use tile::{BLOCK, GROUP, ROW, Tile};

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

    /// Whether the cells are large enough for the kernel.
    pub(super) fn reaches(&self) -> bool {
        (1..=REACH).contains(&self.reach())
    }

    /// Whether it can be summed.
    pub(super) fn fits(&self, dimensions: usize) -> bool {
        let mean = self.density * libm::pow(self.side(), dimensions as f64);
        self.reaches() && (LEAST as f32..=CROWD as f32).contains(&(mean as f32))
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

/// A cell near a point's own: along each axis where its row begins in [`Tile::seen`].
type Near<const D: usize> = [u16; D];

/// A Poisson process: where impulses are.
struct Process<const D: usize> {
    lattice: Lattice<Endless, D>,
    periodic: Option<Lattice<Periodic<D>, D>>,
    /// Cells a unit.
    cells: f32,
    reach: usize,
    /// The cells that can have impulses that reach a point of the one in the middle.
    near: Vec<Near<D>>,
    /// The middles of those cells, as seen from the lower corner of that one, block by block.
    middles: Vec<[[f32; BLOCK]; D]>,
    /// The impulses of a cell: so many for which every lane looks, and those for which it first asks.
    slots: Vec<Slot<D>>,
    always: usize,
    /// The square of the distance, in [`UNIT`]s, beyond which impulses surely add nothing.
    far: f32,
}

impl<const D: usize> Process<D> {
    fn new(layout: &Layout, params: &Params) -> Result<Process<D>, Unfit> {
        assert!(layout.fits(D), "{layout:?}");
        let (side, reach) = (layout.side(), layout.reach());
        let span = 2 * reach + 1;
        let all = (0..span.pow(D as u32))
            .map(|i| -> [usize; D] { std::array::from_fn(|k| i / span.pow(k as u32) % span) });
        // The distance from one cell to another must be less than the radius.
        let near: Vec<[usize; D]> = all
            .filter(|near| {
                let gap = near.map(|at| side * at.abs_diff(reach).saturating_sub(1) as f64);
                gap.iter().map(|x| x * x).sum::<f64>() < layout.radius * layout.radius
            })
            .collect();
        let middle = |at: usize| (at as f32 - reach as f32 + 0.5) * (1.0 / UNIT);
        let middles = near.chunks(BLOCK).map(|block| -> [[f32; BLOCK]; D] {
            std::array::from_fn(|k| {
                std::array::from_fn(|cell| block.get(cell).map_or(0.0, |near| middle(near[k])))
            })
        });
        let mean = layout.density * libm::pow(side, D as f64);
        let slots = slots(mean);
        Ok(Process {
            lattice: Lattice::new(params.seed, Endless),
            periodic: params.period::<D>()?.map(|period| {
                Lattice::new(params.seed, Periodic(period.map(|p| (f64::from(p) / side) as f32)))
            }),
            cells: (1.0 / side) as f32,
            reach,
            middles: middles.collect(),
            near: near.iter().map(|near| near.map(|at| (at * ROW) as u16)).collect(),
            always: always(mean).min(slots.len()),
            slots,
            far: (libm::pow(layout.radius / side / f64::from(UNIT), 2.0) * 1.0001) as f32,
        })
    }

    /// A block of the cells that are near.
    #[inline(always)]
    fn block(&self, block: usize) -> &[Near<D>] {
        let near = &self.near[block * BLOCK..];
        &near[..near.len().min(BLOCK)]
    }

    /// The sums of all lanes, times `scale`.
    ///
    /// # Panics
    /// If there are not as many coordinates, or if lengths differ.
    fn sum<P: Part<D, N, SLOPE>, const N: usize, const SLOPE: bool>(
        &self,
        isa: Isa,
        what: P,
        scale: f32,
        p: &[&[f32]],
        out: [&mut [f32]; N],
    ) {
        let p = &coordinates::<D>(p);
        let lanes = p[0].len();
        let same = |length: usize| length == lanes;
        assert!(
            p.iter().all(|p| same(p.len())) && out.iter().all(|out| same(out.len())),
            "lanes of different lengths"
        );
        let mut tile = Tile::new();
        for (start, end) in tiles(lanes) {
            tile::locate(isa, self, &mut tile, p, start, end);
            let mut sums: Sums<N> = [[0.0; ROW]; N];
            for block in 0..self.middles.len() {
                tile::look_up(isa, self, &mut tile, block);
                isa.run(Add { isa, process: self, what, tile: &tile, block, sums: &mut sums });
            }
            for n in 0..N {
                for (i, out) in out[n][start..end].iter_mut().enumerate() {
                    *out = sums[n][i] * scale + tile.poison[i];
                }
            }
        }
    }
}

/// A noise of impulses.
struct Impulses<K, const D: usize> {
    kernel: K,
    process: Process<D>,
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
    let (process, scale) = (Process::<D>::new(layout, params)?, layout.scale as f32 * SIZE);
    Ok(Arc::new(Impulses { kernel: Any { profile, waves }, process, scale }))
}

/// The same, faster, of a kernel that is compiled into the loops; which makes them larger.
///
/// # Panics
/// If the layout does not fit.
pub(super) fn fused_field<R: Radial, const D: usize>(
    kernel: R,
    layout: &Layout,
    params: &Params,
) -> Result<Arc<dyn Field>, Unfit> {
    let (process, scale) = (Process::<D>::new(layout, params)?, layout.scale as f32 * SIZE);
    Ok(Arc::new(Impulses { kernel: Fused(kernel), process, scale }))
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
        // Odd numbers without simple relations.
        let factor = |i: u32| hash::seed(8 * k + i) | 1;
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
fn always(mean: f64) -> usize {
    // One that is asked for, if any lane of a group has it, costs so many times more.
    const DEARER: f64 = 2.5;
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

/// A kernel that is called.
struct Any<const D: usize> {
    profile: Box<dyn Profile>,
    waves: Option<Waves<D>>,
}

impl<const D: usize> Impulses<Any<D>, D> {
    fn called(&self) -> Called<'_, D> {
        Called { profile: &*self.kernel.profile, waves: self.kernel.waves }
    }
}

impl<const D: usize> Field for Impulses<Any<D>, D> {
    fn noise(&self, isa: Isa, p: &[&[f32]], out: &mut [f32]) {
        self.process.sum::<_, 1, false>(isa, self.called(), self.scale, p, [out]);
    }

    fn derivative(&self, isa: Isa, p: &[&[f32]], out: &mut [&mut [f32]]) {
        let (scale, out) = (self.scale * self.process.cells, outputs(out));
        self.process.sum::<_, D, true>(isa, self.called(), scale, p, out);
    }
}

impl<R: Radial, const D: usize> Field for Impulses<Fused<R>, D> {
    fn noise(&self, isa: Isa, p: &[&[f32]], out: &mut [f32]) {
        self.process.sum::<_, 1, false>(isa, self.kernel, self.scale, p, [out]);
    }

    fn derivative(&self, isa: Isa, p: &[&[f32]], out: &mut [&mut [f32]]) {
        let (scale, out) = (self.scale * self.process.cells, outputs(out));
        self.process.sum::<_, D, true>(isa, self.kernel, scale, p, out);
    }
}

/// As many outputs as coordinates.
///
/// # Panics
/// If there are more or fewer.
fn outputs<'a, const D: usize>(out: &'a mut [&mut [f32]]) -> [&'a mut [f32]; D] {
    assert_eq!(out.len(), D, "derivatives of {D} coordinates");
    let mut planes = out.iter_mut();
    std::array::from_fn(|_| &mut **planes.next().expect("counted"))
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

#[cfg(test)]
mod tests;
