//! What programs cost on a frame of 1920x1080, on one thread and on two, and beside each the same computation written
//! in Rust: the ratio of the two holds on any machine. `cargo bench --bench programs`; with `UPDATE=1` it writes the
//! table in `docs/performance.md`.

mod native;
mod table;

use criterion::{Criterion, SamplingMode, Throughput};
use native::Native;
use pse::internal::lanes::Isa;
use pse::{Image, Program, RunOptions, Shape, Variable, scene};
use std::borrow::Cow;
use std::hint::black_box;
use std::time::Duration;
use table::Turns;

const WIDTH: usize = 1920;
const HEIGHT: usize = 1080;
const PIXELS: usize = WIDTH * HEIGHT;

/// A workload.
struct Workload {
    name: &'static str,
    text: &'static str,
    frame: Frame,
    /// The same in Rust.
    native: Native,
    /// How many times as long the program should take at most.
    wanted: Option<f64>,
}

/// What it runs on.
#[derive(Clone, Copy)]
enum Frame {
    /// The torus, which fills 58 % of the frame.
    Torus,
    /// Two pictures.
    Pictures,
    /// The torus and a sky, of surfaces that are mixed pixel by pixel.
    Mixed,
}

impl Workload {
    fn image<'a>(
        &self,
        torus: &'a Image<'a>,
        pictures: &'a Image<'a>,
        mixed: &'a Image<'a>,
    ) -> &'a Image<'a> {
        match self.frame {
            Frame::Torus => torus,
            Frame::Pictures => pictures,
            Frame::Mixed => mixed,
        }
    }
}

macro_rules! workload {
    ($name:ident, $frame:ident, $wanted:expr) => {
        Workload {
            name: stringify!($name),
            text: include_str!(concat!("workloads/", stringify!($name), ".pse")),
            frame: Frame::$frame,
            native: native::$name,
            wanted: $wanted,
        }
    };
}

const WORKLOADS: [Workload; 9] = [
    workload!(diffuse, Torus, Some(2.5)),
    workload!(spotted, Torus, Some(1.25)),
    workload!(marble, Torus, Some(1.25)),
    workload!(wrinkled, Torus, Some(1.25)),
    workload!(waves, Torus, Some(1.6)),
    workload!(over, Pictures, Some(2.5)),
    workload!(branchy, Mixed, Some(1.8)),
    workload!(straight, Torus, Some(2.5)),
    workload!(recursive, Torus, None),
];

fn torus() -> Image<'static> {
    let options = scene::Options {
        width: WIDTH,
        height: HEIGHT,
        eye: Some([0.0, -2.6, 2.9]),
        look_at: Some([0.0; 3]),
        fov: Some(33.0),
        ..scene::Options::default()
    };
    scene::render("donut", &options).expect("the donut is a scene")
}

fn variable<'a>(name: &str, planes: Vec<Cow<'a, [f32]>>) -> Variable<'a> {
    let shape = if planes.len() == 1 { Shape::Scalar } else { Shape::Vector(planes.len() as u32) };
    Variable::new(name, shape, planes).expect("a plane for each component")
}

fn plane(f: impl Fn(usize) -> f32) -> Cow<'static, [f32]> {
    Cow::Owned((0..PIXELS).map(f).collect())
}

/// 32 bits for a pixel, unrelated to those of its neighbours.
fn hash(pixel: usize) -> u32 {
    let h = (pixel as u32).wrapping_mul(0x9E37_79B1);
    let h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h ^ (h >> 16)
}

/// Two pictures that are opaque in places, and in places not.
fn pictures() -> Image<'static> {
    let alpha = |of: usize| {
        move |i: usize| {
            let (x, y) = (i % WIDTH, i / WIDTH);
            ((x + of * y) % 1000) as f32 / 999.0
        }
    };
    let mut variables = Vec::new();
    for (of, name) in ["fg", "bg"].into_iter().enumerate() {
        let color = |k: usize| plane(move |i| alpha(of)(i) * (hash(4 * i + k) >> 24) as f32 / 255.0);
        variables.push(variable(&format!("{name}.color"), (0..3).map(color).collect()));
        variables.push(variable(&format!("{name}.alpha"), vec![plane(alpha(of))]));
    }
    Image::new(WIDTH, HEIGHT, variables).expect("planes of the frame")
}

