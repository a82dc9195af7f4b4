//! A mesh of the surface by marching cubes, a few layers of the grid at a time.
//!
//! The triangles of a cell come from the tables of Eric Lengyel's Transvoxel Algorithm (<http://transvoxel.org/>): they
//! divide a face between two cells the same way on both sides, so nothing gapes. Each edge of the grid has one point for
//! all cells about it, which then is moved to where the surface crosses the edge.

use super::cuboid::Cuboid;
use super::error::SolidError;
use super::field::{Bracket, Field, MANY, parts};
use crate::mesh::{Corner, Face, Mesh, decimal};
use crate::program::Progress;
use glam::{DVec3, UVec3};
use transvoxel_data::regular_cell_data::{REGULAR_CELL_CLASS, REGULAR_CELL_DATA, REGULAR_VERTEX_DATA};

/// Cells along the longest side: no fewer, no more.
const CELLS: std::ops::RangeInclusive<usize> = 2..=4096;

/// Points keep so large a part of an edge from its ends, so that no two are the same.
const APART: f64 = 1e-3;

/// The step to both sides for a normal, as a share of a cell.
const GRADIENT_STEP: f64 = 0.125;

/// An edge of the grid without a point.
const NONE: u32 = u32::MAX;

pub(super) fn mesh(
    field: &Field<'_>,
    cuboid: &Cuboid,
    resolution: usize,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Mesh, SolidError> {
    if !CELLS.contains(&resolution) {
        let message = format!("a mesh cannot have {resolution} cells along its longest side");
        return Err(SolidError::new(message, format!("Give {} to {}.", CELLS.start(), CELLS.end())));
    }
    let size = cuboid.size();
    let cells = (size / size.max_element() * resolution as f64).ceil().max(DVec3::splat(2.0));
    let mut maker = Maker::new(field, cuboid, cells.as_uvec3());
    let layers = maker.corners.z as usize;
    let many = (MANY / maker.layer()).max(1);
    let mut below: Option<Vec<f32>> = None;
    for part in parts(0..layers, many) {
        let (first, end) = (part.start, part.end);
        for (values, z) in maker.ask(part)?.chunks(maker.layer()).zip(first as u32..) {
            if let Some(below) = below.replace(values.to_vec()) {
                maker.cells(&below, values, z - 1)?;
            }
        }
        progress(Progress { done: end, total: layers });
    }
    maker.settle()?;
    Ok(maker.mesh)
}

/// A point that is still to be moved to its place.
struct Pending {
    bracket: Bracket,
    /// It stays at the outer end, where the box cuts the solid; its normal.
    cap: Option<DVec3>,
}

struct Maker<'a, 'o> {
    field: &'a Field<'o>,
    low: DVec3,
    cell: DVec3,
    /// Corners of the grid along each axis.
    corners: UVec3,
    /// The points on the edges along x, y and z, by the edge's lower corner in its layer; those along x and y of the
    /// lower and of the upper layer.
    edges: [[Vec<u32>; 2]; 3],
    pending: Vec<Pending>,
    mesh: Mesh,
}

impl<'a, 'o> Maker<'a, 'o> {
    fn new(field: &'a Field<'o>, cuboid: &Cuboid, cells: UVec3) -> Maker<'a, 'o> {
        let corners = cells + UVec3::ONE;
        let none = || vec![NONE; (corners.x * corners.y) as usize];
        let edges = std::array::from_fn(|_| [none(), none()]);
        let mesh = Mesh { surfaces: vec!["solid".into()], ..Mesh::default() };
        let cell = cuboid.size() / cells.as_dvec3();
        Maker { field, low: cuboid.low, cell, corners, edges, pending: Vec::new(), mesh }
    }

    /// Corners of a layer.
    fn layer(&self) -> usize {
        (self.corners.x * self.corners.y) as usize
    }

    /// A cell's width, for the program.
    fn spacing(&self) -> f64 {
        self.cell.max_element()
    }

    fn place(&self, corner: UVec3) -> DVec3 {
        self.low + corner.as_dvec3() * self.cell
    }

    /// How far the density is over the level at the corners of some layers.
    fn ask(&self, layers: std::ops::Range<usize>) -> Result<Vec<f32>, SolidError> {
        let point = |i: usize| {
            let (x, y, z) = (i % self.corners.x as usize, i / self.corners.x as usize, i / self.layer());
            self.place(UVec3::new(x as u32, y as u32 % self.corners.y, z as u32))
        };
        let points: Vec<DVec3> =
            (layers.start * self.layer()..layers.end * self.layer()).map(point).collect();
        Ok(self.field.density(&points, self.spacing())?.into_iter().map(|v| v as f32).collect())
    }

    /// Is the corner on the box, which counts as outside?
    fn on_box(&self, corner: UVec3) -> bool {
        (0..3).any(|axis| corner[axis] == 0 || corner[axis] + 1 == self.corners[axis])
    }

    /// Makes the triangles of the cells between two layers of corners.
    fn cells(&mut self, below: &[f32], above: &[f32], z: u32) -> Result<(), SolidError> {
        for [lower, upper] in &mut self.edges {
            std::mem::swap(lower, upper);
            upper.fill(NONE);
        }
        // Those along z have but one layer.
        self.edges[2][0].fill(NONE);
        let row = self.corners.x as usize;
        for y in 0..self.corners.y - 1 {
            for x in 0..self.corners.x - 1 {
                let at = y as usize * row + x as usize;
                let value = |i: usize| {
                    let layer = if i & 4 == 0 { below } else { above };
                    layer[at + (i & 1) + (i >> 1 & 1) * row]
                };
                let corner = |i: usize| UVec3::new(x, y, z) + offset(i);
                let inside = |i: usize| value(i) > 0.0 && !self.on_box(corner(i));
                let case = (0..8).fold(0, |case, i| case | usize::from(inside(i)) << i);
                if case == 0 || case == 255 {
                    continue;
                }
                let data = &REGULAR_CELL_DATA[REGULAR_CELL_CLASS[case] as usize];
                let mut points = [0; 12];
                for (point, code) in
                    points.iter_mut().zip(REGULAR_VERTEX_DATA[case]).take(data.get_vertex_count() as usize)
                {
                    let (a, b) = (usize::from(code >> 4 & 15), usize::from(code & 15));
                    let (a, b) = (a.min(b), a.max(b));
                    let axis = (a ^ b).trailing_zeros() as usize;
                    let layer = if axis == 2 { 0 } else { a >> 2 };
                    let slot = at + (a & 1) + (a >> 1 & 1) * row;
                    let known = self.edges[axis][layer][slot];
                    *point = match known {
                        NONE => {
                            let ends = [a, b].map(|i| (corner(i), f64::from(value(i)), case >> i & 1 == 1));
                            let made = self.point(ends)?;
                            self.edges[axis][layer][slot] = made;
                            made
                        }
                        known => known,
                    };
                }
                let triangles = data.vertex_index.chunks(3).take(data.get_triangle_count() as usize);
                for triangle in triangles {
                    let first = self.mesh.corners.len() as u32;
                    self.mesh.corners.extend(triangle.iter().map(|&i| {
                        let point = points[usize::from(i)];
                        Corner { point, normal: Some(point), uv: None }
                    }));
                    self.mesh.faces.push(Face { first, corners: 3, surface: 0 });
                }
            }
        }
        if self.pending.len() >= MANY {
            self.settle()?;
        }
        Ok(())
    }

    /// Notes a point on the edge between a corner inside and one outside.
    fn point(&mut self, ends: [(UVec3, f64, bool); 2]) -> Result<u32, SolidError> {
        let [within, out] = if ends[0].2 { ends } else { [ends[1], ends[0]] };
        let (inner, outer) = (self.place(within.0), self.place(out.0));
        let cap = (out.1 > 0.0).then(|| (outer - inner).normalize());
        let number = self.mesh.points.len() + self.pending.len();
        // Corners have a number too: there are at most some eight for each point.
        if number >= (u32::MAX / 16) as usize {
            return Err(SolidError::new("the mesh is too large", "Give a smaller resolution."));
        }
        let bracket = Bracket { out: (outer, out.1), within: (inner, within.1) };
        self.pending.push(Pending { bracket, cap });
        Ok(number as u32)
    }

    /// Moves the points to where the surface is, and asks their normals.
    fn settle(&mut self) -> Result<(), SolidError> {
        let pending = std::mem::take(&mut self.pending);
        let free = || pending.iter().filter(|p| p.cap.is_none()).map(|p| p.bracket);
        let mut brackets: Vec<Bracket> = free().collect();
        self.field.refine(&mut brackets, self.spacing())?;
        let points: Vec<DVec3> = free()
            .zip(&brackets)
            .map(|(edge, found)| {
                let (from, to) = (edge.out.0, edge.within.0);
                let share = (found.within.0 - from).length() / (to - from).length();
                from.lerp(to, share.clamp(APART, 1.0 - APART))
            })
            .collect();
        let step = GRADIENT_STEP * self.cell.min_element();
        let mut found = points.iter().zip(self.field.gradient(&points, |_| step, self.spacing())?);
        for pending in &pending {
            let (point, normal) = match pending.cap {
                Some(normal) => (pending.bracket.out.0, normal),
                None => {
                    let across = (pending.bracket.out.0 - pending.bracket.within.0).normalize();
                    let (point, gradient) = found.next().map_or((DVec3::ZERO, DVec3::ZERO), |(p, g)| (*p, g));
                    // Where the density has no slope, the way out is across.
                    (point, (-gradient).try_normalize().unwrap_or(across))
                }
            };
            self.mesh.points.push(point.as_vec3().to_array().map(decimal));
            self.mesh.normals.push(normal.as_vec3().to_array().map(decimal));
        }
        Ok(())
    }
}

/// A cell's corner, from its lowest one.
fn offset(i: usize) -> UVec3 {
    UVec3::new(i as u32 & 1, i as u32 >> 1 & 1, i as u32 >> 2 & 1)
}
