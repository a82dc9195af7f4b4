//! Vertices that carry all that a corner knows, as PLY and glTF want them.

use super::{Corner, Mesh};
use std::collections::HashMap;

/// The distinct corners of a mesh.
pub(super) struct Split {
    /// In the order of their points; a point that no face uses is there too, so a mesh that is split nowhere keeps its order.
    pub vertices: Vec<Corner>,
    /// For each corner of the mesh its vertex.
    pub of_corner: Vec<u32>,
}

/// Finds the distinct corners of a mesh.
pub(super) fn split(mesh: &Mesh) -> Split {
    let mut numbers: HashMap<Corner, u32> = HashMap::with_capacity(mesh.points.len());
    let mut vertices: Vec<Corner> = Vec::with_capacity(mesh.points.len());
    let mut used = vec![false; mesh.points.len()];
    let mut of_corner = Vec::with_capacity(mesh.corners.len());
    for corner in &mesh.corners {
        used[corner.point as usize] = true;
        of_corner.push(*numbers.entry(*corner).or_insert_with(|| {
            vertices.push(*corner);
            vertices.len() as u32 - 1
        }));
    }
    let unused = (0..).zip(used).filter(|(_, used)| !used);
    vertices.extend(unused.map(|(point, _)| Corner { point, normal: None, uv: None }));
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    order.sort_by_key(|&v| (vertices[v as usize].point, v));
    let mut places = vec![0; order.len()];
    for (place, &vertex) in (0..).zip(&order) {
        places[vertex as usize] = place;
    }
    Split {
        vertices: order.iter().map(|&v| vertices[v as usize]).collect(),
        of_corner: of_corner.iter().map(|&v| places[v as usize]).collect(),
    }
}
