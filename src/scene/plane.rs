//! Flat sheets: endless floors and framed panes.

use super::ray::{FAR, Hit, Ray, Surface};
use glam::{DVec2, DVec3};

/// A plane through `origin`, whose point at (u, v) is `origin + u * du + v * dv`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// Where u and v are 0.
    pub origin: DVec3,
    /// How the point moves with u.
    pub du: DVec3,
    /// How the point moves with v; perpendicular to `du`.
    pub dv: DVec3,
    /// How far it goes, and what is behind it.
    pub kind: PlaneKind,
}

/// The kinds of sheets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PlaneKind {
    /// Without end, seen from both sides.
    Endless,
    /// Without end, and solid behind: where `cross(du, dv)` does not point to.
    Ground,
    /// The part with u and v in `0..1`, seen from both sides.
    Pane,
}

impl Plane {
    /// A horizontal plane at a height, with u along x and v along y.
    pub fn horizontal(z: f64, kind: PlaneKind) -> Plane {
        Plane { origin: DVec3::Z * z, du: DVec3::X, dv: DVec3::Y, kind }
    }

    fn normal(&self) -> DVec3 {
        self.du.cross(self.dv).normalize()
    }
}

impl Surface for Plane {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let normal = self.normal();
        let towards = ray.direction.dot(normal);
        let distance = (self.origin - ray.origin).dot(normal) / towards;
        // An edge-on ray gives an infinite distance or a NaN, and falls out here.
        if !(distance > 0.0 && distance <= FAR) {
            return None;
        }
        let p = ray.at(distance) - self.origin;
        let uv =
            DVec2::new(p.dot(self.du) / self.du.length_squared(), p.dot(self.dv) / self.dv.length_squared());
        if self.kind == PlaneKind::Pane && !(uv.cmpge(DVec2::ZERO).all() && uv.cmple(DVec2::ONE).all()) {
            return None;
        }
        Some(Hit {
            distance,
            // Rebuilt from uv, so that a floor at height 0 is at exactly 0.
            point: self.origin + self.du * uv.x + self.dv * uv.y,
            normal: if towards > 0.0 { -normal } else { normal },
            uv,
            dpdu: self.du,
            dpdv: self.dv,
        })
    }

    fn holds(&self, point: DVec3) -> bool {
        let height = (point - self.origin).dot(self.normal());
        let near = 1e-9 * point.length().max(1.0);
        if self.kind == PlaneKind::Ground { height <= near } else { height.abs() <= near }
    }
}
