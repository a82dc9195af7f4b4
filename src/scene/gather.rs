//! From a scene to an image: a ray for each pixel, rows shared out to threads.

use super::Options;
use super::camera::{self, Camera};
use super::error::SceneError;
use super::model::Model;
use super::ray::{Hit, Ray};
use super::scenes::{self, SceneInfo, World};
use super::sphere::Sphere;
use crate::image::{Image, Metadata, Variable};
use crate::parallel::*;
use crate::shape::Shape;
use glam::DVec3;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

/// The most pixels of a picture: 32768 by 32768. As a whole in memory that would be some 80 gigabytes of planes.
pub(crate) const MAX_PIXELS: usize = 1 << 30;

/// `depth` where nothing was hit, as Blender writes it.
pub(crate) const NOTHING: f64 = 1e10;

/// The variables, in their order, with the number of planes of each.
const VARIABLES: [(&str, u32); 8] = [
    ("surface", 1),
    ("point", 3),
    ("normal", 3),
    ("depth", 1),
    ("uv", 2),
    ("I", 3),
    ("dPdu", 3),
    ("dPdv", 3),
];

/// The variables of the far side, which follow in scenes that have it.
const EXITS: [(&str, u32); 3] = [("exit_point", 3), ("exit_normal", 3), ("exit_uv", 2)];

/// Planes of the one and of the other.
const CELLS: usize = 19;
const EXIT_CELLS: usize = 8;

/// Renders the scene with this name; see the module's conventions for the variables.
pub fn render(name: &str, options: &Options) -> Result<Image<'static>, SceneError> {
    Renderer::new(name, options)?.rows(0..options.height)
}

/// A view of a scene, rendered a few rows at a time.
pub struct Renderer {
    view: View,
    size: [usize; 2],
    exits: bool,
}

impl Renderer {
    /// Creates a view of the scene with this name, without rendering it.
    pub fn new(name: &str, options: &Options) -> Result<Renderer, SceneError> {
        let scene = scenes::find(name)?;
        let size = size(options)?;
        Ok(Renderer { view: View::new(scene, options)?, size, exits: scene.exits })
    }

    /// Creates a view of a mesh with z up, without rendering it.
    ///
    /// # Errors
    /// If the options are no view.
    pub fn of_model(model: &Arc<Model>, options: &Options) -> Result<Renderer, SceneError> {
        let size = size(options)?;
        Ok(Renderer { view: View::of_model(model, options)?, size, exits: false })
    }

    /// The names of a mesh's surfaces, from number 1; empty for a scene.
    pub fn surfaces(&self) -> &[String] {
        match &self.view.seen {
            Seen::Model(model) => model.surfaces(),
            Seen::Surfaces(_) => &[],
        }
    }

