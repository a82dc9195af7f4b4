//! What lattice noises share: which lattice points are the same, and the hashes of lattice points.
//!
//! - Coordinates are cut by `floor`, so cells are of the same size on both sides of zero.
//! - From ±2^23 on every f32 is an integer, so the point is a lattice point and noise is its value.
//! - NaN and infinities give NaN.

use super::hash;
use crate::lanes::array;

/// Which lattice points are the same.
pub(super) trait Wrap<const D: usize>: Copy + Send + Sync {
    /// Of the coordinate of a lattice point, that of the point whose random numbers it has.
    fn wrap(&self, low: f32, axis: usize) -> f32;
    /// [`hash::whole`] of those of the lower and of the upper corner of a cell.
    #[inline(always)]
    fn ends(&self, low: f32, axis: usize) -> [u32; 2] {
        array(|end| hash::whole(self.wrap(low + end as f32, axis)))
    }
}

/// None: noise never repeats.
#[derive(Clone, Copy)]
pub(super) struct Endless;

impl<const D: usize> Wrap<D> for Endless {
    #[inline(always)]
    fn wrap(&self, low: f32, _: usize) -> f32 {
        low
    }

    #[inline(always)]
    fn ends(&self, low: f32, _: usize) -> [u32; 2] {
        let whole = hash::whole(low);
        [whole, whole.wrapping_add(1)]
    }
}

/// Those that lie a period apart along an axis; 0 for an axis along which noise does not repeat.
#[derive(Clone, Copy)]
pub(super) struct Periodic<const D: usize>(pub [f32; D]);

impl<const D: usize> Periodic<D> {
    /// What remains of a whole number after whole periods. No period is one of 0, with which all corrections are 0:
    /// to ask for it, the same in all lanes, would make the compiler write out the loops for each answer.
    #[inline(always)]
    fn rest(&self, low: f32, period: f32) -> f32 {
        let share = if period > 0.0 { 1.0 / period } else { 0.0 };
        // The product may be rounded up to the next integer, or the point lie so far out that the other one is not
        // exact: then the remainder is off by a period at most, or the point beyond 2^23.
        let rest = low - (low * share).floor() * period;
        let rest = if rest < 0.0 { rest + period } else { rest };
        if rest >= period { rest - period } else { rest }
    }
}

impl<const D: usize> Wrap<D> for Periodic<D> {
    #[inline(always)]
    fn wrap(&self, low: f32, axis: usize) -> f32 {
        self.rest(low, self.0[axis])
    }

    #[inline(always)]
    fn ends(&self, low: f32, axis: usize) -> [u32; 2] {
        let period = self.0[axis];
        let rest = self.rest(low, period);
        let (lower, end) = (hash::whole(rest), hash::whole(period));
        let upper = lower.wrapping_add(1);
        [lower, if upper == end { hash::whole(0.0) } else { upper }]
    }
}

/// The integer lattice of a seed, of which some points may be the same.
#[derive(Clone, Copy)]
pub(super) struct Lattice<W, const D: usize> {
    seed: u32,
    wrap: W,
}

impl<W: Wrap<D>, const D: usize> Lattice<W, D> {
    /// That of a user's seed.
    pub(super) fn new(seed: u32, wrap: W) -> Lattice<W, D> {
        Lattice { seed: hash::seed(seed) ^ hash::seed(0), wrap }
    }

    /// Which lattice points are the same.
    pub(super) fn wrapping(&self) -> W {
        self.wrap
    }

    /// What is random along an axis with this lattice's seed.
    pub(super) fn seed(&self, axis: usize) -> u32 {
        hash::mix(hash::key(axis as u32 + 1, axis) ^ self.seed)
    }

    /// The hash of a lattice point's coordinate (a whole number) along an axis. The exclusive or of those of all
    /// axes goes to [`hash::point`] to become the point's; that of the first axis has the seed in it.
    #[inline(always)]
    pub(super) fn key(&self, axis: usize, coordinate: f32) -> u32 {
        // The key of an integer is its own bit pattern: exact at any size, and no conversion can overflow.
        // Adding zero makes one of the two zeros.
        let key = (self.wrap.wrap(coordinate, axis) + 0.0).to_bits();
        // The seed goes in before the hash: two seeds then differ otherwise at every coordinate. (Put in after it
        // they would differ by the same bits everywhere, and hashes of points that differ so are not all unrelated.)
        let (seed, origin) = if axis == 0 { (self.seed, hash::seed(0)) } else { (0, 0) };
        hash::axis(key ^ seed, axis) ^ origin
    }
}

/// Makes the field of a lattice algorithm: for each number of dimensions listed. `|lattice| algorithm` is the
/// [`Tiled`](super::field::Tiled) algorithm on a [`Lattice`], whatever its dimension. `fast` before all makes a field
/// of its own for a lattice without a period, which is some percent faster, and twice as long to compile.
macro_rules! lattice_field {
    (fast $dimensions:expr, $params:expr, [$($d:literal)*], |$lattice:ident| $algorithm:expr) => {{
        use $crate::noise::{field::ByTiles, lattice::{Endless, Lattice, lattice_field}, options::Params};
        let (dimensions, params): (usize, &Params) = ($dimensions, $params);
        let endless: Option<std::sync::Arc<dyn $crate::noise::Field>> = match dimensions {
            $($d if params.period::<$d>()?.is_none() => {
                let $lattice = Lattice::<Endless, $d>::new(params.seed, Endless);
                Some(std::sync::Arc::new(ByTiles::<_, $d>($algorithm)))
            },)*
            _ => None,
        };
        match endless {
            Some(field) => Ok(field),
            None => lattice_field!(dimensions, params, [$($d)*], |$lattice| $algorithm),
        }
    }};
    ($dimensions:expr, $params:expr, [$($d:literal)*], |$lattice:ident| $algorithm:expr) => {{
        use $crate::noise::{field::ByTiles, lattice::{Lattice, Periodic}};
        let (dimensions, params): (usize, &$crate::noise::options::Params) = ($dimensions, $params);
        Ok(match dimensions {
            $($d => {
                // A period of 0 is none.
                let period = params.period::<$d>()?.unwrap_or([0.0; $d]);
                let $lattice = Lattice::<_, $d>::new(params.seed, Periodic(period));
                std::sync::Arc::new(ByTiles::<_, $d>($algorithm)) as std::sync::Arc<dyn $crate::noise::Field>
            },)*
            _ => unreachable!("the kind has no such dimension"),
        })
    }};
}
pub(super) use lattice_field;
