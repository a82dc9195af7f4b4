//! Smooth curves through points of a plane, as pieces of cubic polynomials.

use glam::DVec2;

/// A cubic piece of a curve, for a parameter t in `0..1`. x is the distance from the axis of a lathe, y the height.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// x by powers of t.
    pub x: [f64; 4],
    /// y by powers of t.
    pub y: [f64; 4],
    /// How much longer than t the piece is: the distance between its ends.
    pub chord: f64,
}

impl Piece {
    /// A straight piece.
    fn line(a: DVec2, b: DVec2) -> Piece {
        Piece { x: [a.x, b.x - a.x, 0.0, 0.0], y: [a.y, b.y - a.y, 0.0, 0.0], chord: a.distance(b) }
    }

    /// The piece between two points that has those velocities there, per unit of chord length (Hermite's form).
    fn between(a: DVec2, b: DVec2, leave: DVec2, arrive: DVec2) -> Piece {
        let chord = a.distance(b);
        let (leave, arrive) = (leave * chord, arrive * chord);
        let square = 3.0 * (b - a) - 2.0 * leave - arrive;
        let cube = 2.0 * (a - b) + leave + arrive;
        Piece { x: [a.x, leave.x, square.x, cube.x], y: [a.y, leave.y, square.y, cube.y], chord }
    }
}

/// The straight pieces that join the points.
pub(super) fn polyline(points: &[[f64; 2]]) -> Vec<Piece> {
    points.windows(2).map(|p| Piece::line(p[0].into(), p[1].into())).collect()
}

/// The curve through the points with continuous curvature: a cubic spline over the chord lengths, which leaves the first
/// point and arrives at the last in the given directions. Consecutive points must differ.
pub(super) fn spline(points: &[[f64; 2]], leave: [f64; 2], arrive: [f64; 2]) -> Vec<Piece> {
    let points: Vec<DVec2> = points.iter().map(|&p| p.into()).collect();
    let chords: Vec<f64> = points.windows(2).map(|p| p[0].distance(p[1])).collect();
    let last = points.len() - 1;

    // Equal second derivatives on both sides of each inner point: a tridiagonal system for the velocities.
    let mut velocity = vec![DVec2::ZERO; points.len()];
    let mut ratio = vec![0.0; points.len()];
    velocity[0] = DVec2::from(leave).normalize();
    for i in 1..last {
        let (h, k) = (chords[i - 1], chords[i]);
        let right = 3.0 * ((points[i] - points[i - 1]) * (k / h) + (points[i + 1] - points[i]) * (h / k));
        let pivot = 2.0 * (h + k) - k * ratio[i - 1];
        ratio[i] = h / pivot;
        velocity[i] = (right - velocity[i - 1] * k) / pivot;
    }
    velocity[last] = DVec2::from(arrive).normalize();
    for i in (1..last).rev() {
        velocity[i] = velocity[i] - velocity[i + 1] * ratio[i];
    }
    (0..last).map(|i| Piece::between(points[i], points[i + 1], velocity[i], velocity[i + 1])).collect()
}

#[cfg(test)]
mod tests {
    use super::super::bernstein::evaluate;
    use super::*;

    #[test]
    fn a_spline_meets_its_points_and_bends_smoothly() {
        let points = [[0.0, 0.0], [1.0, 0.5], [1.2, 2.0], [0.4, 2.4], [0.0, 3.0]];
        let pieces = spline(&points, [1.0, 0.0], [-1.0, 1.0]);
        let second = |c: &[f64; 4], t: f64| 2.0 * c[2] + 6.0 * c[3] * t;
        for (i, pair) in pieces.windows(2).enumerate() {
            let (a, b) = (&pair[0], &pair[1]);
            for (ca, cb, at) in [(&a.x, &b.x, points[i + 1][0]), (&a.y, &b.y, points[i + 1][1])] {
                let ((end, leaving), (start, arriving)) = (evaluate(ca, 1.0), evaluate(cb, 0.0));
                assert!((end - at).abs() < 1e-12 && (start - at).abs() < 1e-12);
                assert!((leaving / a.chord - arriving / b.chord).abs() < 1e-12);
                let bend = [second(ca, 1.0) / (a.chord * a.chord), second(cb, 0.0) / (b.chord * b.chord)];
                assert!((bend[0] - bend[1]).abs() < 1e-9, "{bend:?}");
            }
        }
        assert!((pieces[0].y[1]).abs() < 1e-15, "it leaves flat");
    }
}
