//! Polygons of very many corners cut into triangles, in n log n steps.
//!
//! Ears are cut off in quadratic time where corners lie beside long edges. Here the constrained Delaunay triangulation of all
//! corners is made, and those of its triangles are kept that lie within the outline.

use glam::DVec2;
use spade::handles::{FaceHandle, InnerTag};
use spade::{CdtEdge, ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::{BTreeMap, HashMap};

/// By how much the triangles' area may differ from the polygon's, for an area of 1 of its bounds.
const TOLERANCE: f64 = 1e-9;

type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;
type Triangle<'c> = FaceHandle<'c, InnerTag, Point2<f64>, (), CdtEdge<()>, ()>;

/// The triangles of a polygon in the plane, as corners counted from 0, counterclockwise; in the order of their least corners. Of
/// corners at one place only the first is used. `None` if the outline crosses itself.
pub(super) fn triangles(polygon: &[DVec2]) -> Option<Vec<[u32; 3]>> {
    let Some(scale) = scale(polygon) else { return Some(Vec::new()) };
    // Corners at one place are one vertex.
    let mut vertices: Vec<Point2<f64>> = Vec::new();
    let mut corners: Vec<u32> = Vec::new();
    let mut places: HashMap<[u64; 2], usize> = HashMap::new();
    let mut outline = Vec::with_capacity(polygon.len());
    for (corner, point) in (0..).zip(polygon) {
        // What is nothing beside the whole is 0, with one sign: the crate takes no smaller numbers.
        let [x, y] = point.to_array().map(|c| if (c * scale).abs() < 1e-30 { 0.0 } else { c * scale });
        outline.push(*places.entry([x.to_bits(), y.to_bits()]).or_insert_with(|| {
            vertices.push(Point2::new(x, y));
            corners.push(corner);
            vertices.len() - 1
        }));
    }
    // An edge that is gone both ways, as to a hole and back, does not part inside from outside.
    let mut edges: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for (i, &from) in outline.iter().enumerate() {
        let to = outline[(i + 1) % outline.len()];
        if from != to {
            *edges.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    let edges: Vec<[usize; 2]> =
        edges.into_iter().filter(|(_, n)| n % 2 == 1).map(|(edge, _)| edge).collect();
    let mut area = outline.windows(2).map(|w| cross(vertices[w[0]], vertices[w[1]])).sum::<f64>();
    area += cross(vertices[outline[outline.len() - 1]], vertices[outline[0]]);
    let mut crosses = false;
    let cdt = Cdt::try_bulk_load_cdt(vertices, edges, |_| crosses = true).ok()?;
    if crosses {
        return None;
    }
    let mut list: Vec<[u32; 3]> = Vec::new();
    let mut sum = 0.0;
    for face in inside(&cdt) {
        sum += 2.0 * face.area();
        let triangle = face.vertices().map(|v| corners[v.index()]);
        let least = (0..3).min_by_key(|&i| triangle[i]).unwrap_or(0);
        list.push([0, 1, 2].map(|i| triangle[(least + i) % 3]));
    }
    list.sort_unstable();
    // An outline that runs back over a part of itself has been understood otherwise.
    ((sum - area.abs()).abs() <= TOLERANCE).then_some(list)
}

/// Twice the area between the origin and an edge.
fn cross(a: Point2<f64>, b: Point2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

/// What makes the polygon's size 1; `None` if it has none.
fn scale(polygon: &[DVec2]) -> Option<f64> {
    let size = polygon.iter().fold(0.0, |size: f64, p| size.max(p.abs().max_element()));
    (size > 0.0 && size.is_finite() && (1.0 / size).is_finite()).then(|| 1.0 / size)
}

/// The triangles within the outline: from outside, each edge of it leads in or out again.
fn inside(cdt: &Cdt) -> Vec<Triangle<'_>> {
    let mut is_inside: Vec<Option<bool>> = vec![None; cdt.num_all_faces()];
    let outer = cdt.outer_face();
    is_inside[outer.index()] = Some(false);
    let mut stack: Vec<_> = cdt.convex_hull().map(|edge| edge.fix()).collect();
    let mut list = Vec::new();
    // Each edge has a known face on its left.
    while let Some(edge) = stack.pop() {
        let edge = cdt.directed_edge(edge);
        let here = is_inside[edge.face().index()].unwrap_or(false);
        let there = edge.rev().face();
        let Some(face) = there.as_inner().filter(|face| is_inside[face.index()].is_none()) else { continue };
        let inside = here != edge.is_constraint_edge();
        is_inside[face.index()] = Some(inside);
        if inside {
            list.push(face);
        }
        stack.extend(face.adjacent_edges().map(|edge| edge.fix()));
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(polygon: &[DVec2], triangles: &[[u32; 3]]) -> f64 {
        let of = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| polygon[i as usize]);
            let area = (b - a).perp_dot(c - a) / 2.0;
            assert!(area > 0.0, "counterclockwise");
            area
        };
        triangles.iter().map(of).sum()
    }

    fn points(list: &[[f64; 2]]) -> Vec<DVec2> {
        list.iter().map(|p| DVec2::from(*p)).collect()
    }

    #[test]
    fn outlines_of_many_kinds_are_filled() {
        // A comb, whose teeth are beside long edges; a star; a frame whose hole is reached by an edge that is gone twice.
        let n = 5000;
        let back = (0..n).rev().map(|i| DVec2::new(f64::from(i), if i % 2 == 0 { 9.0 } else { -1.0 }));
        let comb: Vec<DVec2> = (0..n)
            .map(|i| DVec2::new(f64::from(i), if i % 2 == 0 { 10.0 } else { 0.0 }))
            .chain(back)
            .collect();
        let filled = triangles(&comb).unwrap();
        assert_eq!(filled.len(), comb.len() - 2);
        assert!((area(&comb, &filled) - f64::from(n - 1)).abs() < 1e-6);
        let frame = points(&[
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ]);
        assert!((area(&frame, &triangles(&frame).unwrap()) - 8.0).abs() < 1e-12);
        // Clockwise, with a corner twice and one in the middle of an edge.
        let square = points(&[[0.0, 0.0], [0.0, 2.0], [0.0, 2.0], [2.0, 2.0], [2.0, 1.0], [2.0, 0.0]]);
        assert!((area(&square, &triangles(&square).unwrap()) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn outlines_that_cross_themselves_are_known() {
        assert_eq!(triangles(&points(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]])), None);
        // Back over a part of itself.
        let spike = points(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 2.0]]);
        assert!(triangles(&spike).is_none_or(|filled| (area(&spike, &filled) - 1.0).abs() < 1e-12));
        assert_eq!(triangles(&points(&[[0.0, 0.0]; 9])), Some(Vec::new()));
        assert_eq!(triangles(&points(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])), Some(Vec::new()));
    }
}
