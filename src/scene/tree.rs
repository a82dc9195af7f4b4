//! A tree of boxes around triangles, in `f64`.
//!
//! The crates for this compute in `f32`, where a small object beside one that is far away has no shape left, and take quadratic
//! time for boxes that coincide. Here a range of triangles is cut by the surface area heuristic, and in halves where that
//! leads nowhere, so building takes n log n steps whatever the mesh.

use super::ray::Ray;
use glam::DVec3;
use std::cmp::Ordering;

/// Triangles of a leaf, at most.
const LEAF: usize = 4;

/// Intervals into which the centres of a range are sorted to find the best cut.
const BINS: usize = 16;

/// From this depth on ranges are cut in halves, so that no tree is deeper than [`STACK`].
const HALVES: usize = 64;

/// The depth that no tree reaches: 2^32 triangles take 32 levels of halves.
const STACK: usize = HALVES + 36;

/// Ranges of so many triangles are built by a thread of their own.
const PARALLEL: usize = 1 << 14;

/// By how much boxes are looked at as larger than they are, for coordinates of 1: the test of a triangle rounds otherwise than
/// that of its box, and none may be lost.
const MARGIN: f64 = 1e-13;

/// Distances that differ by less, for a distance of 1, count as equal. Then the first triangle of the mesh is seen, so that
/// faces in one plane do not show through one another.
const TIE: f64 = 1e-12;

/// The tree.
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// The numbers of the triangles, in the order of the leaves; in places of copies that were left out, any.
    order: Vec<u32>,
    /// The largest coordinate.
    extent: f64,
}

/// A box, and what is in it.
#[derive(Clone, Copy)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// Of a leaf: where its triangles begin in the order. Else: the second child; the first one is the next node.
    first: u32,
    /// How many triangles a leaf has; 0 for others.
    count: u32,
    /// The least number of a triangle within.
    least: u32,
}

impl Tree {
    /// Builds the tree of so many triangles, which `points` gives by number. Of identical triangles only the first is kept.
    pub fn new(count: u32, points: &(dyn Fn(u32) -> [DVec3; 3] + Sync)) -> Tree {
        let boxes: Vec<[DVec3; 2]> = (0..count)
            .map(|i| {
                let [a, b, c] = points(i);
                [a.min(b).min(c), a.max(b).max(c)]
            })
            .collect();
        let mut order: Vec<u32> = (0..count).collect();
        let mut nodes = Vec::new();
        if count > 0 {
            Builder { boxes: &boxes, points }.range(&mut order, 0, 0, false, &mut nodes);
        }
        let extent = nodes.first().map_or(0.0, |n| n.low.abs().max(n.high.abs()).max_element());
        Tree { nodes, order, extent }
    }

    /// The triangle that a ray meets first. `meet` is the distance at which it meets the triangle of that number.
    pub fn nearest(&self, ray: &Ray, meet: impl Fn(u32) -> Option<f64>) -> Option<u32> {
        let margin = MARGIN * self.extent.max(ray.origin.abs().max_element());
        let slabs = Slabs::new(ray, margin);
        let mut best: Option<(f64, u32)> = None;
        let useful = |best: Option<(f64, u32)>, enters: f64, least: u32| {
            best.is_none_or(|(distance, number)| {
                enters < distance - TIE * distance || enters <= distance + TIE * distance && least < number
            })
        };
        let mut stack = [(0u32, 0.0f64); STACK];
        let mut height = 0;
        let mut next = self.nodes.first().and_then(|root| slabs.enter(root)).map(|enters| (0, enters));
        loop {
            let Some((index, enters)) = next.take() else {
                if height == 0 {
                    return best.map(|(_, number)| number);
                }
                height -= 1;
                next = Some(stack[height]);
                continue;
            };
            let node = &self.nodes[index as usize];
            if !useful(best, enters, node.least) {
                continue;
            }
            if node.count > 0 {
                for &number in &self.order[node.first as usize..][..node.count as usize] {
                    if let Some(distance) = meet(number)
                        && useful(best, distance, number)
                    {
                        best = Some((distance, number));
                    }
                }
                continue;
            }
            let children = [index + 1, node.first].map(|child| {
                let enters = slabs.enter(&self.nodes[child as usize]);
                enters.map(|enters| (child, enters))
            });
            next = match children {
                [Some(a), Some(b)] => {
                    let (near, far) = if b.1 < a.1 { (b, a) } else { (a, b) };
                    stack[height] = far;
                    height += 1;
                    Some(near)
                }
                [a, b] => a.or(b),
            };
        }
    }
}

