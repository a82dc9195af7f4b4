//! Luminance and chroma: `Y`, `RY` = (R - Y) / Y and `BY` = (B - Y) / Y become red, green and blue.
//!
//! What is missing of a subsampled chroma is interpolated, first along the rows and then along the columns, with the
//! filter of OpenEXR's own library where every second sample is stored, and linearly in other cases.

use exr::math::Vec2;
use exr::meta::attribute::Chromaticities;
use std::ops::Range;

/// A part's data window in the rectangle of all parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    /// Its first column.
    pub left: usize,
    /// Its first row.
    pub top: usize,
    /// Its columns.
    pub width: usize,
    /// Its rows.
    pub height: usize,
}

/// How a colour is stored.
#[derive(Clone, Debug)]
pub(super) struct LuminanceChroma {
    /// How much red, green and blue add to the luminance.
    pub weights: [f32; 3],
    /// How many columns and rows each sample of RY, and of BY, stands for.
    pub sampling: [[usize; 2]; 2],
    /// Where the samples are.
    pub window: Window,
}

/// The filter's weights for stored samples at distances of 1, 3, 5, … pixels.
const HALF_BAND: [f32; 7] = [0.627_123, -0.186_077, 0.087_929, -0.043_159, 0.019_597, -0.007_54, 0.002_128];

/// Rec. 709.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.3, 0.6),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.329),
};

/// How much red, green and blue of these primaries add to the luminance; those of Rec. 709 if there are none or they
/// make no sense.
pub(super) fn weights(chromaticities: Option<Chromaticities>) -> [f32; 3] {
    let own = chromaticities.and_then(weights_of);
    own.or_else(|| weights_of(REC_709)).unwrap_or([0.2126, 0.7152, 0.0722])
}

/// The luminances of red, green and blue that together are white.
fn weights_of(c: Chromaticities) -> Option<[f32; 3]> {
    let xyz = |c: Vec2<f32>| {
        let (x, y) = (f64::from(c.x()), f64::from(c.y()));
        [x, y, 1.0 - x - y]
    };
    let [r, g, b] = [c.red, c.green, c.blue].map(xyz);
    let white = xyz(c.white).map(|v| v / f64::from(c.white.y()));
    let det = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    let whole = det(r, g, b);
    let amounts = [det(white, g, b), det(r, white, b), det(r, g, white)];
    let list = [0, 1, 2].map(|i| amounts[i] / whole * [r, g, b][i][1]);
    // Green is what is left of the luminance.
    (list.iter().all(|w| w.is_finite()) && list[1] != 0.0).then(|| list.map(|w| w as f32))
}

impl LuminanceChroma {
    /// How many rows above and below the interpolation looks at.
    pub fn margin(&self) -> usize {
        let reach = |[_, y]: [usize; 2]| match y {
            1 => 0,
            2 => 2 * HALF_BAND.len() - 1,
            step => step,
        };
        self.sampling.into_iter().map(reach).max().unwrap_or(0)
    }

    /// The colour of some rows. The planes hold Y, RY and BY from the row `first` on, with `width` columns, each sample
    /// at its pixel.
    pub fn color(
        &self,
        planes: [&[f32]; 3],
        width: usize,
        first: usize,
        rows: Range<usize>,
    ) -> [Vec<f32>; 3] {
        let [_, g, b] = self.weights;
        let r = self.weights[0];
        let mut out = [0; 3].map(|_| vec![0.0; rows.len() * width]);
        let Window { left, top, width: own, height } = self.window;
        let inside = rows.start.max(top)..rows.end.min(top + height);
        let mut chroma =
            [Interpolated::new(planes[1], self.sampling[0]), Interpolated::new(planes[2], self.sampling[1])];
        for y in inside {
            let luminance = &planes[0][(y - first) * width + left..][..own];
            let [ry, by] = chroma.each_mut().map(|c| c.row(y - top, self.window, width, first));
            let start = (y - rows.start) * width + left;
            for (x, ((&y, ry), by)) in luminance.iter().zip(ry).zip(by).enumerate() {
                let (red, blue) = ((ry + 1.0) * y, (by + 1.0) * y);
                // A grey stays one to the last bit.
                let green = if ry == 0.0 && by == 0.0 { y } else { (y - red * r - blue * b) / g };
                for (plane, value) in out.iter_mut().zip([red, green, blue]) {
                    plane[start + x] = value;
                }
            }
        }
        out
    }
}

