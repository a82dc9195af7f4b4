//! Visible surface finders: built-in scenes, each traced into a G-buffer for programs to paint.
//!
//! [`render`] sends one ray through the centre of each pixel and meets the scene's surfaces by formula, in `f64`,
//! so points and normals are exact to the last bit or so of the `f32` that is stored. [`scenes()`] lists what there is.
//!
//! A polygon mesh is seen by the same [`Renderer`]; see [`Model`].
//!
//! # Conventions
//!
//! - Space is right-handed with **z up**. The default cameras look towards +y, so x grows to the right of the picture.
//! - `surface` is 0 where nothing was hit, else a number from 1 (see [`SceneInfo::surfaces`]).
//! - `point`, `dPdu` and `dPdv` are in world units; `normal` and `I` are unit vectors of the same space.
//! - `normal` points out of a solid. A flat sheet has two sides; its normal is turned towards the eye.
//! - `depth` is the distance along the view axis, not along the ray, and 1e10 where nothing was hit, as in Blender.
//! - `I` is the direction from the eye through the pixel, at every pixel, so that a sky can be painted.
//! - `uv`: on round things u goes once around the z axis from 0 to 1, counterclockwise seen from above, with its
//!   seam at the back (+y); `cross(dPdu, dPdv)` points along the outward normal. At a pole `dPdu` is 0.
//! - A mesh has its own normals and uv. A face that is seen from behind has its normal turned towards the eye, as if it
//!   were a sheet. `dPdu` and `dPdv` are those of the triangle, 0 where it has no uv.
//! - Where nothing was hit, everything but `depth` and `I` is 0.

mod bernstein;
#[doc(hidden)]
pub mod camera;
mod cuboid;
mod error;
pub(crate) mod gather;
mod lathe;
mod model;
mod parse;
mod plane;
pub(crate) mod ray;
mod scenes;
mod sphere;
mod spline;
mod torus;
mod tree;
mod vase;

#[cfg(test)]
mod tests;

pub use error::SceneError;
pub use gather::{Renderer, render};
pub use model::Model;
pub use parse::{parse_point, parse_size};
pub use scenes::{SceneInfo, find, scenes};

/// Options for rendering a scene. `None` means the scene's default.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The position of the eye, in world units.
    pub eye: Option<[f64; 3]>,
    /// The point at the centre of the picture, in world units.
    pub look_at: Option<[f64; 3]>,
    /// The vertical field of view in degrees, between 0 and 180. By default the picture contains the scene's frame,
    /// whatever its proportions.
    pub fov: Option<f64>,
    /// Scales the whole scene in the space of `point`, including the default camera: the outlines stay, and
    /// `Noise(point)` shows finer detail. `eye` and `look_at` are in the scaled space.
    pub scale: f64,
}

impl Default for Options {
    /// 640 by 480, the scene's own camera, no scaling.
    fn default() -> Options {
        Options { width: 640, height: 480, eye: None, look_at: None, fov: None, scale: 1.0 }
    }
}
