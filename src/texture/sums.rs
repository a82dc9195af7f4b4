//! Summed-area tables (Crow 1984): the exact mean of an image over any rectangle, at the same cost for all.
//!
//! The image is taken as texels of constant colour, so its integral is bilinear between the corners of texels.
//! A box of one texel's size is then the same as bilinear interpolation: smaller ones are not needed. Sums are
//! held in f64: those of 2^27 texels still have the precision of a float left when they are subtracted.

use super::Wrap;
use super::level::{Edges, Level, whole};
use smallvec::SmallVec;

/// For each corner of texels, the sum of all texels above and left of it.
#[derive(Debug)]
pub(super) struct Sums {
    width: usize,
    height: usize,
    sums: Vec<f64>,
}

/// A place on an axis as corners with their weights: what they sum up to there.
type Corners = SmallVec<[(usize, f64); 6]>;

impl Sums {
    /// The table of an image.
    pub fn of(image: &Level) -> Sums {
        let (width, height, c) = (image.width, image.height, image.components);
        let stride = (width + 1) * c;
        let mut sums = vec![0.0; stride * (height + 1)];
        for y in 0..height {
            let (above, here) = sums[y * stride..(y + 2) * stride].split_at_mut(stride);
            let mut row = [0.0; super::COMPONENTS];
            for x in 0..width {
                for k in 0..c {
                    row[k] += f64::from(image.texels[(y * width + x) * c + k]);
                    here[(x + 1) * c + k] = above[(x + 1) * c + k] + row[k];
                }
            }
        }
        Sums { width, height, sums }
    }

    /// The mean over a box of these widths about a place.
    pub fn mean<const C: usize>(&self, [s, v]: [f64; 2], widths: [f64; 2], edges: Edges) -> [f32; C] {
        let (w, h) = (self.width as f64, self.height as f64);
        let (dx, dy) = ((widths[0] * w).max(1.0), (widths[1] * h).max(1.0));
        // Beyond an edge that goes on for ever all boxes are alike; near ones keep their precision.
        let near = |x: f64, n: f64, dx: f64| x.clamp(-dx, n + dx);
        let (mut x, mut y) = (s * w, v * h);
        if let Edges::Plane([along, down]) = edges {
            x = if along == Wrap::Clamp { near(x, w, dx) } else { x };
            y = if down == Wrap::Clamp { near(y, h, dy) } else { y };
        }
        let ([x0, x1], [y0, y1]) = ([x - 0.5 * dx, x + 0.5 * dx], [y - 0.5 * dy, y + 0.5 * dy]);
        let sum = match edges {
            Edges::Plane([along, down]) => {
                self.sum::<C>(&between(x0, x1, self.width, along), &between(y0, y1, self.height, down))
            }
            _ => {
                let here = between(x0, x1, self.width, Wrap::Periodic);
                let mut sum = self.sum::<C>(&here, &between(y0, y1, self.height, Wrap::Black));
                // What reaches over a pole comes down on the opposite meridian.
                let beyond = between(x0 + 0.5 * w, x1 + 0.5 * w, self.width, Wrap::Periodic);
                for (from, to) in [(0.0, -y0), (2.0 * h - y1, h)] {
                    if from < to {
                        let part = self.sum::<C>(&beyond, &between(from, to, self.height, Wrap::Black));
                        (0..C).for_each(|c| sum[c] += part[c]);
                    }
                }
                sum
            }
        };
        sum.map(|sum| (sum / (dx * dy)) as f32)
    }

    fn sum<const C: usize>(&self, along: &Corners, down: &Corners) -> [f64; C] {
        let mut sum = [0.0; C];
        for (y, wy) in down {
            let mut row = [0.0; C];
            for (x, wx) in along {
                let at = (y * (self.width + 1) + x) * C;
                for (row, sum) in row.iter_mut().zip(&self.sums[at..at + C]) {
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