/// The torus before a sky, and four surfaces.
fn mixed(torus: &Image<'_>) -> Image<'static> {
    let planes = |name: &str| &torus.variable(name).expect("a scene has it").planes;
    let (seen, point, normal, ray) = (&planes("surface")[0], planes("point"), planes("normal"), planes("I"));
    let before_sky = |planes: &[Cow<'_, [f32]>], sky: f32| {
        let component = |k: usize| plane(|i| if seen[i] == 1.0 { planes[k][i] } else { sky * ray[k][i] });
        (0..3).map(component).collect()
    };
    let variables = [
        variable("surface", vec![plane(|i| (hash(i) >> 30) as f32)]),
        variable("point", before_sky(point, 4.0)),
        variable("normal", before_sky(normal, -1.0)),
    ];
    Image::new(WIDTH, HEIGHT, variables).expect("planes of the frame")
}

/// The two must paint the same picture, or it says nothing which is the faster.
fn compare(workload: &Workload, program: &Program, image: &Image<'_>) {
    let report = program.run(image, &RunOptions::default()).expect("the workloads run");
    let painted = report.image.variables.iter().flat_map(|v| &v.planes);
    let planes = (workload.native)(Isa::detect(), image);
    assert_eq!(painted.clone().count(), planes.len(), "{}: planes", workload.name);
    let mut other = 0;
    for (painted, plane) in painted.zip(&planes) {
        for (i, (a, b)) in painted.iter().zip(plane).enumerate() {
            assert!((a - b).abs() <= 1e-4, "{}: {a} and {b} at pixel {i}", workload.name);
            other += usize::from(a.to_bits() != b.to_bits());
        }
    }
    if other > 0 {
        println!("{}: {other} numbers differ in their last bits", workload.name);
    }
}

fn measure(criterion: &mut Criterion) {
    let torus = torus();
    let (mixed, pictures) = (mixed(&torus), pictures());
    for workload in &WORKLOADS {
        let program = Program::compile(workload.text).expect("the workloads are programs");
        let image = workload.image(&torus, &pictures, &mixed);
        let mut group = criterion.benchmark_group(workload.name);
        group
            .throughput(Throughput::Elements(PIXELS as u64))
            .sampling_mode(SamplingMode::Flat)
            .sample_size(10)
            .warm_up_time(Duration::from_millis(300))
            .measurement_time(Duration::from_millis(1000));
        for threads in [1, 2] {
            let options = RunOptions { threads: Some(threads), ..RunOptions::default() };
            group.bench_function(format!("pse {threads}"), |b| {
                b.iter(|| black_box(program.run(image, &options).expect("the workloads run")));
            });
        }
        let mut compared = false;
        group.bench_function("native 1", |b| {
            if !std::mem::replace(&mut compared, true) {
                compare(workload, &program, image);
            }
            let isa = Isa::detect();
            b.iter(|| black_box((workload.native)(isa, image)));
        });
        group.finish();
    }
}

/// Nanoseconds a pixel, with about as many digits as mean something.
fn shown(nanoseconds: f64) -> String {
    if nanoseconds < 20.0 { format!("{nanoseconds:.1}") } else { format!("{nanoseconds:.0}") }
}

/// Every workload and its Rust in turns, as a table.
fn report() -> String {
    const ROUNDS: usize = 15;
    let header = ["", "1 thread", "2 threads", "1 / 2", "in Rust", "ratio", "target"];
    let torus = torus();
    let (mixed, pictures) = (mixed(&torus), pictures());
    let rows = WORKLOADS.iter().map(|workload| {
        let program = Program::compile(workload.text).expect("the workloads are programs");
        let image = workload.image(&torus, &pictures, &mixed);
        compare(workload, &program, image);
        let run = |threads: usize| {
            let options = RunOptions { threads: Some(threads), ..RunOptions::default() };
            drop(black_box(program.run(image, &options).expect("the workloads run")));
        };
        let turns = Turns::of(
            ROUNDS,
            vec![
                ("one".to_string(), Box::new(|| run(1)) as Box<dyn FnMut()>),
                ("two".to_string(), Box::new(|| run(2))),
                ("native".to_string(), Box::new(|| drop(black_box((workload.native)(Isa::detect(), image))))),
            ],
        );
        let time = |name: &str| shown(turns.median(name) / PIXELS as f64);
        let ratio = |a: &str, b: &str| format!("{:.2}", turns.ratio(a, b));
        vec![
            workload.name.to_string(),
            time("one"),
            time("two"),
            ratio("one", "two"),
            time("native"),
            ratio("one", "native"),
            workload.wanted.map_or_else(String::new, |wanted| format!("≤ {wanted}")),
        ]
    });
    markdown(&header, &rows.collect::<Vec<_>>())
}

/// What is added to a program to ask for a derivative of what costs nothing, and of what costs most.
const DERIVATIVES: [(&str, &str); 2] =
    [("of a point", "w = filterwidth(point.x)\n"), ("of the colour", "w = filterwidth(color)\n")];

/// Programs without derivatives, with one that needs next to nothing run thrice, and with one that needs all of it.
fn derivatives() -> String {
    let torus = torus();
    let rows = WORKLOADS.iter().take(5).map(|workload| {
        let programs: Vec<(&str, Program)> = std::iter::once(("none", ""))
            .chain(DERIVATIVES)
            .map(|(name, more)| {
                let text = format!("{}\n{more}", workload.text);
                (name, Program::compile(&text).expect("the workloads are programs"))
            })
            .collect();
        let runs = programs.iter().map(|(name, program)| {
            let options = RunOptions { threads: Some(1), ..RunOptions::default() };
            let torus = &torus;
            let run = move || drop(black_box(program.run(torus, &options).expect("the workloads run")));
            (name.to_string(), Box::new(run) as Box<dyn FnMut()>)
        });
        let turns = Turns::of(9, runs.collect());
        let mut row = vec![workload.name.to_string(), shown(turns.median("none") / PIXELS as f64)];
        row.extend(DERIVATIVES.map(|(name, _)| format!("{:.2}", turns.ratio(name, "none"))));
        row
    });
    let header = ["", "none, ns a pixel", "of a point, ratio", "of the colour, ratio"];
    markdown(&header, &rows.collect::<Vec<_>>())
}

/// A table in Markdown.
fn markdown<H: AsRef<str>, R: AsRef<str>>(header: &[H], rows: &[Vec<R>]) -> String {
    let header: Vec<&str> = header.iter().map(AsRef::as_ref).collect();
    let mut text = format!("| {} |\n|{}\n", header.join(" | "), "---|".repeat(header.len()));
    for row in rows {
        let cells: Vec<&str> = row.iter().map(AsRef::as_ref).collect();
        text.push_str(&format!("| {} |\n", cells.join(" | ")));
    }
    text
}

/// Lets the allocator keep what was freed: it gives back large blocks to the system until it has seen a still larger
/// one freed. Otherwise some runs, and others not, would pay for pages that the system clears.
fn keep_memory() {
    drop(black_box(vec![1_u8; 31 << 20]));
}

fn main() {
    keep_memory();
    if table::updating() {
        table::update("programs", &report());
        table::update("derivatives", &derivatives());
        return;
    }
    let mut criterion = Criterion::default().without_plots().configure_from_args();
    measure(&mut criterion);
    criterion.final_summary();
}
