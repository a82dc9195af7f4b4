//! The box that a solid lies in.

use super::error::SolidError;
use crate::scene::ray::Ray;
use glam::DVec3;

/// A box along the axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cuboid {
    pub low: DVec3,
    pub high: DVec3,
}

/// The part of a ray that is in the box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub start: f64,
    pub end: f64,
    /// The normal of the face through which the ray comes in; none if it starts inside.
    pub face: Option<DVec3>,
}

impl Cuboid {
    pub fn new([low, high]: [[f64; 3]; 2]) -> Result<Cuboid, SolidError> {
        let (low, high) = (DVec3::from(low), DVec3::from(high));
        let hint = "Give the least and the greatest coordinates: --box -1,-1,-1,1,1,1.";
        if !(low.cmplt(high).all() && (high - low).max_element().is_finite()) {
            return Err(SolidError::new("the box is empty", hint));
        }
        // Points are f32 for programs.
        let size = high - low;
        if low.abs().max(high.abs()).max_element() > 1e4 * size.min_element() {
            return Err(SolidError::new("the box is too thin, or too far from the origin", hint));
        }
        Ok(Cuboid { low, high })
    }

    pub fn size(&self) -> DVec3 {
        self.high - self.low
    }

    pub fn middle(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    pub fn longest(&self) -> f64 {
        self.size().max_element()
    }

    pub fn holds(&self, point: DVec3) -> bool {
        point.cmpge(self.low).all() && point.cmple(self.high).all()
    }

    pub fn corners(&self) -> [DVec3; 8] {
        let pick = |i: usize, axis: usize| if i >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
        std::array::from_fn(|i| DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2)))
    }

    /// How far it is from a point inside to the outside.
    pub fn leave(&self, point: DVec3, direction: DVec3) -> f64 {
        (0..3).fold(f64::INFINITY, |least, axis| match direction[axis] {
            d if d > 0.0 => least.min((self.high[axis] - point[axis]) / d),
            d if d < 0.0 => least.min((self.low[axis] - point[axis]) / d),
            _ => least,
        })
    }

    /// Where a ray is inside.
    pub fn span(&self, ray: &Ray) -> Option<Span> {
        let mut span = Span { start: 0.0, end: f64::INFINITY, face: None };
        for axis in 0..3 {
            let (from, way) = (ray.origin[axis], ray.direction[axis]);
            if way == 0.0 {
                if !(self.low[axis]..=self.high[axis]).contains(&from) {
                    return None;
                }
                continue;
            }
            let (low, high) = ((self.low[axis] - from) / way, (self.high[axis] - from) / way);
            if low.min(high) > span.start {
                span.start = low.min(high);
                span.face = Some(DVec3::AXES[axis] * -way.signum());
            }
            span.end = span.end.min(low.max(high));
        }
        (span.start < span.end).then_some(span)
    }
}
