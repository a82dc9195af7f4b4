//! Vertices as pixels: a mesh becomes an image of one row, and what a program makes of it moves the points.

use super::{FINE, Mesh, decimal};
use crate::diagnostic::Diagnostic;
use crate::image::{Image, Variable};
use crate::shape::Shape;
use glam::DVec3;
use std::borrow::Cow;
use std::collections::HashMap;

/// A mesh whose points a program moves.
///
/// ```
/// use pse::mesh::{Deform, head};
/// use pse::{Program, RunOptions};
///
/// let deform = Deform::new(head());
/// let program = Program::compile("point += 0.1 * vector_noise(2 * point)\nfunction vector_noise(p)\n    return [Noise(p) Noise(p + 7) Noise(p + 13)]")?;
/// let report = program.run(&deform.image(), &RunOptions::default())?;
/// let other = deform.moved(&report.image).map_err(|fault| fault.message)?;
/// assert_eq!(other.faces, head().faces);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Deform {
    mesh: Mesh,
    /// What lies at the origin of the program's space.
    origin: [f64; 3],
    /// The planes of the image: point, normal, and uv if there is any.
    planes: Vec<Vec<f32>>,
    /// For each corner the number of its new normal, of which there are so many.
    group: Vec<u32>,
    groups: usize,
}

impl Deform {
    /// Prepares a mesh. Corners at the same position with the same normal, or without one, will share a normal again:
    /// smooth edges stay smooth, and creases stay creases.
    pub fn new(mesh: Mesh) -> Deform {
        Deform::around(mesh, [0.0; 3])
    }

    /// Prepares a mesh, with points relative to `origin` for the program; the result is moved back. So a mesh far
    /// from the origin keeps detail that a 32-bit `point` would lose.
    pub fn around(mesh: Mesh, origin: [f64; 3]) -> Deform {
        let places = mesh.places();
        let mut numbers: HashMap<(u32, Option<[u64; 3]>), u32> = HashMap::new();
        let mut group = Vec::with_capacity(mesh.corners.len());
        for corner in &mesh.corners {
            let normal = corner.normal.map(|i| mesh.normals[i as usize].map(f64::to_bits));
            let next = numbers.len() as u32;
            group.push(*numbers.entry((places[corner.point as usize], normal)).or_insert(next));
        }
        let groups = numbers.len();

        let count = mesh.points.len();
        // Points at one place must move as one, or the surface would tear: they get one normal, and the first one's uv.
        let smooth = mesh.angle_normals(count, |c| places[mesh.corners[c].point as usize] as usize);
        let mut uvs: Vec<Option<u32>> = vec![None; count];
        for corner in &mesh.corners {
            let uv = &mut uvs[places[corner.point as usize] as usize];
            *uv = uv.or(corner.uv);
        }
        let mut planes: Vec<Vec<f32>> = Vec::new();
        for i in 0..3 {
            planes.push(mesh.points.iter().map(|p| (p[i] - origin[i]) as f32).collect());
        }
        let normals: Vec<[f32; 3]> =
            places.iter().map(|&p| smooth[p as usize].as_vec3().to_array()).collect();
        for i in 0..3 {
            planes.push(normals.iter().map(|n| n[i]).collect());
        }
        if uvs.iter().any(Option::is_some) {
            let uv = |place: u32| uvs[place as usize].map_or([0.0; 2], |uv| mesh.uvs[uv as usize]);
            for i in 0..2 {
                planes.push(places.iter().map(|&p| uv(p)[i] as f32).collect());
            }
        }
        Deform { mesh, origin, planes, group, groups }
    }

