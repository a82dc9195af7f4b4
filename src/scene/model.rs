//! A polygon mesh as something to be seen.
//!
//! The tree of boxes is the crate's, in `f32` and a little too large, so that it never loses a triangle; which triangle a ray
//! meets, and where, is found in `f64`. The test of Woop, Benthin and Wald (2013) lets no ray through between two triangles that
//! share an edge: both compute the same number for it, with opposite signs.

use super::error::SceneError;
use super::ray::{Hit, Ray};
use crate::mesh::{Cutter, Mesh};
use glam::{DVec2, DVec3};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use std::time::Duration;

/// By how much boxes are larger than what is in them, where the whole mesh has a radius of 1. The coordinates there, and
/// those of rays, are off by a tenth of that at most.
const MARGIN: f64 = 4e-6;

/// How much farther than the nearest hit so far boxes are looked into, likewise.
const SLACK: f64 = 1e-5;

/// A mesh with all that rays need: normals, triangles, a tree of boxes. It serves any number of views.
pub struct Model {
    mesh: Mesh,
    triangles: Vec<Triangle>,
    tree: Bvh2,
    /// The middle of its bounds, and half of their diagonal.
    center: DVec3,
    radius: f64,
}

/// A triangle of a face.
#[derive(Clone, Copy)]
struct Triangle {
    points: [[f32; 3]; 3],
    /// The places of its corners in the mesh's list.
    corners: [u32; 3],
    surface: u32,
}

impl Triangle {
    fn points(&self) -> [DVec3; 3] {
        self.points.map(|p| DVec3::from(p.map(f64::from)))
    }
}

impl Model {
    /// Makes ready a mesh whose z points up. Missing normals are made, smooth ones.
    ///
    /// # Errors
    /// If it has no faces.
    pub fn new(mut mesh: Mesh) -> Result<Model, SceneError> {
        mesh.complete_normals();
        let mut triangles = Vec::with_capacity(mesh.faces.len());
        let mut cutter = Cutter::new();
        for face in &mesh.faces {
            cutter.cut(&mesh, face, |t| {
                let corners = t.map(|i| face.first + i);
                let points = corners.map(|c| mesh.points[mesh.corners[c as usize].point as usize]);
                let [a, b, c] = points;
                // Without an area there is nothing to see. What is nearly so must stay: it may be all there is of an edge.
                if a != b && b != c && c != a {
                    triangles.push(Triangle { points, corners, surface: face.surface });
                }
            });
        }
        let mut bounds = None;
        for p in triangles.iter().flat_map(Triangle::points) {
            let [low, high] = bounds.unwrap_or([p, p]);
            bounds = Some([low.min(p), high.max(p)]);
        }
        let Some([low, high]) = bounds else { return Err(SceneError::NoFaces) };
        let center = (low + high) / 2.0;
        // Not 0, whatever the mesh.
        let radius = ((high - low) / 2.0).length().max(f64::from(f32::MIN_POSITIVE));
        let boxes: Vec<Aabb> = triangles
            .iter()
            .map(|triangle| {
                let local = triangle.points().map(|p| (p - center) / radius);
                let low = local[0].min(local[1]).min(local[2]) - MARGIN;
                let high = local[0].max(local[1]).max(local[2]) + MARGIN;
                Aabb { min: low.as_vec3a(), max: high.as_vec3a() }
            })
            .collect();
        let mut tree = build_bvh2(&boxes, BvhBuildParams::fast_build(), &mut Duration::default());
        // The crate takes no tree to be deeper than 96, and would lose branches of one that is.
        tree.max_depth = depth(&tree) + 2;
        Ok(Model { mesh, triangles, tree, center, radius })
    }

    /// The names of its surfaces, the first of which is number 1.
    pub fn surfaces(&self) -> &[String] {
        &self.mesh.surfaces
    }

    /// How many triangles it has.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// Width and height, on the plane at distance 1, of a picture that just holds it; a wide one if the eye is too near.
    pub(super) fn frame(&self, eye: DVec3, look_at: DVec3) -> [f64; 2] {
        const WIDE: [f64; 2] = [2.0, 2.0];
        let Some(forward) = (look_at - eye).try_normalize() else { return WIDE };
        let right = forward.cross(DVec3::Z).try_normalize().unwrap_or(DVec3::X);
        let up = right.cross(forward);
        let mut most = [0.0_f64; 2];
        for p in self.triangles.iter().flat_map(Triangle::points) {
            let p = p - eye;
            let depth = p.dot(forward);
            if depth < 1e-3 * self.radius {
                return WIDE;
            }
            most = [most[0].max((p.dot(right) / depth).abs()), most[1].max((p.dot(up) / depth).abs())];
        }
        // A little more, so that nothing touches the edge; and something, if it is seen from its side.
        let least = 0.1 * most[0].max(most[1]).max(1e-6);
        most.map(|side| 2.1 * side.max(least))
    }

    /// The middle of its bounds.
    pub(super) fn center(&self) -> DVec3 {
        self.center
    }