/// A chroma, row by row, with what is missing.
struct Interpolated<'p> {
    plane: &'p [f32],
    step: [usize; 2],
    /// Stored rows that are interpolated along the row already, with their numbers among the stored ones.
    kept: Vec<(usize, Vec<f32>)>,
}

impl<'p> Interpolated<'p> {
    fn new(plane: &'p [f32], step: [usize; 2]) -> Interpolated<'p> {
        Interpolated { plane, step, kept: Vec::new() }
    }

    /// The row `y` of the window.
    fn row(&mut self, y: usize, window: Window, width: usize, first: usize) -> Vec<f32> {
        let rows = taps(y, self.step[1], window.height / self.step[1]);
        let (low, high) = (rows.iter().map(|t| t.0).min(), rows.iter().map(|t| t.0).max());
        self.kept.retain(|(stored, _)| (low..=high).contains(&Some(*stored)));
        for &(stored, _) in &rows {
            if self.kept.iter().all(|(k, _)| *k != stored) {
                let start = (window.top + stored * self.step[1] - first) * width + window.left;
                let line = &self.plane[start..][..window.width];
                let count = window.width / self.step[0];
                let at = |x: usize| {
                    let taps = taps(x, self.step[0], count);
                    taps.iter().map(|&(k, weight)| weight * line[k * self.step[0]]).sum::<f32>()
                };
                self.kept.push((stored, (0..window.width).map(at).collect()));
            }
        }
        let mut row = vec![0.0; window.width];
        for (stored, weight) in rows {
            if let Some((_, line)) = self.kept.iter().find(|(k, _)| *k == stored) {
                row.iter_mut().zip(line).for_each(|(to, from)| *to += weight * from);
            }
        }
        row
    }
}

/// The stored samples, of `count`, that the one at pixel `at` is made of, with their weights. Beyond the ends the last
/// sample goes on.
fn taps(at: usize, step: usize, count: usize) -> Vec<(usize, f32)> {
    let (before, off) = (at / step, at % step);
    let last = count.saturating_sub(1);
    match (off, step) {
        (0, _) => vec![(before, 1.0)],
        (_, 2) => {
            let pairs = HALF_BAND.iter().enumerate();
            pairs
                .flat_map(|(i, &w)| [(before.saturating_sub(i), w), ((before + 1 + i).min(last), w)])
                .collect()
        }
        _ => {
            let part = off as f32 / step as f32;
            vec![(before, 1.0 - part), ((before + 1).min(last), part)]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_those_of_the_primaries() {
        let [r, g, b] = weights(None);
        assert!(
            (r - 0.2126).abs() < 1e-3 && (g - 0.7152).abs() < 1e-3 && (b - 0.0722).abs() < 1e-3,
            "{r} {g} {b}"
        );
        // Primaries that are X, Y and Z themselves: Y is all of the luminance.
        let xyz = Chromaticities {
            red: Vec2(1.0, 0.0),
            green: Vec2(0.0, 1.0),
            blue: Vec2(0.0, 0.0),
            white: Vec2(1.0 / 3.0, 1.0 / 3.0),
        };
        assert_eq!(weights(Some(xyz)), [0.0, 1.0, 0.0]);
        // Three times the same primary.
        assert_eq!(weights(Some(Chromaticities { green: xyz.red, blue: xyz.red, ..xyz })), weights(None));
        let aces = Chromaticities {
            red: Vec2(0.7347, 0.2653),
            green: Vec2(0.0, 1.0),
            blue: Vec2(0.0001, -0.077),
            white: Vec2(0.32168, 0.33767),
        };
        let [r, g, b] = weights(Some(aces));
        assert!(
            (r - 0.34397).abs() < 1e-4 && (g - 0.72817).abs() < 1e-4 && (b + 0.07213).abs() < 1e-4,
            "{r} {g} {b}"
        );
    }

    #[test]
    fn stored_samples_stay_and_even_ones_are_met_between() {
        for step in [1, 2, 3, 4] {
            for at in 0..6 * step {
                let taps = taps(at, step, 6);
                let sum: f32 = taps.iter().map(|t| t.1).sum();
                assert!((sum - 1.0).abs() < 1e-5 && taps.iter().all(|t| t.0 < 6), "{step} {at}");
                assert!(at % step != 0 || taps == [(at / step, 1.0)]);
            }
        }
    }
}
