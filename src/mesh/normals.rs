//! Normals that are made from the faces.

use super::Mesh;
use super::cut::newell;
use glam::DVec3;
use std::collections::HashMap;

impl Mesh {
    /// For each point the first that lies where it lies: files split points where normals or uv part, and that is no edge.
    pub(crate) fn places(&self) -> Vec<u32> {
        let mut first: HashMap<[u64; 3], u32> = HashMap::with_capacity(self.points.len());
        let zero = self.longest_side() / (1u64 << 50) as f64;
        (0..).zip(&self.points).map(|(i, p)| *first.entry(place(*p, zero)).or_insert(i)).collect()
    }

    /// The unit normals of groups of corners: `group` is the group of a corner by its place in the list. A face counts by its
    /// angle at the corner, so that it does not matter how the surface is cut into faces. A group without a direction has 0.
    ///
    /// Neighbouring corners of a face that lie at one place, as at the poles of a ball of quads, are one corner, whose angle
    /// counts once for each of their groups.
    pub(crate) fn angle_normals(&self, groups: usize, group: impl Fn(usize) -> usize) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; groups];
        let mut polygon: Vec<DVec3> = Vec::new();
        // The groups of the corners, and where those of each place of the polygon end.
        let mut members: Vec<usize> = Vec::new();
        let mut ends: Vec<usize> = Vec::new();
        // The last place at which each group was met.
        let mut met = vec![0usize; groups];
        let mut place_number = 0;
        for face in &self.faces {
            polygon.clear();
            members.clear();
            ends.clear();
            let corners = self.corners_of(face);
            let place = |i: usize| DVec3::from(self.points[corners[i].point as usize]);
            // Begins where a place begins, so that none is cut in two by the end of the list.
            let count = corners.len();
            let Some(first) = (0..count).find(|&i| place(i) != place((i + count - 1) % count)) else {
                continue;
            };
            for i in (0..count).map(|i| (first + i) % count) {
                if polygon.last() != Some(&place(i)) {
                    polygon.push(place(i));
                    ends.push(members.len());
                    place_number += 1;
                }
                let number = group(face.first as usize + i);
                if std::mem::replace(&mut met[number], place_number) != place_number {
                    members.push(number);
                }
                if let Some(end) = ends.last_mut() {
                    *end = members.len();
                }
            }
            let Some(normal) = newell(&polygon).try_normalize() else { continue };
            let count = polygon.len();
            for i in 0..count {
                let here = polygon[i];
                let edges = [polygon[(i + 1) % count] - here, polygon[(i + count - 1) % count] - here];
                let [Some(a), Some(b)] = edges.map(DVec3::try_normalize) else { continue };
                let angle = libm::acos(a.dot(b).clamp(-1.0, 1.0));
                // At a corner that goes in, the angle is the larger one.
                let turn = if a.cross(b).dot(normal) < 0.0 { std::f64::consts::TAU - angle } else { angle };
                let start = i.checked_sub(1).map_or(0, |before| ends[before]);
                for &group in &members[start..ends[i]] {
                    sums[group] += normal * turn;
                }
            }
        }
        sums.into_iter().map(DVec3::normalize_or_zero).collect()
    }

    /// Adds smooth normals to the corners without one, from all faces around the point.
    pub fn complete_normals(&mut self) {
        if self.corners.iter().all(|c| c.normal.is_some()) {
            return;
        }
        let places = self.places();
        let smooth =
            self.angle_normals(self.points.len(), |c| places[self.corners[c].point as usize] as usize);
        let start = self.normals.len() as u32;
        let usable: Vec<bool> = smooth.iter().map(|n| *n != DVec3::ZERO).collect();
        self.normals.extend(smooth.iter().map(|n| n.as_vec3().as_dvec3().to_array()));
        for corner in self.corners.iter_mut().filter(|c| c.normal.is_none()) {
            let place = places[corner.point as usize];
            corner.normal = usable[place as usize].then_some(start + place);
        }
    }
}

/// What is the same for points at one place. Programs compute the two sides of a seam with different rounding (the sine of a whole
/// turn is 1e-16, not 0), so only the leading 44 bits of the largest coordinate count, and what is as large; and no coordinate
/// below `zero`.
fn place(point: [f64; 3], zero: f64) -> [u64; 3] {
    let largest = point.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
    // The power of two below it, without its lower bits.
    let step = f64::from_bits(largest.to_bits() & (0x7FF << 52)) / (1u64 << 44) as f64;
    let rounded = |c: f64| match c.abs() <= zero {
        // -0 lies where 0 lies.
        true => 0.0,
        false if step.is_normal() => (c / step).round() * step + 0.0,
        false => c,
    };
    point.map(|c| rounded(c).to_bits())
}
