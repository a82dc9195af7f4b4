//! Where one part of an object hides another: `pixelsize`, derivatives, widths of look-ups and samples against what the
//! surface itself does, by the differentials of the rays that see it.

use pse::mesh::head;
use pse::scene::{Model, Options, Renderer, find};
use pse::{Filter, Image, Program, RunOptions, Sampling, Shape, Variable};
use std::sync::Arc;

const SIZE: [usize; 2] = [640, 480];

/// A view of a scene or of the head, and the place of its eye.
fn view(name: &str, eye: Option<[f64; 3]>) -> (Renderer, [f64; 3]) {
    let [width, height] = SIZE;
    let options = Options { width, height, eye, ..Options::default() };
    if name == "head" {
        let mut mesh = head();
        mesh.y_up_to_z_up();
        let model = Arc::new(Model::new(mesh).unwrap());
        return (Renderer::of_model(&model, &options).unwrap(), eye.unwrap());
    }
    (Renderer::new(name, &options).unwrap(), eye.unwrap_or(find(name).unwrap().eye))
}

fn outputs(text: &str, names: &[&str], image: &Image<'_>, options: RunOptions<'_>) -> Vec<Vec<f32>> {
    let program = Program::compile(text).unwrap_or_else(|e| panic!("{e}"));
    let outputs = Some(names.iter().map(|n| n.to_string()).collect());
    let report = program.run(image, &RunOptions { outputs, ..options }).unwrap_or_else(|e| panic!("{e}"));
    report.image.variables.iter().flat_map(|v| v.planes.iter().map(|p| p.to_vec())).collect()
}

type V = [f64; 3];

fn dot(a: V, b: V) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn at(image: &Image<'_>, name: &str, pixel: usize) -> V {
    let planes = &image.variable(name).unwrap().planes;
    [0, 1, 2].map(|axis| f64::from(planes[axis][pixel]))
}

/// How fast the point moves over the surface from pixel to pixel, the larger of both axes; NaN where there is no surface.
fn speeds(image: &Image<'_>, eye: V) -> Vec<f64> {
    let [width, height] = SIZE;
    let surface = &image.variable("surface").unwrap().planes[0];
    let speed = |pixel: usize| {
        if surface[pixel] == 0.0 {
            return f64::NAN;
        }
        let (column, row) = (pixel % width, pixel / width);
        let ray = at(image, "I", pixel);
        // Of a mesh, the face.
        let face = cross(at(image, "dPdu", pixel), at(image, "dPdv", pixel));
        let normal = if dot(face, face) > 0.0 { face } else { at(image, "normal", pixel) };
        let from_eye = at(image, "point", pixel).into_iter().zip(eye).map(|(p, e)| (p - e) * (p - e));
        let distance = from_eye.sum::<f64>().sqrt();
        let along = |place: usize, count: usize, stride: usize| {
            let (a, b) =
                (pixel - stride * usize::from(place > 0), pixel + stride * usize::from(place + 1 < count));
            let pixels = ((b - a) / stride) as f64;
            let (a, b) = (at(image, "I", a), at(image, "I", b));
            let turn = [0, 1, 2].map(|axis| (b[axis] - a[axis]) / pixels);
            let nearer = -dot(normal, turn) / dot(normal, ray);
            let step = [0, 1, 2].map(|axis| distance * (turn[axis] + ray[axis] * nearer));
            dot(step, step).sqrt()
        };
        along(column, width, 1).max(along(row, height, width))
    };
    (0..width * height).map(speed).collect()
}

/// Of the pixels of surfaces: the share off by more than a tenth, and how many are over and under by more than 4 times.
fn compare(name: &str, sizes: &[f32], exact: impl Fn(usize, f64) -> f64) -> (f64, usize, usize) {
    let (mut count, mut off, mut over, mut under) = (0, 0, 0, 0);
    for (pixel, &size) in sizes.iter().enumerate() {
        let ratio = f64::from(size) / exact(pixel, size.into());
        if ratio.is_nan() {
            continue;
        }
        count += 1;
        off += usize::from(!(1.0 / 1.1..1.1).contains(&ratio));
        over += usize::from(ratio > 4.0);
        under += usize::from(ratio < 0.25);
    }
    let share = f64::from(off as u32) / f64::from(count as u32);
    println!("{name}: {count} pixels, off {:.3} %, over {over}, under {under}", 100.0 * share);
    (share, over, under)
}

#[test]
fn pixelsize_is_the_derivative_on_the_surface() {
    for (name, eye) in [
        ("donut", None),
        ("donut", Some([0.0, -5.0, 1.0])),
        ("donut", Some([0.0, -4.0, 0.6])),
        ("donut", Some([3.0, -4.0, 2.0])),
        ("floor", None),
        ("floor", Some([0.0, -5.0, 1.0])),
        ("plane", None),
        ("ocean", None),
        ("sphere", None),
    ] {
        let (renderer, place) = view(name, eye);
        let image = renderer.rows(0..SIZE[1]).unwrap();
        let speeds = speeds(&image, place);
        let sizes = outputs("size = pixelsize\n", &["size"], &image, RunOptions::default());
        let (off, over, under) = compare(name, &sizes[0], |pixel, _| speeds[pixel]);
        assert!(off < 0.001, "{name} {eye:?}: {off}");
        assert_eq!(over, 0, "{name} {eye:?}");
        // Where a surface is seen edge-on its derivative has no bounds.
        assert!(under <= 12, "{name} {eye:?}: {under}");
    }
}

