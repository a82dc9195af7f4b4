//! Every program that is printed in Perlin's "An Image Synthesizer" (SIGGRAPH 1985), as printed, on the donut.

use pse::{Program, RunOptions, scene};
use std::path::Path;

#[test]
fn every_program_of_the_paper_runs_on_the_donut() {
    let options = scene::Options { width: 64, height: 48, ..scene::Options::default() };
    let donut = scene::render("donut", &options).unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/paper");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().to_string();
        let text = std::fs::read_to_string(&path).unwrap();
        let program = Program::compile(&text).unwrap_or_else(|e| panic!("{name}\n{e}"));
        let run = |frame| {
            let options = RunOptions { frame, ..RunOptions::default() };
            program.run(&donut, &options).unwrap_or_else(|e| panic!("{name}\n{e}"))
        };
        let report = run(0.0);
        assert_eq!(report.not_finite, 0, "{name} gives NaN or infinity");
        let output = &report.image.variables[0];
        let varies = output.planes.iter().any(|p| p.iter().any(|x| x.to_bits() != p[0].to_bits()));
        assert!(varies, "{name} gives the same {} everywhere", output.name);
        if text.contains("frame *") {
            let later = run(5.0);
            assert_ne!(later.image.variables[0].planes, output.planes, "{name} does not move");
        }
        count += 1;
    }
    assert!(count >= 18, "only {count} programs");
}

#[test]
fn twenty_waves_have_twenty_directions() {
    let program = Program::compile("center = makewaves(20)").unwrap();
    let values = program.eval_pixel(&[], &RunOptions::default()).unwrap();
    let cells = values[0].1.cells();
    let centers: Vec<&[f32]> = cells.chunks(3).collect();
    assert_eq!(centers.len(), 20);
    for (i, a) in centers.iter().enumerate() {
        for b in &centers[..i] {
            let cosine: f32 = a.iter().zip(*b).map(|(a, b)| a * b).sum();
            assert!(cosine < 0.9999, "{a:?} and {b:?}");
        }
    }
}
