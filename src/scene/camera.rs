//! The camera: from pixels to rays.

use super::error::SceneError;
use super::ray::Ray;
use crate::image::Matrix4;
use glam::DVec3;

/// The largest coordinate of an eye or look-at point, in unscaled world units; farther off, a scene is a dot.
pub(super) const LIMIT: f64 = 1e5;

/// A perspective camera with square pixels, as orthonormal axes in world space.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct Camera {
    /// The centre of projection.
    pub eye: DVec3,
    /// The view axis, into the picture.
    pub forward: DVec3,
    /// To the right of the picture.
    pub right: DVec3,
    /// To the top of the picture.
    pub up: DVec3,
    /// From one pixel to the next, on the plane at distance 1.
    step: f64,
    /// Columns and rows.
    size: [f64; 2],
}

impl Camera {
    /// Creates a camera at `eye` with `look_at` in the centre of a picture of `size` columns and rows. `fov` is the
    /// vertical angle in degrees; without it, the picture contains a `frame` of this width and height on the plane at
    /// distance 1.
    pub fn new(
        eye: DVec3,
        look_at: DVec3,
        fov: Option<f64>,
        frame: [f64; 2],
        size: [usize; 2],
    ) -> Result<Camera, SceneError> {
        Camera::within(LIMIT, eye, look_at, fov, frame, size)
    }

    /// The same, where no coordinate of the points may be over `limit`.
    pub fn within(
        limit: f64,
        eye: DVec3,
        look_at: DVec3,
        fov: Option<f64>,
        frame: [f64; 2],
        size: [usize; 2],
    ) -> Result<Camera, SceneError> {
        for (what, point) in [("eye", eye), ("look-at point", look_at)] {
            // Not `>`: a NaN must fail too.
            if !(point.abs().max_element() <= limit && point.is_finite()) {
                return Err(SceneError::BadPoint { what, point: point.to_array(), limit });
            }
        }
        let forward = look_at - eye;
        // Relative to the points: a mesh may have a size of any magnitude.
        if forward.length() <= 1e-9 * eye.length().max(look_at.length()) {
            return Err(SceneError::NoDirection { point: eye.to_array() });
        }
        let forward = forward.normalize();
        // Straight up and straight down are what a camera facing +y comes to when it is tilted: x stays to the right.
        let right = forward.cross(DVec3::Z).try_normalize().filter(|_| forward.z.abs() < 1.0 - 1e-14);
        let right = right.unwrap_or(DVec3::X);
        let up = right.cross(forward);
        let size = size.map(|n| n as f64);
        let step = match fov {
            Some(fov) if fov > 0.0 && fov < 180.0 => 2.0 * libm::tan(fov.to_radians() / 2.0) / size[1],
            Some(fov) => return Err(SceneError::BadFov(fov)),
            None => (frame[0] / size[0]).max(frame[1] / size[1]),
        };
        Ok(Camera { eye, forward, right, up, step, size })
    }

    /// The same camera seen from an origin that lies `by` farther back: that of the world, for a mesh with a local one.
    pub fn moved(&self, by: DVec3) -> Camera {
        Camera { eye: self.eye + by, ..self.clone() }
    }

    /// The matrices from the world, a scene so many times as large, to the camera and to the screen.
    ///
    /// The camera looks along -z, x to the right and y to the top. On the screen x goes from 0 at the left edge to 1
    /// at the right one and y likewise from the bottom to the top; z is one over the depth.
    pub fn spaces(&self, scale: f64) -> [Matrix4; 2] {
        let row = |axis: DVec3| [axis.x, axis.y, axis.z, -axis.dot(self.eye * scale)];
        let camera = [row(self.right), row(self.up), row(-self.forward), [0.0, 0.0, 0.0, 1.0]];
        let depth = row(self.forward);
        let across = |axis: usize| {
            let width = self.step * self.size[axis];
            std::array::from_fn(|i| camera[axis][i] / width + depth[i] / 2.0)
        };
        let screen: [[f64; 4]; 4] = [across(0), across(1), [0.0, 0.0, 0.0, 1.0], depth];
        [camera, screen].map(|matrix| matrix.map(|row| row.map(|x| x as f32)))
    }

