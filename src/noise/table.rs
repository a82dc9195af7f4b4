//! Periodic tables of values, filled once when a field is made, and interpolated smoothly by a [`spline`].
//!
//! What lies between the points of the table is a cubic B-spline along each axis, with two continuous
//! derivatives. Its coefficients are found by Fourier transform, which also lets the mean be 0 and the
//! standard deviation [`DEVIATION`], both of the whole spline over a period, not just of its values at the
//! table's points.
//!
//! There are two cells in a unit, and a power of two of them in a period: see [`size`].

use super::fft::{Complex, Direction, transform};
use super::hash;
#[cfg(doc)]
use super::spline;

/// The standard deviation of every table.
const DEVIATION: f64 = 0.3;
/// Cells in a unit, along each axis.
pub(super) const CELLS: usize = 2;

/// Cells in a period along each axis. Tables of two and three dimensions have a mebibyte. That of one could
/// be longer; but as its deviation is that of a whole period, there would be the less of it in a few units.
pub(super) const fn size(dimensions: usize) -> usize {
    match dimensions {
        1 => 1024,
        2 => 512,
        _ => 64,
    }
}

/// The period, in units.
pub(super) const fn period(dimensions: usize) -> usize {
    size(dimensions) / CELLS
}

/// How far coefficients of neighbouring points along an axis lie apart. Along each axis the first three are
/// there again behind the last, so that those of a cell follow each other. Lines are filled up to whole
/// vectors.
pub(super) const fn stride(dimensions: usize, axis: usize) -> usize {
    match axis {
        0 => 1,
        1 => size(dimensions) + 4,
        _ => stride(dimensions, axis - 1) * (size(dimensions) + 3),
    }
}

/// A periodic spline in D dimensions.
pub(super) struct Table<const D: usize> {
    /// The coefficients divided by 6^D, which the weights leave out. The first is that of the point before
    /// the first cell.
    pub(super) coefficients: Vec<f32>,
}

impl<const D: usize> Table<D> {
    /// The spline of which the coefficients are these, moved and scaled to mean and standard deviation: it
    /// smooths what is given. There are as many as [`size`] says along each axis, the first being the
    /// fastest.
    pub(super) fn smoothed(values: &[f64]) -> Table<D> {
        let mut spectrum: Vec<Complex> = values.iter().map(|&re| Complex { re, im: 0.0 }).collect();
        transform::<D>(&mut spectrum, size(D), Direction::Forward);
        Table::new(spectrum, |_| 1.0)
    }

    /// The spline whose waves of up to half a cycle a cell are these, scaled to the standard deviation. (What
    /// a spline has besides is as it comes.)
    pub(super) fn of_spectrum(spectrum: Vec<Complex>) -> Table<D> {
        // The transform of the B-spline: that of a box of one cell, to the fourth power.
        Table::new(spectrum, |turn| {
            let sinc = if turn == 0.0 { 1.0 } else { libm::sin(0.5 * turn) / (0.5 * turn) };
            (sinc * sinc) * (sinc * sinc)
        })
    }

    /// Divides the spectrum by what the spline makes of a wave that turns so far from point to point.
    fn new(mut spectrum: Vec<Complex>, response: impl Fn(f64) -> f64) -> Table<D> {
        let size = size(D);
        let turn = |k: usize| 2.0 * std::f64::consts::PI * k.min(size - k) as f64 / size as f64;
        let gain: Vec<f64> = (0..size).map(|k| 1.0 / response(turn(k))).collect();
        // The variance of a spline whose coefficients are such a wave, of variance 1. The integral of the
        // product of two B-splines is the value of one of degree 7 at their distance.
        let variance_of = |turn: f64| {
            let waves = 1191.0 * libm::cos(turn) + 120.0 * libm::cos(2.0 * turn) + libm::cos(3.0 * turn);
            (2416.0 + 2.0 * waves) / 5040.0
        };
        let variance_of: Vec<f64> = (0..size).map(|k| variance_of(turn(k))).collect();
        let mut variance = 0.0;
        spectrum[0] = Complex::default();
        for (i, wave) in spectrum.iter_mut().enumerate() {
            let k = place::<D>(i);
            *wave = *wave * k.iter().map(|&k| gain[k]).product::<f64>();
            variance += wave.square() * k.iter().map(|&k| variance_of[k]).product::<f64>();
        }
        transform::<D>(&mut spectrum, size, Direction::Inverse);
        let scale = DEVIATION / variance.sqrt() / [6.0, 36.0, 216.0][D - 1];
        let mut coefficients = vec![0.0; stride(D, D - 1) * (size + 3) + 1];
        for (i, number) in spectrum.iter().enumerate() {
            // The first coefficient of a cell is that of the point before it.
            let first = place::<D>(i).map(|k| (k + 1) % size);
            // Bit k of a copy's number tells whether it stands behind the end along axis k.
            for copy in 0..1 << D {
                let behind = |k: usize| copy >> k & 1 == 1;
                if (0..D).all(|k| !behind(k) || first[k] < 3) {
                    let along = |k: usize| first[k] + if behind(k) { size } else { 0 };
                    let at: usize = (0..D).map(|k| along(k) * stride(D, k)).sum();
                    coefficients[at] = (number.re * scale) as f32;
                }
            }
        }
        Table { coefficients }
    }
}

/// Where along each axis a number of a table stands.
pub(super) fn place<const D: usize>(i: usize) -> [usize; D] {
    std::array::from_fn(|k| i / size(D).pow(k as u32) % size(D))
}

