//! How noise is correlated over distance: the named covariances, and the user's own.

use super::super::kind::Unfit;
use super::super::options::{Opt, Params};
use std::f64::consts::PI;

/// A covariance over distance, 1 at distance 0.
pub(super) enum Covariance {
    /// exp(-d² / 2 width²). The only one that is a product over axes.
    Gaussian { width: f64 },
    /// The same times the mean of waves of that frequency over all directions: in one dimension the cosine, in
    /// two Bessel's J₀, in three sin x / x, each of x = 2π frequency · d. Its spectrum
    /// is a sphere about zero, of that radius and blurred by the gaussian's spectrum: nowhere negative, so it
    /// is the covariance of some noise (which gaussian times cosine is in one dimension only).
    Oscillatory { width: f64, frequency: f64 },
    /// A smooth curve through values from distance 0 to [`REACH`]; from there on its last value.
    Knots(Spline),
}

/// The distance of the last of the user's knots.
pub(super) const REACH: f64 = 2.0;

const NAMES: [&str; 2] = ["gaussian", "oscillatory"];

impl Covariance {
    /// That which the options ask for.
    pub(super) fn new(dimensions: usize, params: &Params) -> Result<Covariance, Unfit> {
        let refuse = |option: Opt, whose: &str| match params.vector(option) {
            None => Ok(()),
            Some(_) => Err(Unfit::of(option, format!("{whose} has no {}", option.name()))
                .hint("width and frequency are of covariance = \"oscillatory\", width of \"gaussian\" too.")),
        };
        let plain = |option: Opt| {
            if dimensions < 4 {
                return Ok(());
            }
            Err(Unfit::of(
                option,
                format!("of {dimensions} coordinates there is the gaussian covariance only"),
            ))
        };
        if let Some(knots) = params.vector(Opt::Knots) {
            plain(Opt::Knots)?;
            refuse(Opt::Width, "a covariance given by knots")?;
            refuse(Opt::Frequency, "a covariance given by knots")?;
            return Ok(Covariance::Knots(through_knots(knots)?));
        }
        let width = |default, most| Ok(f64::from(params.number(Opt::Width, default, 0.25..=most)?));
        if NAMES[params.choice(Opt::Covariance)] == "gaussian" {
            refuse(Opt::Frequency, "the gaussian covariance")?;
            return Ok(Covariance::Gaussian { width: width(0.5, 2.0)? });
        }
        plain(Opt::Covariance)?;
        let frequency = f64::from(params.number(Opt::Frequency, 0.75, 0.0..=2.0)?);
        Ok(Covariance::Oscillatory { width: width(0.7, 2.0)?, frequency })
    }

    /// Is it the product of the same covariances along the axes?
    pub(super) fn is_product(&self) -> bool {
        matches!(self, Covariance::Gaussian { .. })
    }

    /// Its value at the square of a distance.
    pub(super) fn at(&self, square: f64, dimensions: usize) -> f64 {
        match self {
            Covariance::Gaussian { width } => bell(square, *width),
            Covariance::Oscillatory { width, frequency } => {
                bell(square, *width) * wave(2.0 * PI * frequency * square.sqrt(), dimensions)
            }
            Covariance::Knots(curve) => curve.at(square.sqrt().min(REACH)),
        }
    }
}

fn bell(square: f64, width: f64) -> f64 {
    libm::exp(-square / (2.0 * width * width))
}

/// The mean of cos(x u) over the unit vectors' first coordinate u.
fn wave(x: f64, dimensions: usize) -> f64 {
    match dimensions {
        1 => libm::cos(x),
        _ if x < 1e-6 => 1.0,
        2 => libm::j0(x),
        _ => libm::sin(x) / x,
    }
}

fn through_knots(knots: &[f32]) -> Result<Spline, Unfit> {
    if knots.len() < 2 {
        return Err(Unfit::of(Opt::Knots, format!("knots needs at least 2 values, found {}", knots.len())));
    }
    if let Some(bad) = knots.iter().find(|k| !k.is_finite()) {
        return Err(Unfit::of(Opt::Knots, format!("knots must be finite, found {bad}")));
    }
    let variance = f64::from(knots[0]);
    if variance <= 0.0 {
        let message = format!("the first of knots is the variance, which must be above 0, found {variance}");
        return Err(Unfit::of(Opt::Knots, message));
    }
    let values: Vec<f64> = knots.iter().map(|k| f64::from(*k) / variance).collect();
    Ok(Spline::through(&values, REACH, 0.0, 0.0))
}

/// The cubic spline through values at equal steps from 0 on, with two continuous derivatives.
pub(super) struct Spline {
    step: f64,
    /// The polynomial of each step, over 0 … 1, by rising powers.
    pub pieces: Vec<[f64; 4]>,
}

impl Spline {
    /// Through values from 0 to `end`, with these slopes at the two ends.
    pub(super) fn through(values: &[f64], end: f64, first: f64, last: f64) -> Spline {
        let pieces = values.len() - 1;
        let step = end / pieces as f64;
        // The slopes, a step being 1: their neighbours' sum and four times themselves is thrice the rise. The equations
        // have three diagonals; the lower is cleared from the start, the upper from the end (Thomas).
        let mut slopes = vec![first * step; pieces + 1];
        let mut above = vec![0.0; pieces + 1];
        for i in 1..pieces {
            let pivot = 4.0 - above[i - 1];
            above[i] = 1.0 / pivot;
            slopes[i] = (3.0 * (values[i + 1] - values[i - 1]) - slopes[i - 1]) / pivot;
        }
        slopes[pieces] = last * step;
        for i in (1..pieces).rev() {
            slopes[i] -= above[i] * slopes[i + 1];
        }
        let piece = |i: usize| {
            let (rise, a, b) = (values[i + 1] - values[i], slopes[i], slopes[i + 1]);
            [values[i], a, 3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise]
        };
        Spline { step, pieces: (0..pieces).map(piece).collect() }
    }

    /// Its value, up to its end.
    pub(super) fn at(&self, x: f64) -> f64 {
        let x = x / self.step;
        let piece = (x as usize).min(self.pieces.len() - 1);
        let x = x - piece as f64;
        let [a, b, c, d] = self.pieces[piece];
        a + x * (b + x * (c + x * d))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_is_smooth_and_passes_through_its_values() {
        let values = [1.0, 0.3, -0.5, 0.25, 0.0];
        let spline = Spline::through(&values, 2.0, 0.0, -0.125);
        for (i, v) in values.iter().enumerate() {
            assert!((spline.at(0.5 * i as f64) - v).abs() < 1e-14);
        }
        for (p, q) in spline.pieces.iter().zip(&spline.pieces[1..]) {
            assert!((p[1] + 2.0 * p[2] + 3.0 * p[3] - q[1]).abs() < 1e-14);
            assert!((p[2] + 3.0 * p[3] - q[2]).abs() < 1e-13);
        }
        let [_, b, c, d] = spline.pieces[3];
        assert!(spline.pieces[0][1] == 0.0 && (b + 2.0 * c + 3.0 * d + 0.0625).abs() < 1e-14);
    }
}