    /// The ray through a place of the picture; column and row count from the top left corner, pixel centres are at .5.
    pub(crate) fn ray(&self, column: f64, row: f64) -> Ray {
        let x = (column - self.size[0] / 2.0) * self.step;
        let y = (self.size[1] / 2.0 - row) * self.step;
        Ray { origin: self.eye, direction: (self.forward + self.right * x + self.up * y).normalize() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(eye: [f64; 3], look_at: [f64; 3], fov: f64) -> Result<Camera, SceneError> {
        Camera::new(eye.into(), look_at.into(), Some(fov), [1.0, 1.0], [4, 2])
    }

    #[test]
    fn x_grows_to_the_right_and_z_to_the_top() {
        let camera = camera([0.0, -5.0, 0.0], [0.0; 3], 90.0).expect("a camera");
        assert_eq!((camera.right, camera.up, camera.forward), (DVec3::X, DVec3::Z, DVec3::Y));
        let corner = camera.ray(4.0, 0.0).direction;
        assert!((corner / corner.y - DVec3::new(2.0, 1.0, 1.0)).length() < 1e-12, "{corner}");
        assert!((camera.ray(2.0, 1.0).direction - DVec3::Y).length() < 1e-15);
    }

    #[test]
    fn looking_straight_up_or_down_keeps_x_to_the_right() {
        let down = camera([0.0, 0.0, 5.0], [0.0; 3], 40.0).expect("a camera");
        assert_eq!((down.right, down.up), (DVec3::X, DVec3::Y));
        let up = camera([0.0, 0.0, -5.0], [0.0; 3], 40.0).expect("a camera");
        assert_eq!((up.right, up.up), (DVec3::X, DVec3::NEG_Y));
        let nearly = camera([0.0, -1e-3, 5.0], [0.0; 3], 40.0).expect("a camera");
        assert!((nearly.up - DVec3::Y).length() < 1e-3);
    }

    #[test]
    fn the_frame_fits_whatever_the_proportions() {
        for size in [[100, 100], [200, 100], [50, 300]] {
            let camera = Camera::new(DVec3::NEG_Y, DVec3::ZERO, None, [0.5, 0.4], size).expect("a camera");
            let corner = camera.ray(size[0] as f64, 0.0).direction;
            let [x, z] = [2.0 * corner.x / corner.y, 2.0 * corner.z / corner.y];
            assert!(x > 0.5 - 1e-12 && z > 0.4 - 1e-12, "{size:?} shows {x} by {z}");
            assert!(x < 0.5 + 1e-12 || z < 0.4 + 1e-12, "{size:?} shows {x} by {z}");
        }
    }

    #[test]
    fn degenerate_cameras_are_errors_that_say_what_to_do() {
        let say = |result: Result<Camera, SceneError>| result.expect_err("an error").to_string();
        assert_eq!(
            say(camera([1.0, 2.0, 3.0], [1.0, 2.0, 3.0], 40.0)),
            "the eye and the point that it looks at are the same, 1,2,3; move the eye away from the point it looks at"
        );
        assert!(
            say(camera([f64::NAN, 0.0, 0.0], [0.0; 3], 40.0))
                .starts_with("eye NaN,0,0 is not a finite point")
        );
        assert!(say(camera([0.0; 3], [0.0, f64::INFINITY, 0.0], 40.0)).contains("look-at point"));
        assert!(say(camera([1e9, 0.0, 0.0], [0.0; 3], 40.0)).contains("too far away"));
        for fov in [0.0, -10.0, 180.0, 400.0, f64::NAN] {
            assert!(say(camera([1.0, 0.0, 0.0], [0.0; 3], fov)).contains("between 0 and 180"));
        }
    }
}
