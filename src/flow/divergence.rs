//! How much a flow gathers and spreads.

use super::Vector;
use super::field::Field;
use super::trajectories::velocities;
use crate::program::{Error, RunOptions};
use glam::DVec3;

/// The divergence of a velocity, measured at some points by central differences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Divergence {
    /// The root mean square of the divergence, in 1 over units of time.
    pub divergence: f64,
    /// The root mean square of all nine derivatives, for comparison with the divergence.
    pub gradient: f64,
    /// The number of points.
    pub points: usize,
}

impl Divergence {
    /// The divergence relative to the derivatives: at most about 1e-3 for a flow without divergence, because of
    /// single precision.
    pub fn share(&self) -> f64 {
        if self.gradient > 0.0 { self.divergence / self.gradient } else { 0.0 }
    }
}

/// Looks at six neighbours of each point, `distance` away.
pub(super) fn measure(
    velocity: &Field,
    points: &[Vector],
    distance: f64,
    options: &RunOptions<'_>,
) -> Result<Divergence, Error> {
    const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];
    let at = |i: usize| {
        let (point, side) = (points[i / 6], i % 6);
        let shift = if side < 3 { distance } else { -distance };
        DVec3::from(point.map(f64::from)) + AXES[side % 3] * shift
    };
    let found = velocities(velocity, 6 * points.len(), at, options)?;
    let mut squares = [0.0; 2];
    for (i, six) in found.chunks_exact(6).enumerate() {
        // The places are rounded to single precision, so it is their difference that counts.
        let derivative = |axis: usize| {
            let place = |side: usize| f64::from(at(6 * i + side)[axis] as f32);
            (six[axis] - six[axis + 3]) / (place(axis) - place(axis + 3))
        };
        let d = [derivative(0), derivative(1), derivative(2)];
        let divergence = d[0].x + d[1].y + d[2].z;
        squares[0] += divergence * divergence;
        squares[1] += d.iter().map(|d| d.length_squared()).sum::<f64>();
    }
    let mean = |sum: f64| (sum / points.len().max(1) as f64).sqrt();
    Ok(Divergence { divergence: mean(squares[0]), gradient: mean(squares[1]), points: points.len() })
}
