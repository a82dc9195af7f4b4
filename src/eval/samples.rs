//! Stochastic supersampling: where in a pixel a program runs, and what is made of the results.
//!
//! The program runs once for each sample, over all pixels. So that is all there is to it: an input is moved to the
//! sample's place before the run, and the outputs are summed up after it. Places are jittered: the pixel is cut into as many
//! parts of one area as there are samples, with one place somewhere in each (Cook, Porter and Carpenter, *Distributed Ray
//! Tracing*, 1984; Cook, *Stochastic Sampling in Computer Graphics*, 1986). What is left of frequencies that are too
//! high is noise then, and no pattern.
//!
//! A wider filter does not weigh samples: more of them lie where it is high. (Mitchell's and Catmull and Rom's are negative in
//! places; samples there count as -1.)

use super::run::Options;
use crate::host::HostError;
use crate::image::Image;
use crate::noise::hash;
use std::sync::LazyLock;

/// How many samples a pixel takes, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Samples of a pixel. One is taken in its middle.
    pub count: u32,
    /// What the pixel sees of its surroundings.
    pub filter: Filter,
    /// Other places for another seed.
    pub seed: u32,
}

/// A filter of an image, for rows and columns alike. The unit is a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Filter {
    /// The pixel itself.
    #[default]
    Box,
    /// A tent, one pixel to either side.
    Triangle,
    /// Catmull and Rom's cubic, two pixels to either side: sharp, negative in places.
    CatmullRom,
    /// Mitchell and Netravali's cubic with B = C = 1/3, two pixels to either side: *Reconstruction Filters in Computer
    /// Graphics*, 1988.
    Mitchell,
}

impl Sampling {
    /// So many samples of the pixel itself.
    pub fn of(count: u32) -> Sampling {
        Sampling { count, filter: Filter::Box, seed: 0 }
    }
}

impl Options<'_> {
    /// How each pixel is sampled, if not in its middle alone.
    pub(super) fn sampling(&self) -> Option<Sampling> {
        self.samples.filter(|s| s.count > 1)
    }
}

/// Makes variables of an image anew, as they are at a sample's places of the pixels that the image holds.
pub type Resample<'o> = dyn Fn(&Image<'_>, &Places) -> Result<Image<'static>, HostError> + Sync + 'o;

/// Where a sample lies in each pixel.
#[derive(Clone, Copy, Debug)]
pub struct Places {
    sampling: Sampling,
    /// Which sample, from 0.
    pub(super) sample: u32,
    /// Is it at the same place in all pixels, so that a grid of them stays one?
    pub(super) alike: bool,
}

impl Places {
    pub(super) fn new(sampling: Sampling, sample: u32, alike: bool) -> Places {
        Places { sampling, sample, alike }
    }

    /// How far from its middle a pixel of the display window is sampled: columns to the right, rows down.
    pub fn offset(&self, pixel: [i32; 2]) -> [f32; 2] {
        let Places { sampling, sample, alike } = *self;
        let [column, row] = if alike { [0, 0] } else { pixel.map(|i| i as u32) };
        let bits = hash::mix(hash::mix(hash::mix(hash::mix(sampling.seed) ^ column) ^ row) ^ sample);
        // Parts of one area: rows of places, as many in one row as in another or one more.
        let (count, sample) = (u64::from(sampling.count), u64::from(sample));
        let rows = count.isqrt();
        let of = sample * rows / count;
        let first = (of * count).div_ceil(rows);
        let end = ((of + 1) * count).div_ceil(rows);
        let random = |bits: u32| (f64::from(bits >> 8) + 0.5) * (1.0 / f64::from(1 << 24));
        let x = ((sample - first) as f64 + random(bits)) / (end - first) as f64;
        let y = (first as f64 + (end - first) as f64 * random(hash::mix(!bits))) / count as f64;
        [x, y].map(|x| sampling.filter.place(x) as f32)
    }

    /// Do samples count differently?
    pub(super) fn signed(&self) -> bool {
        matches!(self.sampling.filter, Filter::CatmullRom | Filter::Mitchell)
    }

    /// How much a sample counts: 1 or -1.
    pub(super) fn weight(&self, pixel: [i32; 2]) -> f64 {
        match self.sampling.filter {
            Filter::Box | Filter::Triangle => 1.0,
            filter => {
                let sign = |x: f32| if filter.at(x.into()) < 0.0 { -1.0 } else { 1.0 };
                self.offset(pixel).map(sign).iter().product()
            }
        }
    }
}

/// Places of a filter's table on either side of its middle.
const HALF: usize = 512;

