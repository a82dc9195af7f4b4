//! Polygons cut into triangles.

use super::{Face, Mesh};
use earcut::Earcut;
use glam::{DVec2, DVec3};

/// The most corners of a polygon whose ears are cut off one by one, which may take quadratic time.
pub(crate) const MAX_EARS: u32 = 1000;

/// A polygon of very many corners whose outline crosses itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub corners: u32,
}

/// Cuts faces into triangles; it keeps its buffers from one to the next.
pub(crate) struct Cutter {
    earcut: Earcut<f64>,
    polygon: Vec<DVec3>,
    triangles: Vec<u32>,
}

impl Cutter {
    pub fn new() -> Cutter {
        Cutter { earcut: Earcut::new(), polygon: Vec::new(), triangles: Vec::new() }
    }

    /// Gives each triangle of a face to `each`, as three of the face's corners counted from 0, in the face's own order round.
    ///
    /// Quads and convex polygons become fans, which keep every corner, so that two faces that share an edge share
    /// those of their triangles too. A polygon that is not convex loses its ears one by one.
    ///
    /// # Errors
    /// If it has more corners than [`MAX_EARS`], is not convex, and its outline crosses itself.
    pub fn cut(&mut self, mesh: &Mesh, face: &Face, mut each: impl FnMut([u32; 3])) -> Result<(), Crossing> {
        let corners = mesh.corners_of(face);
        let count = corners.len() as u32;
        if count == 3 {
            each([0, 1, 2]);
            return Ok(());
        }
        self.polygon.clear();
        self.polygon.extend(corners.iter().map(|c| DVec3::from(mesh.points[c.point as usize])));
        let polygon = &self.polygon;
        let normal = newell(polygon);
        // Does the triangle look where the polygon looks, or nowhere?
        let faces = |t: [u32; 3]| {
            let [a, b, c] = t.map(|i| polygon[i as usize]);
            (b - a).cross(c - a).dot(normal) >= 0.0
        };
        let fan_from = |first: u32, each: &mut dyn FnMut([u32; 3])| {
            for i in 1..count - 1 {
                each([first, (first + i) % count, (first + i + 1) % count]);
            }
        };
        // In a quad that is not convex the diagonal starts at the corner that goes in.
        let starts = if count == 4 { 2 } else { 1 };
        for first in 0..starts {
            if (1..count - 1).all(|i| faces([first, (first + i) % count, (first + i + 1) % count])) {
                fan_from(first, &mut each);
                return Ok(());
            }
        }
        let Some(normal) = normal.try_normalize() else {
            fan_from(0, &mut each);
            return Ok(());
        };
        let (u, v) = normal.any_orthonormal_pair();
        let flatten = |p: &DVec3| [(p - polygon[0]).dot(u), (p - polygon[0]).dot(v)];
        let flat: Vec<[f64; 2]> = polygon.iter().map(flatten).collect();
        if count > MAX_EARS {
            let flat: Vec<DVec2> = flat.into_iter().map(DVec2::from).collect();
            let triangles = super::cut_large::triangles(&flat).ok_or(Crossing { corners: count })?;
            triangles.into_iter().for_each(each);
            return Ok(());
        }
        self.earcut.earcut(flat.iter().copied(), &[], &mut self.triangles);
        for &triangle in self.triangles.as_chunks::<3>().0 {
            let [a, b, c] = triangle.map(|i| DVec2::from(flat[i as usize]));
            match (b - a).perp_dot(c - a) < 0.0 {
                true => each([triangle[0], triangle[2], triangle[1]]),
                false => each(triangle),
            }
        }
        Ok(())
    }
}

/// The normal of a polygon that need not be flat, by Newell's sums; its length is twice the area.
pub(crate) fn newell(polygon: &[DVec3]) -> DVec3 {
    let Some(&origin) = polygon.first() else { return DVec3::ZERO };
    polygon.windows(2).map(|w| (w[0] - origin).cross(w[1] - origin)).sum()
}
