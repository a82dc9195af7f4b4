//! The noise kernels on batches of 512 scattered points, in one run: divide the times by 512.
//!
//! `baseline` is the same loop compiled for every machine of the target; `one point a call` is what an
//! evaluator without batches would pay.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use pse::lanes::{Arg, Isa};
use pse::math;
use pse::noise::{KINDS, Params, random};

const LANES: usize = 512;

fn scattered(seed: u32) -> Vec<f32> {
    let mut points = vec![0.0; LANES];
    let lanes: Vec<f32> = (0..LANES).map(|i| i as f32).collect();
    random::random(Isa::detect(), &[&lanes], seed, &mut points);
    points.iter_mut().for_each(|x| *x = *x * 200.0 - 100.0);
    points
}

fn kernels(criterion: &mut Criterion) {
    let (x, y, z) = (scattered(1), scattered(2), scattered(3));
    let p: [&[f32]; 3] = [&x, &y, &z];
    let mut out = [vec![0.0; LANES], vec![0.0; LANES], vec![0.0; LANES]];
    for isa in [Isa::detect(), Isa::baseline()] {
        let mut group = criterion.benchmark_group(format!("noise {}", isa.name()));
        group.throughput(Throughput::Elements(LANES as u64));
        for kind in KINDS {
            let name = kind.name;
            for d in 1..=3 {
                let Ok(field) = kind.field(d, &Params::default()) else { continue };
                group.bench_function(format!("{name} {d}-D"), |b| {
                    b.iter(|| field.noise(isa, black_box(&p[..d]), &mut out[0]));
                });
            }
            let Ok(field) = kind.field(3, &Params::default()) else { continue };
            group.bench_function(format!("{name} derivative"), |b| {
                let [dx, dy, dz] = &mut out;
                b.iter(|| field.derivative(isa, black_box(&p), &mut [&mut *dx, &mut *dy, &mut *dz]));
            });
        }
        group.bench_function("random", |b| b.iter(|| random::random(isa, black_box(&p), 0, &mut out[0])));
        group.finish();
    }
}

fn mathematics(criterion: &mut Criterion) {
    let (x, y) = (scattered(1), scattered(2));
    let mut out = vec![0.0; LANES];
    for isa in [Isa::detect(), Isa::baseline()] {
        let mut group = criterion.benchmark_group(format!("math {}", isa.name()));
        group.throughput(Throughput::Elements(LANES as u64));
        group.bench_function("sin", |b| b.iter(|| math::sin_lanes(isa, black_box(&x), &mut out)));
        group.bench_function("exp", |b| b.iter(|| math::exp_lanes(isa, black_box(&x), &mut out)));
        group.bench_function("log", |b| b.iter(|| math::log_lanes(isa, black_box(&x), &mut out)));
        group.bench_function("pow", |b| {
            b.iter(|| math::pow_lanes(isa, Arg::Varying(black_box(&x)), Arg::Varying(&y), &mut out));
        });
        group.finish();
    }
}

criterion_group!(benches, kernels, mathematics);
criterion_main!(benches);
