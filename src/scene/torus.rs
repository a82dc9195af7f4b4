//! A torus.

use super::bernstein::Roots;
use super::ray::{FAR, Hit, Ray, Surface, around, turn};
use super::sphere::Sphere;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A solid ring around the z axis through its centre. u goes around that axis; v goes around the tube, from its underside
/// (0) by the outside (0.25), the top (0.5) and the hole (0.75).
#[derive(Clone, Copy, Debug)]
pub(super) struct Torus {
    /// Its centre.
    pub center: DVec3,
    /// From the centre to the middle of the tube.
    pub major: f64,
    /// The radius of the tube.
    pub minor: f64,
}

impl Torus {
    /// Below 0 inside, over 0 outside: `(|p|^2 + R^2 - r^2)^2 - 4 R^2 (x^2 + y^2)` for p from the centre.
    pub fn implicit(&self, point: DVec3) -> f64 {
        let p = point - self.center;
        let sum = p.length_squared() + self.major * self.major - self.minor * self.minor;
        sum * sum - 4.0 * self.major * self.major * (p.x * p.x + p.y * p.y)
    }

    fn place(&self, ray: &Ray, distance: f64) -> Hit {
        let point = ray.at(distance);
        let p = point - self.center;
        let across = libm::hypot(p.x, p.y);
        let outward = DVec2::new(p.x, p.y) / across;
        // The tube's own circle, in the half-plane of (distance from the axis, z).
        let tube = DVec2::new(across - self.major, p.z).normalize();
        Hit {
            distance,
            point,
            normal: (outward * tube.x).extend(tube.y),
            uv: DVec2::new(turn(p.x, p.y), tube_turn(tube)),
            dpdu: around(p.x, p.y),
            dpdv: (outward * -tube.y).extend(tube.x) * (self.minor * TAU),
        }
    }
}

/// The share of a turn around the tube, from straight down by straight outward.
fn tube_turn(tube: DVec2) -> f64 {
    let share = libm::atan2(tube.x, -tube.y) / TAU;
    if share < 0.0 { share + 1.0 } else { share }
}

impl Surface for Torus {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        // Clip the ray to the ring's bounding ball and slab.
        let ball = Sphere { center: self.center, radius: (self.major + self.minor) * (1.0 + 1e-6) };
        let [mut low, mut high] = ball.span(ray)?;
        let half = self.minor * (1.0 + 1e-6);
        let height = ray.origin.z - self.center.z;
        if ray.direction.z != 0.0 {
            let (a, b) = ((-half - height) / ray.direction.z, (half - height) / ray.direction.z);
            low = low.max(a.min(b));
            high = high.min(a.max(b));
        } else if height.abs() > half {
            return None;
        }
        low = low.max(0.0);
        if low >= high {
            return None;
        }
        // The implicit function along the ray is a quartic; measured from the clipped piece's middle it keeps its digits.
        let middle = 0.5 * (low + high);
        let o = ray.at(middle) - self.center;
        let d = ray.direction;
        let (r2, along) = (self.major * self.major, 2.0 * o.dot(d));
        let sum = o.length_squared() + r2 - self.minor * self.minor;
        let quartic = [
            sum * sum - 4.0 * r2 * (o.x * o.x + o.y * o.y),
            2.0 * sum * along - 8.0 * r2 * (o.x * d.x + o.y * d.y),
            2.0 * sum + along * along - 4.0 * r2 * (d.x * d.x + d.y * d.y),
            2.0 * along,
            1.0,
        ];
        let roots = Roots::of(&quartic, low - middle, high - middle);
        let distance = middle + roots.as_slice().first()?;
        (distance > 0.0 && distance <= FAR).then(|| self.place(ray, distance))
    }

    fn holds(&self, point: DVec3) -> bool {
        self.implicit(point) <= 1e-9 * self.major * self.major * self.minor * self.minor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DONUT: Torus = Torus { center: DVec3::new(0.3, -0.2, 0.1), major: 1.0, minor: 0.5 };

    fn towards(origin: [f64; 3], target: [f64; 3]) -> Ray {
        let origin = DVec3::from(origin);
        Ray { origin, direction: (DVec3::from(target) - origin).normalize() }
    }

    #[test]
    fn hits_lie_on_the_ring_and_the_normal_is_its_gradient() {
        let mut hits = 0;
        for i in 0..200 {
            for j in 0..200 {
                let target = [f64::from(i) * 0.02 - 2.0, 0.0, f64::from(j) * 0.02 - 2.0];
                let Some(hit) = DONUT.hit(&towards([0.5, -6.0, 3.0], target)) else { continue };
                hits += 1;
                assert!(DONUT.implicit(hit.point).abs() < 1e-12);
                let h = 1e-5;
                let slope =
                    |axis: DVec3| DONUT.implicit(hit.point + axis * h) - DONUT.implicit(hit.point - axis * h);
                let gradient = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize();
                assert!((gradient - hit.normal).length() < 1e-6, "{gradient} {}", hit.normal);
            }
        }
        assert!(hits > 5000, "{hits}");
    }

    #[test]
    fn grazing_rays_agree_with_the_geometry() {
        // Straight down beside the outer rim and beside the hole, a hair on either side of touching.
        for (x, seen) in [(1.5 - 1e-9, true), (1.5 + 1e-9, false), (0.5 + 1e-9, true), (0.5 - 1e-9, false)] {
            let ray = Ray { origin: DONUT.center + DVec3::new(x, 0.0, 9.0), direction: DVec3::NEG_Z };
            assert_eq!(DONUT.hit(&ray).is_some(), seen, "at {x}");
        }
        // Along the flat top, where the whole circle is touched at once.
        for (z, seen) in [(0.5 - 1e-7, true), (0.5 + 1e-9, false)] {
            let ray = Ray { origin: DONUT.center + DVec3::new(-9.0, 1.0, z), direction: DVec3::X };
            assert_eq!(DONUT.hit(&ray).is_some(), seen, "at {z}");
        }
    }

    #[test]
    fn what_is_behind_is_not_seen() {
        let ray = Ray { origin: DONUT.center, direction: DVec3::Z };
        assert!(DONUT.hit(&ray).is_none());
        let out = Ray { origin: DONUT.center, direction: DVec3::X };
        assert!((DONUT.hit(&out).expect("the hole's wall").distance - 0.5).abs() < 1e-12);
        assert!(DONUT.holds(DONUT.center + DVec3::X));
        assert!(!DONUT.holds(DONUT.center));
    }

    #[test]
    fn uv_starts_underneath_and_at_the_back() {
        let uv = |x: f64, y: f64, z: f64| {
            let outside = DVec3::new(x, y, z);
            let ring = DVec3::new(x, y, 0.0).normalize();
            let direction = (ring - outside).normalize();
            DONUT.hit(&Ray { origin: DONUT.center + outside, direction }).expect("a hit").uv
        };
        assert!((uv(0.0, -3.0, 0.0) - DVec2::new(0.5, 0.25)).length() < 1e-12);
        assert!((uv(-1.0, 1e-12, 3.0) - DVec2::new(0.25, 0.5)).length() < 1e-9);
    }
}
