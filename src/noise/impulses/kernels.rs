//! Kernels: what stands about an impulse, as a function of the distance, and of where in their cycle waves are.

use super::UNIT;
use crate::lanes::{Isa, Kernel, array};
use std::f64::consts::PI;

/// A kernel.
pub(in crate::noise) trait Profile: Send + Sync {
    /// Multiplies sizes by the kernel's value, at offsets of which the squares are given (in [`UNIT`]s) and where
    /// waves are at so many turns. Beyond the radius it is zero.
    fn values(&self, isa: Isa, squares: &[f32], turns: &[f32], sizes: &mut [f32]);

    /// The derivative by the point, a cell, is the impulse's offset times one number plus the waves along each axis times
    /// another: multiplies sizes by the former and turns `turns` into the latter.
    fn slopes(&self, isa: Isa, squares: &[f32], turns: &mut [f32], sizes: &mut [f32]);
}

/// A kernel without waves.
pub(in crate::noise) trait Radial: Copy + Send + Sync + 'static {
    /// The value.
    fn value(&self, square: f32) -> f32;
    /// By what the offset is to be multiplied for the derivative.
    fn slope(&self, square: f32) -> f32;
}

impl<R: Radial> Profile for R {
    fn values(&self, isa: Isa, squares: &[f32], _: &[f32], sizes: &mut [f32]) {
        isa.run(Values { kernel: *self, squares, sizes });
    }

    fn slopes(&self, isa: Isa, squares: &[f32], _: &mut [f32], sizes: &mut [f32]) {
        isa.run(Slopes { kernel: *self, squares, sizes });
    }
}

struct Values<'a, R> {
    kernel: R,
    squares: &'a [f32],
    sizes: &'a mut [f32],
}

impl<R: Radial> Kernel for Values<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Values { kernel, squares, sizes } = self;
        let squares = &squares[..sizes.len()];
        for i in 0..sizes.len() {
            sizes[i] *= kernel.value(squares[i]);
        }
    }
}

struct Slopes<'a, R> {
    kernel: R,
    squares: &'a [f32],
    sizes: &'a mut [f32],
}

impl<R: Radial> Kernel for Slopes<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Slopes { kernel, squares, sizes } = self;
        let squares = &squares[..sizes.len()];
        for i in 0..sizes.len() {
            sizes[i] *= kernel.slope(squares[i]);
        }
    }
}

/// The square of u Q(u), where u is 1 less the square of the distance, counted in radii. It ends with slope 0, since
/// u is 0 there.
#[derive(Clone, Copy)]
pub(in crate::noise) struct Bell<const N: usize> {
    q: [f32; N],
    /// The square of a [`UNIT`] in radii.
    rate: f32,
}

/// ½ + ½ cos πr = cos² πr/2, an analytic function of r²: fit in u with error 7e-6, exact at r = 0 and 1.
const COSINE: [f32; 3] = [0.785_697_7, 0.195_005_27, 0.019_297_069];
/// A Gaussian whose standard deviation is a third of the radius, times a window, (1 - r⁸)²: fit with error 1.4e-5.
const GAUSSIAN: [f32; 6] =
    [0.427_712_98, 0.246_178_97, 0.360_033_72, -0.537_439_94, 0.620_821_8, -0.117_307_46];
/// The radius of the latter in standard deviations.
pub(in crate::noise) const GAUSSIAN_RADIUS: f64 = 3.0;

impl Bell<3> {
    /// ½ + ½ cos πr, for a radius in cells.
    pub(in crate::noise) fn cosine(radius: f64) -> Bell<3> {
        Bell { q: COSINE, rate: rate(radius) }
    }
}

impl Bell<6> {
    /// A windowed Gaussian, for a radius in cells.
    pub(in crate::noise) fn gaussian(radius: f64) -> Bell<6> {
        Bell { q: GAUSSIAN, rate: rate(radius) }
    }
}

fn rate(radius: f64) -> f32 {
    let unit = f64::from(UNIT) / radius;
    (unit * unit) as f32
}

/// Of (u Q(u))² the root and its derivative.
#[inline(always)]
fn root<const N: usize>(q: &[f32; N], u: f32) -> (f32, f32) {
    let (mut root, mut slope) = (q[N - 1], N as f32 * q[N - 1]);
    for n in (0..N - 1).rev() {
        root = root * u + q[n];
        slope = slope * u + (n + 1) as f32 * q[n];
    }
    (root * u, slope)
}

