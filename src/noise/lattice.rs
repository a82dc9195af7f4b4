//! What lattice noises share: the hashes of lattice points, and the blend of the corners of a cell.
//!
//! The noises of Perlin give each lattice point a linear function, value + gradient · (p − point), and blend
//! those of the corners of the cell about p, first in x, then in y, then in z (Perlin 1985, "Noise()").
//! Fewer coordinates than three are the same noise with the others 0, bit for bit.
//!
//! - Coordinates are cut by `floor`, so cells are of the same size on both sides of zero.
//! - From ±2^23 on every f32 is an integer, so the point is a lattice point and noise is its value.
//! - NaN and infinities give NaN.

// Loops over axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::direction::direction;
use super::field::{Jet, Pointwise};
use super::hash;

/// Which lattice points are the same.
pub(super) trait Wrap<const D: usize>: Copy + Send + Sync {
    /// Of the coordinate of a lattice point, that of the point whose random numbers it has.
    fn wrap(&self, low: f32, axis: usize) -> f32;
}

/// None: noise never repeats.
#[derive(Clone, Copy)]
pub(super) struct Endless;

impl<const D: usize> Wrap<D> for Endless {
    #[inline(always)]
    fn wrap(&self, low: f32, _: usize) -> f32 {
        low
    }
}

/// Those that lie a period apart along an axis; 0 for an axis along which noise does not repeat.
#[derive(Clone, Copy)]
pub(super) struct Periodic<const D: usize>(pub [f32; D]);

impl<const D: usize> Wrap<D> for Periodic<D> {
    #[inline(always)]
    fn wrap(&self, low: f32, axis: usize) -> f32 {
        let period = self.0[axis];
        // The quotient may be rounded up to the next integer, or the point lie so far out that the product
        // is not exact: then the remainder is off by a period at most, or the point beyond 2^23.
        let rest = low - (low / period).floor() * period;
        let rest = if rest < 0.0 { rest + period } else { rest };
        let rest = if rest >= period { rest - period } else { rest };
        if period > 0.0 { rest } else { low }
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

    /// The hash of a lattice point's coordinate (a whole number) along an axis. The exclusive or of those of all
    /// axes goes to [`hash::point`] to become the point's; that of the first axis has the seed in it.
    #[inline(always)]
    pub(super) fn key(&self, axis: usize, coordinate: f32) -> u32 {
        // The key of an integer is its own bit pattern: exact at any size, and no conversion can overflow.
        // Adding zero makes one of the two zeros.
        let key = (self.wrap.wrap(coordinate, axis) + 0.0).to_bits();
        // The seed goes in before the hash: two seeds then differ otherwise at every coordinate. (Put in after it
        // they would differ by the same bits everywhere, and hashes of points that differ so are not all unrelated.)
        if axis == 0 { hash::axis(key ^ self.seed, 0) ^ hash::seed(0) } else { hash::axis(key, axis) }
    }
}

/// Makes the field of a lattice algorithm: for each number of dimensions listed. `|lattice| algorithm` is the
/// [`Pointwise`] algorithm on a [`Lattice`], whatever its dimension. An algorithm of another sort has the name of its
/// field before that, in place of `Each`. `fast` before all makes a field of its own for a lattice without a period,
/// which is some percent faster, and twice as long to compile.
macro_rules! lattice_field {
    (fast $dimensions:expr, $params:expr, [$($d:literal)*], |$lattice:ident| $algorithm:expr) => {{
        use $crate::noise::{field::Each, lattice::{Endless, Lattice, lattice_field}, options::Params};
        let (dimensions, params): (usize, &Params) = ($dimensions, $params);
        let endless: Option<std::sync::Arc<dyn $crate::noise::Field>> = match dimensions {
            $($d if params.period::<$d>()?.is_none() => {
                let $lattice = Lattice::<Endless, $d>::new(params.seed, Endless);
                Some(std::sync::Arc::new(Each::<_, $d>($algorithm)))
            },)*
            _ => None,
        };
        match endless {
            Some(field) => Ok(field),
            None => lattice_field!(dimensions, params, [$($d)*], |$lattice| $algorithm),
        }
    }};
    ($dimensions:expr, $params:expr, [$($d:literal)*], |$lattice:ident| $algorithm:expr) => {{
        use $crate::noise::{field::Each, lattice::lattice_field};
        lattice_field!($dimensions, $params, [$($d)*], Each |$lattice| $algorithm)
    }};
    ($dimensions:expr, $params:expr, [$($d:literal)*], $field:ident |$lattice:ident| $algorithm:expr) => {{
        use $crate::noise::lattice::{Lattice, Periodic};
        let (dimensions, params): (usize, &$crate::noise::options::Params) = ($dimensions, $params);
        Ok(match dimensions {
            $($d => {
                // A period of 0 is none.
                let period = params.period::<$d>()?.unwrap_or([0.0; $d]);
                let $lattice = Lattice::<_, $d>::new(params.seed, Periodic(period));
                std::sync::Arc::new($field::<_, $d>($algorithm)) as std::sync::Arc<dyn $crate::noise::Field>
            },)*
            _ => unreachable!("the kind has no such dimension"),
        })
    }};
}
pub(super) use lattice_field;

/// The linear functions of one algorithm. Their gradients are [`direction`]s.
pub trait Planes: Copy + Send + Sync {
    /// What the whole is multiplied by, once in the end.
    const SCALE: f32;
    /// The value, at an offset from it, of the linear function of the lattice point with this hash.
    fn height<const D: usize>(hash: u32, offset: [f32; D]) -> f32;
    /// The weight of the upper corner along an axis, at t from the lower one, and its derivative.
    #[inline(always)]
    fn weight(t: f32) -> (f32, f32) {
        // 3t² - 2t³: 0 and 1 at the ends, with slopes 0.
        (t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t))
    }
    /// The offsets along an axis from the lower and the upper corner that heights are taken at, and their
    /// derivatives.
    #[inline(always)]
    fn offsets(t: f32) -> ([f32; 2], [f32; 2]) {
        ([t, t - 1.0], [1.0; 2])
    }
}

