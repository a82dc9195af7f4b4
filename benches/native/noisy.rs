//! The workloads that are mostly noise: spotted, marble, wrinkled.

use super::frame::{Hits, LANES, Row, Workload, each, lit, norm, over, part, plane, planes, run};
use pse::Image;
use pse::internal::lanes::Isa;
use pse::internal::math;
use pse::noise::{Field, Kind, Params};
use std::ops::Range;
use std::sync::Arc;

fn gradient() -> Arc<dyn Field> {
    let kind = Kind::from_name("gradient").expect("it is a kind of noise");
    kind.field(3, &Params::default()).expect("it has three dimensions")
}

/// What the three need.
struct Torus<'a> {
    surface: &'a [f32],
    point: [&'a [f32]; 3],
    normal: [&'a [f32]; 3],
    noise: Arc<dyn Field>,
    hits: Hits,
}

impl<'a> Torus<'a> {
    fn new(image: &'a Image<'_>) -> Torus<'a> {
        Torus {
            surface: plane(image, "surface"),
            point: planes(image, "point"),
            normal: planes(image, "normal"),
            noise: gradient(),
            hits: Hits::new(),
        }
    }

    /// Finds the lanes on the surface; tells whether there are any, and if not, paints the block.
    #[inline(always)]
    fn seen(&mut self, at: &Range<usize>, out: &mut [&mut [f32]; 3], off: [f32; 3]) -> bool {
        self.hits.find(&self.surface[at.clone()]);
        if self.hits.count == 0 {
            out.iter_mut().zip(off).for_each(|(out, off)| out.fill(off));
        }
        self.hits.count > 0
    }

    #[inline(always)]
    fn pick<const N: usize>(&self, planes: [&[f32]; N], at: &Range<usize>, to: &mut [Row; N]) {
        for (plane, to) in part(planes, at).into_iter().zip(to) {
            self.hits.pick(plane, to);
        }
    }
}

/// What is beside the torus.
const BLUE: [f32; 3] = [0.0, 0.0, 0.1];

/// The first `n` lanes of some rows.
#[inline(always)]
fn first<const N: usize>(rows: &[Row; N], n: usize) -> [&[f32]; N] {
    rows.each_ref().map(|row| &row[..n])
}

#[inline(always)]
fn first_mut<const N: usize>(rows: &mut [Row; N], n: usize) -> [&mut [f32]; N] {
    rows.each_mut().map(|row| &mut row[..n])
}

#[inline(always)]
fn multiply(rows: &mut [Row; 3], n: usize, factor: f32) {
    for row in rows {
        row[..n].iter_mut().for_each(|x| *x *= factor);
    }
}

/// `spotted.pse`
pub fn spotted(isa: Isa, image: &Image<'_>) -> Vec<Vec<f32>> {
    run(isa, image, Spotted { torus: Torus::new(image), p: [[0.0; LANES]; 3], spots: [[0.0; LANES]; 1] })
}

struct Spotted<'a> {
    torus: Torus<'a>,
    p: [Row; 3],
    spots: [Row; 1],
}

impl Workload<3> for Spotted<'_> {
    #[inline(always)]
    fn block(&mut self, isa: Isa, at: Range<usize>, mut out: [&mut [f32]; 3]) {
        let Spotted { torus, p, spots } = self;
        if !torus.seen(&at, &mut out, [0.0; 3]) {
            return;
        }
        let n = torus.hits.count;
        torus.pick(torus.point, &at, p);
        multiply(p, n, 8.0);
        torus.noise.noise(isa, &first(p, n), &mut spots[0][..n]);
        for out in out {
            torus.hits.put(spots, [out], [0.0]);
        }
    }
}

/// `marble.pse`
pub fn marble(isa: Isa, image: &Image<'_>) -> Vec<Vec<f32>> {
    let row = [0.0; LANES];
    let marble = Marble {
        torus: Torus::new(image),
        stone: std::array::from_fn(|k| spline(STONE.map(|color| color[k]))),
        p: [row; 3],
        x: [row; 1],
        noise: row,
        sum: row,
        color: [row; 3],
    };
    run(isa, image, marble)
}

struct Marble<'a> {
    torus: Torus<'a>,
    /// The pieces of the spline of each component.
    stone: [[[f32; 4]; PIECES]; 3],
    p: [Row; 3],
    x: [Row; 1],
    noise: Row,
    sum: Row,
    color: [Row; 3],
}

