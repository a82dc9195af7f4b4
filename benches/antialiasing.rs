//! How far pictures are from what their pixels should show, and what a smaller error costs: four patterns on a plane that
//! recedes to the horizon, point sampled, filtered by formulas, and supersampled. `cargo bench --bench antialiasing`
//! prints the table; with `UPDATE=1` it writes it into `docs/antialiasing.md`, and with `PICTURE=FILE` crops as a PNG.
//!
//! A pattern is written with widths. The sharp one is the same with 0 for `filterwidth`, and with eight octaves of
//! noise whatever the size of a pixel.

#[allow(
    dead_code,
    reason = "this table writes times its own way; the ratios of turns are for the other benches"
)]
mod table;

use pse::image::WriteOptions;
use pse::scene::{Options, Renderer};
use pse::{Filter, Image, Program, RunOptions, Sampling};
use std::borrow::Cow;
use std::time::Instant;

const WIDTH: usize = 240;
const HEIGHT: usize = 180;

/// Samples of the pictures that others are compared with.
const REFERENCE: u32 = 512;

/// Pictures are painted so often, for the median of their times.
const ROUNDS: usize = 3;

const PATTERNS: [(&str, &str); 4] = [
    ("checker", include_str!("antialiasing/checker.pse")),
    ("brick", include_str!("antialiasing/brick.pse")),
    ("star", include_str!("antialiasing/star.pse")),
    ("marble", include_str!("antialiasing/marble.pse")),
];

/// A way to paint.
struct Way {
    name: &'static str,
    filtered: bool,
    sampling: Option<Sampling>,
    /// Is the scene asked again for each sample, or is what the pixels' middles hold continued?
    resample: bool,
}

const fn way(name: &'static str, filtered: bool, count: u32, filter: Filter, resample: bool) -> Way {
    let sampling = if count > 1 { Some(Sampling { count, filter, seed: 1 }) } else { None };
    Way { name, filtered, sampling, resample }
}

const WAYS: [Way; 10] = [
    way("point sampled", false, 1, Filter::Box, false),
    way("filtered", true, 1, Filter::Box, false),
    way("4 samples", false, 4, Filter::Box, true),
    way("16 samples", false, 16, Filter::Box, true),
    way("64 samples", false, 64, Filter::Box, true),
    way("16 samples, inputs continued", false, 16, Filter::Box, false),
    way("16 samples, triangle", false, 16, Filter::Triangle, true),
    way("16 samples, Mitchell", false, 16, Filter::Mitchell, true),
    way("16 samples, Catmull-Rom", false, 16, Filter::CatmullRom, true),
    way("filtered, 4 samples", true, 4, Filter::Box, true),
];

fn program(text: &str, filtered: bool) -> Program {
    let sharp = || text.replace("filterwidth(", "0 * (").replace("high = pixel_freq", "high = 256, fade = 0");
    let text = if filtered { text.to_string() } else { sharp() };
    Program::compile(&text).expect("the patterns are programs")
}

/// The scene, and the image of its pixels' middles.
struct Scene {
    renderer: Renderer,
    image: Image<'static>,
}

impl Scene {
    fn new() -> Scene {
        let options = Options { width: WIDTH, height: HEIGHT, ..Options::default() };
        let renderer = Renderer::new("plane", &options).expect("a scene");
        let image = renderer.rows(0..HEIGHT).expect("memory");
        Scene { renderer, image }
    }

    fn paint(
        &self,
        program: &Program,
        sampling: Option<Sampling>,
        resample: bool,
        threads: Option<usize>,
    ) -> Image<'static> {
        let again = |_: &Image<'_>, places: &pse::internal::eval::Places| {
            let rows = self.renderer.rows_at(0..HEIGHT, |pixel| places.offset(pixel));
            rows.map_err(|e| e.to_string().into())
        };
        let resample = resample.then_some(&again as &pse::internal::eval::Resample<'_>);
        let options = RunOptions { samples: sampling, resample, threads, ..RunOptions::default() };
        program.run(&self.image, &options).expect("the patterns run").image
    }
}

/// The root of the mean square of what two pictures differ by.
fn error(a: &Image<'_>, b: &Image<'_>) -> f64 {
    let planes = a.variables[0].planes.iter().zip(&b.variables[0].planes);
    let squares =
        planes.flat_map(|(a, b)| a.iter().zip(&**b)).map(|(a, b)| f64::from(a - b) * f64::from(a - b));
    (squares.sum::<f64>() / (3 * WIDTH * HEIGHT) as f64).sqrt()
}

