//! Finding the surface: all rays go on together, each by a step in which the density cannot reach the level.

use super::cuboid::Span;
use super::error::SolidError;
use super::field::{Bracket, Field, MANY, parts};
use super::slopes::Slopes;
use crate::parallel::*;
use crate::scene::ray::Ray;
use glam::DVec3;

/// The least step, as a share of a pixel's width there; and where the density is flat, just at the level.
const LEAST_STEP: f64 = 1.0 / 64.0;
const FLAT_STEP: f64 = 0.25;

/// The step to both sides for a gradient, as a share of a pixel's width there.
const GRADIENT_STEP: f64 = 0.125;

/// More than the slope's bound allows, which rounding may do.
const TOLERANCE: f64 = 1e-3;

/// What becomes of the doubt in a bound with each step that did not contradict it.
const CALM: f64 = 0.9;

/// What does not change from ray to ray.
pub(super) struct March<'a, 'o> {
    pub field: &'a Field<'o>,
    pub slopes: &'a Slopes,
    /// A pixel's width at distance 1.
    pub pixel: f64,
    /// A pixel is at least so wide.
    pub finest: f64,
    /// The distance of neighbouring points, for the program.
    pub spacing: f64,
}

/// A ray on its way.
struct Walker {
    index: usize,
    ray: Ray,
    end: f64,
    /// Where it is, and how far the density is over the level there: not.
    at: f64,
    value: f64,
    /// Where it goes next.
    step: f64,
    /// How many times the bound, because that was found too low.
    doubt: f64,
    state: State,
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    Going,
    /// Inside at the end of its step, where the value is this.
    Hit(f64),
    Through,
}

/// A place of the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Which of the rays.
    pub index: usize,
    pub point: DVec3,
    /// The unit normal, outwards; zero where the density has no slope.
    pub normal: DVec3,
}

/// What was found, and at what cost.
#[derive(Default)]
pub(super) struct Found {
    pub places: Vec<Place>,
    /// Steps in which the density changed by more than the bound.
    pub doubts: u64,
    /// The maximum number of steps of a ray.
    pub rounds: u64,
}

impl March<'_, '_> {
    /// The first place of the surface on each of the rays.
    pub fn surface(&self, rays: &[(Ray, Span)]) -> Result<Found, SolidError> {
        let mut found = Found::default();
        for part in parts(0..rays.len(), MANY) {
            self.some(rays, part.start, &rays[part], &mut found)?;
        }
        Ok(found)
    }

    fn some(
        &self,
        all: &[(Ray, Span)],
        first: usize,
        rays: &[(Ray, Span)],
        found: &mut Found,
    ) -> Result<(), SolidError> {
        let points: Vec<DVec3> = rays.iter().map(|(ray, span)| ray.at(span.start)).collect();
        let values = self.field.density(&points, self.spacing)?;
        let mut walkers = Vec::new();
        for (i, (((ray, span), value), point)) in rays.iter().zip(values).zip(points).enumerate() {
            match span.face {
                // The box cuts the solid.
                Some(normal) if value > 0.0 => found.places.push(Place { index: first + i, point, normal }),
                _ => walkers.push(Walker {
                    index: first + i,
                    ray: *ray,
                    end: span.end,
                    at: span.start,
                    value: value.min(0.0),
                    step: 0.0,
                    doubt: 1.0,
                    state: State::Going,
                }),
            }
        }
        let mut hits = Vec::new();
        let mut brackets = Vec::new();
        let mut rounds = 0;
        while !walkers.is_empty() {
            rounds += 1;
            walkers.par_iter_mut().for_each(|walker| walker.step = self.step(walker));
            let points: Vec<DVec3> = walkers.par_iter().map(|w| w.ray.at(w.at + w.step)).collect();
            let values = self.field.density(&points, self.spacing)?;
            let doubts = walkers
                .par_iter_mut()
                .zip(&values)
                .map(|(walker, value)| u64::from(self.judge(walker, *value)));
            found.doubts += doubts.sum::<u64>();
            for walker in &walkers {
                if let State::Hit(value) = walker.state {
                    hits.push(walker.index);
                    brackets.push(Bracket {
                        out: (walker.ray.at(walker.at), walker.value),
                        within: (walker.ray.at(walker.at + walker.step), value),
                    });
                }
            }
            walkers.retain(|walker| walker.state == State::Going);
        }
        found.rounds = found.rounds.max(rounds);
        self.field.refine(&mut brackets, self.spacing)?;
        let points: Vec<DVec3> = brackets.iter().map(|b| b.within.0).collect();
        let wide = |i: usize| {
            let step = GRADIENT_STEP * self.width(points[i].distance(all[hits[i]].0.origin));
            // Not so near that the rounding of the density would be a slope.
            step.max(2.5 * self.finest)
        };
        let gradients = self.field.gradient(&points, wide, self.spacing)?;
        for ((index, point), gradient) in hits.into_iter().zip(points.iter().copied()).zip(gradients) {
            found.places.push(Place { index, point, normal: -gradient.normalize_or_zero() });
        }
        Ok(())
    }

    /// How wide a pixel is at a distance.
    fn width(&self, distance: f64) -> f64 {
        (self.pixel * distance).max(self.finest)
    }

    /// The least step of a walker.
    fn least(&self, walker: &Walker) -> f64 {
        self.width(walker.at) * if walker.value == 0.0 { FLAT_STEP } else { LEAST_STEP }
    }

    /// How far a walker may go.
    fn step(&self, walker: &Walker) -> f64 {
        let (bound, reach) = self.slopes.at(walker.ray.at(walker.at), walker.ray.direction);
        let safe = -walker.value / (bound * walker.doubt);
        safe.min(reach).max(self.least(walker)).min(walker.end - walker.at)
    }

    /// Takes the step, or not. Was the bound contradicted?
    fn judge(&self, walker: &mut Walker, value: f64) -> bool {
        let value = self.slopes.cap(value);
        let (bound, _) = self.slopes.at(walker.ray.at(walker.at), walker.ray.direction);
        let most = bound * walker.doubt * walker.step * (1.0 + TOLERANCE);
        if (value - walker.value).abs() > most && walker.step > self.least(walker) {
            walker.doubt *= 2.0;
            return true;
        }
        if value > 0.0 {
            walker.state = State::Hit(value);
            return false;
        }
        walker.at += walker.step;
        walker.value = value;
        walker.doubt = (walker.doubt * CALM).max(1.0);
        if walker.at >= walker.end {
            walker.state = State::Through;
        }
        false
    }
}
