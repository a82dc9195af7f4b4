//! Measures of signals and of solid noises: moments, histograms, spectra, covariances.
//!
//! It knows nothing of the language and of the noises: it takes samples, or a closure that gives them. Numbers are
//! summed as f64 in a fixed order, so that a measure is the same on every machine but for the last digits of the
//! sines within the transforms.
//!
//! | what | where | source |
//! |---|---|---|
//! | [`Moments`]: mean, deviation, excess kurtosis, extremes | `moments` | |
//! | [`Histogram`] | `histogram` | Peachey recommends one for every noise ("Generating Irregular Patterns") |
//! | [`Section`]: the points of a plane or a line through a solid | `section` | Lewis 1989, figures 2, 4, 5 |
//! | [`Spectrum`]: power by frequency of plane sections | `spectrum` | Peachey, figures 2.37 and 2.39 |
//! | [`LineSpectrum`]: amplitude by frequency of a long straight section | `spectrum` | Lewis 1989, figure 4 |
//! | [`autocovariance`], [`correlation`] | `covariance` | Lewis 1989, sections 4 and 5 |
//! | [`Random`]: the points where to look | `random` | |
//!
//! Lengths are in units of the noise, frequencies in cycles a unit, energies and covariances in squares of its values.
//!
//! ```
//! use pse::measure::{Random, Section, Spectrum};
//!
//! let mut spectrum = Spectrum::new(128, 1.0 / 8.0);
//! let mut random = Random::new(1);
//! for _ in 0..4 {
//!     let section = Section::tilted(&mut random, 3, 128, 1.0 / 8.0, 100.0);
//!     // Plane waves of half a cycle a unit along x.
//!     let waves = section.sample(|p, out| {
//!         for (out, x) in out.iter_mut().zip(p[0]) {
//!             *out = (std::f32::consts::PI * x).sin();
//!         }
//!     });
//!     spectrum.add(&waves);
//! }
//! // A tilted section shows them longer, never shorter.
//! assert!(spectrum.share(0.0, 0.6) > 0.99);
//! ```

mod covariance;
mod histogram;
mod moments;
mod random;
mod section;
mod spectrum;

pub use covariance::{autocovariance, correlation, covariance};
pub use histogram::Histogram;
pub use moments::Moments;
pub use random::Random;
pub use section::Section;
pub use spectrum::{LineSpectrum, Spectrum};

/// The slope of the straight line through points, by least squares.
pub fn slope(points: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let points: Vec<(f64, f64)> = points.into_iter().collect();
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / count, b + y / count));
    let (up, along) = points
        .iter()
        .fold((0.0, 0.0), |(up, along), (a, b)| (up + (a - x) * (b - y), along + (a - x) * (a - x)));
    up / along
}
