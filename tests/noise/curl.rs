//! `curl`, through the language.

use pse::measure::{Moments, Random};
use pse::{Image, Program, RunOptions, Shape, Variable};

/// The planes of `flow` at points, as a program gives it.
fn flow(text: &str, p: &[Vec<f32>]) -> Vec<Vec<f32>> {
    let program = Program::compile(text).unwrap_or_else(|e| panic!("{e}"));
    let variable = Variable::new("p", Shape::Vector(p.len() as u32), p.iter().map(Vec::as_slice)).unwrap();
    let image = Image::new(p[0].len(), 1, [variable]).unwrap();
    let result = program.run(&image, &RunOptions::default()).unwrap_or_else(|e| panic!("{e}")).image;
    result.variable("flow").unwrap().planes.iter().map(|plane| plane.to_vec()).collect()
}

#[test]
fn curl_has_no_sources() {
    let step = 1.0 / 256.0;
    for text in ["flow = curl(p)\n", "flow = curl(p, kind = \"gradient\", seed = 3)\n"] {
        for d in [2, 3] {
            let points = Random::new(50).points(d, 20_000, 16.0, 1.0 / 1024.0);
            let mut divergence = vec![0.0; points[0].len()];
            let mut changes = 0.0;
            for k in 0..d {
                let ends = [-step, step].map(|by| {
                    let mut moved = points.clone();
                    moved[k].iter_mut().for_each(|x| *x += by);
                    flow(text, &moved).swap_remove(k)
                });
                let change: Vec<f32> =
                    ends[1].iter().zip(&ends[0]).map(|(b, a)| (b - a) / (2.0 * step)).collect();
                divergence.iter_mut().zip(&change).for_each(|(sum, x)| *sum += x);
                changes += Moments::of(&change).rms();
            }
            let left = Moments::of(&divergence).rms() / changes;
            println!("{d}-D: {left:.5}");
            assert!(left < 0.01, "{text}{d}-D: {left}");
        }
    }
}
