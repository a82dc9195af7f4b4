//! Hypertexture: what is soft has no surface, but dims what lies behind it and gives off light, all along the ray.

use super::cuboid::Span;
use super::error::SolidError;
use super::field::{Field, MANY, parts};
use crate::parallel::*;
use crate::scene::ray::Ray;
use glam::DVec3;

/// A ray that lets less light than this through is at its end.
const OPAQUE: f64 = 1e-3;

/// What a ray has met, before all that it has not.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gathered {
    /// The absorbed share of the light from behind.
    pub alpha: f64,
    /// The mean distance of the absorption.
    pub distance: f64,
    /// The emitted light that reaches the eye.
    pub color: DVec3,
}

struct Walker {
    index: usize,
    ray: Ray,
    start: f64,
    step: f64,
    steps: usize,
    through: f64,
    gathered: Gathered,
}

/// Integrates the density along each of the rays, in steps of no more than that length.
pub(super) fn gather(
    field: &Field<'_>,
    rays: &[(Ray, Span)],
    step: f64,
    spacing: f64,
) -> Result<Vec<Gathered>, SolidError> {
    let mut all = Vec::with_capacity(rays.len());
    for part in parts(0..rays.len(), MANY) {
        all.extend(some(field, &rays[part], step, spacing)?);
    }
    Ok(all)
}

fn some(
    field: &Field<'_>,
    rays: &[(Ray, Span)],
    step: f64,
    spacing: f64,
) -> Result<Vec<Gathered>, SolidError> {
    let mut all = vec![Gathered::default(); rays.len()];
    let walker = |(index, (ray, span)): (usize, &(Ray, Span))| {
        let length = span.end - span.start;
        let steps = (length / step).ceil().max(1.0);
        let (step, steps) = (length / steps, steps as usize);
        Walker {
            index,
            ray: *ray,
            start: span.start,
            step,
            steps,
            through: 1.0,
            gathered: Gathered::default(),
        }
    };
    let mut walkers: Vec<Walker> = rays.iter().enumerate().map(walker).collect();
    for round in 0.. {
        for walker in walkers.extract_if(.., |w| w.steps == round || w.through < OPAQUE) {
            let Gathered { alpha, distance, color } = walker.gathered;
            let distance = if alpha > 0.0 { distance / alpha } else { 0.0 };
            // What hardly anything comes through is opaque, and then all that was met counts for the whole.
            let whole = if walker.through < OPAQUE { 1.0 / alpha } else { 1.0 };
            all[walker.index] = Gathered { alpha: alpha * whole, distance, color: color * whole };
        }
        if walkers.is_empty() {
            break;
        }
        // In the middle of the step.
        let points: Vec<DVec3> =
            walkers.par_iter().map(|w| w.ray.at(w.start + (round as f64 + 0.5) * w.step)).collect();
        let densities = field.density(&points, spacing)?;
        let dense: Vec<DVec3> =
            points.iter().zip(&densities).filter(|(_, d)| **d > 0.0).map(|(p, _)| *p).collect();
        let mut emissions = match field.has_emission() {
            true => field.emission(&dense, spacing)?,
            false => Vec::new(),
        }
        .into_iter();
        for (walker, density) in walkers.iter_mut().zip(densities).filter(|(_, d)| *d > 0.0) {
            let emission = emissions.next().unwrap_or_default();
            let remains = walker.through * libm::exp(-density * walker.step);
            let share = walker.through - remains;
            walker.through = remains;
            let gathered = &mut walker.gathered;
            gathered.alpha += share;
            gathered.distance += share * (walker.start + (round as f64 + 0.5) * walker.step);
            gathered.color += share * emission;
        }
    }
    Ok(all)
}
