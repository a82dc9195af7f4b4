//! A run with several samples of each pixel: a pass over all pixels for each sample, and the mean of what the passes
//! gave.

use super::bind::{Bound, bind};
use super::output::Output;
use super::run::{Attempt, Failure, Job, Report};
use super::samples::{Places, is_id};
use crate::diagnostic::Diagnostic;
use crate::image::Image;
use crate::parallel::*;
use std::sync::Mutex;

impl Job<'_> {
    /// Runs the whole image with the shapes known so far: once, or for each sample.
    pub fn samples(&self) -> Result<Attempt, Failure> {
        let parts = Mutex::new(Vec::new());
        let Some(sampling) = self.options.sampling() else { return self.attempt(&parts) };
        // Where neighbours are compared they must be a pixel apart.
        let sized = |name: &str| matches!(name, "pixelsize" | "pixel_freq");
        let reads_size = self.program.globals.iter().any(|g| g.read.is_some() && sized(&g.name));
        let alike = self.options.resample.is_some() && (self.program.derivatives || reads_size);
        let (mut sums, mut whole) = (Sums::default(), None::<Box<Report>>);
        let mut wrong: Option<Failure> = None;
        for sample in 0..sampling.count {
            let places = Places::new(sampling, sample, alike);
            match self.sample_at(places) {
                Err(Failure::Cancelled) => return Err(Failure::Cancelled),
                Err(failure) => {
                    // A later sample may go wrong at an earlier pixel.
                    if wrong.as_ref().is_none_or(|wrong| failure.place() < wrong.place()) {
                        wrong = Some(failure);
                    }
                }
                Ok(_) if wrong.is_some() => {}
                Ok(Attempt::Again(misfit)) => return Ok(Attempt::Again(misfit)),
                Ok(Attempt::Done(report)) => {
                    sums.add(&report.image, &places);
                    match &mut whole {
                        None => whole = Some(report),
                        Some(whole) => whole.add(*report),
                    }
                }
            }
        }
        if let Some(failure) = wrong {
            return Err(failure);
        }
        // There is at least one sample.
        let Some(mut report) = whole else { return Err(Failure::Cancelled) };
        sums.finish(&mut report.image, &self.outputs);
        let assigned = |name: &str| self.outputs.iter().any(|o| o.name == name && o.slot.is_some());
        report.not_finite = report.image.not_finite(assigned);
        Ok(Attempt::Done(report))
    }

    /// Runs one sample of each pixel.
    fn sample_at(&self, places: Places) -> Result<Attempt, Failure> {
        let Some(resample) = self.options.resample else {
            return Job { places: Some(places), ..self.clone() }.attempt(&Mutex::default());
        };
        let Some(image) = self.image else { return Err(Failure::Cancelled) };
        let sampled = resample(image, &places)
            .map_err(|e| Failure::Program(vec![Diagnostic::bare("input", e.message())]))?;
        let bound: Bound<'_> = bind(self.program, image, Some(&sampled), self.options)?;
        Job { places: Some(places), bound: &bound, ..self.clone() }.attempt(&Mutex::default())
    }
}

impl Failure {
    /// The pixel at which the program went wrong, row first; first of all what is no pixel's fault.
    fn place(&self) -> Option<[i32; 2]> {
        match self {
            Failure::Program(errors) => errors.first()?.pixel.map(|[column, row]| [row, column]),
            Failure::Cancelled => None,
        }
    }
}

impl Report {
    /// Adds what another sample took.
    fn add(&mut self, other: Report) {
        self.time += other.time;
        self.threads = self.threads.max(other.threads);
        if let (Some(all), Some(more)) = (&mut self.profile, other.profile) {
            more.into_iter().for_each(|(place, spent)| all.entry(place).or_default().add(&spent));
        }
    }
}

/// Sums of the outputs over samples.
#[derive(Default)]
struct Sums {
    /// Of each plane of each output.
    planes: Vec<Vec<f64>>,
    /// Of the weights.
    weights: Vec<f64>,
    /// The sums without signs, where those would leave nothing to divide by.
    plain: Vec<Vec<f64>>,
    samples: u32,
}

impl Sums {
    /// Adds the outputs of a sample.
    fn add(&mut self, image: &Image<'_>, places: &Places) {
        let (width, [x, y]) = (image.width.max(1), image.metadata.origin);
        let signed = places.signed();
        let count = image.width * image.height;
        let zeros = || vec![vec![0.0; count]; image.variables.iter().map(|v| v.planes.len()).sum()];
        if self.planes.is_empty() {
            self.planes = zeros();
            self.plain = if signed { zeros() } else { Vec::new() };
            self.weights = vec![0.0; if signed { count } else { 0 }];
        }
        self.samples += 1;
        let planes = || image.variables.iter().flat_map(|v| &v.planes);
        if !signed {
            for (sums, plane) in self.planes.iter_mut().zip(planes()) {
                sums.iter_mut().zip(&**plane).for_each(|(sum, x)| *sum += f64::from(*x));
            }
            return;
        }
        let place = |i: usize| [(i % width) as i32 + x, (i / width) as i32 + y];
        let weights: Vec<f64> = (0..count).into_par_iter().map(|i| places.weight(place(i))).collect();
        self.weights.iter_mut().zip(&weights).for_each(|(sum, w)| *sum += w);
        for ((sums, plain), plane) in self.planes.iter_mut().zip(&mut self.plain).zip(planes()) {
            for (((sum, plain), x), w) in sums.iter_mut().zip(plain).zip(&**plane).zip(&weights) {
                *sum += f64::from(*x) * w;
                *plain += f64::from(*x);
            }
        }
    }

    /// Writes the means to the outputs that the program has assigned, but ids.
    fn finish(self, image: &mut Image<'static>, outputs: &[Output]) {
        let samples = f64::from(self.samples);
        let mut sums = self.planes.iter().enumerate();
        for (variable, output) in image.variables.iter_mut().zip(outputs) {
            for (plane, (k, sums)) in variable.planes.iter_mut().zip(&mut sums) {
                if output.slot.is_none() || is_id(&output.name) {
                    continue;
                }
                for (i, out) in plane.to_mut().iter_mut().enumerate() {
                    let mean = match self.weights.get(i) {
                        // Fewer than half a sample in four: what is left would be noise many times over.
                        Some(&weight) if weight < 0.25 * samples => self.plain[k][i] / samples,
                        Some(weight) => sums[i] / weight,
                        None => sums[i] / samples,
                    };
                    *out = if mean.is_nan() { f32::NAN } else { mean as f32 };
                }
            }
        }
    }
}
