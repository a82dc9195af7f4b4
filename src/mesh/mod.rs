//! Polygon meshes: points, faces of any number of corners, and what else is known at the corners.
//!
//! A mesh here is what a file of one of the usual formats holds, with nothing lost that a program can ask for or that has to be
//! written again: the order of points and faces, faces of any number of corners, normals and uv with indices of their own.
//! A mesh knows nothing of the language, nor of how it is looked at.
//!
//! # Conventions
//!
//! - Right-handed space. Faces run counterclockwise seen from outside.
//! - `uv` has its origin at the bottom left of an image, v up, as in OBJ. (Readers of formats with v down turn it.)
//! - Numbers are `f64`: text files and PLY can hold more digits than an `f32` has, and a mesh far from the origin needs them.

mod cut;
mod cut_large;
mod deform;
mod format;
mod gltf_data;
mod gltf_json;
mod head;
mod normals;
mod ply_header;
mod read;
mod read_gltf;
mod read_obj;
mod read_ply;
mod single;
mod split;
mod text;
mod write_glb;
mod write_obj;
mod write_ply;

#[cfg(feature = "scene")]
pub(crate) use cut::{Crossing, Cutter, MAX_EARS};
pub use deform::Deform;
pub use format::Format;
pub use gltf_data::companions;
pub use head::head;
pub use read::{File, read};
pub use single::{decimal, shortest};

/// A polygon mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The positions of the vertices, in the units of the file.
    pub points: Vec<[f64; 3]>,
    /// Unit normals that corners refer to; may be none.
    pub normals: Vec<[f64; 3]>,
    /// Texture coordinates that corners refer to; may be none.
    pub uvs: Vec<[f64; 2]>,
    /// The corners of all faces, one face after the other.
    pub corners: Vec<Corner>,
    /// The faces, in order.
    pub faces: Vec<Face>,
    /// The names of the surfaces, by object or material; the number of `surface` is the index plus 1.
    pub surfaces: Vec<String>,
}

/// A corner of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Corner {
    /// The index in [`Mesh::points`].
    pub point: u32,
    /// The index in [`Mesh::normals`].
    pub normal: Option<u32>,
    /// The index in [`Mesh::uvs`].
    pub uv: Option<u32>,
}

/// A face: a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    /// The first of its corners in [`Mesh::corners`].
    pub first: u32,
    /// The number of corners, at least three.
    pub corners: u32,
    /// The index of its surface in [`Mesh::surfaces`].
    pub surface: u32,
}

/// Steps along a mesh's longest side, below which rounding shows in a picture of some thousand pixels.
pub(crate) const FINE: f64 = 65536.0;

impl Mesh {
    /// The corners of a face, counterclockwise.
    pub fn corners_of(&self, face: &Face) -> &[Corner] {
        &self.corners[face.first as usize..][..face.corners as usize]
    }

    /// The smallest and the largest coordinates of the points; `None` without points.
    pub fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        let first = *self.points.first()?;
        Some(self.points.iter().fold([first, first], |[low, high], p| {
            [std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i]))]
        }))
    }

    /// Rotates the mesh from y up, as in glTF and OBJ, to z up, as in scenes.
    pub fn y_up_to_z_up(&mut self) {
        for [_, y, z] in self.points.iter_mut().chain(&mut self.normals) {
            (*y, *z) = (-*z, *y);
        }
    }

    /// Rotates the mesh from z up to y up.
    pub fn z_up_to_y_up(&mut self) {
        for [_, y, z] in self.points.iter_mut().chain(&mut self.normals) {
            (*y, *z) = (*z, -*y);
        }
    }

    /// The middle of its bounds; the origin if there are no points.
    pub fn middle(&self) -> [f64; 3] {
        let [low, high] = self.bounds().unwrap_or_default();
        std::array::from_fn(|i| low[i] + (high[i] - low[i]) / 2.0)
    }

    /// The middle of its bounds, rounded to the decimal place of a hundredth of its longest side.
    pub fn round_middle(&self) -> [f64; 3] {
        let side = self.longest_side();
        if side <= 0.0 {
            return self.middle();
        }
        let place = libm::log10(side).floor() as i32 - 2;
        let power = libm::pow(10.0, f64::from(place.abs()));
        self.middle()
            .map(|c| if place < 0 { (c * power).round() / power } else { (c / power).round() * power })
    }

    /// The longest side of its bounds.
    pub(crate) fn longest_side(&self) -> f64 {
        let [low, high] = self.bounds().unwrap_or_default();
        (0..3).fold(0.0, |most, i| most.max(high[i] - low[i]))
    }

    /// Moves all points by `offset`.
    pub fn translate(&mut self, offset: [f64; 3]) {
        for point in &mut self.points {
            *point = std::array::from_fn(|i| point[i] + offset[i]);
        }
    }

    /// The step of the 32-bit `point` at the mesh's farthest coordinate, if it is a noticeable part of the mesh's
    /// size. `None` for a mesh near the origin.
    pub fn coarse_step(&self) -> Option<f64> {
        let [low, high] = self.bounds()?;
        let farthest = low.iter().chain(&high).fold(0.0, |most: f64, c| most.max(c.abs()));
        let side = self.longest_side();
        let step = f64::from((farthest as f32).next_up()) - f64::from(farthest as f32);
        (side > 0.0 && step * FINE > side).then_some(step)
    }
}
