//! Solids of revolution: a profile of cubic pieces turned about the z axis.

use super::bernstein::{Roots, evaluate, to_bernstein};
use super::ray::{FAR, Hit, Ray, Surface, around, turn};
use super::spline::Piece;
use glam::{DVec2, DVec3};

/// Pieces overlap by this share of their parameter, so that no ray slips through between two.
const OVERLAP: f64 = 1e-9;

/// Below this slope a ray counts as horizontal: its two crossings of a piece lie too close in t for the general way.
const LEVEL: f64 = 1e-6;

/// How far from the axis a line must pass a pole for its crossing to stand out of the rounding of the sextic.
const NUDGE: f64 = 1e-6;

/// A solid whose outline starts on the axis at the bottom and ends on the axis, with the solid to its left. u goes around
/// the axis; v goes along the outline.
#[derive(Clone, Debug)]
pub(super) struct Lathe {
    foot: DVec3,
    parts: Vec<Part>,
    bound: Ring,
}

/// A piece of the outline with what is known of it.
#[derive(Clone, Copy, Debug)]
struct Part {
    piece: Piece,
    ring: Ring,
    /// v at its two ends.
    v: [f64; 2],
}

/// Bounds of distance from the axis and of height.
#[derive(Clone, Copy, Debug)]
struct Ring {
    low: DVec2,
    high: DVec2,
}

impl Ring {
    /// Does the line pass through it? (The line measured from the lathe's foot.) Too often true, never too seldom.
    fn meets(&self, ray: &Ray) -> bool {
        let (o, d) = (ray.origin, ray.direction);
        let (mut from, mut to) = (-2.0 * FAR, 2.0 * FAR);
        if d.z != 0.0 {
            let (a, b) = ((self.low.y - o.z) / d.z, (self.high.y - o.z) / d.z);
            from = a.min(b).max(from);
            to = a.max(b).min(to);
        } else if o.z < self.low.y || o.z > self.high.y {
            return false;
        }
        if from > to {
            return false;
        }
        let (o, d) = (o.truncate(), d.truncate());
        let nearest = (-o.dot(d) / d.length_squared().max(f64::MIN_POSITIVE)).clamp(from, to);
        let distance = |s: f64| (o + d * s).length();
        distance(nearest) <= self.high.x && distance(from).max(distance(to)) >= self.low.x
    }
}

impl Lathe {
    /// Turns an outline (see [`super::spline`]; x is the distance from the axis, y the height) about the vertical through
    /// `foot`. Its first `outside` pieces have v from 0 to 1, the others, which line a cavity, from 1 to 2.
    pub fn new(foot: DVec3, outline: &[Piece], outside: usize) -> Lathe {
        let (outer, inner) = outline.split_at(outside);
        let mut parts = Vec::with_capacity(outline.len());
        for (first, pieces) in [(0.0, outer), (1.0, inner)] {
            let whole: f64 = pieces.iter().map(|p| p.chord).sum();
            let mut done = 0.0;
            for piece in pieces {
                let start = first + done / whole;
                done += piece.chord;
                // The hull of the Bernstein coefficients holds the piece.
                let (x, y) = (to_bernstein(&piece.x), to_bernstein(&piece.y));
                let margin = DVec2::splat(1e-6 * piece.chord.max(1.0));
                let corners = || (0..4).map(|i| DVec2::new(x[i], y[i]));
                let ring = Ring {
                    low: corners().fold(DVec2::INFINITY, DVec2::min) - margin,
                    high: corners().fold(DVec2::NEG_INFINITY, DVec2::max) + margin,
                };
                parts.push(Part { piece: *piece, ring, v: [start, first + done / whole] });
            }
        }
        let bound = Ring {
            low: parts.iter().fold(DVec2::INFINITY, |low, p| low.min(p.ring.low)),
            high: parts.iter().fold(DVec2::NEG_INFINITY, |high, p| high.max(p.ring.high)),
        };
        Lathe { foot, parts, bound }
    }
}

