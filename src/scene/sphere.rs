//! A sphere.

use super::ray::{FAR, Hit, Ray, Surface, around, turn};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// A solid ball. u goes around the z axis, v from the south pole (0) to the north pole (1) by equal angles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sphere {
    /// Its centre.
    pub center: DVec3,
    /// Its radius.
    pub radius: f64,
}

impl Sphere {
    /// Where a line enters and leaves it, as distances; `None` where they miss.
    pub fn span(&self, ray: &Ray) -> Option<[f64; 2]> {
        // Measure from the line's nearest point to the centre: a far eye then costs no digits.
        let middle = (self.center - ray.origin).dot(ray.direction);
        let miss = (ray.at(middle) - self.center).length_squared();
        let square = self.radius * self.radius - miss;
        (square > 0.0).then(|| [middle - square.sqrt(), middle + square.sqrt()])
    }

    /// The place on the surface at that distance.
    pub fn place(&self, ray: &Ray, distance: f64) -> Hit {
        let normal = (ray.at(distance) - self.center).normalize();
        let local = normal * self.radius;
        let across = libm::hypot(local.x, local.y);
        // North along the meridian; at a pole any meridian will do.
        let outward = if across > 0.0 { DVec2::new(local.x, local.y) / across } else { DVec2::NEG_Y };
        Hit {
            distance,
            point: self.center + local,
            normal,
            uv: DVec2::new(turn(local.x, local.y), libm::atan2(across, -local.z) / PI),
            dpdu: around(local.x, local.y),
            dpdv: (outward * -local.z).extend(across) * PI,
        }
    }
}

impl Surface for Sphere {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let [near, _] = self.span(ray)?;
        (near > 0.0 && near <= FAR).then(|| self.place(ray, near))
    }

    fn holds(&self, point: DVec3) -> bool {
        point.distance(self.center) <= self.radius * (1.0 + 1e-9)
    }
}
