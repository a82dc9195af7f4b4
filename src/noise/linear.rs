//! The noise of linear functions on a lattice: how a tile of lanes is computed.
//!
//! The noises of Perlin give each lattice point a linear function, value + gradient · (p − point), and blend
//! those of the corners of the cell about p (Perlin 1985, "Noise()"). Fewer coordinates than three are the same
//! noise with the others 0, bit for bit.
//!
//! - Coordinates are cut by `floor`, so cells are of the same size on both sides of zero.
//! - From ±2^22 on, where an f32 knows halves of a cell at most, cells need not join, and two neighbouring lattice
//!   points may be alike. From ±2^23 on every f32 is an integer, so the point is a lattice point and noise is its
//!   value.
//! - NaN and infinities give NaN.
//!
//! A tile goes through short loops rather than one long one: first what the axes need, then each corner, then their
//! blend (for derivatives, the corners of a column, and then the blend of columns). In one loop the constants and what is known of the
//! axes don't fit into the registers, and its chains of operations are too long for the processor to work
//! on several of them at once (`docs/performance.md`). Each loop is straight code over lanes.

// Loops over lanes and axes index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::direction::{ARC, arc};
use super::field::{Field, Jet, TILE, WIDTH, coordinates, tiles};
use super::hash;
use super::lattice::{Lattice, Wrap};
use crate::lanes::{Isa, Kernel, array};

/// What the noises differ in. Its functions must be `#[inline(always)]`.
pub(super) trait Planes: Copy + Send + Sync {
    /// What the whole is multiplied by, gradients being of length 1.
    const SCALE: f32;
    /// Values of lattice points are even in -VALUE … VALUE.
    const VALUE: f32;
    /// Whether [`Planes::offsets`] have other derivatives than 1.
    const STRETCHES: bool = false;
    /// The weight of the upper corner along an axis, at t from the lower one, and its derivative.
    #[inline(always)]
    fn weight(t: f32) -> (f32, f32) {
        // 3t² - 2t³: 0 and 1 at the ends, with slopes 0.
        (t * t * (3.0 - (t + t)), 6.0 * t * (1.0 - t))
    }
    /// The offsets along an axis from the lower and the upper corner that the linear functions are taken at,
    /// in 1/`unit`.
    #[inline(always)]
    fn offsets(t: f32, unit: f32) -> [f32; 2] {
        let offset = t * unit;
        [offset, offset - unit]
    }
    /// The derivatives of the offsets.
    #[inline(always)]
    fn stretches(_: f32) -> [f32; 2] {
        [1.0; 2]
    }
}

/// A noise of linear functions on a lattice.
#[derive(Clone, Copy)]
pub(super) struct Linear<P, W, const D: usize> {
    wrap: W,
    /// What the seed adds to the keys along each axis.
    seeds: [u32; 4],
    /// [`hash::FURTHER`].
    further: [u32; 3],
    planes: std::marker::PhantomData<P>,
}

/// Its field.
pub(super) struct Tiled<A, const D: usize>(pub A);

impl<P: Planes, W: Wrap<D>, const D: usize> Field for Tiled<Linear<P, W, D>, D> {
    fn noise(&self, isa: Isa, p: &[&[f32]], out: &mut [f32]) {
        isa.run(Values { linear: &self.0, p: coordinates(p), out });
    }

    fn derivative(&self, isa: Isa, p: &[&[f32]], out: &mut [&mut [f32]]) {
        assert_eq!(out.len(), D, "derivatives of {D} coordinates");
        isa.run(Derivatives { linear: &self.0, p: coordinates(p), out });
    }
}

impl<P: Planes, W: Wrap<D>, const D: usize> Linear<P, W, D> {
    /// On this lattice.
    pub(super) fn new(lattice: Lattice<W, D>) -> Self {
        let seeds = array(|axis| lattice.seed(axis));
        Linear { wrap: lattice.wrapping(), seeds, further: hash::FURTHER, planes: std::marker::PhantomData }
    }

    /// The keys of the lower and of the upper corner along an axis.
    #[inline(always)]
    fn keys(&self, low: f32, axis: usize) -> [u32; 2] {
        let ends = self.wrap.ends(low, axis);
        array(|end| hash::key(ends[end], axis).wrapping_add(self.seeds[axis]))
    }

    /// The key along an axis that is not given, which counts as 0.
    #[inline(always)]
    fn origin(&self, axis: usize) -> u32 {
        hash::key(hash::whole(0.0), axis).wrapping_add(self.seeds[axis])
    }
}

/// Random numbers as integers are so many times as large.
const WHOLE: f32 = (1_u32 << 31) as f32;
const SQUARE: f32 = WHOLE * WHOLE;

