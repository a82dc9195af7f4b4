//! The library's patterns are means over pixels, and its materials keep within the light that they are given.

use pse::{Program, RunOptions, scene};

const WIDTH: usize = 96;
const HEIGHT: usize = 72;

/// A scalar or a colour's green of a program on the scene `floor`, so many times as fine as a small picture.
fn floor(text: &str, finer: usize) -> Vec<f64> {
    let options =
        scene::Options { width: WIDTH * finer, height: HEIGHT * finer, ..scene::Options::default() };
    let image = scene::render("floor", &options).unwrap();
    let program = Program::compile(text).unwrap_or_else(|e| panic!("{e}"));
    let report = program.run(&image, &RunOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let plane = &report.image.variable("color").unwrap().planes[1];
    let mut means = vec![0.0; WIDTH * HEIGHT];
    for (i, x) in plane.iter().enumerate() {
        let (column, row) = (i % (WIDTH * finer), i / (WIDTH * finer));
        means[row / finer * WIDTH + column / finer] += f64::from(*x) / (finer * finer) as f64;
    }
    means
}

#[test]
fn a_pixel_shows_the_mean_of_what_it_covers() {
    // The pattern, and how far it may be from the mean of 36 samples a pixel: rms near the horizon, and its own mean.
    let patterns = [
        ("checker(uv)", 0.1, 0.003),
        ("checker(3 * point + 0.1)", 0.12, 0.003),
        ("brick(uv)", 0.05, 0.003),
        ("brick(0.3 * uv, jitter = 0.1)", 0.07, 0.003),
        ("wallpaper(uv)", 0.16, 0.02),
        ("cellrandom(floor(uv), uv)", 0.13, 0.02),
        ("cloudplane(uv / 3)", 0.05, 0.01),
        ("granite(6 * point)", 0.05, 0.01),
        ("pine(3 * point)", 0.05, 0.01),
        ("oak(3 * point)", 0.05, 0.01),
        ("zebrawood(3 * point)", 0.05, 0.01),
    ];
    let mut wrong = Vec::new();
    for (pattern, rms, shift) in patterns {
        let text = format!("color = surface == 1 ? white * {pattern} : black\n");
        let (coarse, fine) = (floor(&text, 1), floor(&text, 6));
        // The upper third, where the floor recedes; things stand in the rest.
        let far = 0..WIDTH * HEIGHT / 6;
        let count = far.len() as f64;
        let off: Vec<f64> = far.map(|i| coarse[i] - fine[i]).collect();
        let found = [
            (off.iter().map(|d| d * d).sum::<f64>() / count).sqrt(),
            (off.iter().sum::<f64>() / count).abs(),
        ];
        if found[0] > rms || found[1] > shift {
            wrong.push(format!("{pattern}: rms {:.4}, mean {:.4}", found[0], found[1]));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The share of light that a model sends into all directions together, if it comes from one.
fn reflected(call: &str, incident: &str) -> f64 {
    // Directions are spread evenly over the hemisphere by height. Diffuse light in the model's scale is 1 in all: the
    // sum over the hemisphere of the model by the solid angle, over pi.
    let text = format!(
        "total = 0\n\
         incident = direction({incident})\n\
         for i in [1 .. 60]\n    \
             z = (i - 0.5) / 60\n    \
             for j in [1 .. 60]\n        \
                 a = 2 * pi * (j - 0.5) / 60\n        \
                 l = [sqrt(1 - z * z) * cos(a) sqrt(1 - z * z) * sin(a) z]\n        \
                 total += {call}, reflectance = 1) / 1800\n"
    );
    let program = Program::compile(&text).unwrap_or_else(|e| panic!("{e}"));
    let values = program.eval_pixel(&[], &RunOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let total = values.iter().find(|(name, _)| name == "total").unwrap();
    f64::from(total.1.cells()[0])
}

#[test]
fn facets_mirror_no_more_light_than_there_is() {
    for incident in ["[0 0 -1]", "[1 0 -1]", "[2 0 -1]"] {
        for roughness in [0.2, 0.3, 0.5] {
            let share = reflected(&format!("cooktorrance([0 0 1], incident, l, {roughness}"), incident);
            assert!((0.6..1.02).contains(&share), "cooktorrance {roughness} from {incident}: {share}");
        }
        let share = reflected("blinn([0 0 1], incident, l", incident);
        assert!((0.6..1.02).contains(&share), "blinn from {incident}: {share}");
    }
}
