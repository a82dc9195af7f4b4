//! What noise costs: every kind and its derivative at points of three dimensions, in batches as the evaluator's, on one
//! thread; beside it Perlin noise of the crate `noise`, called point by point; and the mathematics of `pse::math`.
//!
//! *Scattered* points are even in ±100; *coherent* ones lie as a picture's: on scan lines of a plane through
//! space, 64 points a unit. Times are those of a point. `UPDATE=1 cargo bench --bench noise` writes the medians into
//! `docs/performance.md`.

#[path = "table/mod.rs"]
mod table;

use std::fmt::Write;
use std::hint::black_box;
use std::time::Duration;

use criterion::{
    BenchmarkGroup, Criterion, SamplingMode, Throughput, criterion_group, measurement::WallTime,
};
use noise::{NoiseFn, Perlin};
use pse::internal::lanes::{Arg, Isa};
use pse::internal::math;
use pse::noise::{Field, KINDS, Kind, Opt, Params, random};
use table::Turns;

const LANES: usize = pse::BATCH;
/// So many batches take turns, lest the processor learn the branches of one by heart.
const BATCHES: usize = 16;

/// What lies where: the names of the two groups.
const PLACES: [&str; 2] = ["noise scattered", "noise coherent"];

/// A batch of points of up to four coordinates.
type Batch = [Vec<f32>; 4];

/// Numbers even in ±100.
fn scattered(seed: u32) -> Vec<f32> {
    let mut points = vec![0.0; LANES];
    let lanes: Vec<f32> = (0..LANES).map(|i| i as f32).collect();
    random::random(Isa::detect(), &[&lanes], seed, &mut points);
    points.iter_mut().for_each(|x| *x = *x * 200.0 - 100.0);
    points
}

/// The batches of scattered points.
fn clouds() -> Vec<Batch> {
    (0..BATCHES as u32).map(|batch| std::array::from_fn(|k| scattered(4 * batch + k as u32))).collect()
}

/// The batches of a picture of 512 points a line: of a slanting plane, all at one time.
fn pictures() -> Vec<Batch> {
    const WIDTH: usize = 512;
    let (right, down) = ([2.0, 1.0, 2.0].map(|x| x / 3.0), [-2.0, 2.0, 1.0].map(|x| x / 3.0));
    let corner = [-37.3, 12.8, 5.1];
    let coordinate = |pixel: usize, k: usize| {
        let (column, line) = ((pixel % WIDTH) as f32 / 64.0, (pixel / WIDTH) as f32 / 64.0);
        if k < 3 { corner[k] + column * right[k] + line * down[k] } else { 7.3 }
    };
    let batch =
        |first: usize| std::array::from_fn(|k| (0..LANES).map(|lane| coordinate(first + lane, k)).collect());
    (0..BATCHES).map(|b| batch(b * LANES)).collect()
}

/// A row of the table: a name, and what is measured.
struct Row {
    name: String,
    dimensions: usize,
    isa: Isa,
    field: std::sync::Arc<dyn Field>,
}

/// All rows but that of the crate `noise`, which comes last.
fn rows() -> Vec<Row> {
    let row = |name: &str, kind: &'static Kind, dimensions: usize, isa: Isa, params: &Params| {
        let field = kind.field(dimensions, params).unwrap_or_else(|e| panic!("{name}: {e:?}"));
        Row { name: name.to_string(), dimensions, isa, field }
    };
    let (isa, plain) = (Isa::detect(), Params::default());
    let named = |name: &str| Kind::from_name(name).unwrap_or_else(|| panic!("no {name}"));
    let mut rows: Vec<Row> =
        KINDS.iter().map(|kind| row(kind.name, kind, kind.usual_dimensions(), isa, &plain)).collect();
    let sparse = plain.clone().with(Opt::Density, &[1.0]);
    rows.push(row("sparse_convolution, density = 1", named("sparse_convolution"), 3, isa, &sparse));
    for d in [1, 2, 4] {
        rows.push(row(&format!("gradient, {d}-D"), named("gradient"), d, isa, &plain));
    }
    rows.push(row("gradient, baseline", named("gradient"), 3, Isa::baseline(), &plain));
    rows
}

/// The row of the crate `noise`.
const CRATE: &str = "Perlin of the crate noise";

/// How long and how often: the whole takes about two minutes, nearly all of it measuring. With plots, and the usual
/// number of resamples, criterion would reckon longer than it measures. Samples are short, so that on a machine that
/// is shared the median is of one that was not interrupted.
fn brief(group: &mut BenchmarkGroup<WallTime>) {
    group
        .throughput(Throughput::Elements(LANES as u64))
        .sampling_mode(SamplingMode::Flat)
        .sample_size(100)
        .nresamples(2000)
        .warm_up_time(Duration::from_millis(150))
        .measurement_time(Duration::from_millis(700));
}