/// Faces and lips hardly larger than a pixel: there the derivative is another at every place in the pixel, and each is as
/// good.
#[test]
fn pixelsize_is_within_the_derivatives_in_the_pixel() {
    for (name, eye, most) in [
        ("donut", Some([0.0, -5.0, 1.0]), 0.001),
        ("vase", None, 0.001),
        ("vase", Some([0.0, -27.0, 3.0]), 0.001),
        ("vase", Some([0.0, -14.0, 22.0]), 0.001),
        ("head", Some([0.0, -5.0, 1.0]), 0.006),
        ("head", Some([-3.0, -3.0, 0.3]), 0.006),
    ] {
        let (renderer, place) = view(name, eye);
        let image = renderer.rows(0..SIZE[1]).unwrap();
        let surface = &image.variable("surface").unwrap().planes[0];
        let middle = speeds(&image, place);
        let (mut least, mut largest) = (middle.clone(), middle);
        for (x, y) in [-0.48, 0.0, 0.48].iter().flat_map(|&x| [(x, -0.48), (x, 0.0), (x, 0.48)]) {
            let beside = renderer.rows_at(0..SIZE[1], |_| [x, y]).unwrap();
            let there = &beside.variable("surface").unwrap().planes[0];
            for (pixel, speed) in speeds(&beside, place).into_iter().enumerate() {
                if there[pixel] == surface[pixel] {
                    least[pixel] = least[pixel].min(speed);
                    largest[pixel] = largest[pixel].max(speed);
                }
            }
        }
        let sizes = outputs("size = pixelsize\n", &["size"], &image, RunOptions::default());
        let exact = |pixel: usize, size: f64| size.max(least[pixel]).min(largest[pixel]) + 0.0 * least[pixel];
        let (off, over, under) = compare(name, &sizes[0], exact);
        assert!(off < most && over <= 20 && under <= 20, "{name} {eye:?}: {off} {over} {under}");
    }
}

#[test]
fn turbulence_draws_no_line() {
    for (name, eye) in [("donut", [0.0, -5.0, 1.0]), ("vase", [0.0, -27.0, 15.0]), ("head", [0.0, -5.0, 1.0])]
    {
        let (renderer, place) = view(name, Some(eye));
        let image = renderer.rows(0..SIZE[1]).unwrap();
        let speeds = speeds(&image, place);
        let text = "own = turbulence(4 * point)\nfull = turbulence(4 * point, high = 1000)\n";
        let planes = outputs(text, &["own", "full"], &image, RunOptions::default());
        let mut lines = 0;
        for (pixel, speed) in speeds.into_iter().enumerate().filter(|(_, speed)| !speed.is_nan()) {
            // The octaves that are left out: those finer than the pixel, 4 units of noise to one of space.
            lines += usize::from(
                f64::from((planes[0][pixel] - planes[1][pixel]).abs()) > 4.0 * 4.0 * speed.max(0.005),
            );
        }
        println!("{name}: {lines}");
        assert_eq!(lines, 0, "{name}");
    }
}

const WIDTH: usize = 48;
const HEIGHT: usize = 36;

/// One surface of two planes, one far behind the other, with a slanted edge between them, and a wire one pixel wide before
/// both. `uv` grows by 0.01 and 0.02 a pixel on the front, and three times as fast behind.
fn planes(gap: f32) -> Image<'static> {
    let behind = |c: usize, r: usize| c + r / 3 > 24;
    let wire = |c: usize, r: usize| c + 2 * r == 40;
    let plane = |f: &dyn Fn(f32, f32, bool) -> f32, before: f32| -> Vec<f32> {
        let of = |i: usize| {
            let (c, r) = (i % WIDTH, i / WIDTH);
            f(c as f32, r as f32, behind(c, r)) + if wire(c, r) { before } else { 0.0 }
        };
        (0..WIDTH * HEIGHT).map(of).collect()
    };
    let scale = |far: bool| if far { 3.0 } else { 1.0 };
    let point = [
        plane(&|c, _, far| 0.1 * c * scale(far), 0.0),
        plane(&|_, r, far| -0.1 * r * scale(far), 0.0),
        plane(&|c, _, far| if far { -gap } else { 0.05 * c }, gap),
    ];
    let uv = [plane(&|c, _, far| 0.01 * c * scale(far), 7.0), plane(&|_, r, far| 0.02 * r * scale(far), 7.0)];
    let variables = [
        Variable::new("point", Shape::Vector(3), point).unwrap(),
        Variable::new("uv", Shape::Vector(2), uv).unwrap(),
        Variable::new("wire", Shape::Scalar, [plane(&|_, _, _| 0.0, 1.0)]).unwrap(),
        Variable::new("behind", Shape::Scalar, [plane(&|_, _, far| f32::from(u8::from(far)), 0.0)]).unwrap(),
    ];
    Image::new(WIDTH, HEIGHT, variables).unwrap()
}

