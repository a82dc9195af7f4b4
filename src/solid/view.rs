//! From a solid to an image: rows of rays.

use super::cuboid::{Cuboid, Span};
use super::error::SolidError;
use super::field::{Field, written};
use super::march::March;
use super::slopes::Slopes;
use super::soft::gather;
use super::{Isosurface, SolidOptions};
use crate::image::{Image, Metadata, Variable};
use crate::parallel::*;
use crate::scene::SceneError;
use crate::scene::camera::Camera;
use crate::scene::gather::{MAX_PIXELS, NOTHING};
use crate::scene::ray::Ray;
use crate::shape::Shape;
use glam::DVec3;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};

/// From where a box is seen by default, as a direction from its middle, and how many of its half diagonals away.
const DEFAULT_EYE: (DVec3, f64) = (DVec3::new(0.35, -1.0, 0.5), 3.5);

/// A pixel is no narrower than this share of the box.
const FINEST: f64 = 1.0 / 20_000.0;

/// Steps through the box in what is soft, if nothing else is said.
const SOFT_STEPS: f64 = 256.0;

/// The variables of a solid, with the number of planes of each.
const SOLID: [(&str, u32); 5] = [("surface", 1), ("point", 3), ("depth", 1), ("I", 3), ("normal", 3)];

/// Those of what is soft; the last only if the program tells of it.
const SOFT: [(&str, u32); 6] =
    [("surface", 1), ("point", 3), ("depth", 1), ("I", 3), ("alpha", 1), ("color", 3)];

/// The most cells of a pixel.
const CELLS: usize = 12;

/// How the solid is looked at.
pub(super) struct View {
    camera: Camera,
    size: [usize; 2],
    soft: bool,
    step: f64,
    lipschitz: Option<f64>,
    /// A pixel's width at distance 1, and in the middle of the box.
    pixel: f64,
    spacing: f64,
    /// Found when it is first wanted.
    slopes: Mutex<Option<Arc<Slopes>>>,
}

impl View {
    pub fn new(cuboid: &Cuboid, options: &SolidOptions) -> Result<View, SolidError> {
        let SolidOptions { view, lipschitz, step, .. } = options;
        let (width, height) = (view.width, view.height);
        if !width.checked_mul(height).is_some_and(|n| n > 0 && n <= MAX_PIXELS) {
            return Err(SceneError::BadSize { width, height }.into());
        }
        let positive = |x: &f64| x.is_finite() && *x > 0.0;
        if view.scale != 1.0 {
            return Err(SolidError::new(
                "a solid is not scaled",
                "Its size is that of its density. Remove --scale.",
            ));
        }
        if !options.level.is_finite() {
            return Err(SolidError::new(
                "the level is not finite",
                "Give a number that the density crosses.",
            ));
        }
        if lipschitz.is_some_and(|l| !positive(&l)) {
            let hint = "Give the steepest slope of the density, in density per unit of space.";
            return Err(SolidError::new("the bound of the slope is not a positive number", hint));
        }
        if step.is_some_and(|s| !positive(&s) || s < cuboid.longest() * 1e-5) {
            let hint = format!("Give a length like {}.", cuboid.longest() / SOFT_STEPS);
            return Err(SolidError::new("the step is too short for the box", hint));
        }
        let middle = cuboid.middle();
        let (way, far) = DEFAULT_EYE;
        let default_eye = middle + way.normalize() * far * 0.5 * cuboid.size().length();
        let eye = view.eye.map_or(default_eye, DVec3::from);
        let look_at = view.look_at.map_or(middle, DVec3::from);
        let size = [width, height];
        let mut camera = Camera::new(eye, look_at, view.fov, [1.0, 1.0], size)?;
        if view.fov.is_none() {
            // The box just fits, as far as it lies before the eye.
            let frame = cuboid.corners().iter().fold([1e-3; 2], |[w, h]: [f64; 2], corner| {
                let to = *corner - eye;
                let depth = to.dot(camera.forward).max(0.3 * to.length()).max(1e-9);
                let across = |axis: DVec3| 2.0 * (to.dot(axis) / depth).abs();
                [w.max(across(camera.right)), h.max(across(camera.up))]
            });
            camera = Camera::new(eye, look_at, None, frame, size)?;
        }
        let (x, y) = (width as f64 / 2.0, height as f64 / 2.0);
        let pixel = camera.ray(x - 0.5, y).direction.distance(camera.ray(x + 0.5, y).direction);
        let spacing = (pixel * middle.distance(eye)).max(FINEST * cuboid.longest());
        let step = step.unwrap_or(cuboid.longest() / SOFT_STEPS);
        let lipschitz = *lipschitz;
        Ok(View {
            camera,
            size,
            soft: options.soft,
            step,
            lipschitz,
            pixel,
            spacing,
            slopes: Mutex::default(),
        })
    }

