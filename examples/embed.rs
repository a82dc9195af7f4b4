//! Embedding: a host runs programs on planes of its own, without files. See the end of docs/tutorial.md.
//!
//! `cargo run --release --example embed`

use pse::{Compiler, HostFunction, Image, PixelValue, Program, Progress, RunOptions, Shape, Variable};
use std::error::Error;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

const WIDTH: usize = 64;
const HEIGHT: usize = 28;

const TEXT: &str = "
param veins = 4 in [1 16]
if surface == 1
    layers = sin(veins * (point.x + turbulence(2 * point, high = 32)))
    color = white * (0.6 + 0.4 * layers) * studio(normal)
else
    color = black
";

fn main() -> Result<(), Box<dyn Error>> {
    paint()?;
    one_pixel()?;
    cancel()?;
    errors();
    Ok(())
}

/// A whole image: the host's planes in, new planes out.
fn paint() -> Result<(), Box<dyn Error>> {
    // Compile once. A program holds no state: any number of threads may share it.
    let program = Compiler::new().function(studio()).compile("stone.pse", TEXT)?;
    for param in &program.resolved().params {
        println!("param {}", param.name);
    }

    // The host's own planes, row after row from the top. The image borrows them.
    let ball = Ball::new();
    let image = Image::new(
        WIDTH,
        HEIGHT,
        [
            Variable::new("surface", Shape::Scalar, [&ball.surface[..]])?,
            Variable::new("point", Shape::Vector(3), ball.point.iter().map(|p| &p[..]))?,
            Variable::new("normal", Shape::Vector(3), ball.normal.iter().map(|p| &p[..]))?,
        ],
    )?;

    let done = AtomicUsize::new(0);
    let progress = |p: Progress| {
        done.store(p.done, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    let options = RunOptions {
        frame: 12.0,
        set: vec![("veins".to_string(), 6.0.into())],
        progress: Some(&progress),
        ..RunOptions::default()
    };
    let report = program.run(&image, &options)?;
    println!("{} pixels done, {} with NaN or infinity", done.into_inner(), report.not_finite);

    let color = report.image.variable("color").ok_or("the program gives a color")?;
    for row in color.planes[0].chunks(WIDTH) {
        println!("{}", row.iter().map(|&red| shade(red)).collect::<String>());
    }
    Ok(())
}

/// A function for programs, written in Rust: for whole batches, a plane of numbers for each component.
fn studio() -> HostFunction {
    HostFunction::for_batch("studio", &["normal"], |arguments| {
        if *arguments.shape(0) != Shape::Vector(3) {
            return Err(format!("the normal must be a vector of 3, found {}", arguments.shape(0)).into());
        }
        let [x, y, z] = [0, 1, 2].map(|cell| arguments.plane(0, cell));
        let light = |i: usize| (0.48 * z[i] - 0.6 * x[i] - 0.64 * y[i]).max(0.05);
        let plane = (0..arguments.lanes()).map(light).collect();
        Ok(pse::BatchResult { shape: Shape::Scalar, planes: vec![plane] })
    })
}

/// One pixel: variables by name in, everything that the program assigns out.
fn one_pixel() -> Result<(), Box<dyn Error>> {
    let double = HostFunction::for_pixel("double", &["x"], |values| {
        values[0].as_scalar().map(|x| (2.0 * x).into()).ok_or("it takes a scalar".into())
    });
    let text = "size = double(radius)\nbox = [size size size]";
    let program = Compiler::new().function(double).compile("box.pse", text)?;
    let radius: PixelValue = 1.5.into();
    for (name, value) in program.eval_pixel(&[("radius", radius)], &RunOptions::default())? {
        println!("{name} = {value}");
    }
    Ok(())
}

/// A run that is given up: here by whoever watches its progress, usually from another thread.
fn cancel() -> Result<(), Box<dyn Error>> {
    let program = Program::compile("color = turbulence(pixel / 50, high = 64)")?;
    let image = Image::new(512, 256, [])?;
    let progress = |_: Progress| ControlFlow::Break(());
    let options = RunOptions { progress: Some(&progress), ..RunOptions::default() };
    match program.run(&image, &options) {
        Ok(_) => println!("the run came to its end"),
        Err(error) => println!("cancelled: {}", error.cancelled),
    }
    Ok(())
}

/// Errors are values: facts to look at, and a text to show.
fn errors() {
    // In the text: every fault that could be found, each with its place.
    if let Err(error) = Program::compile("color = whit * Nois(point)") {
        for fault in &error.diagnostics {
            let place = fault.span().map(|span| error.sources.line_column(span));
            println!("{} at {place:?}: {} ({})", fault.code, fault.message, fault.hints.join(" "));
        }
    }
    // At a pixel: which one, and the text as the command line shows it.
    let run = || {
        let program = Program::compile("v = [1 2 3]\ncolor = white * v[pixel.x]")?;
        program.run(&Image { width: 8, height: 1, ..Image::default() }, &RunOptions::default())
    };
    if let Err(error) = run() {
        println!("pixel {:?}\n{error}", error.diagnostics[0].pixel);
    }
}

/// A ball that a renderer might have seen, as planes.
struct Ball {
    surface: Vec<f32>,
    point: [Vec<f32>; 3],
    normal: [Vec<f32>; 3],
}

impl Ball {
    fn new() -> Ball {
        let mut ball = Ball { surface: Vec::new(), point: Default::default(), normal: Default::default() };
        for row in 0..HEIGHT {
            for column in 0..WIDTH {
                // Characters are about twice as high as wide.
                let x = (column as f32 + 0.5 - WIDTH as f32 / 2.0) / HEIGHT as f32;
                let y = (row as f32 + 0.5 - HEIGHT as f32 / 2.0) * 2.0 / HEIGHT as f32;
                let z2 = 1.0 - x * x - y * y;
                let seen = z2 > 0.0;
                let normal = if seen { [x, y, z2.sqrt()] } else { [0.0; 3] };
                ball.surface.push(if seen { 1.0 } else { 0.0 });
                for (axis, component) in normal.into_iter().enumerate() {
                    ball.normal[axis].push(component);
                    ball.point[axis].push(component);
                }
            }
        }
        ball
    }
}

fn shade(red: f32) -> char {
    let shades: Vec<char> = " .:-=+*#%@".chars().collect();
    shades[(red.clamp(0.0, 0.999) * shades.len() as f32) as usize]
}