fn kernels(criterion: &mut Criterion) {
    let rows = rows();
    for (place, batches) in PLACES.into_iter().zip([clouds(), pictures()]) {
        let mut group = criterion.benchmark_group(place);
        brief(&mut group);
        let mut out: [Vec<f32>; 4] = std::array::from_fn(|_| vec![0.0; LANES]);
        for Row { name, dimensions, isa, field } in &rows {
            let mut turns = batches.iter().cycle();
            group.bench_function(name.as_str(), |b| {
                b.iter(|| {
                    let p = turns.next().expect("a cycle").each_ref().map(Vec::as_slice);
                    field.noise(*isa, black_box(&p[..*dimensions]), black_box(&mut out[0]));
                });
            });
            group.bench_function(derivative(name), |b| {
                b.iter(|| {
                    let p = turns.next().expect("a cycle").each_ref().map(Vec::as_slice);
                    let mut out = out.each_mut().map(Vec::as_mut_slice);
                    field.derivative(*isa, black_box(&p[..*dimensions]), black_box(&mut out[..*dimensions]));
                });
            });
        }
        let perlin = Perlin::new(0);
        let mut turns = batches.iter().cycle();
        group.bench_function(CRATE, |b| {
            b.iter(|| {
                let [x, y, z, _] = turns.next().expect("a cycle");
                for (i, out) in out[0].iter_mut().enumerate() {
                    *out = perlin.get([x[i], y[i], z[i]].map(f64::from)) as f32;
                }
                black_box(&mut out[0]);
            });
        });
        group.finish();
    }
}

/// The benchmark of a row's derivative.
fn derivative(name: &str) -> String {
    format!("{name}: Dnoise")
}

fn mathematics(criterion: &mut Criterion) {
    let (x, y) = (scattered(1), scattered(2));
    let mut out = vec![0.0; LANES];
    for isa in [Isa::detect(), Isa::baseline()] {
        let mut group = criterion.benchmark_group(format!("math {}", isa.name()));
        brief(&mut group);
        group.bench_function("sin", |b| b.iter(|| math::sin_lanes(isa, black_box(&x), &mut out)));
        group.bench_function("exp", |b| b.iter(|| math::exp_lanes(isa, black_box(&x), &mut out)));
        group.bench_function("log", |b| b.iter(|| math::log_lanes(isa, black_box(&x), &mut out)));
        group.bench_function("pow", |b| {
            b.iter(|| math::pow_lanes(isa, Arg::Varying(black_box(&x)), Arg::Varying(&y), &mut out));
        });
        group.finish();
    }
}

/// All rows in turns at these points, and the crate.
fn turns(batches: &[Batch]) -> Turns {
    const ROUNDS: usize = 24;
    let perlin = Perlin::new(0);
    let mut runs: Vec<table::Run<'_>> = Vec::new();
    for Row { name, dimensions, isa, field } in rows() {
        let (again, mut out) = (field.clone(), vec![0.0; LANES]);
        let noise = move || {
            for p in batches {
                let p = p.each_ref().map(Vec::as_slice);
                field.noise(isa, black_box(&p[..dimensions]), black_box(&mut out));
            }
        };
        let mut out: [Vec<f32>; 4] = std::array::from_fn(|_| vec![0.0; LANES]);
        let slopes = move || {
            for p in batches {
                let p = p.each_ref().map(Vec::as_slice);
                let mut out = out.each_mut().map(Vec::as_mut_slice);
                again.derivative(isa, black_box(&p[..dimensions]), black_box(&mut out[..dimensions]));
            }
        };
        runs.push((derivative(&name), Box::new(slopes)));
        runs.push((name, Box::new(noise)));
    }
    let crate_noise = move || {
        for [x, y, z, _] in batches {
            let sum: f64 = (0..LANES).map(|i| perlin.get([x[i], y[i], z[i]].map(f64::from))).sum();
            black_box(sum);
        }
    };
    runs.push((CRATE.to_string(), Box::new(crate_noise)));
    Turns::of(ROUNDS, runs)
}

/// The rows in nanoseconds a point, and as ratios to `gradient` at the same points.
fn table() -> String {
    let places = [turns(&clouds()), turns(&pictures())];
    let mut text = String::from(
        "| | Noise, scattered | ratio | Noise, coherent | ratio | Dnoise, scattered | ratio | Dnoise, coherent | ratio |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    let cell = |turns: &Turns, name: &str| {
        let time = turns.median(name) / (BATCHES * LANES) as f64;
        let places = usize::from(time < 100.0) + usize::from(time < 10.0);
        format!(" {time:.places$} | {:.2} |", turns.ratio(name, "gradient"))
    };
    let both = |name: &str| places.each_ref().map(|turns| cell(turns, name)).concat();
    for Row { name, .. } in rows() {
        let _ = writeln!(text, "| {name} |{}{}", both(&name), both(&derivative(&name)));
    }
    let _ = writeln!(text, "| {CRATE} |{} | | | |", both(CRATE));
    text
}

criterion_group! {
    name = benches;
    config = Criterion::default().without_plots();
    targets = kernels, mathematics
}

fn main() {
    if table::updating() {
        table::update("noise", &table());
        return;
    }
    benches();
    Criterion::default().configure_from_args().final_summary();
}
