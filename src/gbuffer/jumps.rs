//! Points that jump from pixel to pixel within one surface.
//!
//! Renderers take the position from one sample of each pixel. With depth of field or motion blur that is a random one, and blurred
//! parts are noise. On a smooth surface the second difference of three neighbours is much smaller than the first; at a silhouette
//! both are equal; where the three are independent it is larger. Thin parts go on in some direction, so the second
//! difference has to be larger along the row and along the column.

use super::projection::Projection;
use crate::image::{Image, Variable};
use crate::shape::Shape;
use glam::{DVec2, DVec3};
use half::f16;

/// How much larger than the first difference the second one is where a point jumps.
const RATIO: f64 = 1.5;

/// How far from the middle of its pixel, in pixels, the camera sees a point that was taken from another ray.
const OFF_RAY: f64 = 0.25;

/// The share of pixels that jump in noisy points. Of hairy surfaces about a tenth jump without noise, and of positions that lossy
/// compression has changed up to 0.8 %.
const SHARE: f64 = 0.015;

/// The most jumps of which the places are remembered.
const MAX_JUMPS: usize = 1 << 20;

/// Counts the pixels whose point jumps, in an image that is read in bands of rows.
#[derive(Default)]
pub struct JumpCounter {
    /// Pixels whose neighbours along the row and the column are of the same surface.
    tested: usize,
    jumps: usize,
    /// The first jumps: the point, and the middle of its pixel.
    places: Vec<(DVec3, DVec2)>,
}

/// The noise of an image's points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jumps {
    /// Pixels whose point jumps; if the camera is known, only those that are off their pixel's ray.
    pub jumps: usize,
    /// Pixels within a surface.
    pub tested: usize,
    /// Whether there are so many jumps that the points are noise.
    pub noisy: bool,
}

impl JumpCounter {
    /// Counts in some rows of the image, all but the first and the last, which are there as neighbours.
    pub fn add(&mut self, band: &Image<'_>) {
        let Some(point) = band.variable("point").filter(|v| v.shape == Shape::Vector(3)) else { return };
        let surface = band.variable("surface").filter(|v| v.shape == Shape::Scalar);
        let [left, top] = band.metadata.origin.map(f64::from);
        let width = band.width;
        for row in 1..band.height.saturating_sub(1) {
            for column in 1..width.saturating_sub(1) {
                let at = row * width + column;
                let pairs = [[at - 1, at + 1], [at - width, at + width]];
                let id = |i: usize| surface.map_or(0.0, |s| s.planes[0][i]);
                let of_one_surface = pairs.iter().flatten().all(|&i| id(i) == id(at) && is_point(point, i))
                    && is_point(point, at);
                if !of_one_surface {
                    continue;
                }
                self.tested += 1;
                if pairs.iter().all(|&[a, b]| jumps(point, a, at, b)) {
                    self.jumps += 1;
                    if self.places.len() < MAX_JUMPS {
                        let middle = DVec2::new(column as f64 + left + 0.5, row as f64 + top + 0.5);
                        self.places.push((place(point, at), middle));
                    }
                }
            }
        }
    }

    /// The counts, with the camera if it is known.
    pub fn finish(&self, camera: Option<&Projection>) -> Jumps {
        let Some(camera) = camera else {
            let noisy = self.jumps as f64 > SHARE * self.tested as f64;
            return Jumps { jumps: self.jumps, tested: self.tested, noisy };
        };
        let off = |(point, middle): &&(DVec3, DVec2)| {
            camera.depth(*point) <= 0.0 || camera.place(*point).distance(*middle) > OFF_RAY
        };
        let jumps = self.places.iter().filter(off).count();
        Jumps { jumps, tested: self.tested, noisy: jumps as f64 > SHARE * self.tested as f64 }
    }
}

fn place(point: &Variable<'_>, at: usize) -> DVec3 {
    DVec3::from([0, 1, 2].map(|i| f64::from(point.planes[i][at])))
}

/// Whether a pixel has a point, not the background's placeholder.
fn is_point(point: &Variable<'_>, at: usize) -> bool {
    let x = [0, 1, 2].map(|i| point.planes[i][at]);
    x != [0.0; 3] && x.iter().all(|x| x.abs() < super::points::MAX_COORDINATE)
}

/// Whether the point in the middle of three lies far from between the others.
fn jumps(point: &Variable<'_>, before: usize, at: usize, after: usize) -> bool {
    let [a, b, c] = [before, at, after].map(|i| place(point, i));
    let second = (a + c - 2.0 * b).length();
    // Four roundings of half a unit in the last place, and as much again.
    let is_half = |x: f32| f16::from_f32(x).to_f32() == x;
    let halves = point.planes.iter().all(|plane| [before, at, after].iter().all(|&i| is_half(plane[i])));
    let rounding = if halves { 1.0 / 512.0 } else { 1.0 / (1 << 21) as f64 };
    second > RATIO * (a - c).length() && second > rounding * b.abs().max_element()
}
