//! What the workloads share: blocks of lanes, those of them that lie on the surface, loops over planes.

use pse::Image;
use pse::internal::lanes::{Isa, Kernel};
use std::array::from_fn;
use std::ops::Range;

/// Lanes of a block: a few buffers of so many stay in the nearest cache.
pub const LANES: usize = 512;

/// A buffer for a block.
pub type Row = [f32; LANES];

/// The planes of a variable.
pub fn planes<'a, const N: usize>(image: &'a Image<'_>, name: &str) -> [&'a [f32]; N] {
    let variable = image.variable(name).expect("the image has what its workload needs");
    assert_eq!(variable.planes.len(), N, "planes of {name}");
    from_fn(|k| &variable.planes[k][..])
}

/// The only plane of a variable.
pub fn plane<'a>(image: &'a Image<'_>, name: &str) -> &'a [f32] {
    let [plane] = planes(image, name);
    plane
}

/// A stretch of each plane.
#[inline(always)]
pub fn part<'a, const N: usize>(planes: [&'a [f32]; N], at: &Range<usize>) -> [&'a [f32]; N] {
    planes.map(|plane| &plane[at.clone()])
}

/// What is done with a block of at most [`LANES`] pixels. Must be `#[inline(always)]`.
pub trait Workload<const OUT: usize> {
    fn block(&mut self, isa: Isa, at: Range<usize>, out: [&mut [f32]; OUT]);
}

/// All blocks of an image, one after another, and the planes that they fill.
pub fn run<W: Workload<OUT>, const OUT: usize>(isa: Isa, image: &Image<'_>, workload: W) -> Vec<Vec<f32>> {
    let mut planes: [Vec<f32>; OUT] = from_fn(|_| vec![0.0; image.width * image.height]);
    isa.run(Blocks { isa, workload, planes: planes.each_mut().map(|plane| &mut plane[..]) });
    planes.into()
}

struct Blocks<'a, W, const OUT: usize> {
    isa: Isa,
    workload: W,
    planes: [&'a mut [f32]; OUT],
}

impl<W: Workload<OUT>, const OUT: usize> Kernel for Blocks<'_, W, OUT> {
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        let total = self.planes[0].len();
        for start in (0..total).step_by(LANES) {
            let at = start..(start + LANES).min(total);
            let out = self.planes.each_mut().map(|plane| &mut plane[at.clone()]);
            self.workload.block(self.isa, at, out);
        }
    }
}

/// The lanes of a block that lie on the surface.
pub struct Hits {
    list: [u16; LANES],
    /// How many they are.
    pub count: usize,
    all: bool,
}

impl Hits {
    pub fn new() -> Hits {
        Hits { list: [0; LANES], count: 0, all: false }
    }

    #[inline(always)]
    pub fn find(&mut self, surface: &[f32]) {
        self.count = hits(surface);
        self.all = self.count == surface.len();
        // The list is needed only where an outline goes through the block.
        if self.count > 0 && !self.all {
            let mut next = 0;
            for (i, &surface) in surface.iter().enumerate() {
                self.list[next % LANES] = i as u16;
                next += usize::from(surface == 1.0);
            }
        }
    }

    /// Their numbers out of a block's, without gaps.
    #[inline(always)]
    pub fn pick(&self, from: &[f32], to: &mut Row) {
        if self.all {
            to[..from.len()].copy_from_slice(from);
        } else {
            for (to, &lane) in to[..self.count].iter_mut().zip(&self.list) {
                *to = from[usize::from(lane)];
            }
        }
    }

    /// Their numbers put back, and `off` in all other lanes.
    #[inline(always)]
    pub fn put<const OUT: usize>(&self, from: &[Row; OUT], out: [&mut [f32]; OUT], off: [f32; OUT]) {
        for ((from, out), off) in from.iter().zip(out).zip(off) {
            if self.all {
                out.copy_from_slice(&from[..out.len()]);
                continue;
            }
            out.fill(off);
            for (from, &lane) in from[..self.count].iter().zip(&self.list) {
                out[usize::from(lane)] = *from;
            }
        }
    }
}

/// How many lanes lie on the surface.
#[inline(always)]
pub fn hits(surface: &[f32]) -> usize {
    surface.iter().map(|&surface| u32::from(surface == 1.0)).sum::<u32>() as usize
}

/// So many lanes are computed at a time, into buffers of which the compiler knows that they are apart.
const STRIP: usize = 32;

/// What is computed of a lane's numbers. Must be `#[inline(always)]`.
pub trait Formula<const N: usize, const OUT: usize> {
    fn of(&self, lane: [f32; N]) -> [f32; OUT];
}

struct Closure<F>(F);

impl<F: Fn([f32; N]) -> [f32; OUT], const N: usize, const OUT: usize> Formula<N, OUT> for Closure<F> {
    #[inline(always)]
    fn of(&self, lane: [f32; N]) -> [f32; OUT] {
        self.0(lane)
    }
}

/// Computes a closure of a few lines in each lane. The compiler would call a large one, and then nothing of it would
/// be vectorised: that must be a [`Formula`].
#[inline(always)]
pub fn each<const N: usize, const OUT: usize>(
    inputs: [&[f32]; N],
    out: [&mut [f32]; OUT],
    f: impl Fn([f32; N]) -> [f32; OUT],
) {
    each_of(inputs, out, Closure(f));
}

/// Computes a formula in each lane.
#[inline(always)]
pub fn each_of<const N: usize, const OUT: usize>(
    inputs: [&[f32]; N],
    mut out: [&mut [f32]; OUT],
    formula: impl Formula<N, OUT>,
) {
    let n = out[0].len();
    let inputs = inputs.map(|plane| &plane[..n]);
    let whole = n - n % STRIP;
    for start in (0..whole).step_by(STRIP) {
        let strips: [&[f32; STRIP]; N] =
            from_fn(|k| inputs[k][start..].first_chunk().expect("it is within the planes"));
        let mut results = [[0.0; STRIP]; OUT];
        for i in 0..STRIP {
            let result = formula.of(from_fn(|k| strips[k][i]));
            for k in 0..OUT {
                results[k][i] = result[k];
            }
        }
        for (out, strip) in out.iter_mut().zip(&results) {
            out[start..start + STRIP].copy_from_slice(strip);
        }
    }
    for i in whole..n {
        let result = formula.of(from_fn(|k| inputs[k][i]));
        for k in 0..OUT {
            out[k][i] = result[k];
        }
    }
}

/// The larger number, as the language has it.
#[inline(always)]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b || a.is_nan() { a } else { b }
}

/// The smaller number.
#[inline(always)]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b || a.is_nan() { a } else { b }
}

#[inline(always)]
pub fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub fn norm(v: [f32; 3]) -> f32 {
    dot(v, v).sqrt()
}

/// `v / length`; zero vectors stay zero.
#[inline(always)]
pub fn over(v: [f32; 3], length: f32) -> [f32; 3] {
    v.map(|x| {
        let quotient = x / length;
        if length == 0.0 { 0.0 } else { quotient }
    })
}

/// What the workloads' light leaves of a surface.
#[inline(always)]
pub fn lit(normal: [f32; 3]) -> f32 {
    max(0.1, dot(normal, [1.0, 0.0, 0.0]))
}
