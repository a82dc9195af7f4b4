//! Wiener's weights along one axis, as polynomials.
//!
//! Where the covariance is a product over axes so is C, and with it C⁻¹ and a = C⁻¹c: the weight of a lattice point
//! is the product of one weight an axis, that of the same interpolation in one dimension. Those are smooth
//! functions of the place t in the cell. They are fitted once, as what must be added to the weights of linear
//! interpolation, times a factor that is 0 at lattice points; so those keep their values to the bit.

use super::covariance::Covariance;
use super::solve::Matrix;

/// Coefficients of a polynomial; the fit is within 2e-6 of the true weights for the narrowest gaussian,
/// and 1e-9 for that of width ½.
const TERMS: usize = 6;

/// Of that of the error, in which there are products of two covariances: within 1e-6.
const ERROR_TERMS: usize = 9;

/// A polynomial in 4s², |s| ≤ ½.
type Even<const T: usize> = [f32; T];

/// The weights of the lattice points about the cell, -1 … 2, or about the nearest one, -1 … 1.
pub(super) struct Weights {
    /// Four: with s = t - ½, and a factor t(1 - t), even and odd part of the outer ones; then of the inner ones,
    /// less what is linear. Three: the even part of the outer ones, divided by t²; their odd part, divided by
    /// t; the middle one, less 1 and divided by t².
    parts: [Even<TERMS>; 4],
    /// The expected squared error, divided by t²(1 - t)² for four, by t² for three; over s, or t.
    error: Even<ERROR_TERMS>,
}

/// The exact weights in f64.
pub(super) struct Exact<'a> {
    covariance: &'a Covariance,
    inverse: Matrix,
}

impl Exact<'_> {
    /// Those of so many points, of a covariance that is a product over axes.
    pub(super) fn new(covariance: &Covariance, points: usize) -> Exact<'_> {
        let between = |i: usize, j: usize| covariance.at((i as f64 - j as f64) * (i as f64 - j as f64), 1);
        let inverse = Matrix::new(points, between).inverse(0.0).expect("gaussians are positive definite");
        Exact { covariance, inverse }
    }

    fn covariances(&self, t: f64) -> Vec<f64> {
        let offset = |i: usize| t + 1.0 - i as f64;
        (0..self.inverse.size).map(|i| self.covariance.at(offset(i) * offset(i), 1)).collect()
    }

    /// At a place in the cell, or about the lattice point.
    pub(super) fn at(&self, t: f64) -> Vec<f64> {
        self.inverse.times(&self.covariances(t))
    }

    pub(super) fn error(&self, t: f64) -> f64 {
        1.0 - self.at(t).iter().zip(self.covariances(t)).map(|(a, c)| a * c).sum::<f64>()
    }

    /// The mean of the sum of the weights' squares: the variance of what is interpolated, that of the data being 1.
    pub(super) fn variance(&self) -> f64 {
        let start = if self.inverse.size == 4 { 0.0 } else { -0.5 };
        let n = 64;
        let square =
            |i| self.at(start + (f64::from(i) + 0.5) / f64::from(n)).iter().map(|a| a * a).sum::<f64>();
        (0..n).map(square).sum::<f64>() / f64::from(n)
    }
}

/// The even polynomial through a function at Chebyshev's points of ±½.
fn fit<const T: usize>(f: impl Fn(f64) -> f64) -> Even<T> {
    let points: [f64; T] =
        std::array::from_fn(|i| 0.5 * libm::cos(std::f64::consts::PI * (2 * i + 1) as f64 / (4 * T) as f64));
    let x = points.map(|s| 4.0 * s * s);
    // Newton's divided differences, multiplied out.
    let mut differences = points.map(f);
    for order in 1..T {
        for i in (order..T).rev() {
            differences[i] = (differences[i] - differences[i - 1]) / (x[i] - x[i - order]);
        }
    }
    let mut sum = [0.0; T];
    for i in (0..T).rev() {
        for k in (0..T).rev() {
            let lower = if k == 0 { differences[i] } else { sum[k - 1] };
            sum[k] = lower - x[i] * sum[k];
        }
    }
    sum.map(|c| c as f32)
}

