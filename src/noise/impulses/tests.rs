//! The process and the sums, against plain loops in f64.

use super::*;
use crate::noise::direction::{LENGTH, direction as towards};
use crate::noise::{Field, Kind};
use std::f64::consts::PI;

/// Even numbers in -size … size, from a linear congruence.
struct Random(u64);

impl Random {
    fn within(&mut self, size: f32) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as f32 / (1_u32 << 30) as f32 - 1.0) * size
    }

    fn points<const D: usize>(&mut self, n: usize, size: f32) -> [Vec<f32>; D] {
        std::array::from_fn(|_| (0..n).map(|_| self.within(size)).collect())
    }
}

fn slices<const D: usize>(p: &[Vec<f32>; D]) -> [&[f32]; D] {
    std::array::from_fn(|k| &p[k][..])
}

fn noise(field: &dyn Field, isa: Isa, p: &[&[f32]]) -> Vec<f32> {
    let mut out = vec![0.0; p[0].len()];
    field.noise(isa, p, &mut out);
    out
}

fn derivative(field: &dyn Field, isa: Isa, p: &[&[f32]]) -> Vec<Vec<f32>> {
    let mut out = vec![vec![0.0; p[0].len()]; p.len()];
    let mut planes: Vec<&mut [f32]> = out.iter_mut().map(Vec::as_mut_slice).collect();
    field.derivative(isa, p, &mut planes);
    out
}

fn layout(radius: f64, density: f64, octave: i32) -> Layout {
    Layout { octave, radius, density, scale: 1.0 }
}

/// The impulses of a cell: coordinates in it, 0 … 1, size and word.
fn of_cell<const D: usize>(process: &Process<D>, cell: [f32; D]) -> Vec<([f64; D], f64, u32)> {
    let key = |k: usize| match &process.periodic {
        None => process.lattice.key(k, cell[k]),
        Some(lattice) => lattice.key(k, cell[k]),
    };
    let hash = hash::point((0..D).fold(0, |joined, k| joined ^ key(k)));
    let part = |factor: u32| f64::from(hash.wrapping_mul(factor) as i32) / 4_294_967_296.0;
    let slots = process.slots.iter().take_while(|slot| hash as i32 > slot.above);
    slots.map(|s| (s.place.map(|f| part(f) + 0.5), 2.0 * part(s.size), hash.wrapping_mul(s.word))).collect()
}

/// The sum of a kernel over the impulses near a point: of its offset from the impulse in units, size and word.
fn sum<const D: usize>(process: &Process<D>, p: [f64; D], kernel: impl Fn([f64; D], f64, u32) -> f64) -> f64 {
    let (cells, span) = (f64::from(process.cells), 2 * process.reach + 1);
    let all = (0..span.pow(D as u32)).map(|i| -> [f64; D] {
        std::array::from_fn(|k| (p[k] * cells).floor() + (i / span.pow(k as u32) % span) as f64)
    });
    let near = all.map(|cell| cell.map(|x| x - process.reach as f64));
    near.flat_map(|cell| of_cell(process, cell.map(|x| x as f32)).into_iter().map(move |i| (cell, i)))
        .map(|(cell, (at, size, word))| {
            kernel(std::array::from_fn(|k| p[k] - (cell[k] + at[k]) / cells), size, word)
        })
        .sum()
}