    /// The bounds of the slope, if they were already computed.
    pub fn slopes(&self) -> Option<Arc<Slopes>> {
        self.slopes.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Computes the bounds of the slope, and checks that the eye is outside the solid.
    fn prepare(&self, field: &Field<'_>, cuboid: &Cuboid) -> Result<Arc<Slopes>, SolidError> {
        let mut slopes = self.slopes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(slopes) = &*slopes {
            return Ok(Arc::clone(slopes));
        }
        let eye = self.camera.eye;
        if cuboid.holds(eye) && field.density(&[eye], self.spacing)?[0] > 0.0 {
            let (way, far) = DEFAULT_EYE;
            let instead = cuboid.middle() + way.normalize() * far * 0.5 * cuboid.size().length();
            let hint =
                format!("Move it out, for example to --eye {}.", written((instead * 100.0).round() / 100.0));
            return Err(SolidError::new(format!("the eye, {}, is inside the solid", written(eye)), hint));
        }
        let found = match self.lipschitz {
            Some(bound) => Slopes::Stated(bound),
            None => Slopes::estimate(field, cuboid, self.spacing)?,
        };
        Ok(Arc::clone(slopes.insert(Arc::new(found))))
    }
}

impl Isosurface<'_> {
    /// Columns and rows of the whole picture.
    pub fn size(&self) -> [usize; 2] {
        self.view.size
    }

