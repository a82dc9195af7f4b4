//! Solids from density functions: the surface where the `density` of a program crosses a level, its rendering, a mesh of
//! it, and volumes.
//!
//! A program defines a solid by functions of a point. All but the first are optional:
//!
//! - `density(p)`: above the level inside, at most the level outside.
//! - `gradient(p)`: the exact gradient of the density, for normals.
//! - `emission(p)`: the colour of the light that a volume emits.
//!
//! docs/solids.md describes the methods and their bounds.

mod cuboid;
mod error;
mod field;
mod march;
mod mesh;
mod slopes;
mod soft;
mod view;

pub use error::SolidError;

use crate::program::{Compiler, Program, Progress, RunOptions};
use crate::scene;
use cuboid::Cuboid;
use field::Field;
use std::sync::atomic::{AtomicU64, Ordering};
use view::View;

/// Options for rendering a solid.
#[derive(Clone, Debug)]
pub struct SolidOptions {
    /// The picture's size and the camera. The default camera shows the whole box; `scale` is not used.
    pub view: scene::Options,
    /// The box around the solid; parts outside are cut off.
    pub bounds: [[f64; 3]; 2],
    /// The density at the surface; inside it is higher.
    pub level: f64,
    /// An upper bound of the density's slope; estimated if `None`.
    pub lipschitz: Option<f64>,
    /// Render a volume, which absorbs light where the density exceeds the level, instead of a surface.
    pub soft: bool,
    /// The longest step through a volume; by default 1/256 of the box.
    pub step: Option<f64>,
}

impl Default for SolidOptions {
    /// A box of 3 about the origin, level 0, a surface.
    fn default() -> SolidOptions {
        SolidOptions {
            view: scene::Options::default(),
            bounds: [[-1.5; 3], [1.5; 3]],
            level: 0.0,
            lipschitz: None,
            soft: false,
            step: None,
        }
    }
}

/// Statistics of the work so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolidStats {
    /// The number of evaluations of the density.
    pub evaluations: u64,
    /// The smallest and the largest bound of the density's slope; of all blocks, if it was estimated.
    pub slope_bounds: Option<[f64; 2]>,
    /// Steps in which the density changed by more than the bound, and which were undone.
    pub contradictions: u64,
    /// The maximum number of steps of a ray.
    pub max_steps: u64,
    /// Pixels that show the solid.
    pub visible_pixels: u64,
}

/// The solid of a program.
///
/// ```
/// use pse::solid::{Isosurface, SolidOptions};
/// use pse::{Compiler, RunOptions};
///
/// let text = "function density(p)\n    return 1 - length(p)";
/// let mut options = SolidOptions::default();
/// (options.view.width, options.view.height) = (64, 48);
/// let ball = Isosurface::new(&Compiler::new(), "ball", text, &options, &RunOptions::default())?;
/// let image = ball.rows(0..48)?;
/// let [x, y, z] = [0, 1, 2].map(|i| image.variable("point").unwrap().planes[i][24 * 64 + 32]);
/// assert!((x * x + y * y + z * z - 1.0).abs() < 1e-5);
///
/// let mesh = ball.mesh(32, &|_| ())?;
/// assert_eq!(mesh.points.len() + mesh.faces.len() - 3 * mesh.faces.len() / 2, 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Isosurface<'o> {
    field: Field<'o>,
    cuboid: Cuboid,
    view: View,
    counters: Counters,
}

/// The counters behind [`SolidStats`].
#[derive(Default)]
struct Counters {
    contradictions: AtomicU64,
    max_steps: AtomicU64,
    visible_pixels: AtomicU64,
}

impl<'o> Isosurface<'o> {
    /// Creates the solid of a program. `run` has the frame, the params and the limits. By default `pixelsize` is the width
    /// of a pixel in the middle of the box.
    ///
    /// # Errors
    /// If the program or the options have errors. Errors at points occur when the points are evaluated.
    pub fn new(
        compiler: &Compiler<'_>,
        name: &str,
        text: &str,
        options: &SolidOptions,
        run: &RunOptions<'o>,
    ) -> Result<Isosurface<'o>, SolidError> {
        let cuboid = Cuboid::new(options.bounds)?;
        let view = View::new(&cuboid, options)?;
        let field = Field::new(compiler, name, text, options.level, run)?;
        Ok(Isosurface { field, cuboid, view, counters: Counters::default() })
    }

    /// The compiled program for the density.
    pub fn program(&self) -> &Program {
        self.field.program()
    }

    /// Whether normals come from the program's own `gradient`.
    pub fn has_gradient(&self) -> bool {
        self.field.has_gradient()
    }

    /// Makes a mesh of the surface, with `resolution` cells along the longest side of the box. It is closed, also
    /// where the box cuts the solid. Each edge has two faces, which are counterclockwise seen from outside.
    ///
    /// # Errors
    /// If the program fails, or the mesh is too large.
    pub fn mesh(
        &self,
        resolution: usize,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<crate::mesh::Mesh, SolidError> {
        mesh::mesh(&self.field, &self.cuboid, resolution, progress)
    }

    /// Statistics of the work so far.
    pub fn stats(&self) -> SolidStats {
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        SolidStats {
            evaluations: self.field.asked(),
            slope_bounds: self.view.slopes().map(|slopes| slopes.range()),
            contradictions: of(&self.counters.contradictions),
            max_steps: of(&self.counters.max_steps),
            visible_pixels: of(&self.counters.visible_pixels),
        }
    }
}
