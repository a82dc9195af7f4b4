//! Trajectories as lines of a picture: antialiased, and sorted by depth at every pixel.

use super::trajectories::Trajectories;
use super::{MAX_POINTS, Vector};
use crate::gbuffer::{Projection, surfaces};
use crate::image::{Image, Metadata, Variable};
use crate::parallel::*;
use crate::shape::Shape;
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::ops::Range;

/// Options for drawing lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    /// The width of a line in pixels. Below 1 the line stays a pixel wide and is fainter.
    pub width: f64,
}

impl Default for Pen {
    /// A pixel wide.
    fn default() -> Pen {
        Pen { width: 1.0 }
    }
}

/// Rows that one thread works on at a time.
const BAND: usize = 8;
/// So much of its depth may a line lie behind a surface and still be seen: seeds lie on the surface itself.
const BIAS: f64 = 1e-3;
/// `depth` where there is no line.
const NOTHING: f32 = 1e10;
/// The variables, with the number of planes of each.
const VARIABLES: [(&str, usize); 8] = [
    ("surface", 1),
    ("point", 3),
    ("along", 3),
    ("depth", 1),
    ("age", 1),
    ("line", 1),
    ("color", 3),
    ("alpha", 1),
];
const PLANES: usize = 14;

/// Draws the lines into a picture of the projection's size.
///
/// The image has `color`, which is premultiplied by `alpha`, of all lines that a pixel sees; and of the first of these that covers
/// at least half of the pixel, or else the one that covers most: `surface` (1), `point`, `along` (the unit vector along the
/// line), `depth`, `age` and the number `line`, from 0. Where there is none, `depth` is 1e10 and all else 0.
///
/// `colors` are those of the trajectories' points ([`Flow::colors`](super::Flow::colors)); without them lines are white, and darker
/// the more they point at the eye, as thin cylinders under a headlight are. What lies behind the surfaces of `before`, an image with `depth` or
/// `point` of that picture or of a part of it, is hidden.
///
/// A segment with an end behind the eye is left out. Lines that touch in a pixel are taken as covering it independently.
pub fn draw(
    trajectories: &Trajectories,
    colors: Option<&[[f32; 4]]>,
    projection: &Projection,
    pen: &Pen,
    before: Option<&Image<'_>>,
) -> Image<'static> {
    let [width, height] = projection.size;
    let drawing = Drawing::new(trajectories, colors, projection, pen, before);
    let bins = drawing.bins();
    let mut planes: Vec<Vec<f32>> = (0..PLANES).map(|_| vec![0.0; width * height]).collect();
    let mut stretches: Vec<Vec<&mut [f32]>> = (0..bins.len()).map(|_| Vec::new()).collect();
    for plane in &mut planes {
        let parts = plane.chunks_mut(BAND * width.max(1));
        parts.zip(&mut stretches).for_each(|(part, stretch)| stretch.push(part));
    }
    stretches.par_iter_mut().zip(&bins).enumerate().for_each(|(band, (planes, segments))| {
        drawing.band(band * BAND..height.min((band + 1) * BAND), segments, planes);
    });
    let mut planes = planes.into_iter();
    let variables = VARIABLES.map(|(name, count)| Variable {
        name: name.into(),
        shape: if count == 1 { Shape::Scalar } else { Shape::Vector(count as u32) },
        planes: planes.by_ref().take(count).map(Cow::Owned).collect(),
    });
    Image { width, height, variables: variables.into(), metadata: Metadata::default() }
}

/// What a segment covers of a pixel.
#[derive(Clone, Copy)]
struct Fragment {
    pixel: u32,
    /// The point at which the segment begins.
    segment: u32,
    /// How much of the pixel it covers.
    coverage: f32,
    depth: f32,
    /// How far along the segment, in space.
    part: f32,
}

struct Drawing<'a> {
    trajectories: &'a Trajectories,
    colors: Option<&'a [[f32; 4]]>,
    eye: DVec3,
    /// Columns and rows.
    size: [usize; 2],
    /// Half the width of a line, and how dark it is.
    radius: f64,
    strength: f64,
    /// Where each point is seen, and its depth; not finite where it cannot be.
    seen: Vec<(DVec2, f64)>,
    /// How far away the surfaces are that lines may be behind, for all pixels of the picture.
    hiding: Option<Vec<f32>>,
}

