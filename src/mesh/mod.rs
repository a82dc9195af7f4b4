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
//! - Numbers are `f32`, as in the files; whoever computes with them does it in `f64`.

mod cut;
mod deform;
mod format;
mod gltf_data;
mod head;
mod normals;
mod ply_header;
mod read;
mod read_gltf;
mod read_obj;
mod read_ply;
mod split;
mod write_glb;
mod write_obj;
mod write_ply;

pub(crate) use cut::Cutter;
pub use deform::Deform;
pub use format::Format;
pub use gltf_data::companions;
pub use head::head;
pub use read::{File, read};

/// A polygon mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Where the vertices are, in the units of the file.
    pub points: Vec<[f32; 3]>,
    /// Unit normals that corners refer to; may be none.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates that corners refer to; may be none.
    pub uvs: Vec<[f32; 2]>,
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
    /// Its place in [`Mesh::points`].
    pub point: u32,
    /// Its place in [`Mesh::normals`].
    pub normal: Option<u32>,
    /// Its place in [`Mesh::uvs`].
    pub uv: Option<u32>,
}

/// A face: a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    /// The first of its corners in [`Mesh::corners`].
    pub first: u32,
    /// How many corners it has: three at least.
    pub corners: u32,
    /// The index in [`Mesh::surfaces`] of the surface that it belongs to.
    pub surface: u32,
}

impl Mesh {
    /// The corners of a face, counterclockwise.
    pub fn corners_of(&self, face: &Face) -> &[Corner] {
        &self.corners[face.first as usize..][..face.corners as usize]
    }

    /// The least and the greatest coordinates of the points; `None` without any.
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        let first = *self.points.first()?;
        Some(self.points.iter().fold([first, first], |[low, high], p| {
            [std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i]))]
        }))
    }

    /// Turns it so that what pointed along y points along z: from the space of glTF and OBJ to that of scenes.
    pub fn y_up_to_z_up(&mut self) {
        for [_, y, z] in self.points.iter_mut().chain(&mut self.normals) {
            (*y, *z) = (-*z, *y);
        }
    }

    /// Turns it so that what pointed along z points along y: the way back.
    pub fn z_up_to_y_up(&mut self) {
        for [_, y, z] in self.points.iter_mut().chain(&mut self.normals) {
            (*y, *z) = (*z, -*y);
        }
    }
}