/// A number in -[`WHOLE`] … [`WHOLE`].
#[inline(always)]
fn number(bits: u32) -> f32 {
    bits as i32 as f32
}

/// Changes the sign by the uppermost bit.
#[inline(always)]
fn turn(v: f32, bits: u32) -> f32 {
    f32::from_bits(v.to_bits() ^ (bits & (1 << 31)))
}

/// The units of offsets along the axes, for [`height`]. On a sphere each coordinate is evenly distributed
/// (Archimedes): so is the first component of a gradient; the others go round a circle of what remains. In four
/// dimensions they go round two circles, whose radii squared share 1 evenly (Marsaglia 1972).
const fn units<const D: usize>() -> [f32; 4] {
    let (cos, sin) = (ARC[0] / (SQUARE * WHOLE), ARC[1] / SQUARE);
    if D == 4 { [cos, sin, cos, sin] } else { [WHOLE, cos, sin, 0.0] }
}

/// The linear function of the lattice point with this hash, at an offset, times [`SQUARE`].
///
/// Random numbers stay integers, and their squares and cubes are as large as they come out: what makes them
/// numbers about 1 is in the units of the offsets, which are so many times smaller, and is multiplied once for
/// all corners.
#[inline(always)]
fn height<P: Planes, const D: usize>(further: [u32; 3], hash: u32, offset: [f32; D]) -> f32 {
    let first = number(hash);
    // The sum of the components of a circle, turned to either half of it.
    let around = |bits: u32, cos: usize, sin: usize| {
        let (c, s) = arc(number(bits << 1), SQUARE);
        let along = c * offset[cos % D];
        turn(if sin < D { along + s * offset[sin % D] } else { along }, bits)
    };
    let mut sum = first * offset[0];
    if D == 4 {
        let share = (first + WHOLE) * (WHOLE / 2.0);
        let [a, b, _] = number_of(further, hash);
        sum = share.sqrt() * around(a, 0, 1) + (SQUARE - share).sqrt() * around(b, 2, 3);
    } else if D > 1 {
        sum += (SQUARE - first * first).sqrt() * around(number_of(further, hash)[0], 1, 2);
    }
    if P::VALUE == 0.0 { sum } else { sum + number(number_of(further, hash)[2]) * (P::VALUE * WHOLE) }
}

/// More random numbers of a lattice point.
#[inline(always)]
fn number_of(further: [u32; 3], hash: u32) -> [u32; 3] {
    array(|i| hash.wrapping_mul(further[i]))
}

/// The units of gradients along the axes, and of offsets, for [`jet`].
const fn jet_units<const D: usize>() -> [f32; 4] {
    if D == 4 { [ARC[0], ARC[1], ARC[0], ARC[1]] } else { [1.0, ARC[0], ARC[1], 0.0] }
}

/// The linear function and its gradient, times [`WHOLE`].
#[inline(always)]
fn jet<P: Planes, const D: usize>(further: [u32; 3], hash: u32, offset: [f32; D]) -> Jet<D> {
    let first = number(hash);
    let mut gradient = [first; D];
    let mut around = |bits: u32, radius: f32, cos: usize, sin: usize| {
        let (c, s) = arc(number(bits << 1) * (1.0 / WHOLE), 1.0);
        let radius = turn(radius, bits);
        gradient[cos % D] = radius * c;
        if sin < D {
            gradient[sin % D] = radius * s;
        }
    };
    if D == 4 {
        let share = (first + WHOLE) * (WHOLE / 2.0);
        let [a, b, _] = number_of(further, hash);
        around(a, share.sqrt(), 0, 1);
        around(b, (SQUARE - share).sqrt(), 2, 3);
    } else if D > 1 {
        around(number_of(further, hash)[0], (SQUARE - first * first).sqrt(), 1, 2);
    }
    let mut value = gradient[0] * offset[0];
    for k in 1..D {
        value += gradient[k] * offset[k];
    }
    if P::VALUE != 0.0 {
        value += number(number_of(further, hash)[2]) * P::VALUE;
    }
    Jet { value, gradient }
}

/// The weighted mean.
#[inline(always)]
fn lerp(w: f32, a: f32, b: f32) -> f32 {
    a + w * (b - a)
}

/// Rows that begin where cache lines do, so that no vector lies across two.
#[repr(align(64))]
struct Aligned<T>(T);

type Row<T> = [T; TILE];

/// What the corners need to know of the lanes of a tile.
struct Tile<const D: usize> {
    p: [Row<f32>; D],
    /// The factors of the corners' hashes: of both ends along x and y, and of both along z and w.
    columns: [Row<u32>; 4],
    stacks: [Row<u32>; D],
    /// The point as seen from the lower and from the upper corner, in the units of the axes.
    offsets: [[Row<f32>; 2]; D],
    /// The weights of the upper corners.
    weights: [Row<f32>; D],
}