/// The depths of an image, at its place in the picture: its own, or those of its points.
fn hiding(image: &Image<'_>, projection: &Projection) -> Option<Vec<f32>> {
    let [width, height] = projection.size;
    let own = image.variable("depth").filter(|v| v.shape == Shape::Scalar).map(|v| v.planes[0].clone());
    let depth = own.or_else(|| {
        let seen = surfaces(image).map(|hit| {
            hit.map_or(f64::INFINITY, |point| projection.depth(DVec3::from(point.map(f64::from))))
        });
        let depths: Vec<f32> = seen.map(|depth| depth as f32).collect();
        (!depths.is_empty()).then(|| depths.into())
    })?;
    let [left, top] = image.metadata.origin.map(i64::from);
    let mut plane = vec![f32::INFINITY; width * height];
    for (y, line) in (top..).zip(depth.chunks(image.width.max(1))) {
        for (x, depth) in (left..).zip(line) {
            if (0..width as i64).contains(&x) && (0..height as i64).contains(&y) {
                plane[y as usize * width + x as usize] = *depth;
            }
        }
    }
    Some(plane)
}

impl<'a> Drawing<'a> {
    fn new(
        trajectories: &'a Trajectories,
        colors: Option<&'a [[f32; 4]]>,
        projection: &Projection,
        pen: &Pen,
        before: Option<&Image<'_>>,
    ) -> Drawing<'a> {
        assert!(trajectories.points.len() <= MAX_POINTS, "a flow has fewer than 2^32 points");
        let seen = trajectories.points.par_iter().map(|point| {
            let point = DVec3::from(point.map(f64::from));
            let depth = projection.depth(point);
            if depth > 0.0 { (projection.place(point), depth) } else { (DVec2::NAN, depth) }
        });
        let size = projection.size;
        Drawing {
            trajectories,
            colors,
            eye: projection.eye(),
            size,
            radius: pen.width.max(1.0) / 2.0,
            strength: pen.width.clamp(0.0, 1.0),
            seen: seen.collect(),
            hiding: before.and_then(|image| hiding(image, projection)),
        }
    }

    /// The segments that touch each band of rows.
    fn bins(&self) -> Vec<Vec<u32>> {
        let [_, height] = self.size;
        let mut bins: Vec<Vec<u32>> = vec![Vec::new(); height.div_ceil(BAND)];
        for start in 0..self.seen.len() {
            let Some((low, high)) = self.extent(start) else { continue };
            let rows = low.y.max(0.0)..high.y.min(height as f64);
            if rows.start < rows.end && high.x > 0.0 && low.x < self.size[0] as f64 {
                let last = (rows.end.ceil() as usize - 1) / BAND;
                bins[rows.start as usize / BAND..=last].iter_mut().for_each(|bin| bin.push(start as u32));
            }
        }
        bins
    }

    /// The corners of what the segment from that point on may cover; `None` if there is no such segment to be seen.
    fn extent(&self, start: usize) -> Option<(DVec2, DVec2)> {
        if start % (self.trajectories.steps + 1) == self.trajectories.steps {
            return None;
        }
        let ((a, _), (b, _)) = (self.seen[start], self.seen[start + 1]);
        let around = DVec2::splat(self.radius + 0.5);
        (a.is_finite() && b.is_finite()).then(|| (a.min(b) - around, a.max(b) + around))
    }

    fn band(&self, rows: Range<usize>, segments: &[u32], planes: &mut [&mut [f32]]) {
        planes[7].fill(NOTHING);
        let mut fragments = Vec::new();
        for &segment in segments {
            self.cover(segment, &rows, &mut fragments);
        }
        fragments.sort_unstable_by_key(|f| (f.pixel, f.segment));
        let mut rest = &fragments[..];
        let mut seen: Vec<Fragment> = Vec::new();
        while let Some(first) = rest.first() {
            let count = rest.partition_point(|f| f.pixel == first.pixel);
            let (here, after) = rest.split_at(count);
            rest = after;
            // What follows each other along a line covers the same part of the pixel, not one after the other.
            seen.clear();
            for (i, fragment) in here.iter().enumerate() {
                match seen.last_mut() {
                    Some(last) if fragment.segment <= here[i - 1].segment + 1 => {
                        if fragment.coverage > last.coverage {
                            *last = *fragment;
                        }
                    }
                    _ => seen.push(*fragment),
                }
            }
            seen.sort_unstable_by(|a, b| a.depth.total_cmp(&b.depth).then(a.segment.cmp(&b.segment)));
            let pixel = self.pixel(&seen);
            planes.iter_mut().zip(pixel).for_each(|(plane, x)| plane[first.pixel as usize] = x);
        }
    }

    /// Adds what a segment covers of each pixel of some rows.
    fn cover(&self, segment: u32, rows: &Range<usize>, fragments: &mut Vec<Fragment>) {
        let start = segment as usize;
        let Some((low, high)) = self.extent(start) else { return };
        let ((a, near), (b, far)) = (self.seen[start], self.seen[start + 1]);
        let [width, _] = self.size;
        let across = |x: f64, end: usize| (x.max(0.0) as usize).min(end);
        let columns = across(low.x, width)..across(high.x.ceil(), width);
        let rows_here = across(low.y, rows.end).max(rows.start)..across(high.y.ceil(), rows.end);
        let way = b - a;
        for row in rows_here {
            for column in columns.clone() {
                let middle = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                let t = (middle - a).dot(way) / way.length_squared();
                let t = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 };
                let coverage = (self.radius + 0.5 - middle.distance(a + way * t)).clamp(0.0, 1.0);
                if coverage <= 0.0 {
                    continue;
                }
                // Halfway on the picture is nearer to the near end in space.
                let depth = 1.0 / ((1.0 - t) / near + t / far);
                let part = if t > 0.0 { t * depth / far } else { 0.0 };
                let pixel = (row - rows.start) * width + column;
                let hidden = self
                    .hiding
                    .as_ref()
                    .is_some_and(|plane| depth > f64::from(plane[row * width + column]) * (1.0 + BIAS));
                if !hidden {
                    fragments.push(Fragment {
                        pixel: pixel as u32,
                        segment,
                        coverage: (coverage * self.strength) as f32,
                        depth: depth as f32,
                        part: part as f32,
                    });
                }
            }
        }
    }

    /// The numbers of a pixel, in the order of the variables, from what it sees, nearest first.
    fn pixel(&self, seen: &[Fragment]) -> [f32; PLANES] {
        let (mut color, mut alpha) = ([0.0f32; 3], 0.0f32);
        for fragment in seen {
            let [r, g, b, opacity] = self.color(fragment);
            let share = (1.0 - alpha) * fragment.coverage * opacity.clamp(0.0, 1.0);
            color = [color[0] + r * share, color[1] + g * share, color[2] + b * share];
            alpha += share;
        }
        let half = self.strength as f32 / 2.0;
        let most = seen.iter().max_by(|a, b| a.coverage.total_cmp(&b.coverage));
        let Some(shown) = seen.iter().find(|f| f.coverage >= half).or(most) else { return [0.0; PLANES] };
        let start = shown.segment as usize;
        let (age, next) = (self.trajectories.age(start), self.trajectories.age(start + 1));
        let point = self.mix(shown, |i| self.trajectories.points[i]);
        let along = self.mix(shown, |i| self.trajectories.along(i));
        let along = DVec3::from(along.map(f64::from)).normalize_or_zero().to_array().map(|x| x as f32);
        let line = (start / (self.trajectories.steps + 1)) as f32;
        let mut cells = [0.0; PLANES];
        cells[0] = 1.0;
        cells[1..4].copy_from_slice(&point);
        cells[4..7].copy_from_slice(&along);
        cells[7] = shown.depth;
        cells[8] = age + (next - age) * shown.part;
        cells[9] = line;
        cells[10..13].copy_from_slice(&color);
        cells[13] = alpha;
        cells
    }

    /// Between the values at the ends of a segment.
    fn mix<const N: usize>(&self, at: &Fragment, value: impl Fn(usize) -> [f32; N]) -> [f32; N] {
        let (a, b) = (value(at.segment as usize), value(at.segment as usize + 1));
        std::array::from_fn(|i| a[i] + (b[i] - a[i]) * at.part)
    }

    /// The colour of a line, and how opaque it is.
    fn color(&self, at: &Fragment) -> [f32; 4] {
        if let Some(colors) = self.colors {
            return self.mix(at, |i| colors[i]);
        }
        let vector = |v: Vector| DVec3::from(v.map(f64::from));
        let point = vector(self.mix(at, |i| self.trajectories.points[i]));
        let along = vector(self.mix(at, |i| self.trajectories.along(i))).normalize_or_zero();
        let towards = (self.eye - point).normalize_or_zero().dot(along);
        let light = (1.0 - towards * towards).max(0.0).sqrt() as f32;
        [light, light, light, 1.0]
    }
}