/// A ray as boxes are tested: between which distances it is between two parallel planes.
struct Slabs {
    /// Where it starts, with the margin added and taken away.
    from: [DVec3; 2],
    /// One over its direction, finite.
    inverse: DVec3,
}

impl Slabs {
    fn new(ray: &Ray, margin: f64) -> Slabs {
        let inverse = |d: f64| if d.abs() < 1e-300 { 1e300_f64.copysign(d) } else { 1.0 / d };
        let inverse = DVec3::from(ray.direction.to_array().map(inverse));
        Slabs { from: [ray.origin + margin, ray.origin - margin], inverse }
    }

    /// Where the ray enters a box, if it does.
    fn enter(&self, node: &Node) -> Option<f64> {
        let a = (node.low - self.from[0]) * self.inverse;
        let b = (node.high - self.from[1]) * self.inverse;
        let (enters, leaves) = (a.min(b).max_element(), a.max(b).min_element());
        (enters <= leaves && leaves >= 0.0).then_some(enters.max(0.0))
    }
}

/// What the nodes are built from.
struct Builder<'a> {
    boxes: &'a [[DVec3; 2]],
    points: &'a (dyn Fn(u32) -> [DVec3; 3] + Sync),
}

impl Builder<'_> {
    /// Adds the nodes of a range of the order, whose first place is `start`. `distinct`: no two of its triangles are identical.
    fn range(&self, order: &mut [u32], start: usize, depth: usize, distinct: bool, nodes: &mut Vec<Node>) {
        let (mut order, mut distinct) = (order, distinct);
        let mut middle = if order.len() <= LEAF { None } else { self.cut(order, depth) };
        if middle.is_none() && order.len() > LEAF {
            // All centres are at one place.
            if !distinct {
                let count = self.remove_copies(order);
                order = &mut order[..count];
                distinct = true;
            }
            middle = (order.len() > LEAF).then_some(order.len() / 2);
        }
        let here = nodes.len();
        let Some(middle) = middle else { return nodes.push(self.leaf(order, start)) };
        nodes.push(Node { low: DVec3::ZERO, high: DVec3::ZERO, first: 0, count: 0, least: 0 });
        let (left, right) = order.split_at_mut(middle);
        let behind = start + middle;
        let second;
        if left.len().min(right.len()) >= PARALLEL {
            let mut others = Vec::new();
            crate::parallel::join(
                || self.range(left, start, depth + 1, distinct, nodes),
                || self.range(right, behind, depth + 1, distinct, &mut others),
            );
            second = nodes.len();
            nodes.extend(others.into_iter().map(|node| match node.count {
                0 => Node { first: node.first + second as u32, ..node },
                _ => node,
            }));
        } else {
            self.range(left, start, depth + 1, distinct, nodes);
            second = nodes.len();
            self.range(right, behind, depth + 1, distinct, nodes);
        }
        let (a, b) = (nodes[here + 1], nodes[second]);
        nodes[here] = Node {
            low: a.low.min(b.low),
            high: a.high.max(b.high),
            first: second as u32,
            count: 0,
            least: a.least.min(b.least),
        };
    }

    /// A node of all triangles of a range.
    fn leaf(&self, order: &[u32], start: usize) -> Node {
        let mut node = Node {
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
            first: start as u32,
            count: order.len() as u32,
            least: u32::MAX,
        };
        for &i in order {
            let [low, high] = self.boxes[i as usize];
            (node.low, node.high, node.least) = (node.low.min(low), node.high.max(high), node.least.min(i));
        }
        node
    }

    /// Twice the centre of a triangle's box: the same for identical triangles, whichever corner comes first.
    fn center(&self, number: u32) -> DVec3 {
        let [low, high] = self.boxes[number as usize];
        low + high
    }

    /// Puts the triangles of a range that are to come first before the others: how many these are. `None` if all centres are at
    /// one place.
    fn cut(&self, order: &mut [u32], depth: usize) -> Option<usize> {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &i in order.iter() {
            let center = self.center(i);
            (low, high) = (low.min(center), high.max(center));
        }
        let size = high - low;
        let axis = size.max_position();
        if size[axis] <= 0.0 {
            return None;
        }
        if depth >= HALVES {
            let middle = order.len() / 2;
            let along = |i: &u32| self.center(*i)[axis];
            order.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)).then(a.cmp(b)));
            return Some(middle);
        }
        // The first and the last interval have a triangle each, so both sides of any cut have one.
        let bin = |i: u32| {
            let share = (self.center(i)[axis] - low[axis]) / size[axis];
            ((share * BINS as f64) as usize).min(BINS - 1)
        };
        let mut bins = [([DVec3::INFINITY, DVec3::NEG_INFINITY], 0usize); BINS];
        for &i in order.iter() {
            let ([low, high], count) = &mut bins[bin(i)];
            let [from, to] = self.boxes[i as usize];
            (*low, *high, *count) = (low.min(from), high.max(to), *count + 1);
        }
        // The cost of what lies behind each cut, then of what lies before it too.
        let mut costs = [0.0; BINS];
        let mut all = ([DVec3::INFINITY, DVec3::NEG_INFINITY], 0);
        for k in (1..BINS).rev() {
            all = joined(all, bins[k]);
            costs[k] = cost(all);
        }
        all = ([DVec3::INFINITY, DVec3::NEG_INFINITY], 0);
        // Of cuts that cost the same, as all do along a line, the most even one.
        let mut best = (f64::INFINITY, usize::MAX, 1);
        for k in 1..BINS {
            all = joined(all, bins[k - 1]);
            let (sum, larger) = (cost(all) + costs[k], all.1.max(order.len() - all.1));
            if sum < best.0 || sum == best.0 && larger < best.1 {
                best = (sum, larger, k);
            }
        }
        Some(partition(order, |i| bin(i) < best.2))
    }

    /// Leaves one of each set of identical triangles, that of the least number: how many there are, at the beginning. They are
    /// sorted by size, so that a ray that passes by the small ones looks at none of them.
    fn remove_copies(&self, order: &mut [u32]) -> usize {
        let key = |i: u32| {
            // Zeros of either sign are the same place.
            let mut corners = (self.points)(i).map(|p| p + 0.0);
            corners.sort_by(|a, b| compare(*a, *b));
            corners
        };
        let by_corners = |a: u32, b: u32| {
            let each = key(a).into_iter().zip(key(b)).map(|(a, b)| compare(a, b));
            each.fold(Ordering::Equal, Ordering::then)
        };
        order.sort_unstable_by(|a, b| by_corners(*a, *b).then(a.cmp(b)));
        let mut count = 1;
        for i in 1..order.len() {
            if by_corners(order[count - 1], order[i]) != Ordering::Equal {
                order[count] = order[i];
                count += 1;
            }
        }
        let size = |i: u32| {
            let [low, high] = self.boxes[i as usize];
            (high - low).length_squared()
        };
        order[..count].sort_unstable_by(|a, b| size(*a).total_cmp(&size(*b)).then(a.cmp(b)));
        count
    }
}