impl Weights {
    /// Fits them.
    pub(super) fn new<const N: usize>(exact: &Exact<'_>) -> Weights {
        if N == 3 {
            // What the lower one has at t the upper one has at -t.
            let (lower, upper) = (|t: f64| exact.at(t)[0], |t: f64| exact.at(-t)[0]);
            let parts = [
                fit(|t| 0.5 * (upper(t) + lower(t)) / (t * t)),
                fit(|t| 0.5 * (upper(t) - lower(t)) / t),
                fit(|t| (exact.at(t)[1] - 1.0) / (t * t)),
                [0.0; TERMS],
            ];
            return Weights { parts, error: fit(|t| exact.error(t) / (t * t)) };
        }
        let rest = |s: f64, weight: usize| {
            let linear = [0.0, 0.5 - s, 0.5 + s, 0.0];
            (exact.at(0.5 + s)[weight] - linear[weight]) / (0.25 - s * s)
        };
        let even = |weight: usize| fit(|s| 0.5 * (rest(s, weight) + rest(-s, weight)));
        let odd = |weight: usize| fit(|s| 0.5 * (rest(s, weight) - rest(-s, weight)) / s);
        let square = |s: f64| (0.25 - s * s) * (0.25 - s * s);
        let error = fit(|s| exact.error(0.5 + s) / square(s));
        Weights { parts: [even(0), odd(0), even(1), odd(1)], error }
    }

    /// Those of the points from -1 on.
    #[inline(always)]
    pub(super) fn at<const N: usize>(&self, t: f32) -> [f32; 4] {
        let [a, b, c, d] = &self.parts;
        if N == 3 {
            let square = t * t;
            let (even, odd) = (square * value(a, square), t * value(b, square));
            return [even - odd, 1.0 + square * value(c, square), even + odd, 0.0];
        }
        let (s, inside) = (t - 0.5, t * (1.0 - t));
        let (outer, outer_odd) = (value(a, s * s), s * value(b, s * s));
        let (inner, inner_odd) = (value(c, s * s), s * value(d, s * s));
        [
            inside * (outer + outer_odd),
            (1.0 - t) + inside * (inner + inner_odd),
            t + inside * (inner - inner_odd),
            inside * (outer - outer_odd),
        ]
    }

    /// Their derivatives.
    #[inline(always)]
    pub(super) fn slopes<const N: usize>(&self, t: f32) -> [f32; 4] {
        let [a, b, c, d] = &self.parts;
        if N == 3 {
            let (even, odd) = (squared_slope(a, t), odd_slope(b, t));
            return [even - odd, squared_slope(c, t), even + odd, 0.0];
        }
        let (s, inside) = (t - 0.5, t * (1.0 - t));
        let (outer, outer_odd) = (value(a, s * s), s * value(b, s * s));
        let (inner, inner_odd) = (value(c, s * s), s * value(d, s * s));
        let fall = -2.0 * s;
        let (outer_slope, inner_slope) = (even_slope(a, s), even_slope(c, s));
        let (outer_odd_slope, inner_odd_slope) = (odd_slope(b, s), odd_slope(d, s));
        [
            fall * (outer + outer_odd) + inside * (outer_slope + outer_odd_slope),
            fall * (inner + inner_odd) + inside * (inner_slope + inner_odd_slope) - 1.0,
            fall * (inner - inner_odd) + inside * (inner_slope - inner_odd_slope) + 1.0,
            fall * (outer - outer_odd) + inside * (outer_slope - outer_odd_slope),
        ]
    }

    /// The expected squared error of interpolation along this axis, relative to the variance, and its derivative.
    #[inline(always)]
    pub(super) fn error(&self, nearest: bool, t: f32) -> (f32, f32) {
        let s = if nearest { t } else { t - 0.5 };
        let (factor, fall) = if nearest { (t, 1.0) } else { (t * (1.0 - t), -2.0 * s) };
        let (rest, rest_slope) = (value(&self.error, s * s), even_slope(&self.error, s));
        (factor * factor * rest, factor * (factor * rest_slope + 2.0 * fall * rest))
    }
}

/// A polynomial at s².
#[inline(always)]
fn value<const T: usize>(c: &Even<T>, square: f32) -> f32 {
    let x = 4.0 * square;
    let mut sum = c[T - 1];
    for k in (0..T - 1).rev() {
        sum = sum * x + c[k];
    }
    sum
}

/// The derivative of the polynomial by s².
#[inline(always)]
fn slope<const T: usize>(c: &Even<T>, square: f32) -> f32 {
    let x = 4.0 * square;
    let mut sum = (T - 1) as f32 * c[T - 1];
    for k in (1..T - 1).rev() {
        sum = sum * x + k as f32 * c[k];
    }
    4.0 * sum
}

/// The derivative of an even part, which is the polynomial at s².
#[inline(always)]
fn even_slope<const T: usize>(c: &Even<T>, s: f32) -> f32 {
    2.0 * s * slope(c, s * s)
}

/// The derivative of an odd part, which is s times the polynomial.
#[inline(always)]
fn odd_slope<const T: usize>(c: &Even<T>, s: f32) -> f32 {
    value(c, s * s) + 2.0 * (s * s) * slope(c, s * s)
}

/// The derivative of s² times the polynomial.
#[inline(always)]
fn squared_slope<const T: usize>(c: &Even<T>, s: f32) -> f32 {
    2.0 * s * (value(c, s * s) + s * s * slope(c, s * s))
}
