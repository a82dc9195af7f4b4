//! The steps of `point` from pixel to pixel, and on which side of a pixel its surface goes on.
//!
//! `pixelsize`, the helper lanes of derivatives and the extrapolation of samples all compare a pixel with its neighbours.
//! Where one part of an object hides another, a neighbour is of the same `surface` and far behind: the step to it is the
//! gap between the two parts and no change along the surface. Such a step is recognized by its length: it is several
//! times that of the step on the other side of the pixel, or that of the step behind it.

use super::input::{InputVariable, Inputs};
use crate::parallel::for_rows;
use crate::shape::Shape;
use smallvec::SmallVec;

/// How many pixels to each side of a pixel are looked at.
pub const REACH: usize = 3;

/// A step so many times as long as that to the other side leads over a silhouette. On a round surface the outermost step
/// is at most 1 + √2 times as long as the next.
const SILHOUETTE: f32 = 3.0;

/// The same for two steps in one direction, where no step to the other side is known.
const SILHOUETTE_AHEAD: f32 = 4.0;

/// Steps that differ by less than this factor are those of a surface seen evenly: each is as good as the other.
const EVEN: f32 = 1.1;

/// A point's derivative at the edge of a round surface is at most taken for so many times the step beside it. (It grows
/// beyond all bounds there.)
const STEEPEST: f32 = 4.0;

/// The same where the steps are not those of a round surface.
const UNEVEN: f32 = 2.0;

/// By how much the second step from the edge of a round surface is longer than the third, where the outermost one shows
/// that the edge is very near.
const ROUND: std::ops::Range<f32> = 1.2..1.4;

/// The sine of the angle up to which two steps follow each other in a straight line.
const STRAIGHT: f64 = 1e-3;

/// The length of a step to a pixel that is not there, is of another surface, or has a point that is not finite.
const NONE: f32 = f32::INFINITY;

/// An axis of the picture.
#[derive(Clone, Copy)]
pub(super) enum Along {
    Row,
    Column,
}

/// The lengths of the steps between all neighbouring pixels of an image.
pub(super) struct Steps<'i> {
    width: usize,
    height: usize,
    surface: Option<&'i [f32]>,
    /// The planes of `point`; none if the image has none, and then no steps.
    point: SmallVec<[&'i [f32]; 4]>,
    /// From each pixel to the next one of its row, and of its column.
    lengths: [Vec<f32>; 2],
}

impl<'i> Steps<'i> {
    /// Measures the steps of an image, into these buffers. Without `surface`, all pixels are of one. `staged` takes copies of
    /// planes whose pixels do not follow one another.
    pub fn of(
        inputs: &Inputs<'i>,
        lengths: [Vec<f32>; 2],
        staged: &'i mut Vec<f32>,
        threads: bool,
    ) -> Steps<'i> {
        let (width, height) = (inputs.width, inputs.height);
        let point = inputs.iter().find(|v| v.name == "point" && matches!(v.shape, Shape::Vector(1..)));
        let surface = inputs.iter().find(|v| v.name == "surface" && v.shape.is_scalar());
        let both = || point.iter().chain(&surface).flat_map(InputVariable::planes);
        let pixels = width * height;
        let copies = both().filter(|plane| plane.contiguous().is_none()).count();
        staged.resize(copies * pixels, 0.0);
        let mut rest = &mut staged[..];
        let mut planes: SmallVec<[&'i [f32]; 4]> = SmallVec::new();
        for samples in both() {
            planes.push(samples.contiguous().unwrap_or_else(|| {
                let (copy, others) = std::mem::take(&mut rest).split_at_mut(pixels);
                samples.copy(0, copy);
                rest = others;
                copy
            }));
        }
        let surface = surface.and_then(|_| planes.pop());
        let point = planes;
        let mut steps = Steps { width, height, surface, point, lengths: Default::default() };
        let [mut row, mut column] = lengths;
        if !steps.point.is_empty() {
            steps.measure(Along::Row, threads, &mut row);
            steps.measure(Along::Column, threads, &mut column);
        }
        steps.lengths = [row, column];
        steps
    }