/// What derivatives need beside that.
struct Slopes<const D: usize> {
    /// The derivatives of the weights, in the units of the axes.
    weights: [Row<f32>; D],
    /// The derivatives of the offsets.
    offsets: [[Row<f32>; 2]; D],
}

#[inline(always)]
fn store(out: &mut [f32], row: &Row<f32>) {
    match <&mut Row<f32>>::try_from(&mut *out) {
        Ok(out) => *out = *row,
        Err(_) => out.copy_from_slice(&row[..out.len()]),
    }
}

/// The most corners that a cell has.
const MOST: usize = 16;

/// How many corners there are in x and y.
const fn columns<const D: usize>() -> usize {
    if D == 1 { 2 } else { 4 }
}

impl<const D: usize> Tile<D> {
    fn new() -> Aligned<Self> {
        let (row, whole) = ([0.0; TILE], [0; TILE]);
        let (p, offsets, weights) = ([row; D], [[row; 2]; D], [row; D]);
        Aligned(Tile { p, columns: [whole; 4], stacks: [whole; D], offsets, weights })
    }

    /// Fills it with lanes, and tells how many to work on.
    #[inline(always)]
    fn fill<P: Planes, W: Wrap<D>>(
        &mut self,
        linear: &Linear<P, W, D>,
        p: &[&[f32]; D],
        (start, end): (usize, usize),
        units: [f32; 4],
        mut slopes: Option<&mut Slopes<D>>,
    ) -> usize {
        for (row, p) in self.p.iter_mut().zip(p) {
            // Of a length that is known, most often.
            match p[start..end].try_into() {
                Ok(tile) => *row = tile,
                Err(_) => row[..end - start].copy_from_slice(&p[start..end]),
            }
        }
        let work = (end - start).next_multiple_of(WIDTH).min(TILE);
        for i in 0..work {
            let x = self.axis(linear, 0, i, units, &mut slopes);
            let y = if D > 1 { self.axis(linear, 1, i, units, &mut slopes) } else { [linear.origin(1); 2] };
            for j in 0..columns::<D>() {
                self.columns[j][i] = hash::column(x[j & 1] ^ y[j >> 1]);
            }
            if D > 2 {
                let z = self.axis(linear, 2, i, units, &mut slopes);
                let w = if D > 3 { self.axis(linear, 3, i, units, &mut slopes) } else { [0; 2] };
                for j in 0..2 * (D - 2) {
                    self.stacks[j][i] = hash::stack(z[j & 1] ^ w[j >> 1]);
                }
            }
        }
        work
    }

    /// Finds the cell along an axis, and gives the keys of its ends.
    #[inline(always)]
    fn axis<P: Planes, W: Wrap<D>>(
        &mut self,
        linear: &Linear<P, W, D>,
        k: usize,
        i: usize,
        units: [f32; 4],
        slopes: &mut Option<&mut Slopes<D>>,
    ) -> [u32; 2] {
        let low = self.p[k][i].floor();
        let t = self.p[k][i] - low;
        let (weight, slope) = P::weight(t);
        self.weights[k][i] = weight;
        let offsets = P::offsets(t, units[k]);
        let stretches = P::stretches(t);
        for end in 0..2 {
            self.offsets[k][end][i] = offsets[end];
        }
        if let Some(slopes) = slopes {
            slopes.weights[k][i] = slope * (1.0 / units[k]);
            for end in 0..2 {
                slopes.offsets[k][end][i] = stretches[end];
            }
        }
        linear.keys(low, k)
    }

    /// What the corners of a column give, blended along z and w. A corner is made of its hash, the offset from it,
    /// and, along each axis, which end it is at.
    #[inline(always)]
    fn column<T>(
        &self,
        (j, i): (usize, usize),
        flat: u32,
        corner: impl Fn(u32, [f32; D], [usize; 4]) -> T,
        blend: impl Fn(usize, T, T) -> T,
    ) -> T {
        let one = |stack: usize| {
            let ends = [j & 1, j >> 1, stack & 1, stack >> 1];
            let factor = if D > 2 { self.stacks[stack % D][i] } else { flat };
            let offset = array(|k| self.offsets[k][ends[k]][i]);
            corner(self.columns[j][i].wrapping_mul(factor), offset, ends)
        };
        match D {
            4 => blend(3, blend(2, one(0), one(1)), blend(2, one(2), one(3))),
            3 => blend(2, one(0), one(1)),
            _ => one(0),
        }
    }
}

/// Blends the columns, along x and y.
#[inline(always)]
fn across<T, const D: usize>(column: impl Fn(usize) -> T, blend: impl Fn(usize, T, T) -> T) -> T {
    let lower = blend(0, column(0), column(1));
    if D == 1 { lower } else { blend(1, lower, blend(0, column(2), column(3))) }
}