impl<const N: usize> Bell<N> {
    /// The value at a distance, in radii.
    pub(in crate::noise) fn at(&self, r: f64) -> f64 {
        let u = (1.0 - r * r).max(0.0);
        let root = self.q.iter().rev().fold(0.0, |sum, c| sum * u + f64::from(*c)) * u;
        root * root
    }
}

impl<const N: usize> Radial for Bell<N> {
    #[inline(always)]
    fn value(&self, square: f32) -> f32 {
        let u = 1.0 - square * self.rate;
        let (root, _) = root(&self.q, if u > 0.0 { u } else { 0.0 });
        root * root
    }

    #[inline(always)]
    fn slope(&self, square: f32) -> f32 {
        let u = 1.0 - square * self.rate;
        let (root, slope) = root(&self.q, if u > 0.0 { u } else { 0.0 });
        root * slope * (4.0 * self.rate / UNIT)
    }
}

/// The kernel of Catmull and Rom's spline, over the distance: of radius 2, in cells.
#[derive(Clone, Copy)]
pub(in crate::noise) struct CatmullRom;

impl CatmullRom {
    /// The value at a distance.
    pub(in crate::noise) fn at(r: f64) -> f64 {
        let s = (2.0 - r).max(0.0);
        if r < 1.0 { 1.0 + r * r * (1.5 * r - 2.5) } else { 0.5 * s * s * (s - 1.0) }
    }
}

impl Radial for CatmullRom {
    #[inline(always)]
    fn value(&self, square: f32) -> f32 {
        let r = square.sqrt() * UNIT;
        let s = if r < 2.0 { 2.0 - r } else { 0.0 };
        let (near, far) = (1.0 + r * r * (1.5 * r - 2.5), 0.5 * s * s * (s - 1.0));
        if r < 1.0 { near } else { far }
    }

    #[inline(always)]
    fn slope(&self, square: f32) -> f32 {
        let r = square.sqrt() * UNIT;
        let s = if r < 2.0 { 2.0 - r } else { 0.0 };
        // The derivative by r, divided by r.
        let (near, far) = (4.5 * r - 5.0, s * (1.0 - 1.5 * s) / r);
        (if r < 1.0 { near } else { far }) * -UNIT
    }
}

/// The most steps of a [`Curve`].
pub(in crate::noise) const STEPS: usize = 32;

/// Catmull and Rom's spline through values at equal steps of the distance, with slope 0 at both ends; of radius 1, in
/// cells.
#[derive(Clone, Copy)]
pub(in crate::noise) struct Curve {
    /// The polynomial of each step, its constant first.
    pieces: [[f32; 4]; STEPS],
    steps: f32,
}

impl Curve {
    /// The curve of 2 values or more, at most one more than [`STEPS`].
    pub(in crate::noise) fn new(values: &[f32]) -> Curve {
        let steps = values.len() - 1;
        // The curve is even about both ends.
        let value = |i: i64| f64::from(values[i.abs().min(2 * steps as i64 - i) as usize]);
        let mut pieces = [[0.0; 4]; STEPS];
        for (i, piece) in pieces[..steps].iter_mut().enumerate() {
            let [a, b, c, d] = [-1, 0, 1, 2].map(|k| value(i as i64 + k));
            let (rise, start, end) = (c - b, (c - a) / 2.0, (d - b) / 2.0);
            *piece = [b, start, 3.0 * rise - 2.0 * start - end, start + end - 2.0 * rise].map(|x| x as f32);
        }
        Curve { pieces, steps: steps as f32 }
    }

    /// The value at a distance.
    pub(in crate::noise) fn at(&self, r: f64) -> f64 {
        let x = r * f64::from(self.steps);
        let piece = self.pieces[(x as usize).min(STEPS - 1)];
        let part = x - x.floor();
        if r < 1.0 { piece.iter().rev().fold(0.0, |sum, c| sum * part + f64::from(*c)) } else { 0.0 }
    }

    /// The polynomial for a distance in [`UNIT`]s, all 0 beyond the radius, and where in it that is.
    #[inline(always)]
    fn piece(&self, r: f32) -> ([f32; 4], f32) {
        let x = r * (self.steps * UNIT);
        let low = x.floor();
        // The integer stands in the lowest bits.
        let piece = self.pieces[(low + 8_388_608.0).to_bits() as usize % STEPS];
        let inside = x < self.steps;
        (array(|k| if inside { piece[k] } else { 0.0 }), x - low)
    }
}

