//! Summed-area tables (Crow 1984): the exact mean of an image over any rectangle, at the same cost for all.
//!
//! The image is taken as texels of constant colour, so its integral is bilinear between the corners of texels.
//! A box of one texel's size is then the same as bilinear interpolation: smaller ones are not needed. Sums are
//! held in f64: those of 2^27 texels still have the precision of a float left when they are subtracted.

use super::Wrap;
use super::grid::{Grid, Rows};
use super::level::{Edges, whole};
use super::store::{Near, Store};
use crate::image::ImageError;
use smallvec::SmallVec;
use std::sync::Arc;

/// For each corner of texels, the sum of all texels above and left of it.
#[derive(Debug)]
pub(super) struct Sums(Grid<f64>);

/// A table in the making.
pub(super) struct SumsRows {
    components: usize,
    /// The last row of corners.
    above: Vec<f64>,
    rows: Rows<f64>,
}

impl SumsRows {
    /// The table of an image of so many columns and rows, in memory or in a store.
    ///
    /// # Errors
    /// If memory does not suffice.
    pub fn new(
        [width, height]: [usize; 2],
        components: usize,
        stored: Option<(Arc<Store>, u64)>,
    ) -> Result<SumsRows, ImageError> {
        let above = vec![0.0; (width + 1) * components];
        let mut rows = Rows::new([width + 1, height + 1], components, stored)?;
        rows.push(&above)?;
        Ok(SumsRows { components, above, rows })
    }

    /// Adds a row of the image.
    ///
    /// # Errors
    /// If it cannot be stored.
    pub fn push(&mut self, row: &[f32]) -> Result<(), ImageError> {
        let mut sums = [0.0; super::COMPONENTS];
        let corners = self.above.chunks_mut(self.components).skip(1);
        for (texel, corner) in row.chunks(self.components).zip(corners) {
            for ((sum, texel), corner) in sums.iter_mut().zip(texel).zip(corner) {
                *sum += f64::from(*texel);
                *corner += *sum;
            }
        }
        self.rows.push(&self.above)
    }

    /// The whole table.
    ///
    /// # Errors
    /// If the last rows cannot be stored.
    pub fn finish(self) -> Result<Sums, ImageError> {
        Ok(Sums(self.rows.finish()?))
    }
}

/// A place on an axis as corners with their weights: what they sum up to there.
type Corners = SmallVec<[(usize, f64); 6]>;

impl Sums {
    /// The mean over a box of these widths about a place.
    pub fn mean<const C: usize>(
        &self,
        [s, v]: [f64; 2],
        widths: [f64; 2],
        edges: Edges,
        near: &mut Near,
    ) -> [f32; C] {
        let (width, height) = (self.0.width - 1, self.0.height - 1);
        let (w, h) = (width as f64, height as f64);
        let (dx, dy) = ((widths[0] * w).max(1.0), (widths[1] * h).max(1.0));
        // Beyond an edge that goes on for ever all boxes are alike; near ones keep their precision.
        let held = |x: f64, n: f64, dx: f64| x.clamp(-dx, n + dx);
        let (mut x, mut y) = (s * w, v * h);
        if let Edges::Plane([along, down]) = edges {
            x = if along == Wrap::Clamp { held(x, w, dx) } else { x };
            y = if down == Wrap::Clamp { held(y, h, dy) } else { y };
        }
        let ([x0, x1], [y0, y1]) = ([x - 0.5 * dx, x + 0.5 * dx], [y - 0.5 * dy, y + 0.5 * dy]);
        let sum = match edges {
            Edges::Plane([along, down]) => {
                self.sum::<C>(&between(x0, x1, width, along), &between(y0, y1, height, down), near)
            }
            _ => {
                let here = between(x0, x1, width, Wrap::Periodic);
                let mut sum = self.sum::<C>(&here, &between(y0, y1, height, Wrap::Black), near);
                // What reaches over a pole comes down on the opposite meridian.
                let beyond = between(x0 + 0.5 * w, x1 + 0.5 * w, width, Wrap::Periodic);
                for (from, to) in [(0.0, -y0), (2.0 * h - y1, h)] {
                    if from < to {
                        let part = self.sum::<C>(&beyond, &between(from, to, height, Wrap::Black), near);
                        (0..C).for_each(|c| sum[c] += part[c]);
                    }
                }
                sum
            }
        };
        sum.map(|sum| (sum / (dx * dy)) as f32)
    }

    fn sum<const C: usize>(&self, along: &Corners, down: &Corners, near: &mut Near) -> [f64; C] {
        let mut sum = [0.0; C];
        for (y, wy) in down {
            let mut row = [0.0; C];
            for (x, wx) in along {
                for (row, sum) in row.iter_mut().zip(&self.0.at::<C>(*x, *y, near)) {
                    *row += wx * sum;
                }
            }
            for c in 0..C {
                sum[c] += wy * row[c];
            }
        }
        sum
    }
}

/// The stretch from one place to another on an axis of `n` texels.
fn between(from: f64, to: f64, n: usize, wrap: Wrap) -> Corners {
    let mut corners = Corners::new();
    reach(to, n, wrap, 1.0, &mut corners);
    reach(from, n, wrap, -1.0, &mut corners);
    corners
}

/// The stretch from 0 to `x`, times a sign.
fn reach(x: f64, n: usize, wrap: Wrap, sign: f64, corners: &mut Corners) {
    let end = n as f64;
    let mut add = |corner: usize, weight: f64| {
        if weight != 0.0 {
            corners.push((corner, sign * weight));
        }
    };
    let mut inside = |x: f64, weight: f64| {
        let whole = whole(x).clamp(0, n as i64 - 1);
        let rest = x - whole as f64;
        add(whole as usize, weight * (1.0 - rest));
        add(whole as usize + 1, weight * rest);
    };
    match wrap {
        Wrap::Black => inside(x.clamp(0.0, end), 1.0),
        Wrap::Periodic => {
            let rounds = whole(x / end) as f64;
            inside(x - rounds * end, 1.0);
            add(n, rounds);
        }
        Wrap::Mirror => {
            let rounds = whole(x / (2.0 * end)) as f64;
            let x = x - rounds * 2.0 * end;
            if x <= end {
                inside(x, 1.0);
                add(n, 2.0 * rounds);
            } else {
                inside(2.0 * end - x, -1.0);
                add(n, 2.0 * rounds + 2.0);
            }
        }
        // The edge's texels go on for ever: `inside` extends the line of the first and of the last.
        Wrap::Clamp => inside(x, 1.0),
    }
}