impl Part {
    /// Calls `found` with the distance s and the parameter t of each crossing with the line.
    fn crossings(&self, ray: &Ray, mut found: impl FnMut(f64, f64)) {
        let (o, d) = (ray.origin, ray.direction);
        let Piece { x, y, .. } = &self.piece;
        if d.z.abs() >= LEVEL {
            // Where the line is at height y(t), its squared distance from the axis is x(t)^2. With s = (y(t) - o.z) / d.z
            // and times d.z^2 this is a polynomial of degree 6 in t.
            let mut height = *y;
            height[0] -= o.z;
            let mut sextic = [0.0; 7];
            let [mut bx, mut by] = [height.map(|c| c * d.x), height.map(|c| c * d.y)];
            let near = if self.ring.low.x <= 0.0 { beside_axis(o, d) } else { o };
            bx[0] += d.z * near.x;
            by[0] += d.z * near.y;
            for i in 0..4 {
                for j in 0..4 {
                    sextic[i + j] += d.z * d.z * x[i] * x[j] - bx[i] * bx[j] - by[i] * by[j];
                }
            }
            for &t in Roots::of(&sextic, -OVERLAP, 1.0 + OVERLAP).as_slice() {
                let (s, t) = self.polish(ray, (evaluate(y, t).0 - o.z) / d.z, t);
                found(s, t);
            }
            return;
        }
        // A level line: where the outline is at its height, it crosses the circle there, or not.
        let mut height = *y;
        height[0] -= o.z;
        let (flat_o, flat_d) = (o.truncate(), d.truncate());
        let middle = -flat_o.dot(flat_d) / flat_d.length_squared();
        let miss = (flat_o + flat_d * middle).length_squared();
        for &t in Roots::of(&height, -OVERLAP, 1.0 + OVERLAP).as_slice() {
            let radius = evaluate(x, t).0;
            let square = (radius * radius - miss) / flat_d.length_squared();
            if square > 0.0 {
                for s in [middle - square.sqrt(), middle + square.sqrt()] {
                    let (s, t) = self.polish(ray, s, t);
                    found(s, t);
                }
            }
        }
    }

    /// Newton's steps for s and t together: the root of the sextic alone loses digits on lines that are nearly level.
    fn polish(&self, ray: &Ray, mut s: f64, mut t: f64) -> (f64, f64) {
        let (o, d) = (ray.origin.truncate(), ray.direction.truncate());
        for _ in 0..3 {
            let ((x, dx), (y, dy)) = (evaluate(&self.piece.x, t), evaluate(&self.piece.y, t));
            let at = o + d * s;
            let (f, g) = (ray.origin.z + s * ray.direction.z - y, at.length_squared() - x * x);
            let (fs, ft, gs, gt) = (ray.direction.z, -dy, 2.0 * at.dot(d), -2.0 * x * dx);
            let determinant = fs * gt - ft * gs;
            let (ds, dt) = ((f * gt - g * ft) / determinant, (g * fs - f * gs) / determinant);
            // Where the line touches the surface the step is wild; what there was is good enough.
            if !(ds.abs() < 1e-3 && dt.abs() < 1e-3) {
                break;
            }
            s -= ds;
            t -= dt;
        }
        (s, t.clamp(0.0, 1.0))
    }
}

/// Moves a line that meets the axis a little aside. Through the very pole its crossing would be a double root, a touch; the
/// polish, which takes the true line, takes the move back.
fn beside_axis(o: DVec3, d: DVec3) -> DVec3 {
    let flat = d.truncate();
    let aside = DVec2::new(flat.y, -flat.x).try_normalize().unwrap_or(DVec2::X);
    let miss = if flat == DVec2::ZERO { o.truncate().length() } else { o.truncate().dot(aside) };
    let nudge = if miss < 0.0 { -NUDGE } else { NUDGE };
    if miss.abs() < NUDGE { o + (aside * nudge).extend(0.0) } else { o }
}

impl Surface for Lathe {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        // Measure from the ray's nearest point to the foot: a far eye then costs no digits.
        let middle = (self.foot - ray.origin).dot(ray.direction);
        let near = Ray { origin: ray.at(middle) - self.foot, direction: ray.direction };
        if !self.bound.meets(&near) {
            return None;
        }
        let mut best: Option<(f64, f64, &Part)> = None;
        for part in self.parts.iter().filter(|p| p.ring.meets(&near)) {
            part.crossings(&near, |s, t| {
                let visible = s + middle > 0.0 && s + middle <= FAR;
                if visible && best.is_none_or(|(nearest, ..)| s < nearest) {
                    best = Some((s, t, part));
                }
            });
        }
        let (s, t, part) = best?;