/// The picture, and nanoseconds a pixel: the median of some rounds.
fn timed(paint: impl Fn() -> Image<'static>) -> (Image<'static>, f64) {
    let mut times = Vec::new();
    let mut picture = Image::default();
    for _ in 0..ROUNDS {
        let start = Instant::now();
        picture = paint();
        times.push(start.elapsed().as_nanos() as f64);
    }
    times.sort_by(f64::total_cmp);
    (picture, times[ROUNDS / 2] / (WIDTH * HEIGHT) as f64)
}

/// The rows of the table: for each way the errors, and how many times as long it takes as point sampling.
fn rows(scene: &Scene) -> Vec<Vec<String>> {
    let mut rows: Vec<Vec<String>> = WAYS.iter().map(|w| vec![w.name.to_string()]).collect();
    let mut ratios: Vec<Vec<String>> = vec![Vec::new(); WAYS.len()];
    for (_, text) in PATTERNS {
        let programs = [program(text, false), program(text, true)];
        let mut references: Vec<(Filter, Image<'static>)> = Vec::new();
        let mut point = 0.0;
        for (i, way) in WAYS.iter().enumerate() {
            let filter = way.sampling.map_or(Filter::Box, |s| s.filter);
            if !references.iter().any(|r| r.0 == filter) {
                let sampling = Sampling { count: REFERENCE, filter, seed: 7 };
                references.push((filter, scene.paint(&programs[0], Some(sampling), true, None)));
            }
            let reference = &references.iter().find(|r| r.0 == filter).expect("just made").1;
            let program = &programs[usize::from(way.filtered)];
            let (picture, time) = timed(|| scene.paint(program, way.sampling, way.resample, Some(1)));
            point = if i == 0 { time } else { point };
            rows[i].push(format!("{:.4}", error(&picture, reference)));
            ratios[i].push(format!("{:.1}", time / point));
        }
    }
    rows.iter_mut().zip(ratios).for_each(|(row, ratios)| row.extend(ratios));
    rows
}

fn markdown(rows: &[Vec<String>]) -> String {
    let names = || PATTERNS.iter().map(|(name, _)| *name);
    let times = names().map(|name| format!("time, {name}"));
    let header: Vec<String> =
        std::iter::once(String::new()).chain(names().map(String::from)).chain(times).collect();
    let mut text = format!("| {} |\n|{}\n", header.join(" | "), "---|".repeat(header.len()));
    rows.iter().for_each(|row| text.push_str(&format!("| {} |\n", row.join(" | "))));
    text
}

/// A row of crops for each pattern: point sampled, filtered, 16 samples.
fn picture(scene: &Scene, path: &str) {
    const CROP: [usize; 2] = [160, 90];
    const LEFT: usize = 40;
    const TOP: usize = 16;
    const GAP: usize = 4;
    let shown = [&WAYS[0], &WAYS[1], &WAYS[3]];
    let (width, height) = (shown.len() * (CROP[0] + GAP) - GAP, PATTERNS.len() * (CROP[1] + GAP) - GAP);
    let mut planes = vec![vec![1.0f32; width * height]; 3];
    for (y, (_, text)) in PATTERNS.iter().enumerate() {
        for (x, way) in shown.iter().enumerate() {
            let crop = scene.paint(&program(text, way.filtered), way.sampling, way.resample, None);
            for (out, plane) in planes.iter_mut().zip(&crop.variables[0].planes) {
                for row in 0..CROP[1] {
                    let from = &plane[(TOP + row) * WIDTH + LEFT..][..CROP[0]];
                    out[(y * (CROP[1] + GAP) + row) * width + x * (CROP[0] + GAP)..][..CROP[0]]
                        .copy_from_slice(from);
                }
            }
        }
    }
    let planes: Vec<Cow<'_, [f32]>> = planes.into_iter().map(Cow::from).collect();
    let color = pse::Variable::new("color", pse::Shape::Vector(3), planes).expect("three planes");
    let image = Image::new(width, height, [color]).expect("planes of that size");
    let mut writer =
        pse::image::Writer::create(path.as_ref(), height, &WriteOptions::default()).expect("a file");
    writer.rows(&image).expect("the picture can be written");
    writer.finish().expect("the picture can be written");
}

fn main() {
    let scene = Scene::new();
    if let Ok(path) = std::env::var("PICTURE") {
        picture(&scene, &path);
        return;
    }
    let text = markdown(&rows(&scene));
    match table::updating() {
        true => table::update_in("antialiasing", "antialiasing", &text),
        false => print!("{text}"),
    }
}