/// Whether the pixel lies where the wire crosses the edge, and parts are a pixel or two wide to all sides; or between the
/// wire and the border of the image.
fn at_crossing(pixel: usize) -> bool {
    let (c, r) = (pixel % WIDTH, pixel / WIDTH);
    (20..=28).contains(&(c + r / 3)) && (34..=46).contains(&(c + 2 * r)) || c == 38 && r <= 1
}

#[test]
fn derivatives_end_at_silhouettes() {
    let text = "u = Du(uv)\nv = Dv(uv)\nw = filterwidth(uv)\nn = calculatenormal(point)\nsize = pixelsize\n";
    for gap in [3.0, 50.0, 1e4] {
        let image = planes(gap);
        let found =
            outputs(text, &["u", "v", "w", "n", "size", "wire", "behind"], &image, RunOptions::default());
        let [near, far] = [[-0.05, 0.0, 0.1], [0.0, 0.0, 1.0]].map(|n: [f32; 3]| {
            let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
            n.map(|x| x / length)
        });
        for i in (0..WIDTH * HEIGHT).filter(|&i| !at_crossing(i)) {
            let (wire, behind) = (found[10][i] == 1.0, found[11][i] == 1.0);
            let scale = if behind { 3.0 } else { 1.0 };
            let expected = [0.01, 0.0, 0.0, 0.02, 0.01, 0.02].map(|x: f32| scale * x);
            let place = [i % WIDTH, i / WIDTH];
            for (k, expected) in expected.into_iter().enumerate() {
                // A wire has no neighbour: nothing changes.
                let expected = if wire { 0.0 } else { expected };
                assert!((found[k][i] - expected).abs() < 1e-4, "{gap} {k} at {place:?}: {}", found[k][i]);
            }
            let normal = if wire {
                [0.0; 3]
            } else if behind {
                far
            } else {
                near
            };
            for (axis, expected) in normal.into_iter().enumerate() {
                assert!((found[6 + axis][i] - expected).abs() < 1e-2, "{gap} normal at {place:?}");
            }
            let size = found[9][i];
            let exact = if behind { 0.3 } else { 0.111_803_4 };
            assert!(
                size / exact < if wire { 4.0 } else { 1.01 } && size / exact > 0.3,
                "{gap} {place:?}: {size}"
            );
        }
    }
}

#[test]
fn samples_end_at_silhouettes() {
    let image = planes(50.0);
    for filter in [Filter::Box, Filter::Mitchell] {
        let samples = Some(Sampling { count: 9, filter, seed: 1 });
        let options = || RunOptions { samples, ..RunOptions::default() };
        // `uv` is a linear function of the place on both parts: so it is at every sample.
        let text = "scale = behind > 0.5 ? 3 : 1\n\
                    a = abs(uv.x - 7 * wire - 0.01 * scale * (pixel.x - 0.5))\n\
                    b = abs(uv.y - 7 * wire - 0.02 * scale * (pixel.y - 0.5))\n";
        let planes = outputs(text, &["a", "b"], &image, options());
        let wire = &image.variable("wire").unwrap().planes[0];
        for i in (0..WIDTH * HEIGHT).filter(|&i| wire[i] == 0.0 && !at_crossing(i)) {
            let place = [i % WIDTH, i / WIDTH];
            assert!(planes[0][i] < 1e-3, "{filter:?} {place:?}: {}", planes[0][i]);
            assert!(planes[1][i] < 1e-3, "{filter:?} {place:?}: {}", planes[1][i]);
        }
    }
}

/// The result does not depend on batches, threads, or on which rows the image holds beside those that are run.
#[test]
fn rows_and_batches_agree_at_silhouettes() {
    let (renderer, _) = view("donut", Some([0.0, -5.0, 1.0]));
    let image = renderer.rows(0..SIZE[1]).unwrap();
    let text = "a = [pixelsize Du(point)]\nb = [filterwidth(uv) calculatenormal(point)]\n";
    let names = ["a", "b"];
    let known = outputs(text, &names, &image, RunOptions { batch: Some(1), ..RunOptions::default() });
    let batched = outputs(
        text,
        &names,
        &image,
        RunOptions { batch: Some(700), threads: Some(2), ..RunOptions::default() },
    );
    let bits = |planes: &[Vec<f32>]| planes.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert!(bits(&known) == bits(&batched));
    for top in (90..150).step_by(7) {
        let part = renderer.rows(top - 3..top + 4).unwrap();
        let found = outputs(text, &names, &part, RunOptions::default());
        for (plane, known) in found.iter().zip(&known) {
            let (row, known) = (&plane[3 * SIZE[0]..][..SIZE[0]], &known[top * SIZE[0]..][..SIZE[0]]);
            assert!(row.iter().zip(known).all(|(a, b)| a.to_bits() == b.to_bits()), "row {top}");
        }
    }
}