impl Radial for Curve {
    #[inline(always)]
    fn value(&self, square: f32) -> f32 {
        let ([a, b, c, d], t) = self.piece(square.sqrt());
        a + t * (b + t * (c + t * d))
    }

    #[inline(always)]
    fn slope(&self, square: f32) -> f32 {
        let r = square.sqrt();
        let ([_, b, c, d], t) = self.piece(r);
        // At the impulse itself it is 0.
        (b + t * (2.0 * c + t * (3.0 * d))) * -self.steps / if r > 1.0 { r } else { 1.0 }
    }
}

/// The cosine of an angle in turns, up to 2^20, and its derivative.
#[inline(always)]
pub(super) fn cosine(turns: f32) -> (f32, f32) {
    // cos πt/2 over 1 - t² as above, with error 2e-7.
    const QUARTER: [f32; 4] = [0.785_394_2, 0.196_376_96, 0.017_363_792, 0.000_865_033_4];
    // Added, it rounds to whole turns.
    const ROUNDER: f32 = 12_582_912.0;
    let t = turns - ((turns + ROUNDER) - ROUNDER);
    // cos 2πt = 2 cos² πt - 1, and t is at most a half.
    let (root, slope) = root(&QUARTER, 1.0 - 4.0 * (t * t));
    (2.0 * (root * root) - 1.0, root * slope * (-32.0 * t))
}

/// Waves under a Gaussian: Gabor's function.
#[derive(Clone, Copy)]
pub(in crate::noise) struct Gabor(pub Bell<6>);

impl Profile for Gabor {
    fn values(&self, isa: Isa, squares: &[f32], turns: &[f32], sizes: &mut [f32]) {
        isa.run(WaveValues { bell: self.0, squares, turns, sizes });
    }

    fn slopes(&self, isa: Isa, squares: &[f32], turns: &mut [f32], sizes: &mut [f32]) {
        isa.run(WaveSlopes { bell: self.0, squares, turns, sizes });
    }
}

struct WaveValues<'a> {
    bell: Bell<6>,
    squares: &'a [f32],
    turns: &'a [f32],
    sizes: &'a mut [f32],
}

impl Kernel for WaveValues<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let WaveValues { bell, squares, turns, sizes } = self;
        let (squares, turns) = (&squares[..sizes.len()], &turns[..sizes.len()]);
        for i in 0..sizes.len() {
            sizes[i] *= bell.value(squares[i]) * cosine(turns[i]).0;
        }
    }
}

struct WaveSlopes<'a> {
    bell: Bell<6>,
    squares: &'a [f32],
    turns: &'a mut [f32],
    sizes: &'a mut [f32],
}

impl Kernel for WaveSlopes<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let WaveSlopes { bell, squares, turns, sizes } = self;
        let (squares, turns) = (&squares[..sizes.len()], &mut turns[..sizes.len()]);
        for i in 0..sizes.len() {
            let (wave, turn) = cosine(turns[i]);
            turns[i] = sizes[i] * bell.value(squares[i]) * turn * (-1.0 / UNIT);
            sizes[i] *= bell.slope(squares[i]) * wave;
        }
    }
}

/// The integral of a function of the distance over space, up to a radius.
pub(in crate::noise) fn integral(dimensions: usize, radius: f64, f: impl Fn(f64) -> f64) -> f64 {
    // Simpson's rule; in so many steps that the joints of a curve hardly matter.
    const STEPS: usize = 4096;
    let sphere = [2.0, 2.0 * PI, 4.0 * PI, 2.0 * PI * PI][dimensions - 1];
    let sum: f64 = (0..=STEPS)
        .map(|i| {
            let weight = [2.0, 4.0][i % 2] / if i == 0 || i == STEPS { 2.0 } else { 1.0 };
            let r = radius * i as f64 / STEPS as f64;
            weight * f(r) * sphere * libm::pow(r, dimensions as f64 - 1.0)
        })
        .sum();
    sum * radius / (3.0 * STEPS as f64)
}

/// The mean over all directions of the cosine of `turns` times the direction's first coordinate.
pub(in crate::noise) fn mean_cosine(dimensions: usize, turns: f64) -> f64 {
    let x = 2.0 * PI * turns;
    match dimensions {
        1 => libm::cos(x),
        2 => libm::j0(x),
        _ if x < 1e-6 => 1.0,
        3 => libm::sin(x) / x,
        _ => 2.0 * libm::j1(x) / x,
    }
}