    /// The mean length of the edges, which is the `pixelsize` of a deformation.
    pub fn spacing(&self) -> f32 {
        let place = |corner: &super::Corner| DVec3::from(self.mesh.points[corner.point as usize]);
        let (mut sum, mut count) = (0.0, 0usize);
        for face in &self.mesh.faces {
            let corners = self.mesh.corners_of(face);
            for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                sum += place(a).distance(place(b));
                count += 1;
            }
        }
        (sum / count.max(1) as f64) as f32
    }

    /// The original mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The points as an image of one row, with the variables `point`, `normal` and, if the mesh has it, `uv`.
    pub fn image(&self) -> Image<'_> {
        let mut variables = Vec::new();
        for (name, range) in [("point", 0..3), ("normal", 3..6), ("uv", 6..8)] {
            let Some(planes) = self.planes.get(range) else { continue };
            variables.push(Variable {
                name: name.into(),
                shape: Shape::Vector(planes.len() as u32),
                planes: planes.iter().map(|p| Cow::Borrowed(&p[..])).collect(),
            });
        }
        Image { width: self.mesh.points.len(), height: 1, variables, ..Image::default() }
    }

    /// Returns the mesh with the points of `image`, the result of a program on [`Deform::image`].
    ///
    /// A coordinate that the program left as it was keeps the file's number, with all its digits. Normals are made anew from the
    /// faces where one of these changed, and where there are none; if no point moved, the mesh is as it was.
    ///
    /// # Errors
    /// If it has no `point`, one that is no vector of 3, or one that is not finite.
    pub fn moved(&self, image: &Image<'_>) -> Result<Mesh, Box<Diagnostic>> {
        let wrong =
            |message: String, hint: &str| Err(Box::new(Diagnostic::bare("deform", message).hint(hint)));
        let point =
            image.variable("point").filter(|v| v.planes.iter().all(|p| p.len() == self.mesh.points.len()));
        let Some(point) = point else {
            return wrong(
                "the program does not assign `point`".into(),
                "Assign the new position of each vertex, for example: point += 0.1 * normal * Noise(4 * point).",
            );
        };
        let [x, y, z] = &point.planes[..] else {
            let message = format!("`point` is {}, and a vertex needs a vector of 3", point.shape);
            return wrong(message, "Assign a vector of 3: point = [x y z].");
        };
        let mut mesh = self.mesh.clone();
        let mut moved = vec![false; mesh.points.len()];
        // A number of few digits, if it is near enough: of singles at 448262.1 it is a noticeable way off.
        let slack = mesh.longest_side() / FINE;
        let number = |x: f32| {
            let (exact, short) = (f64::from(x), decimal(x));
            if (exact - short).abs() <= slack { short } else { exact }
        };
        for (i, place) in mesh.points.iter_mut().enumerate() {
            let new = [x[i], y[i], z[i]];
            for k in 0..3 {
                if new[k].to_bits() != self.planes[k][i].to_bits() {
                    place[k] = self.origin[k] + number(new[k]);
                    moved[i] = true;
                }
            }
            if new.iter().chain(&place.map(|c| c as f32)).any(|c| !c.is_finite()) {
                let ([x, y, z], [a, b, c], vertex) = (new, [0, 1, 2].map(|k| self.planes[k][i]), i + 1);
                return wrong(
                    format!(
                        "the program moves vertex {vertex} to [{x} {y} {z}], which is not a valid position"
                    ),
                    &format!("It was at [{a} {b} {c}]."),
                );
            }
        }
        if moved.contains(&true) {
            self.renew_normals(&mut mesh, &moved);
        }
        Ok(mesh)
    }

    /// Makes the normals anew of corners that are at a face of which a point has moved, or that have none. Others keep theirs.
    fn renew_normals(&self, mesh: &mut Mesh, moved: &[bool]) {
        let mut changed = vec![false; self.groups];
        for face in &mesh.faces {
            if mesh.corners_of(face).iter().any(|corner| moved[corner.point as usize]) {
                let groups = &self.group[face.first as usize..][..face.corners as usize];
                groups.iter().for_each(|&group| changed[group as usize] = true);
            }
        }
        let normals = mesh.angle_normals(self.groups, |corner| self.group[corner] as usize);
        let mut kept: Vec<[f64; 3]> = normals.iter().map(|n| n.as_vec3().to_array().map(decimal)).collect();
        // All corners of a group had the same one.
        for (corner, &group) in mesh.corners.iter_mut().zip(&self.group) {
            match corner.normal {
                Some(old) if !changed[group as usize] => kept[group as usize] = mesh.normals[old as usize],
                _ => {}
            }
            corner.normal = (kept[group as usize] != [0.0; 3]).then_some(group);
        }
        mesh.normals = kept;
    }
}