    /// Columns and rows of the whole picture.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The names of the variables.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.variables().map(|(name, _)| *name)
    }

    fn variables(&self) -> impl Iterator<Item = &'static (&'static str, u32)> {
        VARIABLES.iter().chain(EXITS.iter().filter(|_| self.exits))
    }

    /// Renders some rows, as an image with their origin.
    ///
    /// # Errors
    /// If memory does not suffice.
    pub fn rows(&self, rows: Range<usize>) -> Result<Image<'static>, SceneError> {
        self.rows_at(rows, |_| [0.0; 2])
    }

    /// Renders some rows with an offset from the centre of each pixel, `[column row]`: columns to the right, rows
    /// down.
    ///
    /// # Errors
    /// If memory does not suffice.
    pub fn rows_at(
        &self,
        rows: Range<usize>,
        offset: impl Fn([i32; 2]) -> [f32; 2] + Sync,
    ) -> Result<Image<'static>, SceneError> {
        let [width, height] = self.size;
        let total = width * rows.len();
        // One plane after another is filled with zeros, so that a lack of memory is an error and no abort.
        let count = self.variables().map(|v| v.1 as usize).sum();
        let mut planes: Vec<Vec<f32>> = Vec::with_capacity(count);
        for _ in 0..count {
            let mut plane = Vec::new();
            let size = || SceneError::OutOfMemory { width, height: rows.len() };
            plane.try_reserve_exact(total).map_err(|_| size())?;
            plane.resize(total, 0.0);
            planes.push(plane);
        }

        // Cut all planes into the same stretches of pixels, and give each to some thread.
        let stretch = 4096.min(total).max(1);
        let mut stretches: Vec<Vec<&mut [f32]>> = Vec::new();
        for plane in &mut planes {
            for (i, part) in plane.chunks_mut(stretch).enumerate() {
                match stretches.get_mut(i) {
                    Some(parts) => parts.push(part),
                    None => stretches.push(vec![part]),
                }
            }
        }
        stretches.par_iter_mut().enumerate().for_each(|(i, parts)| {
            for j in 0..parts[0].len() {
                let pixel = i * stretch + j;
                let (column, row) = (pixel % width, rows.start + pixel / width);
                let [x, y] = offset([column as i32, row as i32]).map(|x| f64::from(x) + 0.5);
                let cells = self.view.place(column as f64 + x, row as f64 + y);
                for (part, cell) in parts.iter_mut().zip(cells) {
                    part[j] = cell as f32;
                }
            }
        });

        let mut planes = planes.into_iter();
        let variables = self
            .variables()
            .map(|&(name, cells)| Variable {
                name: name.into(),
                shape: if cells == 1 { Shape::Scalar } else { Shape::Vector(cells) },
                planes: planes.by_ref().take(cells as usize).map(Cow::Owned).collect(),
            })
            .collect();
        let mut metadata = Metadata::default();
        let camera = self.view.camera.moved(self.view.origin);
        let [camera, screen] = camera.spaces(self.view.scale);
        metadata.attributes.set_matrix("worldToCamera", &camera);
        metadata.attributes.set_matrix("worldToNDC", &screen);
        if rows != (0..height) {
            metadata.resolution = Some(self.size);
            metadata.origin[1] = rows.start as i32;
        }
        Ok(Image { width, height: rows.len(), variables, metadata })
    }
}

/// Columns and rows, if there may be as many.
fn size(options: &Options) -> Result<[usize; 2], SceneError> {
    let (width, height) = (options.width, options.height);
    match width.checked_mul(height).is_some_and(|n| n > 0 && n <= MAX_PIXELS) {
        true => Ok([width, height]),
        false => Err(SceneError::BadSize { width, height }),
    }
}

/// What there is to be seen.
enum Seen {
    Surfaces(World),
    Model(Arc<Model>),
}

/// A scene with a camera before it.
pub(super) struct View {
    pub camera: Camera,
    /// Where the origin of the camera and of hits is in the world: not 0 for a mesh far away.
    origin: DVec3,
    seen: Seen,
    scale: f64,
    /// The sphere whose far side is wanted.
    exit: Option<Sphere>,
}

impl View {
    pub fn new(scene: &SceneInfo, options: &Options) -> Result<View, SceneError> {
        let scale = scale(options)?;
        let distance = DVec3::from(scene.eye).distance(scene.look_at.into());
        let [eye, look_at] = places(options, scene.eye.into(), scene.look_at.into());
        let frame = scene.frame.map(|side| side / distance);
        let size = [options.width, options.height];
        let camera =
            Camera::new(eye, look_at, options.fov, frame, size).map_err(|error| error.scaled(scale))?;
        let world = scene.build(&camera)?;
        if let Some(i) = world.iter().position(|surface| surface.holds(camera.eye)) {
            let instead = scene.eye.map(|c| c * scale);
            return Err(SceneError::EyeInside { what: scene.surfaces[i], instead });
        }
        let exit = scene.exits.then_some(Sphere { center: DVec3::ZERO, radius: 1.0 });
        Ok(View { camera, origin: DVec3::ZERO, seen: Seen::Surfaces(world), scale, exit })
    }

