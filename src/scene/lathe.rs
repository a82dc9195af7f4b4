//! Solids of revolution: a profile of cubic pieces turned about the z axis.

use super::bernstein::{Roots, evaluate, to_bernstein};
use super::ray::{FAR, Hit, Ray, Surface, around, turn};
use super::spline::Piece;
use glam::{DVec2, DVec3};

/// Pieces overlap by this share of their parameter, so that no ray slips through between two.
const OVERLAP: f64 = 1e-9;

/// Below this slope a ray counts as horizontal: its two crossings of a piece lie too close in t for the general way.
const LEVEL: f64 = 1e-6;

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
            bx[0] += d.z * o.x;
            by[0] += d.z * o.y;
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
        // Going straight outward from inside, the outline is crossed an odd number of times.
        let p = point - self.foot;
        let across = libm::hypot(p.x, p.y);
        let mut inside = false;
        for part in &self.parts {
            let mut height = part.piece.y;
            height[0] -= p.z;
            for &t in Roots::of(&height, 0.0, 1.0).as_slice() {
                inside ^= evaluate(&part.piece.x, t).0 >= across - 1e-9;
            }
        }
        inside
    }
}
