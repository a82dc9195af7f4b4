//! A covariance as a table, so that any one costs the same and no root is taken.

use super::covariance::{Covariance, Spline};

/// A covariance as cubic polynomials in the square of distance, with two continuous derivatives.
pub(super) struct Table {
    /// Polynomials a unit of the square.
    pub scale: f32,
    pieces: Box<[[f32; 4]; PIECES]>,
}

const PIECES: usize = 1024;

impl Table {
    /// Up to two units along each of `D` axes.
    pub(super) fn new<const D: usize>(covariance: &Covariance) -> Table {
        let squares = 4 * D;
        // A whole number a unit, so that the covariances between lattice points are exact.
        let scale = (PIECES - 1) / squares;
        let at = |square: f64| covariance.at(square, D);
        let values: Vec<f64> = (0..=squares * scale).map(|i| at(i as f64 / scale as f64)).collect();
        let (end, tiny) = (squares as f64, 1e-6);
        let (first, last) = ((at(tiny) - at(0.0)) / tiny, (at(end) - at(end - tiny)) / tiny);
        let spline = Spline::through(&values, end, first, last);
        let mut pieces = Box::new([[0.0; 4]; PIECES]);
        for (to, from) in pieces.iter_mut().zip(&spline.pieces) {
            *to = from.map(|c| c as f32);
        }
        // The very end may count as the start of the next.
        pieces[spline.pieces.len()] =
            [values[values.len() - 1] as f32, (last / scale as f64) as f32, 0.0, 0.0];
        Table { scale: scale as f32, pieces }
    }

    /// Of a square times the scale, the number of the polynomial (in the lowest bits) and the place in it, 0 … 1.
    #[inline(always)]
    pub(super) fn entry(x: f32) -> (u32, f32) {
        // From 1.5·2^23 on sums are rounded to integers, which then stand in the lowest bits.
        const ROUNDER: f32 = 12_582_912.0;
        let rounded = (x - 0.5) + ROUNDER;
        (rounded.to_bits(), x - (rounded - ROUNDER))
    }

    /// A polynomial, by rising powers.
    #[inline(always)]
    pub(super) fn piece(&self, number: u32) -> &[f32; 4] {
        &self.pieces[number as usize % PIECES]
    }
}