    /// Creates a view of a mesh. By default it is seen from the front, a little from the right and above, and fills
    /// the picture.
    pub fn of_model(model: &Arc<Model>, options: &Options) -> Result<View, SceneError> {
        let scale = scale(options)?;
        let (origin, center, radius) = (model.origin(), model.center(), model.radius());
        // Points that are given are those of the world.
        let [eye, look_at] =
            [(options.eye, center + radius * DVec3::new(1.2, -3.6, 1.0)), (options.look_at, center)]
                .map(|(given, default)| given.map_or(default, |p| DVec3::from(p) / scale - origin));
        let limit = camera::LIMIT.max(center.abs().max_element() + 1e3 * radius);
        let frame = model.frame(eye, look_at);
        let camera = Camera::within(limit, eye, look_at, options.fov, frame, [options.width, options.height])
            .map_err(|error| error.moved(origin).scaled(scale))?;
        Ok(View { camera, origin, seen: Seen::Model(Arc::clone(model)), scale, exit: None })
    }

    /// The values at a place of the picture, in the order of the variables.
    fn place(&self, column: f64, row: f64) -> [f64; CELLS + EXIT_CELLS] {
        let ray = self.camera.ray(column, row);
        let incident = ray.direction.to_array();
        let mut cells = [0.0; CELLS + EXIT_CELLS];
        cells[7] = NOTHING;
        cells[10..13].copy_from_slice(&incident);
        let Some((surface, hit)) = self.nearest(&ray) else { return cells };

        let s = self.scale;
        cells[0] = (surface + 1) as f64;
        // Only here the place in the world becomes an `f32`.
        cells[1..4].copy_from_slice(&((hit.point + self.origin) * s).to_array());
        cells[4..7].copy_from_slice(&hit.normal.to_array());
        cells[7] = hit.distance * ray.direction.dot(self.camera.forward) * s;
        cells[8..10].copy_from_slice(&hit.uv.to_array());
        cells[13..16].copy_from_slice(&(hit.dpdu * s).to_array());
        cells[16..19].copy_from_slice(&(hit.dpdv * s).to_array());
        if let Some((sphere, [_, far])) = self.exit.and_then(|e| Some((e, e.span(&ray)?))) {
            let exit = sphere.place(&ray, far);
            cells[19..22].copy_from_slice(&(exit.point * s).to_array());
            cells[22..25].copy_from_slice(&exit.normal.to_array());
            cells[25..27].copy_from_slice(&exit.uv.to_array());
        }
        cells
    }

    /// The surface met first, counted from 0, and where.
    pub fn nearest(&self, ray: &Ray) -> Option<(usize, Hit)> {
        let world = match &self.seen {
            Seen::Surfaces(world) => world,
            Seen::Model(model) => return model.hit(ray),
        };
        let mut nearest: Option<(usize, Hit)> = None;
        for (i, surface) in world.iter().enumerate() {
            if let Some(hit) = surface.hit(ray)
                && nearest.is_none_or(|(_, n)| hit.distance < n.distance)
            {
                nearest = Some((i, hit));
            }
        }
        nearest
    }
}

/// The scale of a view.
fn scale(options: &Options) -> Result<f64, SceneError> {
    // Not `<`: a NaN must fail too. The limits keep every depth well below that of the background.
    match (1e-3..=1e3).contains(&options.scale) {
        true => Ok(options.scale),
        false => Err(SceneError::BadScale(options.scale)),
    }
}

/// The eye and the point that it looks at, in unscaled world units, from those by default.
fn places(options: &Options, eye: DVec3, look_at: DVec3) -> [DVec3; 2] {
    [(options.eye, eye), (options.look_at, look_at)]
        .map(|(given, default)| given.map_or(default, |p| DVec3::from(p) / options.scale))
}