/// Two independent numbers of a Gaussian distribution of variance 1, from the hash of a lattice point (Box
/// and Muller 1958).
pub(super) fn gaussian(bits: u32) -> [f64; 2] {
    const UNIT: f64 = 1.0 / (1_u64 << 32) as f64;
    let length = (-2.0 * libm::log((f64::from(bits) + 0.5) * UNIT)).sqrt();
    let (sin, cos) = libm::sincos(2.0 * std::f64::consts::PI * f64::from(hash::more(bits)) * UNIT);
    [length * cos, length * sin]
}

#[cfg(test)]
mod tests {
    use super::super::field::{ByTiles, Field};
    use super::*;
    use crate::lanes::Isa;

    /// Coefficients without order.
    fn numbers(n: usize) -> Vec<f64> {
        (0..n as u32).map(|i| gaussian(hash::mix(i))[0]).collect()
    }

    #[test]
    fn gaussian_numbers_are() {
        let all: Vec<[f64; 2]> = (0..200_000).map(|i| gaussian(hash::mix(i))).collect();
        let mean = |f: &dyn Fn([f64; 2]) -> f64| all.iter().map(|&g| f(g)).sum::<f64>() / 2e5;
        assert!(mean(&|[a, _]| a).abs() < 0.01 && mean(&|[_, b]| b).abs() < 0.01);
        assert!((mean(&|[a, _]| a * a) - 1.0).abs() < 0.02 && (mean(&|[_, b]| b * b) - 1.0).abs() < 0.02);
        assert!(mean(&|[a, b]| a * b).abs() < 0.01 && mean(&|[a, b]| a * a * b * b - 1.0).abs() < 0.03);
        assert!((mean(&|[a, _]| a * a * a * a) - 3.0).abs() < 0.1);
        // The rarest are still finite.
        assert!([0, u32::MAX].iter().all(|&h| gaussian(h).iter().all(|g| g.abs() < 7.0)));
    }

    /// Mean and standard deviation of the spline over a period, from several points a cell.
    fn moments<const D: usize>(table: &ByTiles<Table<D>, D>, each: usize) -> [f64; 2] {
        let n = size(D) * each;
        let at = |i: usize| (i as f32 + 0.5) / (each * CELLS) as f32;
        let x: Vec<f32> = (0..n).map(at).collect();
        let (mut sum, mut squares) = (0.0, 0.0);
        let mut out = vec![0.0; n];
        for line in 0..n.pow(D as u32 - 1) {
            let rest: Vec<Vec<f32>> = (0..D as u32 - 1).map(|k| vec![at(line / n.pow(k) % n); n]).collect();
            let p: Vec<&[f32]> = std::iter::once(&x[..]).chain(rest.iter().map(|r| &r[..])).collect();
            table.noise(Isa::detect(), &p, &mut out);
            sum += out.iter().map(|&v| f64::from(v)).sum::<f64>();
            squares += out.iter().map(|&v| f64::from(v) * f64::from(v)).sum::<f64>();
        }
        let count = n.pow(D as u32) as f64;
        [sum / count, (squares / count).sqrt()]
    }

    fn check_moments<const D: usize>() {
        // A white spectrum, and one that ends where that of `fourier` does.
        let values = numbers(size(D).pow(D as u32));
        let mut spectrum: Vec<Complex> = values.iter().map(|&re| Complex { re, im: 0.0 }).collect();
        transform::<D>(&mut spectrum, size(D), Direction::Forward);
        for (i, wave) in spectrum.iter_mut().enumerate() {
            let k = place::<D>(i).map(|k| k.min(size(D) - k));
            *wave = if k.iter().all(|k| *k < size(D) * 3 / 8) { *wave } else { Complex::default() };
        }
        for table in [Table::<D>::smoothed(&values), Table::of_spectrum(spectrum)] {
            let [mean, deviation] = moments(&ByTiles(table), 2);
            assert!(mean.abs() < 1e-6 && (deviation - DEVIATION).abs() < 2e-3, "{D}-D: {mean} {deviation}");
        }
    }

    #[test]
    fn mean_and_deviation_are_those_of_the_spline() {
        check_moments::<1>();
        check_moments::<2>();
        check_moments::<3>();
    }

    #[test]
    fn waves_are_kept() {
        // A single wave of a third of a cycle a cell stays what it is, but for the spline's own images.
        let (n, k) = (size(1), size(1) / 3);
        let mut spectrum = vec![Complex::default(); n];
        spectrum[k] = Complex { re: 0.6, im: -0.8 };
        spectrum[n - k] = spectrum[k].conjugate();
        let table = ByTiles::<_, 1>(Table::of_spectrum(spectrum));
        let x: Vec<f32> = (0..8 * n).map(|i| i as f32 / (8 * CELLS) as f32).collect();
        let mut out = vec![0.0; x.len()];
        table.noise(Isa::detect(), &[&x], &mut out);
        let mut projection = Complex::default();
        for (x, value) in x.iter().zip(&out) {
            let angle = -2.0 * std::f64::consts::PI * k as f64 * f64::from(*x) / period(1) as f64;
            projection = projection + Complex::unit(angle) * (f64::from(*value) / x_len(&out));
        }
        let power = 2.0 * projection.square() / (DEVIATION * DEVIATION);
        assert!(power > 0.99 && power <= 1.0, "{power}");
        let turned = projection * Complex { re: 0.6, im: 0.8 };
        assert!(turned.re > 0.0 && turned.im.abs() < 1e-6, "{turned:?}");
    }

    fn x_len(x: &[f32]) -> f64 {
        x.len() as f64
    }
}
