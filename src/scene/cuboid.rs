//! A box that may be turned about the vertical.

use super::ray::{FAR, Hit, Ray, Surface};
use glam::{DMat3, DVec2, DVec3};

/// A solid box. On each face u and v go from 0 to 1; on the upright faces v goes up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cuboid {
    /// Its centre.
    pub center: DVec3,
    /// Half its size along its own axes.
    pub half: DVec3,
    /// Its own axes in world space, as orthonormal columns.
    pub axes: DMat3,
}

impl Cuboid {
    /// A cube standing on a point of the ground, turned about the vertical so that its x axis points along (x, y).
    pub fn standing(ground: DVec3, side: f64, x: f64, y: f64) -> Cuboid {
        let axis = DVec3::new(x, y, 0.0).normalize();
        let axes = DMat3::from_cols(axis, DVec3::Z.cross(axis), DVec3::Z);
        Cuboid { center: ground + DVec3::Z * (side / 2.0), half: DVec3::splat(side / 2.0), axes }
    }
}

impl Surface for Cuboid {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let turn = self.axes.transpose();
        let origin = turn * (ray.origin - self.center);
        let direction = turn * ray.direction;
        // The ray is in the box where it is between all three pairs of faces.
        let (mut near, mut far, mut axis) = (0.0, FAR, None);
        for i in 0..3 {
            let (o, d, h) = (origin[i], direction[i], self.half[i]);
            if d == 0.0 {
                if o.abs() > h {
                    return None;
                }
                continue;
            }
            let side = -h * d.signum();
            let (enter, leave) = ((side - o) / d, (-side - o) / d);
            if enter > near {
                (near, axis) = (enter, Some(i));
            }
            far = leave.min(far);
        }
        let axis = axis.filter(|_| near < far)?;

        // Name the face's directions so that cross(du, dv) is its outward normal.
        let outward = DVec3::AXES[axis] * -direction[axis].signum();
        let up = if axis == 2 { DVec3::Y } else { DVec3::Z };
        let across = up.cross(outward);
        let mut local = origin + direction * near;
        local[axis] = self.half[axis] * outward[axis];
        let share = |along: DVec3| 0.5 + 0.5 * local.dot(along) / self.half.dot(along.abs());
        Some(Hit {
            distance: near,
            point: self.center + self.axes * local,
            normal: self.axes * outward,
            uv: DVec2::new(share(across), share(up)),
            dpdu: self.axes * across * (2.0 * self.half.dot(across.abs())),
            dpdv: self.axes * up * (2.0 * self.half.dot(up.abs())),
        })
    }

    fn holds(&self, point: DVec3) -> bool {
        let local = self.axes.transpose() * (point - self.center);
        local.abs().cmple(self.half * (1.0 + 1e-9)).all()
    }
}
