//! Space functions made solid: the surface where the `density` of a program passes a level, what of it can be seen, and
//! a mesh of it; or what is soft, seen through.
//!
//! A program tells of a solid by functions of a point, of which all but the first may be missing:
//!
//! - `density(p)`: over the level inside, below or at it outside.
//! - `gradient(p)`: the density's gradient, where it is known exactly. Normals are made of it.
//! - `emission(p)`: the colour of what is soft.
//!
//! What is computed how, and within which bounds, is told in docs/solids.md.

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

/// How a solid is looked at.
#[derive(Clone, Debug)]
pub struct SolidOptions {
    /// The picture's size and the camera. The default camera has the whole box in the picture; a solid has no `scale`.
    pub view: scene::Options,
    /// The box that the solid lies in; what would go on beyond is cut off.
    pub bounds: [[f64; 3]; 2],
    /// The density is more than this inside.
    pub level: f64,
    /// A bound of the density's slope, if it is known; otherwise it is estimated.
    pub lipschitz: Option<f64>,
    /// Does the density, over the level, dim the light along the ray, instead of making a surface?
    pub soft: bool,
    /// The longest step through what is soft; a 256th of the box if not given.
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

/// What is known of the work so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Told {
    /// How often the density was asked.
    pub asked: u64,
    /// The least and the greatest bound of the density's slope; of all blocks, if it was estimated.
    pub slopes: Option<[f64; 2]>,
    /// Steps in which the density changed by more than the bound; they were taken back.
    pub contradictions: u64,
    /// Most steps of a ray.
    pub steps: u64,
    /// Pixels with something of the solid.
    pub seen: u64,
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
    told: Counters,
}

/// [`Told`] as it grows.
#[derive(Default)]
struct Counters {
    contradictions: AtomicU64,
    steps: AtomicU64,
    seen: AtomicU64,
}

impl<'o> Isosurface<'o> {
    /// The solid of the program of that text. `run` says what the program is run with: the frame, what is set, limits.
    /// `pixelsize` is the width of a pixel in the middle of the box, if it does not say.
    ///
    /// # Errors
    /// What is wrong with the program or the options. What goes wrong at points is found when they are asked.
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
        Ok(Isosurface { field, cuboid, view, told: Counters::default() })
    }

    /// The program, as it is asked for its density.
    pub fn program(&self) -> &Program {
        self.field.program()
    }

    /// Are normals made of the program's own `gradient`?
    pub fn has_gradient(&self) -> bool {
        self.field.has_gradient()
    }

    /// A mesh of the surface: `resolution` cells along the longest side of the box. It is closed, also where the box
    /// cuts the solid; each edge has two faces, and these run counterclockwise seen from outside.
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

    /// What is known of the work so far.
    pub fn told(&self) -> Told {
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Told {
            asked: self.field.asked(),
            slopes: self.view.slopes().map(|slopes| slopes.range()),
            contradictions: of(&self.told.contradictions),
            steps: of(&self.told.steps),
            seen: of(&self.told.seen),
        }
    }
}