#[test]
fn impulses_are_a_poisson_process() {
    let mean = 1.7;
    let process = Process::<3>::new(&layout(1.0, mean, 0), &Params::seeded(4)).unwrap();
    let mut counts = [0; 12];
    // Sums of coordinates and size, of their products, and of products with those of the next impulse.
    let (mut n, mut sums, mut products, mut next) = (0.0, [0.0; 4], [[0.0; 4]; 4], [[0.0; 4]; 4]);
    for i in 0..64_000 {
        let cell = [i % 40 - 20, i / 40 % 40 - 20, i / 1600 - 20].map(|x| x as f32);
        let all: Vec<[f64; 4]> = of_cell(&process, cell)
            .into_iter()
            .map(|(at, size, _)| [at[0] - 0.5, at[1] - 0.5, at[2] - 0.5, size / 2.0])
            .collect();
        counts[all.len()] += 1;
        for (i, x) in all.iter().enumerate() {
            n += 1.0;
            for k in 0..4 {
                sums[k] += x[k];
                for l in 0..4 {
                    products[k][l] += 12.0 * x[k] * x[l];
                    next[k][l] += all.get(i + 1).map_or(0.0, |y| 12.0 * x[k] * y[l]);
                }
            }
        }
    }
    let mut share = libm::exp(-mean) * 64_000.0;
    for (k, &count) in counts.iter().enumerate() {
        assert!((f64::from(count) - share).abs() < 4.0 * share.sqrt() + 2.0, "{k}: {count} for {share}");
        share *= mean / (k + 1) as f64;
    }
    for k in 0..4 {
        assert!((sums[k] / n).abs() < 0.004, "{sums:?}");
        for l in 0..4 {
            let known = if k == l { 1.0 } else { 0.0 };
            assert!((products[k][l] / n - known).abs() < 0.015, "{products:?}");
            assert!((next[k][l] / n).abs() < 0.015, "{next:?}");
        }
    }
}

#[test]
fn factors_have_no_common_law() {
    // If small multiples of two of them summed up to nearly 0, impulses would lie on lines.
    let slots = slots::<4>(3.0);
    let factors: Vec<u32> =
        slots[..8].iter().flat_map(|s| s.place.into_iter().chain([s.size, s.word])).collect();
    for (i, &a) in factors.iter().enumerate() {
        for &b in &factors[..i] {
            for m in 0..=8_u32 {
                for n in -8..=8_i32 {
                    let sum = a.wrapping_mul(m).wrapping_add(b.wrapping_mul(n as u32)) as i32;
                    assert!((m, n) == (0, 0) || sum.unsigned_abs() > 500, "{a:x} {b:x}: {m} {n}");
                }
            }
        }
    }
}

