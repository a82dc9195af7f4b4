//! The program's functions, asked at many points at once.

use super::error::SolidError;
use crate::image::Variable;
use crate::parallel::*;
use crate::program::{Compiler, Program, RunOptions};
use crate::resolve::NO_FUNCTION;
use crate::shape::Shape;
use glam::DVec3;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// So many points are asked in one run, at most: a run has a cost of its own, and its values take memory.
pub(super) const MANY: usize = 1 << 18;

/// The functions of a program that tell of a solid.
pub(super) struct Field<'o> {
    density: Program,
    gradient: Option<Program>,
    emission: Option<Program>,
    options: RunOptions<'o>,
    level: f64,
    /// The number of evaluations of the density.
    asked: AtomicU64,
}

impl<'o> Field<'o> {
    /// Compiles them. All but `density` may be missing.
    pub fn new(
        compiler: &Compiler<'_>,
        name: &str,
        text: &str,
        level: f64,
        options: &RunOptions<'o>,
    ) -> Result<Field<'o>, SolidError> {
        let compile = |function: &str| compiler.clone().entrance(function, &["point"]).compile(name, text);
        let optional = |function: &str| match compile(function) {
            Err(error) if error.diagnostics.iter().all(|d| d.code == NO_FUNCTION) => Ok(None),
            other => other.map(Some),
        };
        let density = compile("density")?;
        let (gradient, emission) = (optional("gradient")?, optional("emission")?);
        let asked = AtomicU64::new(0);
        Ok(Field { density, gradient, emission, options: options.clone(), level, asked })
    }

    /// The compiled program for the density.
    pub fn program(&self) -> &Program {
        &self.density
    }

    /// Whether the program has a function `gradient`.
    pub fn has_gradient(&self) -> bool {
        self.gradient.is_some()
    }

    /// Whether the program has a function `emission`.
    pub fn has_emission(&self) -> bool {
        self.emission.is_some()
    }

    /// The number of evaluations of the density.
    pub fn asked(&self) -> u64 {
        self.asked.load(Ordering::Relaxed)
    }

    /// How far the density is over the level at some points, whose neighbours are `spacing` away. Infinities are large
    /// numbers.
    pub fn density(&self, points: &[DVec3], spacing: f64) -> Result<Vec<f64>, SolidError> {
        self.asked.fetch_add(points.len() as u64, Ordering::Relaxed);
        let mut all = Vec::with_capacity(points.len());
        for points in points.chunks(MANY) {
            let planes = self.ask(&self.density, "density", points, spacing)?;
            let [plane] = &planes[..] else {
                let message = format!("`density(point)` gives a vector of {}", planes.len());
                return Err(SolidError::new(
                    message,
                    "Return one number: above the level inside, below it outside.",
                ));
            };
            if let Some(i) = plane.iter().position(|x| x.is_nan()) {
                let message = format!("`density` is NaN at {}", written(points[i]));
                return Err(SolidError::new(message, "Return a number at every point of the box."));
            }
            let limit = f64::from(f32::MAX);
            all.extend(plane.iter().map(|&x| f64::from(x).clamp(-limit, limit) - self.level));
        }
        Ok(all)
    }

    /// The gradients of the density: what `gradient` gives, or else central differences over `steps` to both sides.
    pub fn gradient(
        &self,
        points: &[DVec3],
        steps: impl Fn(usize) -> f64 + Sync,
        spacing: f64,
    ) -> Result<Vec<DVec3>, SolidError> {
        if let Some(program) = &self.gradient {
            return self.vectors(program, "gradient", points, spacing);
        }
        let mut all = Vec::with_capacity(points.len());
        for (chunk, part) in points.chunks(MANY / 6).enumerate() {
            let step = |i: usize| steps(chunk * (MANY / 6) + i);
            let around = |(i, &p): (usize, &DVec3)| {
                DVec3::AXES
                    .into_iter()
                    .flat_map(move |axis| [1.0, -1.0].map(|side| (i, p + axis * side * step(i))))
            };
            let places: Vec<DVec3> = part.iter().enumerate().flat_map(around).map(|(_, p)| p).collect();
            let values = self.density(&places, spacing)?;
            // The points are rounded when they are asked: what counts is how far apart they are then.
            let apart = |i: usize, axis: usize| {
                f64::from(places[i][axis] as f32) - f64::from(places[i + 1][axis] as f32)
            };
            all.extend((0..part.len()).map(|i| {
                let slope = |axis: usize| {
                    let at = 6 * i + 2 * axis;
                    (values[at] - values[at + 1]) / apart(at, axis)
                };
                DVec3::new(slope(0), slope(1), slope(2))
            }));
        }
        Ok(all)
    }

    /// Evaluates the emission at some points, as colours.
    pub fn emission(&self, points: &[DVec3], spacing: f64) -> Result<Vec<DVec3>, SolidError> {
        match &self.emission {
            Some(program) => self.vectors(program, "emission", points, spacing),
            None => Ok(vec![DVec3::ZERO; points.len()]),
        }
    }

    fn vectors(
        &self,
        program: &Program,
        name: &str,
        points: &[DVec3],
        spacing: f64,
    ) -> Result<Vec<DVec3>, SolidError> {
        let mut all = Vec::with_capacity(points.len());
        for points in points.chunks(MANY) {
            let planes = self.ask(program, name, points, spacing)?;
            let [x, y, z] = &planes[..] else {
                let message = format!("`{name}(point)` gives {} numbers", planes.len());
                return Err(SolidError::new(message, "Return a vector of 3."));
            };
            let vector = |i| DVec3::new(f64::from(x[i]), f64::from(y[i]), f64::from(z[i]));
            if let Some(i) = (0..points.len()).find(|&i| !vector(i).is_finite()) {
                let message = format!("`{name}` is {} at {}", vector(i), written(points[i]));
                return Err(SolidError::new(message, "Return finite numbers: look for a division by 0."));
            }
            all.extend((0..points.len()).map(vector));
        }
        Ok(all)
    }

    /// The planes of what a function gives.
    fn ask(
        &self,
        program: &Program,
        name: &str,
        points: &[DVec3],
        spacing: f64,
    ) -> Result<Vec<Vec<f32>>, SolidError> {
        let plane = |axis: usize| -> Vec<f32> { points.par_iter().map(|p| p[axis] as f32).collect() };
        let planes = [0, 1, 2].map(plane).map(Into::into).into();
        let point = Variable { name: "point".into(), shape: Shape::Vector(3), planes };
        let pixelsize = self.options.pixelsize.or(Some(spacing as f32));
        let options = RunOptions { pixelsize, ..self.options.clone() };
        Ok(program.ask(name, vec![point], &options)?)
    }
}

