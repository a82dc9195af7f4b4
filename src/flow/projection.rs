//! From space to the picture.

use crate::image::{Matrix4, Metadata};
use crate::scene::SceneError;
use crate::scene::camera::Camera;
use glam::{DMat4, DVec2, DVec3};

/// A camera, as an image's header tells it: where a point is seen, and how far away.
#[derive(Clone, Debug)]
pub struct Projection {
    camera: DMat4,
    screen: DMat4,
    /// Columns and rows of the whole picture.
    pub size: [usize; 2],
}

fn matrix(m: &Matrix4) -> DMat4 {
    let rows = m.map(|row| row.map(f64::from));
    DMat4::from_cols_array_2d(&rows).transpose()
}

impl Projection {
    /// From the matrices from the world to the camera and to the screen.
    pub fn new(camera: &Matrix4, screen: &Matrix4, size: [usize; 2]) -> Projection {
        Projection { camera: matrix(camera), screen: matrix(screen), size }
    }

    /// As the attributes `worldToCamera` and `worldToNDC` tell it, with the conventions of built-in scenes (the screen goes
    /// from 0 to 1, y from the bottom). `None` without these.
    pub fn of(metadata: &Metadata, size: [usize; 2]) -> Option<Projection> {
        let matrix = |name: &str| metadata.attributes.matrix(name);
        Some(Projection::new(&matrix("worldToCamera")?, &matrix("worldToNDC")?, size))
    }

    /// A camera at `eye` that has `look_at` in the middle of the picture and z upwards, and the vertical angle `fov` in degrees.
    ///
    /// # Errors
    /// Points that are not finite, or the same; an angle that is none.
    pub fn looking(
        eye: [f64; 3],
        look_at: [f64; 3],
        fov: f64,
        size: [usize; 2],
    ) -> Result<Projection, SceneError> {
        let camera = Camera::new(eye.into(), look_at.into(), Some(fov), [1.0; 2], size)?;
        let [camera, screen] = camera.spaces(1.0);
        Ok(Projection::new(&camera, &screen, size))
    }

    /// Writes the camera into an image's header, as [`Projection::of`] reads it.
    pub fn note(&self, metadata: &mut Metadata) {
        let rows = |m: &DMat4| m.transpose().to_cols_array_2d().map(|row| row.map(|x| x as f32));
        metadata.attributes.set_matrix("worldToCamera", &rows(&self.camera));
        metadata.attributes.set_matrix("worldToNDC", &rows(&self.screen));
    }

    /// The depth along the view axis, which is negative behind the eye.
    pub fn depth(&self, point: DVec3) -> f64 {
        // Renderers look along -z or along +z; what a point before the eye divides by tells which.
        let across = (self.screen * point.extend(1.0)).w;
        let along = (self.camera * point.extend(1.0)).z.abs();
        if across > 0.0 { along } else { -along }
    }

    /// Where the eye is.
    pub fn eye(&self) -> DVec3 {
        let inverse = self.camera.inverse();
        inverse.w_axis.truncate() / inverse.w_axis.w
    }

    /// Column and row, from the top left corner of the picture; only for points before the eye.
    pub fn place(&self, point: DVec3) -> DVec2 {
        let seen = self.screen * point.extend(1.0);
        let [width, height] = self.size.map(|n| n as f64);
        DVec2::new(seen.x / seen.w * width, (1.0 - seen.y / seen.w) * height)
    }
}
