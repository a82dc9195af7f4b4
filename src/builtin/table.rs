//! Vectors as tables: linear between their elements, with exact means over a width.

use super::apply::each_scalar;
use super::call::{Call, Fault};
use crate::value::{Lanes, Plane, Value};

/// Narrower than this part of a piece, a mean is the value itself.
const POINT: f64 = 1e-5;

/// One lane's table: its knots, and where its areas are wanted what lies below it left of each knot.
struct Lane<'a> {
    knots: &'a [f64],
    areas: &'a [f64],
    periodic: bool,
}

impl Lane<'_> {
    /// Pieces between knots.
    fn pieces(&self) -> f64 {
        (if self.periodic { self.knots.len() } else { self.knots.len() - 1 }) as f64
    }

    /// The knots on both sides of a place, its number of pieces from the first, and how far it is beyond it.
    fn piece(&self, u: f64) -> (usize, [f64; 2], f64) {
        let whole = u.floor().clamp(0.0, (self.pieces() - 1.0).max(0.0));
        let (i, n) = (whole as usize, self.knots.len());
        let next = if self.periodic { (i + 1) % n } else { (i + 1).min(n - 1) };
        (i, [self.knots[i], self.knots[next]], u - whole)
    }

    /// The value at a place from 0 to the number of pieces.
    fn value(&self, u: f64) -> f64 {
        let (_, [a, b], f) = self.piece(u);
        a + (b - a) * f
    }

    /// The area from 0 to any place.
    fn area(&self, u: f64) -> f64 {
        let end = self.pieces();
        let inside = |u: f64| {
            let (i, [a, b], f) = self.piece(u);
            self.areas[i] + f * (a + 0.5 * (b - a) * f)
        };
        let last = self.knots.len() - 1;
        if self.periodic {
            let rounds = (u / end).floor();
            rounds * self.areas[last + 1] + inside(u - rounds * end)
        } else if u <= 0.0 {
            u * self.knots[0]
        } else if u >= end {
            self.areas[last] + (u - end) * self.knots[last]
        } else {
            inside(u)
        }
    }

    /// The mean over a width about x.
    fn mean(&self, x: f32, width: f32) -> f32 {
        let (x, width) = (f64::from(x), f64::from(width).abs());
        // Before all else: bounds that are NaN would be a panic of clamp.
        if x.is_nan() || width.is_nan() {
            return f32::NAN;
        }
        // Farther out, and wider, there is nothing new; near places keep their precision.
        let width = width.clamp(0.0, 1e6);
        let x = if self.periodic { x - x.floor() } else { x.clamp(-0.5 * width, 1.0 + 0.5 * width) };
        let (u, width) = (x * self.pieces(), width * self.pieces());
        if width < POINT {
            return self.value(u) as f32;
        }
        ((self.area(u + 0.5 * width) - self.area(u - 0.5 * width)) / width) as f32
    }
}

/// What lies below the lines left of each knot.
fn sum(knots: &[f64], areas: &mut Vec<f64>) {
    areas.clear();
    let mut area = 0.0;
    for (i, knot) in knots.iter().enumerate() {
        areas.push(area);
        area += 0.5 * (knot + knots[(i + 1) % knots.len()]);
    }
    // Once around.
    areas.push(area);
}

/// One cell of the table at x.
fn cell(call: &Call<'_>, knots: &[&Plane], x: &Plane, width: &Plane, periodic: bool) -> Plane {
    let wide = !matches!(width, Plane::Uniform(0.0));
    let mut numbers: Vec<f64> = knots.iter().map(|k| f64::from(k.lane(0))).collect();
    let mut areas = Vec::new();
    if wide {
        sum(&numbers, &mut areas);
    }
    if knots.iter().all(|k| matches!(k, Plane::Uniform(_))) {
        let lane = Lane { knots: &numbers, areas: &areas, periodic };
        return call.lane([x, width], |[x, width]| lane.mean(x, width));
    }
    let spread: Vec<Lanes> = knots.iter().map(|k| k.spread(call.n)).collect();
    let spread: Vec<&[f32]> = spread.iter().map(|k| k.get(call.n)).collect();
    let (x, width) = (x.spread(call.n), width.spread(call.n));
    let (x, width) = (x.get(call.n), width.get(call.n));
    Plane::filled(call.n, |out| {
        for (i, out) in out.iter_mut().enumerate() {
            numbers.iter_mut().zip(&spread).for_each(|(number, knot)| *number = knot[i].into());
            if wide {
                sum(&numbers, &mut areas);
            }
            *out = Lane { knots: &numbers, areas: &areas, periodic }.mean(x[i], width[i]);
        }
    })
}

/// `table(v, x, width, wrap)`.
pub fn table(call: &Call<'_>) -> Result<Value, Fault> {
    let elements: Vec<Value> = call.args[0].elements().collect();
    let Some(first) = elements.first() else {
        let found = if call.args[0].shape.is_scalar() { "a scalar" } else { "an empty one" };
        return Err(Fault::of(0, format!("table needs a vector, found {found}")));
    };
    if let Some(odd) = elements.iter().find(|e| e.shape != first.shape) {
        let message = format!("table needs elements of one shape, found {} and {}", first.shape, odd.shape);
        return Err(Fault::of(0, message));
    }
    let (width, periodic) = (call.scalar(2)?, call.args[3].as_uniform() == Some(1.0));
    call.room(first.planes.len().saturating_mul(call.args[1].planes.len()))?;
    each_scalar(&call.args[1], &mut |x| {
        let planes = (0..first.planes.len()).map(|c| {
            let knots: Vec<&Plane> = elements.iter().map(|e| &e.planes[c]).collect();
            cell(call, &knots, x, width, periodic)
        });
        Ok(Value { shape: first.shape.clone(), planes: planes.collect() })
    })
}

#[cfg(test)]
mod tests {
    use super::Lane;

    #[test]
    fn nan_gives_nan() {
        let lane = |periodic| Lane { knots: &[1.0, 3.0], areas: &[0.0, 2.0, 4.0], periodic };
        for periodic in [false, true] {
            assert!(lane(periodic).mean(0.5, f32::NAN).is_nan());
            assert!(lane(periodic).mean(f32::NAN, 0.5).is_nan());
        }
    }
}
