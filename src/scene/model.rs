//! A polygon mesh as something to be seen.
//!
//! All of it is in `f64`, and relative to a local origin where the mesh is far from the world's: what is far away keeps its
//! shape. The test of Woop, Benthin and Wald (2013) lets no ray through between two triangles that share an edge: both compute
//! the same number for it, with opposite signs.

use super::error::SceneError;
use super::ray::{Hit, Ray};
use super::tree::Tree;
use crate::mesh::{Crossing, Cutter, Mesh};
use glam::{DVec2, DVec3};

/// A mesh whose middle is farther from the origin than so many times its radius gets an origin of its own. (Nearer ones lose
/// nothing, and keep the bits that they always had.)
const NEAR: f64 = 8.0;

/// A mesh prepared for ray casting: normals, triangles, a tree of boxes. It can be used for any number of views.
pub struct Model {
    mesh: Mesh,
    triangles: Vec<Triangle>,
    tree: Tree,
    /// Where the local origin is in the world. All else is relative to it.
    origin: DVec3,
    /// The middle of its bounds, and half of their diagonal.
    center: DVec3,
    radius: f64,
}

/// A triangle of a face.
#[derive(Clone, Copy)]
struct Triangle {
    points: [DVec3; 3],
    /// The places of its corners in the mesh's list.
    corners: [u32; 3],
    surface: u32,
}

impl Model {
    /// Prepares a mesh with z up. Missing normals are computed as smooth ones.
    ///
    /// # Errors
    /// If it has no faces, or more triangles than can be numbered.
    pub fn new(mut mesh: Mesh) -> Result<Model, SceneError> {
        mesh.complete_normals();
        let [low, high] = mesh.bounds().unwrap_or_default().map(DVec3::from);
        let middle = DVec3::from(mesh.middle());
        let far = middle.abs().max_element() > NEAR * (high - low).length() / 2.0;
        let origin = if far { middle } else { DVec3::ZERO };
        let mut triangles = Vec::with_capacity(mesh.faces.len());
        let mut cutter = Cutter::new();
        for (number, face) in mesh.faces.iter().enumerate() {
            let cut = cutter.cut(&mesh, face, |t| {
                let corners = t.map(|i| face.first + i);
                let points = corners
                    .map(|c| DVec3::from(mesh.points[mesh.corners[c as usize].point as usize]) - origin);
                let [a, b, c] = points;
                // Without an area there is nothing to see. What is nearly so must stay: it may be all there is of an edge.
                if a != b && b != c && c != a {
                    triangles.push(Triangle { points, corners, surface: face.surface });
                }
            });
            cut.map_err(|Crossing { corners }| SceneError::CrossingFace { face: number + 1, corners })?;
        }
        let mut bounds = None;
        for &p in triangles.iter().flat_map(|t: &Triangle| &t.points) {
            let [low, high] = bounds.unwrap_or([p, p]);
            bounds = Some([low.min(p), high.max(p)]);
        }
        let Some([low, high]) = bounds else { return Err(SceneError::NoFaces) };
        // Some triangles without an area do no harm; of these alone nothing is seen.
        let is_line = |t: &Triangle| {
            let [a, b, c] = t.points;
            let longest = (b - a).length_squared().max((c - a).length_squared());
            (b - a).cross(c - a).length() <= 1e-14 * longest
        };
        if triangles.iter().all(is_line) {
            return Err(SceneError::NoFaces);
        }
        let center = (low + high) / 2.0;
        // Not 0, whatever the mesh.
        let radius = ((high - low) / 2.0).length().max(f64::from(f32::MIN_POSITIVE));
        let count = u32::try_from(triangles.len()).map_err(|_| SceneError::TooManyTriangles)?;
        let tree = Tree::new(count, &|i| triangles[i as usize].points);
        Ok(Model { mesh, triangles, tree, origin, center, radius })
    }

    /// The names of its surfaces, from number 1.
    pub fn surfaces(&self) -> &[String] {
        &self.mesh.surfaces
    }

    /// The number of triangles.
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
        for p in self.triangles.iter().flat_map(|t| t.points) {
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

    /// Where the local origin is in the world. The eye, rays and hits are relative to it.
    pub(super) fn origin(&self) -> DVec3 {
        self.origin
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
        let meet = |i: u32| test.meet(self.triangles[i as usize].points);
        let number = self.tree.nearest(ray, |i| meet(i).map(|place| place.distance))?;
        Some(self.look(ray, meet(number)?, &self.triangles[number as usize]))
    }

    /// What is to be seen at a place of a triangle.
    fn look(&self, ray: &Ray, place: Place, triangle: &Triangle) -> (usize, Hit) {
        let [a, b, c] = triangle.points;
        let [u, v, w] = place.shares;
        let (ab, ac) = (b - a, c - a);
        let flat = ab.cross(ac).normalize_or_zero();
        let corners = triangle.corners.map(|i| self.mesh.corners[i as usize]);
        let normals = corners.map(|c| c.normal.map(|i| DVec3::from(self.mesh.normals[i as usize])));
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
        let uvs = corners.map(|c| c.uv.map(|i| DVec2::from(self.mesh.uvs[i as usize])));
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