    /// The buffers, to be used again.
    pub fn into_buffers(self) -> [Vec<f32>; 2] {
        self.lengths
    }

    fn measure(&self, along: Along, threads: bool, lengths: &mut Vec<f32>) {
        lengths.clear();
        lengths.resize(self.width * self.height, NONE);
        for_rows(threads, lengths, self.width, |row, lengths| {
            let (count, stride) = match along {
                Along::Row => (self.width - 1, 1),
                Along::Column if row + 1 < self.height => (self.width, self.width),
                Along::Column => (0, self.width),
            };
            for (column, length) in lengths[..count].iter_mut().enumerate() {
                let (a, b) = (row * self.width + column, row * self.width + column + stride);
                if self.same_surface(a, b) {
                    let squares = self.point.iter().map(|p| (p[a] - p[b]) * (p[a] - p[b]));
                    let distance = squares.sum::<f32>().sqrt();
                    *length = if distance.is_finite() { distance } else { NONE };
                }
            }
        });
    }

    fn same_surface(&self, a: usize, b: usize) -> bool {
        self.surface.is_none_or(|surface| surface[a] == surface[b])
    }

    fn is_finite(&self, pixel: usize) -> bool {
        self.point.iter().all(|p| p[pixel].is_finite())
    }

    /// The pixel of this row and column, and its neighbours along an axis.
    #[inline]
    pub fn line(&self, along: Along, column: usize, row: usize) -> Line<'_, 'i> {
        let (place, size, stride) = match along {
            Along::Row => (column, self.width, 1),
            Along::Column => (row, self.height, self.width),
        };
        let lengths = &self.lengths[along as usize];
        Line { steps: self, lengths, pixel: row * self.width + column, place, size, stride }
    }

    /// How far apart pixels lie in the space of `point` at this one: the larger rate of change of the two along the row
    /// and along the column. `None` if the image has no points, or nothing tells.
    pub fn pixel_size(&self, column: usize, row: usize) -> Option<f32> {
        if self.point.is_empty() {
            return None;
        }
        let lines = [Along::Row, Along::Column].map(|along| self.line(along, column, row));
        let rates = lines.iter().filter_map(Line::rate);
        rates.reduce(f32::max).or_else(|| {
            // A part one pixel wide: its surface goes on to no side. What lies beside it is seen from about as far.
            let alone = |line: &Line<'_, '_>| line.length(0) > 0.0 && line.length(-1) > 0.0;
            let alone = self.is_finite(lines[0].pixel) && lines.iter().all(alone);
            let beside = lines.iter().flat_map(|line| [line.length(1), line.length(-2)]);
            beside.filter(|&length| alone && is_step(length)).reduce(f32::min)
        })
    }
}

/// Whether it is the length of a step, and not 0.
fn is_step(length: f32) -> bool {
    length > 0.0 && length < NONE
}

/// A pixel and its neighbours along an axis.
pub(super) struct Line<'s, 'i> {
    steps: &'s Steps<'i>,
    lengths: &'s [f32],
    pixel: usize,
    /// The pixel's place along the axis, of so many.
    place: usize,
    size: usize,
    stride: usize,
}

/// A direction along a line.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    After,
    Before,
}

impl Side {
    fn other(self) -> Side {
        if self == Side::After { Side::Before } else { Side::After }
    }
}

impl Line<'_, '_> {
    /// Whether the surface goes on to the pixel after this one, and to the one before it.
    #[inline]
    pub fn sides(&self) -> [bool; 2] {
        let (a, b) = (self.length(0), self.length(-1));
        let alike = a.max(b) < NONE && a <= SILHOUETTE * b && b <= SILHOUETTE * a;
        if alike && a <= SILHOUETTE_AHEAD * self.length(1) && b <= SILHOUETTE_AHEAD * self.length(-2) {
            return [true, true];
        }
        self.uneven_sides()
    }

