//! Rays, what they hit, and what can be hit.

use glam::{DVec2, DVec3};

/// Hits farther away than this are none: beyond, an `f32` point is too coarse to paint.
pub(super) const FAR: f64 = 1e6;

/// A half-line from the eye. Distances along it are world distances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes; of length 1.
    pub direction: DVec3,
}

impl Ray {
    /// The point at a distance from the start.
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + self.direction * distance
    }
}

/// A place of a surface that a ray meets. Points and vectors are in world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// How far along the ray.
    pub distance: f64,
    /// The place.
    pub point: DVec3,
    /// The unit normal, out of the solid.
    pub normal: DVec3,
    /// The surface's own coordinates of the place.
    pub uv: DVec2,
    /// How the point moves with u.
    pub dpdu: DVec3,
    /// How the point moves with v.
    pub dpdv: DVec3,
}

/// Something to be seen.
pub(super) trait Surface: Send + Sync {
    /// The first place at a distance over 0 and up to [`FAR`] where the ray enters it.
    fn hit(&self, ray: &Ray) -> Option<Hit>;

    /// Is the point inside it, or on it, so that an eye there could not see it?
    fn holds(&self, point: DVec3) -> bool;
}

/// The share of a turn about the z axis, in `0..1`: 0 at +y, where the default cameras do not see the seam, and 0.25 at -x.
pub(super) fn turn(x: f64, y: f64) -> f64 {
    use std::f64::consts::TAU;
    let share = libm::atan2(-x, y) / TAU;
    if share < 0.0 { share + 1.0 } else { share }
}

/// `dPdu` of a surface of revolution about z: the velocity of a point at (x, y) from the axis, per whole turn.
pub(super) fn around(x: f64, y: f64) -> DVec3 {
    use std::f64::consts::TAU;
    DVec3::new(-y, x, 0.0) * TAU
}