/// Places on straight lines, each between one outside and one inside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bracket {
    /// The outer end, and the density above the level there (not positive).
    pub out: (DVec3, f64),
    /// The inner end, and the density above the level there.
    pub within: (DVec3, f64),
}

/// A bracket is halved at least in so many rounds, however well the secant does.
const PATIENCE: usize = 3;

impl Field<'_> {
    /// Narrows brackets until both ends are the same or neighbouring points, as `f32` go: the first point inside is what
    /// they come to.
    pub fn refine(&self, brackets: &mut [Bracket], spacing: f64) -> Result<(), SolidError> {
        for start in (0..brackets.len()).step_by(MANY) {
            let part = start..brackets.len().min(start + MANY);
            self.refine_some(&mut brackets[part], spacing)?;
        }
        Ok(())
    }

    fn refine_some(&self, brackets: &mut [Bracket], spacing: f64) -> Result<(), SolidError> {
        let mut open: Vec<Open> = (0..brackets.len()).map(|i| Open::new(i, &brackets[i])).collect();
        loop {
            open.retain(|open| !is_narrow(&brackets[open.index]));
            if open.is_empty() {
                return Ok(());
            }
            let points: Vec<DVec3> = open.par_iter().map(|open| open.next(&brackets[open.index])).collect();
            let values = self.density(&points, spacing)?;
            for ((open, point), value) in open.iter_mut().zip(points).zip(values) {
                open.learn(&mut brackets[open.index], point, value);
            }
        }
    }
}

/// Is there hardly an `f32` between both ends?
fn is_narrow(bracket: &Bracket) -> bool {
    let (a, b) = (bracket.out.0, bracket.within.0);
    let size = a.abs().max(b.abs()).max_element();
    (a - b).abs().max_element() <= f64::from(f32::EPSILON) * size
}

/// A bracket that is being narrowed.
struct Open {
    index: usize,
    /// What the secant takes for the values at the ends: those of the ends, or less where an end has stayed.
    values: [f64; 2],
    /// Which end has moved last.
    moved: Option<bool>,
    round: usize,
    /// How long it was when it was last halved.
    length: f64,
}

impl Open {
    fn new(index: usize, bracket: &Bracket) -> Open {
        let values = [bracket.out.1, bracket.within.1];
        Open { index, values, moved: None, round: 0, length: bracket.out.0.distance(bracket.within.0) }
    }

    /// Where to look next: where the secant goes through the level, or in the middle where that was of little help.
    fn next(&self, bracket: &Bracket) -> DVec3 {
        let [out, within] = self.values;
        let share = out / (out - within);
        let halve = self.round % PATIENCE == PATIENCE - 1
            && bracket.out.0.distance(bracket.within.0) > self.length / 4.0;
        // Not `<`: a NaN must be halved too.
        let share = if halve || !(share > 0.0 && share < 1.0) { 0.5 } else { share };
        // A little from the ends, so that both close in.
        bracket.out.0.lerp(bracket.within.0, share.clamp(0.01, 0.99))
    }

    fn learn(&mut self, bracket: &mut Bracket, point: DVec3, value: f64) {
        let inside = value > 0.0;
        let [out, within] = &mut self.values;
        match inside {
            true => {
                (bracket.within, *within) = ((point, value), value);
                *out /= if self.moved == Some(true) { 2.0 } else { 1.0 };
            }
            false => {
                (bracket.out, *out) = ((point, value), value);
                *within /= if self.moved == Some(false) { 2.0 } else { 1.0 };
            }
        }
        self.moved = Some(inside);
        if self.round % PATIENCE == PATIENCE - 1 {
            self.length = bracket.out.0.distance(bracket.within.0);
        }
        self.round += 1;
    }
}

/// Parts of a range that are asked one after another.
pub(super) fn parts(all: Range<usize>, many: usize) -> impl Iterator<Item = Range<usize>> {
    let end = all.end;
    all.step_by(many.max(1)).map(move |start| start..end.min(start + many.max(1)))
}

/// A point as the command line takes it.
pub(super) fn written(point: DVec3) -> String {
    let [x, y, z] = point.to_array().map(|c| c as f32);
    format!("{x},{y},{z}")
}