/// A box and a number of triangles.
type Part = ([DVec3; 2], usize);

fn joined(a: Part, b: Part) -> Part {
    ([a.0[0].min(b.0[0]), a.0[1].max(b.0[1])], a.1 + b.1)
}

/// What it costs to look into a part, in proportion: its surface times its triangles.
fn cost(part: Part) -> f64 {
    let size = part.0[1] - part.0[0];
    if part.1 == 0 { 0.0 } else { (size.x * size.y + size.y * size.z + size.z * size.x) * part.1 as f64 }
}

fn compare(a: DVec3, b: DVec3) -> Ordering {
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
}

/// Swaps those for which `first` holds before the others: how many they are.
fn partition(order: &mut [u32], first: impl Fn(u32) -> bool) -> usize {
    let mut count = 0;
    for i in 0..order.len() {
        if first(order[i]) {
            order.swap(count, i);
            count += 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles at random places, some of them copies, some far away, some in one plane.
    fn triangles() -> Vec<[DVec3; 3]> {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut all: Vec<[DVec3; 3]> = Vec::new();
        for i in 0..3000 {
            let center = DVec3::new(random(), random(), random()) * if i % 100 == 0 { 1e7 } else { 4.0 };
            let mut corners = [(); 3].map(|()| center + DVec3::new(random(), random(), random()));
            match i % 7 {
                0 => corners = corners.map(|c| c.with_z(0.25)),
                1 if i > 10 => {
                    let [a, b, c] = all[i - 10];
                    corners = [b, c, a];
                }
                2 => corners = [center, center.with_x(center.x + 1.0), center],
                _ => {}
            }
            all.push(corners);
        }
        for _ in 0..500 {
            all.push([DVec3::ZERO, DVec3::X, DVec3::Y]);
        }
        all
    }

    /// Where a ray meets a triangle's plane, if within it.
    fn meet(ray: &Ray, [a, b, c]: [DVec3; 3]) -> Option<f64> {
        let normal = (b - a).cross(c - a);
        let distance = (a - ray.origin).dot(normal) / ray.direction.dot(normal);
        let p = ray.at(distance);
        let within = [[a, b], [b, c], [c, a]].iter().all(|[a, b]| (b - a).cross(p - a).dot(normal) >= 0.0);
        (distance > 0.0 && distance.is_finite() && within).then_some(distance)
    }

    #[test]
    fn the_tree_finds_what_a_search_of_all_finds() {
        let all = triangles();
        let tree = Tree::new(all.len() as u32, &|i| all[i as usize]);
        let mut hits = 0;
        for i in 0..4000 {
            let angle = f64::from(i) * 2.399963;
            let origin =
                DVec3::new(3.0 * libm::cos(angle), 3.0 * libm::sin(angle), 1.0 - f64::from(i % 90) / 45.0);
            let target =
                DVec3::new(f64::from(i % 13) - 6.0, f64::from(i % 11) - 5.0, f64::from(i % 7) - 3.0) * 0.2;
            let direction = if i % 10 == 0 { -DVec3::Z } else { (target - origin).normalize() };
            let ray = Ray { origin, direction };
            let found = tree.nearest(&ray, |i| meet(&ray, all[i as usize]));
            let all_hits = (0..).zip(&all).filter_map(|(i, t)| Some((meet(&ray, *t)?, i)));
            let expected = all_hits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(distance, _)| {
                // The first of those that are as near.
                let near = |t: &[DVec3; 3]| meet(&ray, *t).is_some_and(|d| d <= distance + TIE * distance);
                all.iter().position(near).unwrap_or(0) as u32
            });
            assert_eq!(found, expected, "{ray:?}");
            hits += usize::from(found.is_some());
        }
        assert!(hits > 1000, "{hits}");
    }

    #[test]
    fn coincident_triangles_take_no_longer_than_others() {
        let start = std::time::Instant::now();
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let turned = |i: u32| std::array::from_fn(|k| corners[(k + i as usize) % 3]);
        let copies = Tree::new(300_000, &turned);
        assert_eq!((copies.nodes.len(), copies.nodes[0].count, copies.nodes[0].least), (1, 1, 0));
        // Larger and larger around one centre.
        let nested = |i: u32| {
            let size = 1.0 + f64::from(i);
            [DVec3::new(-size, -size, 0.0), DVec3::new(size, -size, 0.0), DVec3::new(0.0, size, 0.0)]
        };
        let nested = Tree::new(100_000, &nested);
        let mut deepest = vec![(0u32, 1usize)];
        let mut depth = 0;
        while let Some((index, level)) = deepest.pop() {
            depth = depth.max(level);
            let node = &nested.nodes[index as usize];
            if node.count == 0 {
                deepest.extend([(index + 1, level + 1), (node.first, level + 1)]);
            }
        }
        assert!(depth < 20, "{depth} levels");
        assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    }
}
