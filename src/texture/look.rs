//! Looking a texture up: at a place, or in a direction, over a width.

use super::level::{Edges, mix, whole};
use super::sphere;
use super::store::Near;
use super::{Layout, Texture, Wrap};
use crate::math;
use std::f32::consts::{PI, TAU};

/// How texels are put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The mip map: between its two levels of about that width.
    Mip,
    /// The summed-area table: the exact mean over a box.
    Sums,
    /// The texel that holds the place; no width.
    Nearest,
    /// Between the four texels around; no width.
    Bilinear,
    /// A cubic B-spline over the sixteen texels around; no width.
    Cubic,
}

/// How a texture is looked up.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// How texels are put together.
    pub filter: Filter,
    /// What is beyond the edges: along the columns, and along the rows. Only a plane has any.
    pub wrap: [Wrap; 2],
}

/// The most probes along the longer side of a footprint.
const PROBES: f64 = 16.0;

/// Further than this from the image all is alike, and a wider box sees nothing new.
const FAR: f64 = 1e6;

impl Texture {
    /// The mean about a place of a plane, over widths in the units of s and v. NaN gives NaN.
    pub fn at<const C: usize>(
        &self,
        look: Look,
        [s, v]: [f64; 2],
        widths: [f32; 2],
        near: &mut Near,
    ) -> [f32; C] {
        let place = [home(s, look.wrap[0]), home(v, look.wrap[1])];
        self.filtered(look.filter, place, widths.map(f64::from), Edges::Plane(look.wrap), near)
    }

    /// The mean about a direction with y up, over a width in radians. NaN gives NaN.
    pub fn toward<const C: usize>(
        &self,
        look: Look,
        direction: [f32; 3],
        width: f32,
        near: &mut Near,
    ) -> [f32; C] {
        if self.layout == Layout::Cube {
            let (side, s, v) = sphere::side_of(direction.map(f64::from));
            // What an angle covers on a side grows towards its corners, along and across unlike: the mean of both.
            let (a, d) = (2.0 * s - 1.0, 2.0 * v - 1.0);
            let stretch = (1.0 + a * a + d * d).sqrt();
            let width = 0.5 * f64::from(width) * stretch * stretch.sqrt();
            return self.filtered(look.filter, [s, v], [width; 2], Edges::Side(side), near);
        }
        let (place, cosine) = sphere::latitude_longitude(direction);
        // Not more than once around; `min` would make a number of NaN.
        let part = |x: f32| if x > 1.0 { 1.0 } else { f64::from(x) };
        let width = width.abs();
        let widths = [part(if width == 0.0 { 0.0 } else { width / (TAU * cosine) }), part(width / PI)];
        self.filtered(look.filter, place, widths, Edges::Poles, near)
    }

    fn filtered<const C: usize>(
        &self,
        filter: Filter,
        place: [f64; 2],
        widths: [f64; 2],
        edges: Edges,
        near: &mut Near,
    ) -> [f32; C] {
        let [s, v] = place;
        if place.iter().chain(&widths).any(|x| x.is_nan()) {
            return [f32::NAN; C];
        }
        let widths = widths.map(|w| w.abs().min(FAR));
        match (filter, &self.sums) {
            (Filter::Nearest, _) => self.levels[0].nearest(s, v, edges, near),
            (Filter::Bilinear, _) => self.levels[0].bilinear(s, v, edges, near),
            (Filter::Cubic, _) => self.levels[0].cubic(s, v, edges, near),
            (Filter::Sums, Some(sums)) => sums.mean(place, widths, edges, near),
            (Filter::Mip | Filter::Sums, _) => self.mip(place, widths, edges, near),
        }
    }

    /// Trilinear, with a probe for each of the parts of a long footprint that are about square.
    fn mip<const C: usize>(
        &self,
        [s, v]: [f64; 2],
        widths: [f64; 2],
        edges: Edges,
        near: &mut Near,
    ) -> [f32; C] {
        let image = &self.levels[0];
        let (along, down) = (widths[0] * image.width as f64, widths[1] * image.height as f64);
        let long = along.max(down);
        if long <= 1.0 {
            return image.bilinear(s, v, edges, near);
        }
        let short = along.min(down).max(1.0);
        let probes = (long / short).round().min(PROBES);
        let level = math::log2(short.max(long / probes) as f32);
        if probes == 1.0 {
            return self.trilinear(s, v, level, edges, near);
        }
        let mut sum = [0.0; C];
        for i in 0..probes as u32 {
            let off = (f64::from(i) + 0.5) / probes - 0.5;
            let (s, v) = if along > down { (s + off * widths[0], v) } else { (s, v + off * widths[1]) };
            let probe = self.trilinear::<C>(s, v, level, edges, near);
            (0..C).for_each(|c| sum[c] += probe[c]);
        }
        sum.map(|sum| sum / probes as f32)
    }

    fn trilinear<const C: usize>(
        &self,
        s: f64,
        v: f64,
        level: f32,
        edges: Edges,
        near: &mut Near,
    ) -> [f32; C] {
        let last = self.levels.len() - 1;
        let whole = (level as usize).min(last);
        let fine = self.levels[whole].bilinear(s, v, edges, near);
        let rest = level - whole as f32;
        if whole == last || rest == 0.0 {
            return fine;
        }
        mix(fine, self.levels[whole + 1].bilinear(s, v, edges, near), rest)
    }
}

/// The same place near the image. Where infinity leads nowhere it is NaN.
#[inline]
fn home(x: f64, wrap: Wrap) -> f64 {
    // Larger numbers are even; no part of infinity is a number.
    const EVEN: f64 = (1_u64 << 60) as f64;
    match wrap {
        Wrap::Periodic | Wrap::Mirror if x.abs() >= EVEN || x.is_nan() => 0.0 * x,
        Wrap::Periodic => x - whole(x) as f64,
        Wrap::Mirror => x - 2.0 * whole(0.5 * x) as f64,
        // Neither `min` nor `max` must make a number of NaN.
        Wrap::Black | Wrap::Clamp => x.clamp(-FAR, FAR),
    }
}