    /// The same, where steps differ, or are missing.
    fn uneven_sides(&self) -> [bool; 2] {
        let after =
            self.place + 1 < self.size && self.steps.same_surface(self.pixel, self.pixel + self.stride);
        let before = self.place > 0 && self.steps.same_surface(self.pixel, self.pixel - self.stride);
        // Nothing is known about the place of a pixel whose point is not finite.
        if !(after || before) || self.lengths.is_empty() || !self.steps.is_finite(self.pixel) {
            return [after, before];
        }
        [after && self.goes_on(Side::After), before && self.goes_on(Side::Before)]
    }

    /// The length of the step from the `k`th pixel after this one to the next.
    #[inline]
    fn length(&self, k: isize) -> f32 {
        // Before the first place it is a large number.
        let place = self.place.wrapping_add_signed(k);
        match self.lengths.get(self.pixel.wrapping_add_signed(k * self.stride as isize)) {
            Some(&length) if place < self.size => length,
            _ => NONE,
        }
    }

    /// The lengths of the steps on a side, the nearest first.
    #[inline]
    fn outward(&self, side: Side) -> [f32; REACH] {
        match side {
            Side::After => [0, 1, 2].map(|k| self.length(k)),
            Side::Before => [-1, -2, -3].map(|k| self.length(k)),
        }
    }

    /// Whether the surface goes on to the neighbour on this side, which has a point: the step to it leads over no
    /// silhouette.
    fn goes_on(&self, side: Side) -> bool {
        let [near, second, third] = self.outward(side);
        let [opposite, beyond, _] = self.outward(side.other());
        let in_line = |other, k| straight(&self.vector(side, 0), &self.vector(other, k));
        near < NONE
            && !(near > SILHOUETTE * opposite
                && self.leads_away([near, opposite, beyond], || in_line(side.other(), 0)))
            && !(near > SILHOUETTE_AHEAD * second
                && self.leads_away([near, second, third], || in_line(side, 1)))
    }

    /// Whether a step that is much longer than the next ones leads over a silhouette.
    fn leads_away(&self, [step, next, third]: [f32; 3], straight: impl Fn() -> bool) -> bool {
        // Where points are coarser than pixels, steps are small multiples of their last digit.
        let largest = self.steps.point.iter().map(|p| p[self.pixel].abs()).fold(0.0, f32::max);
        if !is_step(next) || step <= SILHOUETTE * (next + 8.0 * f32::EPSILON * largest) {
            return false;
        }
        // A plane that recedes to its horizon is seen in steps 1 / (i (i + 1)), by which two of them tell the third.
        let ratio = next / third;
        let recedes = is_step(third) && ratio < 3.0 && step <= 1.5 * next * (1.0 + ratio) / (3.0 - ratio);
        !(recedes && straight())
    }

    /// The step outward from the `k`th pixel on a side, number by number.
    fn vector(&self, side: Side, k: usize) -> SmallVec<[f64; 4]> {
        let [from, to] = [k, k + 1].map(|k| match side {
            Side::After => self.pixel + k * self.stride,
            Side::Before => self.pixel - k * self.stride,
        });
        self.steps.point.iter().map(|p| f64::from(p[to]) - f64::from(p[from])).collect()
    }

    /// How fast the point changes at this pixel, in units a pixel.
    ///
    /// On a surface seen evenly that is the step to the next pixel. Elsewhere (near the edge of what is round, at creases)
    /// the rate is that of a curve through three pixels: of the three triples that hold this one, that which bends
    /// least.
    #[inline]
    fn rate(&self) -> Option<f32> {
        let (after, before) = (self.length(0), self.length(-1));
        let even = is_step(after) && after <= EVEN * before && before <= EVEN * after;
        if even && after <= SILHOUETTE_AHEAD * self.length(1) { Some(after) } else { self.uneven_rate() }
    }