    /// The names of the variables.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.variables().iter().map(|(name, _)| *name)
    }

    fn variables(&self) -> &'static [(&'static str, u32)] {
        match (self.view.soft, self.field.has_emission()) {
            (false, _) => &SOLID,
            (true, false) => &SOFT[..5],
            (true, true) => &SOFT,
        }
    }

    /// Renders some rows of the picture, as an image with their origin. The result does not depend on the division
    /// into rows.
    ///
    /// # Errors
    /// If the program goes wrong at a point, the density is no number, or the eye is inside the solid.
    pub fn rows(&self, rows: Range<usize>) -> Result<Image<'static>, SolidError> {
        self.rows_at(rows, |_| [0.0; 2])
    }

    /// Renders some rows with an offset from the centre of each pixel, `[column row]`: columns to the right, rows
    /// down.
    ///
    /// # Errors
    /// As [`Isosurface::rows`].
    pub fn rows_at(
        &self,
        rows: Range<usize>,
        offset: impl Fn([i32; 2]) -> [f32; 2] + Sync,
    ) -> Result<Image<'static>, SolidError> {
        let [width, height] = self.view.size;
        let total = width * rows.len();
        let ray = |pixel: usize| {
            let (column, row) = (pixel % width, rows.start + pixel / width);
            let [x, y] = offset([column as i32, row as i32]).map(|x| f64::from(x) + 0.5);
            self.view.camera.ray(column as f64 + x, row as f64 + y)
        };
        let rays: Vec<Ray> = (0..total).into_par_iter().map(ray).collect();
        let mut cells: Vec<[f32; CELLS]> = rays
            .par_iter()
            .map(|ray| {
                let mut cells = [0.0; CELLS];
                cells[4] = NOTHING as f32;
                set(&mut cells, 5, ray.direction);
                cells
            })
            .collect();
        let (pixels, inside): (Vec<usize>, Vec<(Ray, Span)>) = rays
            .iter()
            .enumerate()
            .filter_map(|(pixel, ray)| Some((pixel, (*ray, self.cuboid.span(ray)?))))
            .unzip();
        match self.view.soft {
            true => self.soft(&pixels, &inside, &mut cells)?,
            false => self.hard(&pixels, &inside, &mut cells)?,
        }

        let mut planes =
            (0..CELLS).map(|i| Cow::Owned(cells.par_iter().map(|cells| cells[i]).collect::<Vec<f32>>()));
        let variable = |&(name, cells): &(&str, u32)| Variable {
            name: name.into(),
            shape: if cells == 1 { Shape::Scalar } else { Shape::Vector(cells) },
            planes: planes.by_ref().take(cells as usize).collect(),
        };
        let variables = self.variables().iter().map(variable).collect();
        let mut metadata = Metadata::default();
        let [camera, screen] = self.view.camera.spaces(1.0);
        metadata.attributes.set_matrix("worldToCamera", &camera);
        metadata.attributes.set_matrix("worldToNDC", &screen);
        if rows != (0..height) {
            metadata.resolution = Some(self.view.size);
            metadata.origin[1] = rows.start as i32;
        }
        Ok(Image { width, height: rows.len(), variables, metadata })
    }

    /// The surface.
    fn hard(
        &self,
        pixels: &[usize],
        rays: &[(Ray, Span)],
        cells: &mut [[f32; CELLS]],
    ) -> Result<(), SolidError> {
        let slopes = self.view.prepare(&self.field, &self.cuboid)?;
        let march = March {
            field: &self.field,
            slopes: &slopes,
            pixel: self.view.pixel,
            finest: FINEST * self.cuboid.longest(),
            spacing: self.view.spacing,
        };
        let found = march.surface(rays)?;
        self.counters.contradictions.fetch_add(found.doubts, Ordering::Relaxed);
        self.counters.max_steps.fetch_max(found.rounds, Ordering::Relaxed);
        self.counters.visible_pixels.fetch_add(found.places.len() as u64, Ordering::Relaxed);
        for place in found.places {
            let (ray, cells) = (&rays[place.index].0, &mut cells[pixels[place.index]]);
            // A density without a slope has no normal: the surface faces the eye.
            let faces = place.normal == DVec3::ZERO || !place.normal.is_finite();
            let normal = if faces { -ray.direction } else { place.normal };
            self.place(cells, place.point);
            set(cells, 8, normal);
        }
        Ok(())
    }

    /// The volume.
    fn soft(
        &self,
        pixels: &[usize],
        rays: &[(Ray, Span)],
        cells: &mut [[f32; CELLS]],
    ) -> Result<(), SolidError> {
        let gathered = gather(&self.field, rays, self.view.step, self.view.spacing)?;
        for ((pixel, (ray, _)), gathered) in pixels.iter().zip(rays).zip(gathered) {
            if gathered.alpha > 0.0 {
                self.counters.visible_pixels.fetch_add(1, Ordering::Relaxed);
                let cells = &mut cells[*pixel];
                self.place(cells, ray.at(gathered.distance));
                cells[8] = gathered.alpha as f32;
                set(cells, 9, gathered.color);
            }
        }
        Ok(())
    }

    /// Notes where something is.
    fn place(&self, cells: &mut [f32; CELLS], point: DVec3) {
        cells[0] = 1.0;
        set(cells, 1, point);
        cells[4] = (point - self.view.camera.eye).dot(self.view.camera.forward) as f32;
    }
}

/// Puts a vector into three cells.
fn set(cells: &mut [f32; CELLS], first: usize, vector: DVec3) {
    cells[first..first + 3].copy_from_slice(&vector.as_vec3().to_array());
}
