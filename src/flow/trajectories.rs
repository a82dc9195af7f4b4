//! Points that are carried along, step by step.

use super::field::{CHUNK, Field, scalar, vector};
use super::{MAX_POINTS, Vector};
use crate::diagnostic::{Diagnostic, Sources};
use crate::program::{Error, Progress, RunOptions};
use glam::DVec3;

/// The trajectories of seeds, all with the same number of points.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectories {
    /// Steps of each line; it has one point more.
    pub steps: usize,
    /// The points, one line after the other, each from its seed on.
    pub points: Vec<Vector>,
}

impl Trajectories {
    /// The number of lines.
    pub fn lines(&self) -> usize {
        self.points.len() / (self.steps + 1)
    }

    /// The points of a line, the seed first.
    ///
    /// # Panics
    /// If there is no such line.
    pub fn line(&self, index: usize) -> &[Vector] {
        &self.points[index * (self.steps + 1)..][..self.steps + 1]
    }

    /// The age of a point, from 0 at the seed to 1 at the end.
    pub fn age(&self, point: usize) -> f32 {
        (point % (self.steps + 1)) as f32 / self.steps.max(1) as f32
    }

    /// The unit vector along its line at a point, 0 where the line stands still.
    pub fn along(&self, point: usize) -> Vector {
        let (line, at) = (point / (self.steps + 1), point % (self.steps + 1));
        let line = self.line(line);
        let place = |i: usize| DVec3::from(line[i].map(f64::from));
        let way = place((at + 1).min(self.steps)) - place(at.saturating_sub(1));
        way.normalize_or_zero().to_array().map(|x| x as f32)
    }
}

/// Where the seeds go.
pub(super) fn follow(
    velocity: &Field,
    seeds: &[Vector],
    step: f64,
    steps: usize,
    options: &RunOptions<'_>,
) -> Result<Trajectories, Error> {
    let total = seeds.len().checked_mul(steps + 1).filter(|&n| n <= MAX_POINTS);
    let mut points: Vec<Vector> = Vec::new();
    if total.is_none_or(|n| points.try_reserve_exact(n).is_err()) {
        let message = format!("{} lines of {steps} steps are too many points", seeds.len());
        let error = Diagnostic::bare("limit", message).hint(format!("The limit is {MAX_POINTS} in all."));
        return Err(Error { diagnostics: vec![error], sources: Sources::default(), cancelled: false });
    }
    points.resize(seeds.len() * (steps + 1), [0.0; 3]);
    // Lines by the chunk, so that what is between two steps stays small.
    for (chunk, lines) in seeds.chunks(CHUNK).zip(points.chunks_mut(CHUNK * (steps + 1))) {
        let mut place: Vec<DVec3> = chunk.iter().map(|p| DVec3::from(p.map(f64::from))).collect();
        for i in 0..=steps {
            for (line, place) in place.iter().enumerate() {
                lines[line * (steps + 1) + i] = place.to_array().map(|x| x as f32);
            }
            if i < steps {
                advance(velocity, &mut place, step, options)?;
            }
            if let Some(tell) = options.progress {
                let before = (chunk.as_ptr() as usize - seeds.as_ptr() as usize) / size_of::<Vector>();
                let done = before * (steps + 1) + chunk.len() * (i + 1);
                if tell(Progress { done, total: seeds.len() * (steps + 1) }).is_break() {
                    let error = Diagnostic::bare("cancelled", "the run was cancelled");
                    return Err(Error {
                        diagnostics: vec![error],
                        sources: Sources::default(),
                        cancelled: true,
                    });
                }
            }
        }
    }
    Ok(Trajectories { steps, points })
}

/// One step of the classical Runge-Kutta method of fourth order.
fn advance(velocity: &Field, place: &mut [DVec3], step: f64, options: &RunOptions<'_>) -> Result<(), Error> {
    let slopes = |shift: Option<(&[DVec3], f64)>| {
        let at = |i: usize| match shift {
            Some((slope, time)) => place[i] + slope[i] * time,
            None => place[i],
        };
        velocities(velocity, place.len(), at, options)
    };
    let first = slopes(None)?;
    let second = slopes(Some((&first, step / 2.0)))?;
    let third = slopes(Some((&second, step / 2.0)))?;
    let fourth = slopes(Some((&third, step)))?;
    for (i, place) in place.iter_mut().enumerate() {
        *place += (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]) * (step / 6.0);
    }
    Ok(())
}

/// The velocity at each of so many places.
pub(super) fn velocities(
    velocity: &Field,
    count: usize,
    at: impl Fn(usize) -> DVec3,
    options: &RunOptions<'_>,
) -> Result<Vec<DVec3>, Error> {
    let places = (0..count).map(|i| at(i).to_array().map(|x| x as f32));
    let planes = velocity.ask(vec![vector("point", places.clone())], options)?;
    let [x, y, z] = &planes[..] else { return Err(velocity.no_vector(planes.len())) };
    let found: Vec<DVec3> =
        (0..count).map(|i| DVec3::new(f64::from(x[i]), f64::from(y[i]), f64::from(z[i]))).collect();
    if let Some(i) = found.iter().position(|v| !v.is_finite()) {
        let [x, y, z] = at(i).to_array().map(|x| x as f32);
        let [a, b, c] = found[i].to_array();
        let message = format!("`velocity([{x} {y} {z}])` is [{a} {b} {c}]");
        let hint = "Return a finite velocity at every point that lines can reach.";
        return Err(velocity.refuse(message, hint));
    }
    Ok(found)
}

/// The colour at each point, with how opaque the line is.
pub(super) fn colors(
    color: &Field,
    trajectories: &Trajectories,
    options: &RunOptions<'_>,
) -> Result<Vec<[f32; 4]>, Error> {
    let count = trajectories.points.len();
    let mut colors = Vec::with_capacity(count);
    for start in (0..count).step_by(CHUNK) {
        let part = start..count.min(start + CHUNK);
        let arguments = vec![
            vector("point", trajectories.points[part.clone()].iter().copied()),
            scalar("age", part.clone().map(|i| trajectories.age(i)).collect()),
            vector("along", part.clone().map(|i| trajectories.along(i))),
            scalar("line", part.clone().map(|i| (i / (trajectories.steps + 1)) as f32).collect()),
        ];
        let planes = color.ask(arguments, options)?;
        match &planes[..] {
            [grey] => colors.extend(grey.iter().map(|&g| [g, g, g, 1.0])),
            [r, g, b] => colors.extend((0..part.len()).map(|i| [r[i], g[i], b[i], 1.0])),
            [r, g, b, a] => colors.extend((0..part.len()).map(|i| [r[i], g[i], b[i], a[i]])),
            _ => {
                let message = format!("`color()` gives {} numbers", planes.len());
                return Err(color.refuse(message, "Return a vector of 3, or of 4 with the opacity."));
            }
        }
        if let Some(i) = colors[start..].iter().position(|c| !c.iter().all(|x| x.is_finite())) {
            let [x, y, z] = trajectories.points[start + i];
            return Err(color.refuse(
                format!("the colour at [{x} {y} {z}] is not finite"),
                "Look for a division by 0, or a root of a negative number.",
            ));
        }
    }
    Ok(colors)
}
