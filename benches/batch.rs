//! How wide a batch should be: the five workloads over a torus, one thread, for batches of 64 to 4096 lanes.
//! `pse::BATCH` is what this chose. `cargo bench --bench batch`

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use pse::{Program, RunOptions, scene};
use std::hint::black_box;
use std::time::Duration;

const WORKLOADS: [(&str, &str); 5] = [
    ("diffuse", include_str!("workloads/diffuse.pse")),
    ("spotted", include_str!("workloads/spotted.pse")),
    ("marble", include_str!("workloads/marble.pse")),
    ("wrinkled", include_str!("workloads/wrinkled.pse")),
    ("waves", include_str!("workloads/waves.pse")),
];

fn batches(c: &mut Criterion) {
    // The torus fills about 60 % of the frame, as in the workloads' description.
    let options = scene::Options {
        width: 960,
        height: 540,
        eye: Some([0.0, -2.6, 2.9]),
        look_at: Some([0.0; 3]),
        fov: Some(33.0),
        ..scene::Options::default()
    };
    let image = scene::render("donut", &options).expect("the donut is a scene");
    for (name, text) in WORKLOADS {
        let program = Program::compile(text).expect("the workloads are programs");
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(960 * 540));
        group.sample_size(10).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
        for batch in [64, 128, 256, 512, 1024, 2048, 4096] {
            let options = RunOptions { threads: Some(1), batch: Some(batch), ..RunOptions::default() };
            group.bench_function(BenchmarkId::from_parameter(batch), |b| {
                b.iter(|| black_box(program.run(&image, &options).expect("the workloads run")));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, batches);
criterion_main!(benches);