/// A point within its cell.
#[derive(Clone, Copy)]
struct Cell<const D: usize> {
    /// Hashes of the lower and the upper corner, by axis; those of the first axis with the seed.
    keys: [[u32; 2]; D],
    /// The point as seen from the lower and from the upper corner.
    offset: [[f32; 2]; D],
    /// The derivatives of the offsets.
    stretch: [[f32; 2]; D],
    /// The weight of the upper corner.
    weight: [f32; D],
    /// The derivative of the weight.
    slope: [f32; D],
}

/// The weighted mean.
#[inline(always)]
fn lerp(w: f32, a: f32, b: f32) -> f32 {
    a + w * (b - a)
}

impl<const D: usize> Cell<D> {
    /// Finds the cell of a point.
    #[inline(always)]
    fn new<P: Planes, W: Wrap<D>>(p: [f32; D], lattice: &Lattice<W, D>) -> Cell<D> {
        let (two, one) = ([[0.0; 2]; D], [0.0; D]);
        let mut cell = Cell { keys: [[0; 2]; D], offset: two, stretch: two, weight: one, slope: one };
        for k in 0..D {
            let low = p[k].floor();
            cell.keys[k] = [lattice.key(k, low), lattice.key(k, low + 1.0)];
            let t = p[k] - low;
            (cell.offset[k], cell.stretch[k]) = P::offsets(t);
            (cell.weight[k], cell.slope[k]) = P::weight(t);
        }
        cell
    }

    /// Hash and offset of a corner; bit k of its number tells which end of axis k it is at.
    #[inline(always)]
    fn corner(&self, corner: usize) -> (u32, [f32; D]) {
        // An axis that is not given counts as 0, whose hash is 0.
        let mut joined = 0;
        let mut offset = [0.0; D];
        for k in 0..D {
            joined ^= self.keys[k][corner >> k & 1];
            offset[k] = self.offset[k][corner >> k & 1];
        }
        (hash::point(joined), offset)
    }

    #[inline(always)]
    fn corner_value<P: Planes>(&self, corner: usize) -> f32 {
        let (hash, offset) = self.corner(corner);
        P::height(hash, offset)
    }