fn length<const D: usize>(x: [f64; D]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn gaussian(r: f64) -> f64 {
    if r < 1.0 { libm::exp(-4.5 * r * r) * libm::pow(1.0 - libm::pow(r, 8.0), 2.0) } else { 0.0 }
}

/// Field against sum, values and derivatives.
fn agree<const D: usize>(
    name: &str,
    params: &Params,
    layout: &Layout,
    square: f64,
    kernel: impl Fn([f64; D], f64, u32) -> f64,
) {
    let (n, scale) = (150, 0.3 / (layout.density * square).sqrt());
    let field = Kind::from_name(name).unwrap().field(D, params).unwrap();
    let process = Process::<D>::new(layout, params).unwrap();
    let p = Random(D as u64).points::<D>(n, 40.0);
    let (values, slopes) =
        (noise(&*field, Isa::detect(), &slices(&p)), derivative(&*field, Isa::detect(), &slices(&p)));
    for i in 0..n {
        let at = std::array::from_fn(|k| f64::from(p[k][i]));
        let known = scale * sum(&process, at, &kernel);
        assert!((f64::from(values[i]) - known).abs() < 1e-4, "{params:?} {at:?}: {} {known}", values[i]);
        for k in 0..D {
            let moved = |by: f64| {
                let mut at = at;
                at[k] += by;
                scale * sum(&process, at, &kernel)
            };
            let known = (moved(1e-4) - moved(-1e-4)) / 2e-4;
            let slope = f64::from(slopes[k][i]);
            // Slopes are up to 6; the kernels are approximations.
            assert!((slope - known).abs() < 3e-3, "{params:?} {at:?}: {slope} {known}");
        }
    }
}

/// All kernels of sparse convolution.
fn sparse<const D: usize>(params: &Params) {
    let name = "sparse_convolution";
    let radial = |params: &Params, radius: f64, density: f64, h: &dyn Fn(f64) -> f64| {
        let square = integral(D, radius, |r| h(r) * h(r)) / 3.0;
        agree::<D>(name, params, &layout(radius, density, 0), square, |x, size, _| size * h(length(x)));
    };
    let cosine = |r: f64| if r < 1.0 { 0.5 + 0.5 * libm::cos(PI * r) } else { 0.0 };
    radial(params, 1.0, 3.0, &cosine);
    let thin = params.clone().with(Opt::Density, &[0.25]);
    radial(&thin, 1.0, 0.25, &cosine);
    let kernel = |word: &str| thin.clone().with_choice(Opt::Kernel, word);
    radial(&kernel("gaussian"), 1.0, 0.25, &gaussian);
    radial(&kernel("catmull_rom"), 2.0, 0.25, &CatmullRom::at);
    let knots = [1.0, -0.5, 0.25, 0.0];
    radial(&thin.clone().with(Opt::Knots, &knots), 1.0, 0.25, &|r| Curve::new(&knots).at(r));
    let gabor = kernel("gabor").with(Opt::Frequency, &[1.5]);
    let square = |r: f64| gaussian(r) * gaussian(r) * (0.5 + 0.5 * mean_cosine(D, 3.0 * r));
    agree::<D>(name, &gabor, &layout(1.0, 0.25, 0), integral(D, 1.0, square) / 3.0, |x, size, _| {
        size * gaussian(length(x)) * libm::cos(2.0 * PI * 1.5 * x[0])
    });
}

#[test]
fn sparse_convolution_is_the_sum() {
    sparse::<1>(&Params::seeded(2));
    sparse::<2>(&Params::seeded(2));
    sparse::<3>(&Params::seeded(2).with(Opt::Period, &[3.0]));
    sparse::<4>(&Params::seeded(2));
}

fn waves<const D: usize>(frequency: f32, octave: i32) {
    // The Gaussian's deviation is such that its transform is a half at a third of the frequency, for an octave.
    let deviation = libm::sqrt(2.0 * std::f64::consts::LN_2) / (2.0 * PI * f64::from(frequency) / 3.0);
    let (density, radius) = (0.5, 3.0 * deviation);
    let params = Params::seeded(7).with(Opt::Density, &[0.5]).with(Opt::Frequency, &[frequency]);
    let energy = |r: f64| gaussian(r / radius) * gaussian(r / radius) / 2.0;
    let (layout, square) = (layout(radius, density, octave), integral(D, radius, energy));
    let turn = |word: u32| f64::from(word as i32) / 4_294_967_296.0;
    let kernel = |x: [f64; D], along: [f64; D], word: u32| {
        let turns: f64 = (0..D).map(|k| -f64::from(frequency) * along[k] * x[k]).sum();
        gaussian(length(x) / radius) * libm::cos(2.0 * PI * (turns + turn(word)))
    };
    agree::<D>("gabor", &params, &layout, square, |x, _, word| {
        let angle = 2.0 * PI * turn(hash::more(word));
        let around = towards::<3>(hash::more(word)).map(|x| f64::from(x / LENGTH));
        let along = match D {
            1 => [1.0, 0.0, 0.0],
            2 => [libm::cos(angle), libm::sin(angle), 0.0],
            _ => around,
        };
        kernel(x, std::array::from_fn(|k| along[k]), word)
    });
    let along = std::array::from_fn(|k| [0.0, 0.6, 0.8, 1.0][k + 4 - D]);
    let given: Vec<f32> = along.iter().map(|x| (x * 5.0) as f32).collect();
    let length = along.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
    let params = params.with(Opt::Direction, &given);
    agree::<D>("gabor", &params, &layout, square, |x, _, word| kernel(x, along.map(|a| a / length), word));
}

#[test]
fn gabor_is_the_sum() {
    waves::<1>(1.0, 0);
    waves::<2>(0.5, 1);
    waves::<3>(2.5, -1);
}

/// Lanes in runs and alone, of one instruction set or another, in any number: the same bits.
fn same_bits<const D: usize>(field: &dyn Field) {
    let mut random = Random(11);
    let bits = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
    for step in [0.01, 0.05, 0.2, 3.0] {
        let n = 131;
        let mut p: [Vec<f32>; D] = std::array::from_fn(|_| {
            let (start, step) = (random.within(50.0), random.within(step));
            (0..n).map(|i| start + step * i as f32).collect()
        });
        for (i, x) in
            [f32::NAN, f32::INFINITY, 1e30, -f32::MAX, 16_777_216.0, -0.0, -1e-30].iter().enumerate()
        {
            p[i % D][i * 17 + 5] = *x;
        }
        let values = noise(field, Isa::detect(), &slices(&p));
        let slopes = derivative(field, Isa::detect(), &slices(&p));
        let others =
            (noise(field, Isa::baseline(), &slices(&p)), derivative(field, Isa::baseline(), &slices(&p)));
        for i in 0..n {
            let one = slices(&p).map(|x| &x[i..=i]);
            let (value, slope) =
                (noise(field, Isa::detect(), &one), derivative(field, Isa::baseline(), &one));
            assert_eq!([bits(value[0]), bits(others.0[i])], [bits(values[i]); 2], "step {step}, lane {i}");
            for k in 0..D {
                let known = bits(slopes[k][i]);
                assert_eq!([bits(slope[k][0]), bits(others.1[k][i])], [known; 2], "step {step}, lane {i}");
            }
            assert_eq!(values[i].is_nan(), one.iter().any(|x| !x[0].is_finite()), "lane {i}");
        }
    }
}

#[test]
fn every_path_gives_the_same_bits() {
    let of = |name: &str, d: usize, params: Params| Kind::from_name(name).unwrap().field(d, &params).unwrap();
    for density in [0.1, 1.0, 5.0] {
        let params = Params::seeded(5).with(Opt::Density, &[density]);
        same_bits::<1>(&*of("sparse_convolution", 1, params.clone()));
        same_bits::<2>(&*of("sparse_convolution", 2, params.clone()));
        same_bits::<3>(&*of("sparse_convolution", 3, params.clone()));
        same_bits::<2>(&*of("gabor", 2, params));
    }
    let thin = Params::seeded(5).with(Opt::Density, &[0.3]);
    same_bits::<4>(&*of("sparse_convolution", 4, thin.clone()));
    same_bits::<3>(&*of("gabor", 3, thin.clone()));
    same_bits::<2>(&*of("gabor", 2, thin.clone().with(Opt::Direction, &[1.0, 2.0])));
    for kernel in ["catmull_rom", "gaussian", "gabor"] {
        same_bits::<2>(&*of("sparse_convolution", 2, thin.clone().with_choice(Opt::Kernel, kernel)));
    }
    same_bits::<3>(&*of("sparse_convolution", 3, thin.with(Opt::Knots, &[1.0, 0.2, 0.0])));
}

#[test]
fn repeats_after_the_period() {
    let p = Random(3).points::<2>(500, 20.0).map(|x| x.iter().map(|x| (x * 64.0).round() / 64.0).collect());
    let q: [Vec<f32>; 2] = std::array::from_fn(|k| {
        let x: &Vec<f32> = &p[k];
        x.iter().enumerate().map(|(i, x)| x + [6.0, 10.0][k] * (i % 7) as f32).collect()
    });
    let period = Params::seeded(1).with(Opt::Period, &[6.0, 10.0]);
    for (name, params) in [
        ("sparse_convolution", period.clone()),
        ("sparse_convolution", period.clone().with_choice(Opt::Kernel, "catmull_rom")),
        ("gabor", period.clone()),
        ("gabor", period.clone().with(Opt::Frequency, &[0.5])),
        ("gabor", period.with(Opt::Frequency, &[3.0])),
    ] {
        let field = Kind::from_name(name).unwrap().field(2, &params).unwrap();
        let (here, there) =
            (noise(&*field, Isa::detect(), &slices(&p)), noise(&*field, Isa::detect(), &slices(&q)));
        assert_eq!(here, there, "{name} {params:?}");
    }
}
