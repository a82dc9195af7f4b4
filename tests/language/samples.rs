//! Several samples of each pixel: what their mean is, and that it is the same however the pixels are batched.

use pse::{Filter, Image, Program, RunOptions, Sampling, Shape, Variable};

const WIDTH: usize = 41;
const HEIGHT: usize = 29;
const FILTERS: [Filter; 4] = [Filter::Box, Filter::Triangle, Filter::CatmullRom, Filter::Mitchell];

/// `x` and `y` grow by 1 from pixel to pixel; `surface` is 1 to the left and 2 to the right, where `x` is 100 more.
fn image() -> Image<'static> {
    let at = |f: &dyn Fn(usize, usize) -> f32| -> Vec<f32> {
        (0..WIDTH * HEIGHT).map(|i| f(i % WIDTH, i / WIDTH)).collect()
    };
    let right = |c: usize| f32::from(u8::from(c >= 20));
    let variables = [
        Variable::new("x", Shape::Scalar, [at(&|c, _| c as f32 + 0.5 + 100.0 * right(c))]).unwrap(),
        Variable::new("y", Shape::Scalar, [at(&|_, r| r as f32 + 0.5)]).unwrap(),
        Variable::new("surface", Shape::Scalar, [at(&|c, _| 1.0 + right(c))]).unwrap(),
    ];
    Image::new(WIDTH, HEIGHT, variables).unwrap()
}

fn run(text: &str, options: &RunOptions<'_>) -> Vec<Vec<f32>> {
    let program = Program::compile(text).unwrap_or_else(|e| panic!("{e}"));
    let report = program.run(&image(), options).unwrap_or_else(|e| panic!("{e}"));
    report.image.variables.iter().flat_map(|v| v.planes.iter().map(|p| p.to_vec())).collect()
}

fn sampled(text: &str, count: u32, filter: Filter, seed: u32) -> Vec<Vec<f32>> {
    let samples = Some(Sampling { count, filter, seed });
    run(text, &RunOptions { samples, ..RunOptions::default() })
}

#[test]
fn what_is_constant_stays_so() {
    for filter in FILTERS {
        for count in [1, 2, 3, 4, 7, 16, 61] {
            let planes = sampled("color = [0.1 0.7 1e20]\nn = surface\n", count, filter, 3);
            let all = |k: usize, x: f32| planes[k].iter().all(|&y| y == x);
            assert!(all(0, 0.1) && all(1, 0.7) && all(2, 1e20), "{count} {filter:?}");
        }
    }
}

#[test]
fn one_sample_lies_in_the_middle() {
    let text = "v = [x y pixel]\nd = Du(x * x)";
    for filter in FILTERS {
        assert_eq!(sampled(text, 1, filter, 5), run(text, &RunOptions::default()));
    }
}

#[test]
fn samples_lie_where_pixel_says() {
    // Inputs go on by their derivatives, also beside the edge of a surface.
    let text = "v = abs(x - (surface == 2 ? 100 : 0) - pixel.x) + abs(y - pixel.y)";
    for filter in FILTERS {
        assert!(sampled(text, 5, filter, 0)[0].iter().all(|&x| x < 1e-4), "{filter:?}");
    }
    // Some sample lies in each quarter of a pixel.
    let quarter =
        |more: &str| format!("dx = pixel.x % 1 - 0.5\ndy = pixel.y % 1 - 0.5\nv = dx {more} 0 && dy > 0");
    for more in ["<", ">"] {
        assert!(sampled(&quarter(more), 4, Filter::Box, 1)[2].iter().filter(|&&x| x > 0.0).count() > 900);
    }
}

#[test]
fn a_ramp_keeps_its_value() {
    // With 1024 samples of their parts of the pixel the mean is within 1/(2 · 32) · 1/sqrt(1024) or so of the middle.
    let planes = sampled("v = [x y]", 1024, Filter::Box, 0);
    let middle = run("v = [x y]", &RunOptions::default());
    for (mean, middle) in planes.iter().zip(&middle) {
        assert!(mean.iter().zip(middle).all(|(a, b)| (a - b).abs() < 2e-3));
    }
    // A derivative is one over a pixel, wherever the sample lies.
    for filter in FILTERS {
        let planes = sampled("v = [Du(x) Dv(y) Du(3 * x + y) filterwidth(pixel)]", 6, filter, 0);
        for (plane, wanted) in planes.iter().zip([1.0, 1.0, 3.0, 1.0, 1.0]) {
            assert!(plane.iter().all(|x| (x - wanted).abs() < 1e-4), "{filter:?}: {wanted}");
        }
    }
}