    /// The radius of the sphere around its bounds.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// The first place that a ray meets, and the number of its surface, counted from 0.
    pub(super) fn hit(&self, ray: &Ray) -> Option<(usize, Hit)> {
        let test = Test::new(ray);
        // The crate's ray begins near the mesh, where `f32` is fine enough.
        let origin = (ray.origin - self.center) / self.radius;
        let skipped = (-origin.dot(ray.direction) - 1.5).max(0.0);
        let near = (origin + ray.direction * skipped).as_vec3a();
        // A ray that is beside the mesh by far meets nothing, and would leave the range of `f32`.
        if !near.is_finite() || near.abs().max_element() > 1e6 {
            return None;
        }
        let mut best: Option<(Place, u32)> = None;
        let local = obvhs::ray::Ray::new_inf(near, ray.direction.as_vec3a());
        self.tree.ray_traverse(local, &mut obvhs::ray::RayHit::none(), |_, i| {
            let number = self.tree.primitive_indices[i];
            let Some(place) = test.meet(self.triangles[number as usize].points()) else {
                return f32::INFINITY;
            };
            // Of two at the same place the first counts, whatever the order of the tree.
            let nearer = |(b, n): &(Place, u32)| (place.distance, number) < (b.distance, *n);
            if best.as_ref().is_none_or(nearer) {
                best = Some((place, number));
                return (place.distance / self.radius - skipped + SLACK) as f32;
            }
            f32::INFINITY
        });
        best.map(|(place, number)| self.look(ray, place, &self.triangles[number as usize]))
    }

    /// What is to be seen at a place of a triangle.
    fn look(&self, ray: &Ray, place: Place, triangle: &Triangle) -> (usize, Hit) {
        let [a, b, c] = triangle.points();
        let [u, v, w] = place.shares;
        let (ab, ac) = (b - a, c - a);
        let flat = ab.cross(ac).normalize_or_zero();
        let corners = triangle.corners.map(|i| self.mesh.corners[i as usize]);
        let normals =
            corners.map(|c| c.normal.map(|i| DVec3::from(self.mesh.normals[i as usize].map(f64::from))));
        let normal = match normals {
            // Each weighs the same, whatever its length.
            [Some(l), Some(m), Some(n)] => {
                let [l, m, n] = [l, m, n].map(DVec3::normalize_or_zero);
                (l * u + m * v + n * w).try_normalize().unwrap_or(flat)
            }
            _ => flat,
        };
        let away = flat.dot(ray.direction) > 0.0;
        let mut hit = Hit {
            distance: place.distance,
            point: a * u + b * v + c * w,
            normal: if away { -normal } else { normal },
            uv: DVec2::ZERO,
            dpdu: DVec3::ZERO,
            dpdv: DVec3::ZERO,
        };
        let uvs = corners.map(|c| c.uv.map(|i| DVec2::from(self.mesh.uvs[i as usize].map(f64::from))));
        if let [Some(l), Some(m), Some(n)] = uvs {
            hit.uv = l * u + m * v + n * w;
            let (lm, ln) = (m - l, n - l);
            let area = lm.perp_dot(ln);
            let dpdu = (ab * ln.y - ac * lm.y) / area;
            let dpdv = (ac * lm.x - ab * ln.x) / area;
            // Where uv stands still, or nearly so, there is no such direction.
            if dpdu.as_vec3().is_finite() && dpdv.as_vec3().is_finite() {
                (hit.dpdu, hit.dpdv) = (dpdu, dpdv);
            }
        }
        (triangle.surface as usize, hit)
    }
}

/// How deep a tree is.
fn depth(tree: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut nodes = vec![(0, 1)];
    while let Some((index, depth)) = nodes.pop() {
        let Some(node) = tree.nodes.get(index as usize) else { continue };
        deepest = deepest.max(depth);
        if !node.is_leaf() {
            nodes.extend([(node.first_index, depth + 1), (node.first_index + 1, depth + 1)]);
        }
    }
    deepest
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug)]
struct Place {
    distance: f64,
    /// The shares of the corners; their sum is 1.
    shares: [f64; 3],
}

/// A ray in the axes in which triangles are tested: along its longest component, sheared so that the other two are 0.
struct Test {
    origin: DVec3,
    axes: [usize; 3],
    shear: [f64; 3],
}

impl Test {
    fn new(ray: &Ray) -> Test {
        let d = ray.direction;
        let z = d.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            (x, y) = (y, x);
        }
        Test { origin: ray.origin, axes: [x, y, z], shear: [d[x] / d[z], d[y] / d[z], 1.0 / d[z]] }
    }

    fn meet(&self, points: [DVec3; 3]) -> Option<Place> {
        let [x, y, z] = self.axes;
        let [a, b, c] = points.map(|p| {
            let p = p - self.origin;
            [p[x] - self.shear[0] * p[z], p[y] - self.shear[1] * p[z], self.shear[2] * p[z]]
        });
        let edge = |p: [f64; 3], q: [f64; 3]| p[0] * q[1] - p[1] * q[0];
        let [u, v, w] = [edge(c, b), edge(a, c), edge(b, a)];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        let shares = [u / sum, v / sum, w / sum];
        let distance = shares[0] * a[2] + shares[1] * b[2] + shares[2] * c[2];
        (distance > 0.0 && distance.is_finite()).then_some(Place { distance, shares })
    }
}