    // The blends of one more axis each. Straight code rather than loops over corners: a loop within
    // the loop over lanes would keep the latter from being vectorised.

    #[inline(always)]
    fn along_x<P: Planes>(&self, base: usize) -> f32 {
        lerp(self.weight[0], self.corner_value::<P>(base), self.corner_value::<P>(base + 1))
    }

    #[inline(always)]
    fn along_y<P: Planes>(&self, base: usize) -> f32 {
        lerp(self.weight[1 % D], self.along_x::<P>(base), self.along_x::<P>(base + 2))
    }

    #[inline(always)]
    fn along_z<P: Planes>(&self, base: usize) -> f32 {
        lerp(self.weight[2 % D], self.along_y::<P>(base), self.along_y::<P>(base + 4))
    }

    /// The noise at the point.
    #[inline(always)]
    fn value<P: Planes>(&self) -> f32 {
        let sum = match D {
            1 => self.along_x::<P>(0),
            2 => self.along_y::<P>(0),
            3 => self.along_z::<P>(0),
            _ => lerp(self.weight[3 % D], self.along_z::<P>(0), self.along_z::<P>(8)),
        };
        sum * P::SCALE
    }

    #[inline(always)]
    fn corner_jet<P: Planes>(&self, corner: usize) -> Jet<D> {
        let (hash, offset) = self.corner(corner);
        let mut gradient = direction(hash);
        for k in 0..D {
            gradient[k] *= self.stretch[k][corner >> k & 1];
        }
        Jet { value: P::height(hash, offset), gradient }
    }

    /// Blends along an axis: to its own derivative the change of the weight adds.
    #[inline(always)]
    fn blend(&self, axis: usize, a: Jet<D>, b: Jet<D>) -> Jet<D> {
        let axis = axis % D;
        let w = self.weight[axis];
        let mut gradient = [0.0; D];
        for k in 0..D {
            gradient[k] = lerp(w, a.gradient[k], b.gradient[k]);
        }
        let step = b.value - a.value;
        gradient[axis] += self.slope[axis] * step;
        Jet { value: a.value + w * step, gradient }
    }

    #[inline(always)]
    fn jet_x<P: Planes>(&self, base: usize) -> Jet<D> {
        self.blend(0, self.corner_jet::<P>(base), self.corner_jet::<P>(base + 1))
    }

    #[inline(always)]
    fn jet_y<P: Planes>(&self, base: usize) -> Jet<D> {
        self.blend(1, self.jet_x::<P>(base), self.jet_x::<P>(base + 2))
    }

    #[inline(always)]
    fn jet_z<P: Planes>(&self, base: usize) -> Jet<D> {
        self.blend(2, self.jet_y::<P>(base), self.jet_y::<P>(base + 4))
    }

    /// The noise at the point, and its derivative.
    #[inline(always)]
    fn jet<P: Planes>(&self) -> Jet<D> {
        let jet = match D {
            1 => self.jet_x::<P>(0),
            2 => self.jet_y::<P>(0),
            3 => self.jet_z::<P>(0),
            _ => self.blend(3, self.jet_z::<P>(0), self.jet_z::<P>(8)),
        };
        Jet { value: jet.value * P::SCALE, gradient: jet.gradient.map(|g| g * P::SCALE) }
    }
}

/// The noise of linear functions on a lattice.
#[derive(Clone, Copy)]
pub(super) struct Linear<P, W, const D: usize> {
    lattice: Lattice<W, D>,
    planes: std::marker::PhantomData<P>,
}

impl<P: Planes, W: Wrap<D>, const D: usize> Linear<P, W, D> {
    /// On this lattice.
    pub(super) fn new(lattice: Lattice<W, D>) -> Self {
        Linear { lattice, planes: std::marker::PhantomData }
    }
}

impl<P: Planes, W: Wrap<D>, const D: usize> Pointwise<D> for Linear<P, W, D> {
    #[inline(always)]
    fn value(&self, p: [f32; D]) -> f32 {
        Cell::new::<P, W>(p, &self.lattice).value::<P>()
    }

    #[inline(always)]
    fn jet(&self, p: [f32; D]) -> Jet<D> {
        Cell::new::<P, W>(p, &self.lattice).jet::<P>()
    }
}