    /// The same, where steps differ, or are missing.
    fn uneven_rate(&self) -> Option<f32> {
        let (after, before) = (self.length(0), self.length(-1));
        let open = |side| is_step(self.outward(side)[0]) && self.goes_on(side);
        let [after_open, before_open] = [open(Side::After), open(Side::Before)];
        let mut best: Option<(f64, f32)> = None;
        let mut consider = |bend: f64, rate: f32| {
            if best.is_none_or(|(least, _)| bend < least) {
                best = Some((bend, rate));
            }
        };
        if after_open && before_open {
            let (u, v) = (self.vector(Side::After, 0), self.vector(Side::Before, 0));
            let bend = u.iter().zip(&v).map(|(u, v)| (u + v) * (u + v)).sum();
            consider(bend, rate_between(after, before, straight(&u, &v)));
        }
        for (side, open) in [(Side::After, after_open), (Side::Before, before_open)] {
            let [near, second, third] = self.outward(side);
            if open && is_step(second) {
                let (u, v) = (self.vector(side, 0), self.vector(side, 1));
                let bend = u.iter().zip(&v).map(|(u, v)| (u - v) * (u - v)).sum();
                consider(bend, rate_at_end([near, second, third], straight(&u, &v)));
            }
        }
        let single = || after_open.then_some(after).or_else(|| before_open.then_some(before));
        best.map(|(_, rate)| rate).or_else(single)
    }
}

/// Whether two steps lie in one line.
fn straight(u: &[f64], v: &[f64]) -> bool {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (squares, product) = (dot(u, u) * dot(v, v), dot(u, v));
    squares - product * product <= STRAIGHT * STRAIGHT * squares
}

/// The rate of change at the middle of three pixels, by the steps to both others.
///
/// In a straight line, seen in perspective, the point is a quotient of linear functions of the pixel's place. On a round
/// surface it is the place that is a quadratic function of the point, like that of a circle near its edge.
fn rate_between(a: f32, b: f32, straight: bool) -> f32 {
    // The quotients stay within f32 for all steps.
    let ratio = a / b;
    if straight { 2.0 * a / (1.0 + ratio) } else { a * (1.0 + ratio) / (1.0 + ratio * ratio) }
}