        let p = near.at(s);
        let ((_, dx), (_, dy)) = (evaluate(&part.piece.x, t), evaluate(&part.piece.y, t));
        let outward = DVec2::new(p.x, p.y).try_normalize().unwrap_or(DVec2::NEG_Y);
        let rate = part.v[1] - part.v[0];
        Some(Hit {
            distance: s + middle,
            point: p + self.foot,
            normal: (outward * dy).extend(-dx).normalize(),
            uv: DVec2::new(turn(p.x, p.y), part.v[0] + rate * t),
            dpdu: around(p.x, p.y),
            dpdv: (outward * dx).extend(dy) / rate,
        })
    }

    fn holds(&self, point: DVec3) -> bool {
        // From inside, the first surface in any direction is met from behind; this one is along nothing of note.
        let ray = Ray { origin: point, direction: DVec3::new(0.62, 0.53, 0.58).normalize() };
        self.hit(&ray).is_some_and(|hit| hit.normal.dot(ray.direction) > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::spline::polyline;
    use super::super::vase::{HEIGHT, vase};
    use super::*;

    #[test]
    fn the_outline_of_the_vase_is_closed() {
        let vase = vase();
        let ends = |part: &Part| {
            [0.0, 1.0].map(|t| DVec2::new(evaluate(&part.piece.x, t).0, evaluate(&part.piece.y, t).0))
        };
        for pair in vase.parts.windows(2) {
            assert!(ends(&pair[0])[1].distance(ends(&pair[1])[0]) < 1e-12, "{:?}", ends(&pair[0])[1]);
            assert_eq!(pair[0].v[1], pair[1].v[0]);
        }
        let (first, last) = (&vase.parts[0], &vase.parts[vase.parts.len() - 1]);
        assert_eq!(ends(first)[0], DVec2::ZERO);
        assert!(ends(last)[1].x.abs() < 1e-12);
        assert_eq!((first.v[0], last.v[1]), (0.0, 2.0));
        // Only the axis may be at 0, and nothing is above the lip.
        for part in &vase.parts {
            for i in 1..100 {
                let t = f64::from(i) / 100.0;
                assert!(evaluate(&part.piece.x, t).0 > 0.0);
                assert!(evaluate(&part.piece.y, t).0 <= HEIGHT + 1e-9);
            }
        }
    }

    #[test]
    fn a_straight_outline_is_a_cylinder() {
        let lathe = Lathe::new(
            DVec3::new(1.0, 2.0, 3.0),
            &polyline(&[[0.0, 0.0], [0.5, 0.0], [0.5, 2.0], [0.0, 2.0]]),
            3,
        );
        for slope in [0.0, 1e-12, 1e-7, 1e-5, -1e-3, 0.05] {
            let direction = DVec3::new(0.0, 1.0, slope).normalize();
            let ray = Ray { origin: DVec3::new(1.3, -10.0, 4.0), direction };
            let hit = lathe.hit(&ray).expect("a hit");
            let expected = DVec3::new(1.3, 1.6, 4.0 + 11.6 * slope);
            assert!(hit.point.distance(expected) < 1e-10, "{slope}: {}", hit.point);
            assert!(hit.normal.distance(DVec3::new(0.6, -0.8, 0.0)) < 1e-10, "{slope}: {}", hit.normal);
        }
        let down =
            lathe.hit(&Ray { origin: DVec3::new(1.2, 2.1, 9.0), direction: DVec3::NEG_Z }).expect("a hit");
        assert!(down.point.distance(DVec3::new(1.2, 2.1, 5.0)) < 1e-10 && down.normal == DVec3::Z);
    }

    #[test]
    fn level_and_nearly_level_rays_meet_the_vase_alike() {
        let vase = vase();
        for i in 1..200 {
            // Off the places where the outline itself is level.
            let z = f64::from(i) * 0.0491 + 0.003;
            for x in [0.0, 0.31, 0.87] {
                let hit = |slope: f64| {
                    let direction = DVec3::new(0.0, 1.0, slope).normalize();
                    vase.hit(&Ray { origin: DVec3::new(x, -20.0, z), direction })
                };
                let level = hit(0.0).expect("a hit");
                for slope in [1e-9, -1e-9, 0.99e-6, 1.01e-6, -1.01e-6, 1e-5] {
                    let other = hit(slope).expect("a hit");
                    let most = 1e-9 + 200.0 * slope.abs();
                    assert!(level.point.distance(other.point) < most, "{z} {x} {slope}: {}", other.point);
                }
            }
        }
    }

    #[test]
    fn the_wall_is_solid_and_the_cavity_is_not() {
        let vase = vase();
        for (point, inside) in [
            ([3.2, 0.0, 5.75], true),
            ([0.0, 3.4, 5.75], false),
            ([0.5, 0.5, 5.75], false),
            ([0.0, 0.0, 1.0], true),
            ([0.0, 0.0, 2.5], false),
            ([0.0, 0.0, 12.0], false),
        ] {
            assert_eq!(vase.holds(point.into()), inside, "{point:?}");
        }
    }

    #[test]
    fn no_ray_slips_through_a_pole() {
        let (vase, pole) = (vase(), DVec3::Z * 1.9);
        for x in [0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5] {
            for y in [0.0, 0.05, -0.1] {
                for aside in [0.0, 1e-12, 1e-8, 1e-6] {
                    let from = pole + DVec3::new(x, y, 1.0) * 20.0;
                    let ray = Ray { origin: from, direction: (pole + DVec3::X * aside - from).normalize() };
                    let hit = vase.hit(&ray).expect("the bottom inside");
                    let off = hit.point.distance(pole + DVec3::X * aside);
                    assert!(off < 1e-6 && hit.normal.distance(DVec3::Z) < 1e-5, "{x} {y} {aside}: {hit:?}");
                }
            }
        }
    }
}