const STONE: [[f32; 3]; PIECES + 3] = [
    [0.05, 0.05, 0.15],
    [0.2, 0.2, 0.35],
    [0.85, 0.8, 0.75],
    [0.95, 0.95, 0.9],
    [0.5, 0.4, 0.4],
    [0.1, 0.05, 0.1],
];
const PIECES: usize = 3;

/// The polynomials of a Catmull–Rom spline, constant first.
fn spline(knots: [f32; PIECES + 3]) -> [[f32; 4]; PIECES] {
    std::array::from_fn(|i| {
        let [a, b, c, d] = std::array::from_fn(|k| knots[i + k]);
        [b, -0.5 * a + 0.5 * c, a - 2.5 * b + 2.0 * c - 0.5 * d, -0.5 * a + 1.5 * b - 1.5 * c + 0.5 * d]
    })
}

#[inline(always)]
fn stone(pieces: &[[[f32; 4]; PIECES]; 3], t: f32) -> [f32; 3] {
    let at = t.clamp(0.0, 1.0) * PIECES as f32;
    let piece = at.floor().min((PIECES - 1) as f32);
    let x = at - piece;
    pieces.each_ref().map(|p| {
        // There are so few that to choose is cheaper than to look up.
        let c = |k: usize| {
            let lower = if piece < 1.0 { p[0][k] } else { p[1][k] };
            if piece < 2.0 { lower } else { p[2][k] }
        };
        ((c(3) * x + c(2)) * x + c(1)) * x + c(0)
    })
}

impl Workload<3> for Marble<'_> {
    #[inline(always)]
    fn block(&mut self, isa: Isa, at: Range<usize>, mut out: [&mut [f32]; 3]) {
        let Marble { torus, stone: pieces, p, x, noise, sum, color } = self;
        if !torus.seen(&at, &mut out, BLUE) {
            return;
        }
        let n = torus.hits.count;
        torus.pick(torus.point, &at, p);
        *x = [p[0]];
        sum[..n].fill(0.0);
        let mut scale = 1.0;
        while scale > 1.0 / 256.0 {
            torus.noise.noise(isa, &first(p, n), &mut noise[..n]);
            for (sum, noise) in sum[..n].iter_mut().zip(&noise[..n]) {
                *sum += noise.abs() * scale;
            }
            multiply(p, n, 2.0);
            scale /= 2.0;
        }
        for ((arg, x), sum) in noise[..n].iter_mut().zip(&x[0]).zip(&sum[..n]) {
            *arg = 8.0 * (x + sum);
        }
        math::sin_lanes(isa, &noise[..n], &mut sum[..n]);
        torus.pick(torus.normal, &at, p);
        let [x, y, z] = first(p, n);
        each([&sum[..n], x, y, z], first_mut(color, n), |[sine, x, y, z]| {
            let light = lit([x, y, z]);
            stone(pieces, 0.5 + 0.5 * sine).map(|c| c * light)
        });
        torus.hits.put(color, out, BLUE);
    }
}

/// `wrinkled.pse`
pub fn wrinkled(isa: Isa, image: &Image<'_>) -> Vec<Vec<f32>> {
    let rows = [[0.0; LANES]; 3];
    run(isa, image, Wrinkled { torus: Torus::new(image), p: rows, slope: rows, normal: rows })
}

struct Wrinkled<'a> {
    torus: Torus<'a>,
    p: [Row; 3],
    slope: [Row; 3],
    normal: [Row; 3],
}

impl Workload<3> for Wrinkled<'_> {
    #[inline(always)]
    fn block(&mut self, isa: Isa, at: Range<usize>, mut out: [&mut [f32]; 3]) {
        let Wrinkled { torus, p, slope, normal } = self;
        if !torus.seen(&at, &mut out, BLUE) {
            return;
        }
        let n = torus.hits.count;
        torus.pick(torus.point, &at, p);
        torus.pick(torus.normal, &at, normal);
        let mut f = 1.0;
        while f < 64.0 {
            torus.noise.derivative(isa, &first(p, n), &mut first_mut(slope, n));
            for (normal, slope) in normal.iter_mut().zip(&*slope) {
                for (normal, slope) in normal[..n].iter_mut().zip(&slope[..n]) {
                    *normal += 0.3 * slope;
                }
            }
            multiply(p, n, 2.0);
            f *= 2.0;
        }
        each(first(normal, n), first_mut(slope, n), |normal| {
            let light = lit(over(normal, norm(normal)));
            [light, 0.0 * light, 0.0 * light]
        });
        torus.hits.put(slope, out, BLUE);
    }
}