/// The same at the first of three pixels, by the steps that follow each other from it, the third of which may be missing.
fn rate_at_end([step, next, third]: [f32; 3], straight: bool) -> f32 {
    let ratio = step / next;
    if straight {
        return step * (1.0 + ratio) / 2.0;
    }
    let slope = 1.0 + (2.0 - ratio) * ratio;
    let round = !is_step(third) || ROUND.contains(&(next / third));
    let steepest = if round && slope > 0.0 { STEEPEST } else { UNEVEN };
    step * if slope > 0.0 { ((1.0 + ratio) / slope).min(steepest) } else { steepest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Image, Variable};

    /// An image of one row with such points, all of one surface.
    fn row(points: &[[f32; 3]]) -> Image<'static> {
        let planes = (0..3).map(|axis| points.iter().map(|p| p[axis]).collect::<Vec<f32>>().into()).collect();
        let point = Variable { name: "point".into(), shape: Shape::Vector(3), planes };
        Image { width: points.len(), height: 1, variables: vec![point], ..Image::default() }
    }

    fn sides(image: &Image<'_>) -> Vec<[bool; 2]> {
        let mut staged = Vec::new();
        let steps = Steps::of(&Inputs::of(image), Default::default(), &mut staged, true);
        (0..image.width).map(|column| steps.line(Along::Row, column, 0).sides()).collect()
    }

    fn sizes(image: &Image<'_>) -> Vec<Option<f32>> {
        let mut staged = Vec::new();
        let steps = Steps::of(&Inputs::of(image), Default::default(), &mut staged, true);
        (0..image.width).map(|column| steps.pixel_size(column, 0)).collect()
    }

    fn depths(depths: &[f32]) -> Image<'static> {
        row(&depths.iter().enumerate().map(|(i, &z)| [i as f32, 0.0, z]).collect::<Vec<_>>())
    }

    #[test]
    fn a_surface_does_not_go_on_over_a_gap() {
        let image = depths(&[0.0, 0.0, 0.0, 50.0, 50.0, 50.0]);
        let expected =
            [[true, false], [true, true], [false, true], [true, false], [true, true], [false, true]];
        assert_eq!(sides(&image), expected);
        assert_eq!(sizes(&image), [Some(1.0); 6]);
        // The same in the direction of the row itself.
        let image = row(&[0.0, 1.0, 2.0, 60.0, 61.0, 62.0].map(|x| [x, 0.0, 0.0]));
        assert_eq!(sides(&image), expected);
        assert_eq!(sizes(&image), [Some(1.0); 6]);
    }

    #[test]
    fn the_only_neighbour_behind_a_gap_does_not_count() {
        // A part one pixel wide, at the image's edge and in its middle.
        for (points, thin) in [(&[9.0, 0.0, 0.0, 0.0][..], 0), (&[0.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0], 3)] {
            let image = depths(points);
            assert_eq!(sides(&image)[thin], [false, false]);
            // Nothing is known of it but how large pixels are beside it.
            assert_eq!(sizes(&image), vec![Some(1.0); points.len()]);
        }
    }

    #[test]
    fn what_is_round_ends_steeply() {
        for offset in [0.02f32, 0.1, 0.3, 0.6, 0.9] {
            let depth = |i: usize| 20.0 * (i as f32 + offset).sqrt();
            let image = depths(&[0, 1, 2, 3, 4, 5].map(depth));
            let sides = sides(&image);
            assert!(sides.iter().take(5).all(|side| side[0]) && sides.iter().skip(1).all(|side| side[1]));
            for (i, size) in sizes(&image).into_iter().enumerate() {
                let slope = 10.0 / (i as f32 + offset).sqrt();
                let (size, exact) = (size.expect("a size"), (1.0 + slope * slope).sqrt());
                assert!((size / exact - 1.0).abs() < 0.06, "{offset}, {i}: {size}, not {exact}");
            }
        }
    }

    #[test]
    fn a_plane_goes_on_to_its_horizon() {
        for offset in [0.05f32, 0.3, 0.7, 1.0] {
            let points = [0, 1, 2, 3, 4, 5, 6].map(|i| [0.0, 100.0 / (i as f32 + offset), -1.0]);
            let image = row(&points);
            assert!(sides(&image).iter().skip(1).take(5).all(|side| *side == [true, true]), "{offset}");
            for (i, size) in sizes(&image).into_iter().enumerate() {
                let exact = 100.0 / ((i as f32 + offset) * (i as f32 + offset));
                let size = size.expect("a size");
                assert!((size / exact - 1.0).abs() < 0.01, "{offset}, {i}: {size}, not {exact}");
            }
        }
    }

    #[test]
    fn creases_leave_both_sides_as_they_are() {
        let image = depths(&[0.0, 0.0, 0.0, 0.0, 2.0, 4.0, 6.0, 8.0]);
        assert!(sides(&image)[1..7].iter().all(|side| *side == [true, true]));
        let steep = 5.0f32.sqrt();
        let expected = [1.0, 1.0, 1.0, steep, steep, steep, steep, steep];
        assert_eq!(sizes(&image), expected.map(Some));
    }

    #[test]
    fn points_without_a_place_tell_nothing() {
        let mut points = [0.0, 1.0, 2.0, 3.0, 4.0].map(|x| [x, 0.0, 0.0]);
        points[2][1] = f32::NAN;
        points[4][0] = f32::INFINITY;
        let image = row(&points);
        assert_eq!(
            sides(&image),
            [[true, false], [false, true], [true, true], [false, false], [false, true]]
        );
        let unit = [Some(1.0), Some(1.0), None, None, None];
        assert_eq!(sizes(&image), unit);
        // A sky whose points are all alike has no size, nor has an image without points.
        assert_eq!(sizes(&row(&[[0.0; 3]; 4])), [None; 4]);
        assert_eq!(sizes(&Image { width: 2, height: 1, ..Image::default() }), [None; 2]);
        assert_eq!(sides(&Image { width: 2, height: 1, ..Image::default() }), [[true, false], [false, true]]);
    }

    #[test]
    fn coarse_points_have_no_silhouettes() {
        // Halves near 1000 lie 0.5 apart, floats near 5 000 000 as well.
        let image = row(&[0.0, 0.5, 0.5, 3.0, 3.5, 3.5].map(|x| [5e6 + x, 0.0, 0.0]));
        assert!(sides(&image)[1..5].iter().all(|side| *side == [true, true]));
    }
}