/// The integral of a filter's size from its left end to places in even steps, the last of which is 1.
struct Table(Vec<f64>);

static CATMULL_ROM: LazyLock<Table> = LazyLock::new(|| Table::of(Filter::CatmullRom));
static MITCHELL: LazyLock<Table> = LazyLock::new(|| Table::of(Filter::Mitchell));

impl Table {
    fn of(filter: Filter) -> Table {
        let step = 2.0 / HALF as f64;
        let mut sums = vec![0.0];
        let mut sum = 0.0;
        for i in 0..2 * HALF {
            sum += filter.at((i as f64 + 0.5) * step - 2.0).abs();
            sums.push(sum);
        }
        Table(sums.into_iter().map(|s| s / sum).collect())
    }

    /// Where the integral has that value.
    fn place(&self, x: f64) -> f64 {
        let i = self.0.partition_point(|&s| s <= x).clamp(1, 2 * HALF);
        let (a, b) = (self.0[i - 1], self.0[i]);
        (i as f64 - 1.0 + (x - a) / (b - a)) * (2.0 / HALF as f64) - 2.0
    }
}

impl Filter {
    /// Its height at a distance.
    fn at(self, x: f64) -> f64 {
        let x = x.abs();
        let cubic = |near: [f64; 3], far: [f64; 4]| match x {
            x if x < 1.0 => near[0] + x * x * (near[1] + x * near[2]),
            x if x < 2.0 => far[0] + x * (far[1] + x * (far[2] + x * far[3])),
            _ => 0.0,
        };
        match self {
            Filter::Box => f64::from(u8::from(x <= 0.5)),
            Filter::Triangle => (1.0 - x).max(0.0),
            Filter::CatmullRom => cubic([1.0, -2.5, 1.5], [2.0, -4.0, 2.5, -0.5]),
            Filter::Mitchell => {
                cubic([16.0 / 18.0, -2.0, 21.0 / 18.0], [32.0 / 18.0, -60.0 / 18.0, 36.0 / 18.0, -7.0 / 18.0])
            }
        }
    }

    /// Where a share x of what lies under it lies to the left.
    fn place(self, x: f64) -> f64 {
        match self {
            Filter::Box => x - 0.5,
            Filter::Triangle if x < 0.5 => (2.0 * x).sqrt() - 1.0,
            Filter::Triangle => 1.0 - (2.0 - 2.0 * x).sqrt(),
            Filter::CatmullRom => CATMULL_ROM.place(x),
            Filter::Mitchell => MITCHELL.place(x),
        }
    }
}

/// Does the variable tell things apart, so that there is nothing between two of its values?
pub(super) fn is_id(name: &str) -> bool {
    name == "surface" || name.ends_with(".surface")
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILTERS: [Filter; 4] = [Filter::Box, Filter::Triangle, Filter::CatmullRom, Filter::Mitchell];

    #[test]
    fn places_lie_in_parts_of_one_area() {
        for count in [2u32, 3, 5, 7, 16, 50, 64] {
            let mut seen = vec![0; count as usize];
            let rows = count.isqrt();
            for sample in 0..count {
                let [x, y] = Places::new(Sampling::of(count), sample, false).offset([7, -3]);
                assert!(x.abs() <= 0.5 && y.abs() <= 0.5);
                let at = ((y + 0.5) * count as f32) as u32;
                let row = at * rows / count;
                let (first, end) = ((row * count).div_ceil(rows), ((row + 1) * count).div_ceil(rows));
                seen[(first + ((x + 0.5) * (end - first) as f32) as u32) as usize] += 1;
            }
            assert!(seen.iter().all(|&n| n == 1), "{count}: {seen:?}");
        }
    }

    #[test]
    fn samples_lie_as_the_filter_does() {
        for filter in FILTERS {
            // The mean of x² under the filter, by its formula and by places.
            let (steps, mut wanted, mut area) = (4000, 0.0f64, 0.0f64);
            for i in 0..steps {
                let x = (f64::from(i) + 0.5) / f64::from(steps) * 4.0 - 2.0;
                wanted += filter.at(x) * x * x;
                area += filter.at(x);
            }
            let (mut found, mut weight) = (0.0f64, 0.0f64);
            for i in 0..steps {
                let x = filter.place((f64::from(i) + 0.5) / f64::from(steps));
                let sign = if filter.at(x) < 0.0 { -1.0 } else { 1.0 };
                found += sign * x * x;
                weight += sign;
            }
            assert!((area * 4.0 / f64::from(steps) - 1.0).abs() < 1e-3, "{filter:?}: {area}");
            assert!((found / weight - wanted / area).abs() < 2e-3, "{filter:?}");
        }
    }
}
