//! Normals that are made from the faces.

use super::Mesh;
use super::cut::newell;
use glam::DVec3;
use std::collections::HashMap;

impl Mesh {
    /// For each point the first that lies where it lies: files split points where normals or uv part, and that is no edge.
    pub(crate) fn places(&self) -> Vec<u32> {
        let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(self.points.len());
        // -0 lies where 0 lies.
        let key = |p: &[f32; 3]| p.map(|c| (c + 0.0).to_bits());
        (0..).zip(&self.points).map(|(i, p)| *first.entry(key(p)).or_insert(i)).collect()
    }

    /// The unit normals of groups of corners: `group` tells the group of a corner by its place in the list. A face counts by
    /// its angle at the corner, so that it does not matter how the surface is cut into faces. A group without a direction has 0.
    pub(crate) fn angle_normals(&self, groups: usize, group: impl Fn(usize) -> usize) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; groups];
        let mut polygon: Vec<DVec3> = Vec::new();
        for face in &self.faces {
            let corners = self.corners_of(face);
            polygon.clear();
            polygon.extend(corners.iter().map(|c| DVec3::from(self.points[c.point as usize].map(f64::from))));
            let Some(normal) = newell(&polygon).try_normalize() else { continue };
            let count = polygon.len();
            for i in 0..count {
                let here = polygon[i];
                let edges = [polygon[(i + 1) % count] - here, polygon[(i + count - 1) % count] - here];
                let [Some(a), Some(b)] = edges.map(DVec3::try_normalize) else { continue };
                let angle = libm::acos(a.dot(b).clamp(-1.0, 1.0));
                // At a corner that goes in, the angle is the larger one.
                let turn = if a.cross(b).dot(normal) < 0.0 { std::f64::consts::TAU - angle } else { angle };
                sums[group(face.first as usize + i)] += normal * turn;
            }
        }
        sums.into_iter().map(DVec3::normalize_or_zero).collect()
    }

    /// Gives normals to the corners that have none: smooth ones, from all faces around the place.
    pub fn complete_normals(&mut self) {
        if self.corners.iter().all(|c| c.normal.is_some()) {
            return;
        }
        let places = self.places();
        let smooth =
            self.angle_normals(self.points.len(), |c| places[self.corners[c].point as usize] as usize);
        let start = self.normals.len() as u32;
        let usable: Vec<bool> = smooth.iter().map(|n| *n != DVec3::ZERO).collect();
        self.normals.extend(smooth.iter().map(|n| n.as_vec3().to_array()));
        for corner in self.corners.iter_mut().filter(|c| c.normal.is_none()) {
            let place = places[corner.point as usize];
            corner.normal = usable[place as usize].then_some(start + place);
        }
    }
}
