//! Runs over images that are there as a whole, or come a few rows at a time.

use super::bind::bind;
use super::run::{Attempt, Failure, Job, Options, Report};
use crate::image::Image;
use crate::resolve::Resolved;
use crate::shape::Shape;
use std::ops::Range;

/// Runs a program at every pixel of an image.
pub fn run(program: &Resolved, image: &Image<'_>, options: &Options<'_>) -> Result<Report, Failure> {
    let mut stream = Stream::new(program, options);
    loop {
        // Nothing is lost by beginning again: these are all rows.
        if let Some(report) = stream.rows(image, 0..image.height)? {
            return Ok(report);
        }
    }
}

/// A run over an image that comes a few rows at a time, from the top down.
pub struct Stream<'o> {
    program: &'o Resolved,
    options: &'o Options<'o>,
    /// For each output its shape, and a pixel that has it; nothing before the first rows.
    shapes: Vec<(Shape, Option<[i32; 2]>)>,
}

impl<'o> Stream<'o> {
    /// Before the first rows.
    pub fn new(program: &'o Resolved, options: &'o Options<'o>) -> Stream<'o> {
        Stream { program, options, shapes: Vec::new() }
    }

    /// Runs the next rows, which `image` holds, perhaps with others about them: programs that compare neighbours
    /// need three more above and below.
    ///
    /// `None`: an output has more components here than in the rows before. They must all be run again, from the first
    /// on, and will then have as many.
    pub fn rows(&mut self, image: &Image<'_>, rows: Range<usize>) -> Result<Option<Report>, Failure> {
        let bound = bind(self.program, image, None, self.options)?;
        let mut job = Job::new(self.program, &bound, rows, self.options)?;
        job.image = Some(image);
        let begun = !self.shapes.is_empty();
        if begun {
            for (output, (shape, seen)) in job.outputs.iter_mut().zip(&self.shapes) {
                (output.shape, output.seen) = (shape.clone(), *seen);
            }
        } else {
            job.sample();
        }
        // The shapes that the samples did not show are learnt on the way; each round adds at least one.
        let report = loop {
            match job.samples()? {
                Attempt::Done(report) => break Some(*report),
                Attempt::Again(misfit) => job.widen(misfit)?,
            }
            if begun {
                break None;
            }
        };
        bound.sound(self.program)?;
        self.shapes = job.outputs.into_iter().map(|o| (o.shape, o.seen)).collect();
        Ok(report)
    }
}
