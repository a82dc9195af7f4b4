//! From space to the picture.

use super::resection::{ResectionError, resect};
use crate::image::{Image, Matrix4, Metadata};
use crate::scene::SceneError;
use crate::scene::camera::Camera;
use glam::{DMat3, DVec2, DVec3, DVec4};

/// A camera: where a point is seen in a picture, and how far away.
#[derive(Clone, Debug)]
pub struct Projection {
    /// Column and row, each times the last; and what they are times, the depth along the view axis.
    rows: [DVec4; 3],
    /// Columns and rows of the whole picture.
    pub size: [usize; 2],
}

impl Projection {
    /// From the matrix from the world to a screen that goes from 0 to 1, x to the right and y up, as those of built-in
    /// scenes do. `None` if it is none of a perspective camera.
    pub fn new(screen: &Matrix4, size: [usize; 2]) -> Option<Projection> {
        let [x, y, _, w] = screen.map(|row| DVec4::from_array(row.map(f64::from)));
        let [width, height] = size.map(|n| n as f64);
        Projection::of_rows([x * width, (w - y) * height, w], size)
    }

    /// From the rows of the matrix from a point to column and row, times a factor that is the depth but for its scale.
    pub(super) fn of_rows(rows: [DVec4; 3], size: [usize; 2]) -> Option<Projection> {
        let scale = rows[2].truncate().length();
        let rows = rows.map(|row| row / scale);
        let lens = DMat3::from_cols(rows[0].truncate(), rows[1].truncate(), rows[2].truncate());
        let known = rows.iter().all(|row| row.is_finite()) && lens.determinant() != 0.0;
        known.then_some(Projection { rows, size })
    }

    /// The camera of an image: that of the header's attribute `worldToNDC`, or else the one that saw the image's points.
    ///
    /// # Errors
    /// If the header has none, and the points do not tell it.
    pub fn of(image: &Image<'_>) -> Result<Projection, ResectionError> {
        let written = image.metadata.attributes.matrix("worldToNDC");
        match written.and_then(|screen| Projection::new(&screen, image.resolution())) {
            Some(projection) => Ok(projection),
            None => resect(image).map(|found| found.projection),
        }
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
        let [_, screen] = camera.spaces(1.0);
        Projection::new(&screen, size).ok_or(SceneError::BadFov(fov))
    }

    /// The matrices from the world to the camera and to the screen, in the conventions of the built-in scenes: the camera
    /// looks along -z, x to the right and y to the top; the screen goes from 0 to 1, y to the top, and z is one over the
    /// depth.
    pub fn spaces(&self) -> [Matrix4; 2] {
        let [width, height] = self.size.map(|n| n as f64);
        let [column, row, depth] = self.rows;
        let screen = [column / width, depth - row / height, DVec4::W, depth];
        let forward = depth.truncate();
        // Which way x and y go is that of columns and rows, across the view: a mirrored picture has a mirrored camera.
        let across = |row: DVec3| (row - forward * row.dot(forward)).normalize_or_zero();
        let right = across(column.truncate());
        let up = across(-row.truncate());
        let up = (up - right * up.dot(right)).normalize_or_zero();
        let eye = self.eye();
        let axis = |a: DVec3| a.extend(-a.dot(eye));
        let camera = [axis(right), axis(up), axis(-forward), DVec4::W];
        [camera, screen].map(|rows| rows.map(|row| row.to_array().map(|x| x as f32)))
    }

    /// Writes the camera into an image's header, as `worldToCamera` and `worldToNDC`.
    pub fn note(&self, metadata: &mut Metadata) {
        let [camera, screen] = self.spaces();
        metadata.attributes.set_matrix("worldToCamera", &camera);
        metadata.attributes.set_matrix("worldToNDC", &screen);
    }

    /// The depth along the view axis, which is negative behind the eye.
    pub fn depth(&self, point: DVec3) -> f64 {
        self.rows[2].dot(point.extend(1.0))
    }

    /// Where the eye is: the point that is seen nowhere.
    pub fn eye(&self) -> DVec3 {
        let [a, b, c] = self.rows;
        let lens = DMat3::from_cols(a.truncate(), b.truncate(), c.truncate()).transpose();
        lens.inverse() * -DVec3::new(a.w, b.w, c.w)
    }

    /// Column and row, from the top left corner of the picture; only for points before the eye.
    pub fn place(&self, point: DVec3) -> DVec2 {
        let [column, row, depth] = self.rows.map(|row| row.dot(point.extend(1.0)));
        DVec2::new(column, row) / depth
    }
}