struct Values<'a, P, W, const D: usize> {
    linear: &'a Linear<P, W, D>,
    p: [&'a [f32]; D],
    out: &'a mut [f32],
}

impl<P: Planes, W: Wrap<D>, const D: usize> Kernel for Values<'_, P, W, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let (mut tile, mut rows) = (Tile::new(), Aligned(([[0.0; TILE]; MOST], [0.0; TILE])));
        let (tile, (heights, values)) = (&mut tile.0, &mut rows.0);
        let flat = hash::stack(self.linear.origin(2));
        let further = self.linear.further;
        for (start, end) in tiles(self.out.len()) {
            let work = tile.fill(self.linear, &self.p, (start, end), units::<D>(), None);
            for c in 0..1 << D {
                for i in 0..work {
                    let factor = if D > 2 { tile.stacks[(c >> 2) % D][i] } else { flat };
                    let offset = array(|k| tile.offsets[k][c >> k & 1][i]);
                    heights[c][i] =
                        height::<P, D>(further, tile.columns[c & 3][i].wrapping_mul(factor), offset);
                }
            }
            for i in 0..work {
                let blend = |axis: usize, a, b| lerp(tile.weights[axis % D][i], a, b);
                // Of the four corners in x and y from this one on; of the eight in x, y and z.
                let square = |c: usize| across::<_, D>(|j| heights[j + c][i], blend);
                let cube = |c: usize| if D > 2 { blend(2, square(c), square(c + 4)) } else { square(c) };
                values[i] = if D > 3 { blend(3, cube(0), cube(8)) } else { cube(0) } * (P::SCALE / SQUARE);
            }
            store(&mut self.out[start..end], values);
        }
    }
}

struct Derivatives<'a, 'b, P, W, const D: usize> {
    linear: &'a Linear<P, W, D>,
    p: [&'a [f32]; D],
    out: &'a mut [&'b mut [f32]],
}

/// Blends along an axis: to its own derivative the change of the weight adds.
#[inline(always)]
fn blend<const D: usize>(axis: usize, weight: f32, slope: f32, a: Jet<D>, b: Jet<D>) -> Jet<D> {
    let mut gradient = [0.0; D];
    for k in 0..D {
        gradient[k] = lerp(weight, a.gradient[k], b.gradient[k]);
    }
    let step = b.value - a.value;
    gradient[axis % D] += slope * step;
    Jet { value: a.value + weight * step, gradient }
}

impl<P: Planes, W: Wrap<D>, const D: usize> Kernel for Derivatives<'_, '_, P, W, D> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let units = jet_units::<D>();
        let row = [0.0; TILE];
        let (mut tile, mut slopes) =
            (Tile::new(), Aligned(Slopes { weights: [row; D], offsets: [[row; 2]; D] }));
        let mut rows = Aligned(([row; 4], [[row; D]; 4]));
        let (tile, slopes, (heights, gradients)) = (&mut tile.0, &mut slopes.0, &mut rows.0);
        let flat = hash::stack(self.linear.origin(2));
        let further = self.linear.further;
        for (start, end) in tiles(self.p[0].len()) {
            let work = tile.fill(self.linear, &self.p, (start, end), units, Some(&mut *slopes));
            for j in 0..columns::<D>() {
                for i in 0..work {
                    let blend =
                        |k: usize, a, b| blend(k, tile.weights[k % D][i], slopes.weights[k % D][i], a, b);
                    let corner = |hash, offset, ends: [usize; 4]| {
                        let mut jet = jet::<P, D>(further, hash, offset);
                        if P::STRETCHES {
                            for k in 0..D {
                                jet.gradient[k] *= slopes.offsets[k][ends[k]][i];
                            }
                        }
                        jet
                    };
                    let jet = tile.column((j, i), flat, corner, blend);
                    heights[j][i] = jet.value;
                    for k in 0..D {
                        gradients[j][k][i] = jet.gradient[k];
                    }
                }
            }
            for i in 0..work {
                let column = |j: usize| Jet { value: heights[j][i], gradient: array(|k| gradients[j][k][i]) };
                let blend = |k: usize, a, b| blend(k, tile.weights[k % D][i], slopes.weights[k % D][i], a, b);
                let jet: Jet<D> = across::<_, D>(column, blend);
                for k in 0..D {
                    // The row of the coordinate is done with.
                    tile.p[k][i] = jet.gradient[k] * (units[k] * P::SCALE / WHOLE);
                }
            }
            for (out, gradient) in self.out.iter_mut().zip(&tile.p) {
                store(&mut out[start..end], gradient);
            }
        }
    }
}