#[test]
fn an_edge_covers_its_share() {
    let text = "v = 0.8 * x + 0.6 * y < 17.3";
    for (count, filter) in [(4, Filter::Box), (16, Filter::Box), (64, Filter::Box), (64, Filter::Triangle)] {
        let found = &sampled(text, count, filter, 1)[0];
        // The same over many places.
        let exact = &sampled(text, 4096, filter, 2)[0];
        let square: f32 = found.iter().zip(exact).map(|(a, b)| (a - b) * (a - b)).sum();
        let edge = exact.iter().filter(|&&x| x > 0.0 && x < 1.0).count();
        let error = (square / edge as f32).sqrt();
        // Those of independent samples would be off by 0.5 / sqrt(count) at most.
        assert!(edge > 20 && error < 0.5 / (count as f32).sqrt(), "{count} {filter:?}: {error}");
    }
}

#[test]
fn a_sharp_filter_overshoots_and_a_soft_one_does_not() {
    let text = "v = y < 14";
    let least = |filter| sampled(text, 256, filter, 0)[0].iter().copied().fold(1.0, f32::min);
    assert!(least(Filter::CatmullRom) < -0.01);
    assert!(least(Filter::Triangle) == 0.0);
}

#[test]
fn batches_threads_and_seeds() {
    let text = "if surface == 1\n    v = [x y 2]\nelse\n    v = sin(40 * x * y)\nd = filterwidth(x * y)\n";
    for filter in FILTERS {
        let samples = Some(Sampling { count: 5, filter, seed: 9 });
        let known =
            run(text, &RunOptions { samples, batch: Some(1), no_optimize: true, ..RunOptions::default() });
        for (batch, threads) in [(7, 1), (256, 2), (2048, 3)] {
            let (batch, threads) = (Some(batch), Some(threads));
            let found = run(text, &RunOptions { samples, batch, threads, ..RunOptions::default() });
            assert!(found == known, "{filter:?} {batch:?}");
        }
        assert!(sampled(text, 5, filter, 8) != known);
    }
}

#[test]
fn ids_and_variables_that_pass_through_keep_the_pixels_value() {
    let outputs = Some(["surface", "x", "twice"].map(String::from).to_vec());
    let samples = Some(Sampling::of(3));
    let planes = run("twice = 2 * surface", &RunOptions { samples, outputs, ..RunOptions::default() });
    let image = image();
    assert_eq!(planes[0][..], image.variables[2].planes[0][..]);
    assert_eq!(planes[1][..], image.variables[0].planes[0][..]);
    assert!(planes[2].iter().zip(&planes[0]).all(|(a, b)| *a == 2.0 * b));
}

#[test]
fn one_sample_of_nan_poisons_the_pixel_and_is_counted_once() {
    let program = Program::compile("v = sqrt(x - 10.5)").unwrap();
    let options = RunOptions { samples: Some(Sampling::of(16)), ..RunOptions::default() };
    let report = program.run(&image(), &options).unwrap();
    // Ten columns, and the one through which the edge goes.
    assert_eq!(report.not_finite, 11 * HEIGHT);
}

#[test]
fn the_first_pixel_in_error_is_told_whatever_the_sample() {
    let program = Program::compile("v = [1 2]\nw = v[pixel.x % 1 > 0.97 ? 3 : 1]\n").unwrap();
    let options = |count| RunOptions { samples: Some(Sampling::of(count)), ..RunOptions::default() };
    let pixel = |count| program.run(&image(), &options(count)).unwrap_err().diagnostics[0].pixel.unwrap();
    // More samples go wrong earlier, but never later than the first row.
    assert!(pixel(64)[1] == 0 && pixel(64)[0] < 20, "{:?}", pixel(64));
    let first = pixel(16);
    let batch = RunOptions { batch: Some(3), ..options(16) };
    assert_eq!(program.run(&image(), &batch).unwrap_err().diagnostics[0].pixel, Some(first));
}

#[test]
fn progress_ends_at_the_end() {
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
    let most = AtomicUsize::new(0);
    let progress = |p: pse::Progress| {
        assert_eq!(p.total, WIDTH * HEIGHT);
        most.fetch_max(p.done, Relaxed);
        std::ops::ControlFlow::Continue(())
    };
    let options =
        RunOptions { samples: Some(Sampling::of(3)), progress: Some(&progress), ..RunOptions::default() };
    Program::compile("v = x").unwrap().run(&image(), &options).unwrap();
    assert_eq!(most.load(Relaxed), WIDTH * HEIGHT);
}
