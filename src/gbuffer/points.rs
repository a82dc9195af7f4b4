//! The points of an image's surfaces, all of them or a regular sample.

use super::resection::{Resection, ResectionError, solve};
use crate::image::Image;
use crate::shape::Shape;
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// The most points of a sample: enough for what single precision leaves open.
const MAX_POINTS: usize = 40_000;

/// Coordinates from here on are placeholders such as 1e10, not positions.
pub(super) const MAX_COORDINATE: f32 = 1e8;

/// The share of a sample that one exact point may have. A point that more pixels share is the background's.
const MAX_SHARE: f64 = 0.02;

#[cfg(any(test, feature = "flow"))]
/// The point of each pixel, `None` where there is no surface. Nothing for an image without `point`.
pub(crate) fn surfaces<'a>(image: &'a Image<'_>) -> impl Iterator<Item = Option<[f32; 3]>> + 'a {
    let point = image.variable("point").filter(|v| v.shape == Shape::Vector(3));
    let surface = image.variable("surface").filter(|v| v.shape == Shape::Scalar);
    point.into_iter().flat_map(move |point| {
        (0..image.width * image.height).map(move |at| {
            let place = [0, 1, 2].map(|i| point.planes[i][at]);
            // Without numbers of surfaces, the background is where all coordinates are 0.
            let hit = surface.map_or(place != [0.0; 3], |s| s.planes[0][at] > 0.0);
            Some(place).filter(|place| hit && place.iter().all(|x| x.is_finite()))
        })
    })
}

/// A pixel of the sample.
struct Sample {
    /// Column and row of what the image holds.
    at: [usize; 2],
    point: [f32; 3],
    /// Whether the number of its surface is above 0.
    numbered: bool,
}

/// Samples the points of an image that is read in bands of rows. The sample depends on the image alone, not on the bands: it is
/// the pixels of every `n`th row and column, where `n` is the least power of 2 that leaves 40,000 points.
pub struct PointSampler {
    origin: [i32; 2],
    resolution: [usize; 2],
    step: usize,
    samples: Vec<Sample>,
    /// The first row that was not added yet.
    next: usize,
    /// Whether any band had a `point`.
    has_points: bool,
}

impl PointSampler {
    /// A sampler for an image with the size and the windows of `about`.
    pub fn new(about: &Image<'_>) -> PointSampler {
        PointSampler {
            origin: about.metadata.origin,
            resolution: about.resolution(),
            step: 1,
            samples: Vec::new(),
            next: 0,
            has_points: false,
        }
    }

    /// Adds rows of the image, from the top down. Rows that were added before are left out.
    pub fn add(&mut self, band: &Image<'_>) {
        let Some(point) = band.variable("point").filter(|v| v.shape == Shape::Vector(3)) else { return };
        let surface = band.variable("surface").filter(|v| v.shape == Shape::Scalar);
        self.has_points = true;
        let top = (band.metadata.origin[1] - self.origin[1]).max(0) as usize;
        for row in self.next.saturating_sub(top)..band.height {
            for column in 0..band.width {
                let at = [column, top + row];
                if at.iter().any(|i| !i.is_multiple_of(self.step)) {
                    continue;
                }
                let pixel = row * band.width + column;
                let point = [0, 1, 2].map(|i| point.planes[i][pixel]);
                let numbered = surface.is_some_and(|s| s.planes[0][pixel] > 0.0);
                let usable = point.iter().all(|x| x.abs() < MAX_COORDINATE);
                if usable && (numbered || point != [0.0; 3]) {
                    self.samples.push(Sample { at, point, numbered });
                    if self.samples.len() > MAX_POINTS {
                        self.step *= 2;
                        let step = self.step;
                        self.samples.retain(|s| s.at.iter().all(|i| i.is_multiple_of(step)));
                    }
                }
            }
        }
        self.next = self.next.max(top + band.height);
    }

    /// The camera that saw the points.
    ///
    /// # Errors
    /// If no pinhole camera saw them, or they do not determine it.
    pub fn resect(self) -> Result<Resection, ResectionError> {
        if !self.has_points {
            return Err(ResectionError::NoPoints);
        }
        let [left, top] = self.origin;
        let resolution = self.resolution;
        let pairs: Vec<(DVec3, DVec2)> = self
            .surfaces()
            .map(|sample| {
                let [column, row] = sample.at.map(|i| i as f64 + 0.5);
                let center = DVec2::new(column + f64::from(left), row + f64::from(top));
                (DVec3::from(sample.point.map(f64::from)), center)
            })
            .collect();
        solve(&pairs, resolution)
    }

    /// The samples that show a surface.
    fn surfaces(&self) -> impl Iterator<Item = &Sample> {
        // Renderers write 0 for all objects that were given no number: then the numbers say nothing.
        let numbers = self.samples.iter().any(|s| s.numbered);
        let mut counts: HashMap<[u32; 3], usize> = HashMap::new();
        for sample in &self.samples {
            *counts.entry(sample.point.map(f32::to_bits)).or_default() += 1;
        }
        let most = (MAX_SHARE * self.samples.len() as f64).max(4.0) as usize;
        self.samples
            .iter()
            .filter(move |s| (s.numbered || !numbers) && counts[&s.point.map(f32::to_bits)] <= most)
    }
}
