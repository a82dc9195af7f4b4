//! What a host pays beside its pixels: a session's overhead on small images, and buffers that are interleaved.
//!
//! `cargo bench --bench embedding` prints medians of turns side by side. The cases take turns, so that what the machine
//! does meanwhile falls on all of them.

use pse::{BufferView, BufferViewMut, Image, Program, RunOptions, Session, Shape, Strides, Variable, scene};
use std::sync::Arc;
use std::time::Instant;

/// Turns of each case.
const TURNS: usize = 41;

/// A case: its name, and what is measured.
type Case<'a> = (&'a str, Box<dyn FnMut() + 'a>);

/// The median time of each case in microseconds.
fn medians(cases: &mut [Case<'_>]) -> Vec<f64> {
    let mut times = vec![Vec::new(); cases.len()];
    for turn in 0..TURNS + 3 {
        for ((_, case), times) in cases.iter_mut().zip(&mut times) {
            let start = Instant::now();
            case();
            if turn >= 3 {
                times.push(start.elapsed().as_secs_f64() * 1e6);
            }
        }
    }
    times.iter_mut().for_each(|times| times.sort_by(f64::total_cmp));
    times.iter().map(|times| times[TURNS / 2]).collect()
}

fn views<'a>(image: &'a Image<'_>, planes: &'a [Vec<f32>]) -> Vec<BufferView<'a>> {
    let strides = Strides::planar(image.width, image.height);
    let view = |(v, data): (&'a Variable<'_>, &'a Vec<f32>)| BufferView {
        name: &v.name,
        shape: v.shape.clone(),
        data,
        strides,
    };
    image.variables.iter().zip(planes).map(view).collect()
}

fn main() {
    let options = RunOptions { threads: Some(1), ..RunOptions::default() };
    let workload = |name: &str| {
        let path = format!("{}/benches/workloads/{name}.pse", env!("CARGO_MANIFEST_DIR"));
        Arc::new(Program::compile(&std::fs::read_to_string(path).expect("a workload")).expect("a program"))
    };
    let donut = |width, height| {
        scene::render("donut", &scene::Options { width, height, ..scene::Options::default() })
            .expect("a scene")
    };

    // 64 x 64 pixels, and sixteen times as many: what is beyond a sixteenth of those is overhead.
    for name in ["diffuse", "marble", "waves"] {
        let program = workload(name);
        let (small, large) = (donut(64, 64), donut(256, 256));
        let planes =
            |image: &Image<'_>| image.variables.iter().map(|v| v.planes.concat()).collect::<Vec<_>>();
        let (small_planes, large_planes) = (planes(&small), planes(&large));
        let (small_views, large_views) = (views(&small, &small_planes), views(&large, &large_planes));
        let mut sessions = [Session::new(program.clone()), Session::new(program.clone())];
        let [of_small, of_large] = &mut sessions;
        let (mut small_out, mut large_out) = (vec![0.0; 3 * 64 * 64], vec![0.0; 3 * 256 * 256]);
        let run = |session: &mut Session, side: usize, views: &[BufferView<'_>], data: &mut [f32]| {
            let strides = Strides::planar(side, side);
            let output = &mut [BufferViewMut { name: "color", components: 3, data, strides }];
            session.run_into([side, side], views, output, &options).expect("a run");
        };
        let times = medians(&mut [
            ("session 64", Box::new(|| run(of_small, 64, &small_views, &mut small_out))),
            ("session 256", Box::new(|| run(of_large, 256, &large_views, &mut large_out))),
            ("program 64", Box::new(|| drop(program.run(&small, &options).expect("a run")))),
        ]);
        let pixels = times[1] / 16.0;
        println!(
            "{name:>8} 64x64: session {:7.1} us, of which {:6.1} us are not the pixels' own; Program::run {:7.1} us",
            times[0],
            times[0] - pixels,
            times[2]
        );
    }

    let (width, height) = (1920, 1080);
    let count = width * height;
    let rgba: Vec<f32> = (0..4 * count).map(|i| (i % 255) as f32 / 255.0).collect();
    let mut sessions =
        [0, 1].map(|_| Session::new(Program::compile("color = color * 0.5").expect("a program")));
    let [planar, interleaved] = &mut sessions;
    let (mut a, mut b) = (vec![0.0f32; 4 * count], vec![0.0f32; 4 * count]);
    let run = |session: &mut Session, strides: Strides, data: &mut [f32]| {
        let input = BufferView { name: "color", shape: Shape::Vector(4), data: &rgba, strides };
        let output = &mut [BufferViewMut { name: "color", components: 4, data, strides }];
        session.run_into([width, height], &[input], output, &options).expect("a run");
    };
    let times = medians(&mut [
        ("planar", Box::new(|| run(planar, Strides::planar(width, height), &mut a))),
        ("interleaved", Box::new(|| run(interleaved, Strides::interleaved(4, width), &mut b))),
    ]);
    println!(
        "1080p RGBA color*0.5: planar {:.2} ms, interleaved {:.2} ms, {:.2} times",
        times[0] / 1e3,
        times[1] / 1e3,
        times[1] / times[0]
    );
}
