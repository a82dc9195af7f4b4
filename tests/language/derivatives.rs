//! `Du`, `Dv`, `filterwidth`, `calculatenormal`: against differences of the images themselves.
// The images are this machine's own on both sides of each comparison; planes are gone through by the pixel's number;
// NaN minus itself is meant.
#![allow(clippy::disallowed_methods, clippy::eq_op, clippy::needless_range_loop)]

use pse::{HostFunction, Image, Program, RunOptions, Shape, Variable};

const WIDTH: usize = 37;
const HEIGHT: usize = 23;

/// An image with `x`, a smooth function of the place; `p` on two surfaces, the second raised; `hole`, NaN here and there.
fn image() -> Image<'static> {
    let at = |f: &dyn Fn(f32, f32) -> f32| -> Vec<f32> {
        (0..WIDTH * HEIGHT).map(|i| f((i % WIDTH) as f32, (i / WIDTH) as f32)).collect()
    };
    let surface =
        |c: f32, r: f32| f32::from(u8::from((c - 15.0) * (c - 15.0) + (r - 9.0) * (r - 9.0) < 50.0)) + 1.0;
    let hole = |c: f32, r: f32| if (c * 7.0 + r * 3.0) % 11.0 == 0.0 { f32::NAN } else { c * c };
    let variables = [
        Variable::new(
            "x",
            Shape::Scalar,
            [at(&|c, r| pse::internal::math::sin(c * 0.3) * pse::internal::math::cos(r * 0.2))],
        )
        .unwrap(),
        Variable::new("surface", Shape::Scalar, [at(&surface)]).unwrap(),
        Variable::new("hole", Shape::Scalar, [at(&hole)]).unwrap(),
        Variable::new(
            "point",
            Shape::Vector(3),
            [
                at(&|c, r| 0.1 * c + 0.02 * r),
                at(&|_, r| -0.1 * r),
                at(&|c, r| surface(c, r) * 10.0 + 0.03 * c - 0.01 * r),
            ],
        )
        .unwrap(),
    ];
    Image::new(WIDTH, HEIGHT, variables).unwrap()
}

fn run(text: &str, names: &[&str], options: RunOptions<'_>) -> Vec<Vec<f32>> {
    let program = Program::compile(text).unwrap_or_else(|e| panic!("{e}"));
    let outputs = Some(names.iter().map(|n| n.to_string()).collect());
    let report = program.run(&image(), &RunOptions { outputs, ..options }).unwrap_or_else(|e| panic!("{e}"));
    report.image.variables.iter().flat_map(|v| v.planes.iter().map(|p| p.to_vec())).collect()
}

/// The change of a plane at a pixel as the language defines it.
fn change(plane: &[f32], surface: Option<&[f32]>, column: usize, row: usize, along: usize) -> f32 {
    let here = row * WIDTH + column;
    let (place, size, step) = if along == 0 { (column, WIDTH, 1) } else { (row, HEIGHT, WIDTH) };
    let counts = |there: usize| surface.is_none_or(|s| s[there] == s[here]) && plane[there].is_finite();
    if place + 1 < size && counts(here + step) {
        plane[here + step] - plane[here]
    } else if place > 0 && counts(here - step) {
        (plane[here] + (plane[here] - plane[here - step])) - plane[here]
    } else {
        if plane[here].is_finite() { 0.0 } else { f32::NAN }
    }
}

#[test]
fn inputs_change_as_their_neighbours_tell() {
    let image = image();
    let planes = run(
        "a = Du(x)\nb = Dv(x)\nc = Du(hole)\nd = Dv(point)\ne = filterwidth(point)\nf = Du(pixel)\ng = Dv(pixel)\n",
        &["a", "b", "c", "d", "e", "f", "g"],
        RunOptions::default(),
    );
    let input = |name: &str, cell: usize| image.variable(name).unwrap().planes[cell].to_vec();
    let surface = input("surface", 0);
    for row in 0..HEIGHT {
        for column in 0..WIDTH {
            let i = row * WIDTH + column;
            let of = |name: &str, cell: usize, along: usize| {
                change(&input(name, cell), Some(&surface), column, row, along)
            };
            let same = |k: usize, expected: f32| {
                let found = planes[k][i];
                assert!(
                    found == expected || found.is_nan() && expected.is_nan(),
                    "plane {k} at [{column} {row}]: {found}, not {expected}"
                );
            };
            same(0, of("x", 0, 0));
            same(1, of("x", 0, 1));
            same(2, of("hole", 0, 0));
            for cell in 0..3 {
                same(3 + cell, of("point", cell, 1));
                same(6 + cell, of("point", cell, 0).abs() + of("point", cell, 1).abs());
            }
            for (k, expected) in [1.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
                same(9 + k, expected);
            }
        }
    }
}

/// Of a plane in space the normal is known; the edge between the surfaces must not show.
#[test]
fn normals_are_those_of_the_surface() {
    let planes = run("n = calculatenormal(point)\n", &["n"], RunOptions::default());
    let (u, v) = ([0.1f32, 0.0, 0.03], [0.02f32, -0.1, -0.01]);
    let cross = [v[1] * u[2] - v[2] * u[1], v[2] * u[0] - v[0] * u[2], v[0] * u[1] - v[1] * u[0]];
    let length = cross.iter().map(|x| x * x).sum::<f32>().sqrt();
    assert!(cross[2] > 0.0, "towards the eye that looks along -z");
    let mut alone = 0;
    #[allow(clippy::needless_range_loop, reason = "three planes at once")]
    for i in 0..WIDTH * HEIGHT {
        // A pixel with no neighbour of its surface on either side of it.
        if (0..3).all(|cell| planes[cell][i] == 0.0) {
            alone += 1;
            continue;
        }
        for cell in 0..3 {
            assert!((planes[cell][i] - cross[cell] / length).abs() < 2e-4, "{i}: {}", planes[cell][i]);
        }
    }
    assert_eq!(alone, 4);
}

/// A shadow goes its pixel's way through conditions, loops, calls, indices, ranges.
#[test]
fn shadows_follow_their_pixels() {
    let text = "\
function twice(a)
    if a > 0.1
        return 2 * a
    return 3 * a
if x > 0
    y = 10 + x
else
    y = x
z = x > 0.2 ? 5 + x : x
i = 0
s = 0
while i < 3 + 4 * x
    i += 1
    s += x
v = [1 4 9 16 25 36 49 64]
t = v[3 + 2 * x] + x
r = sum([x .. x + 2.9 + x])
k = twice(x)
l = (x && x) + x
a = Du(y)
b = Du(z)
c = Du(s)
d = Du(t)
e = Du(r)
f = Du(k)
g = Du(l)
h = Du(Du(x))
";
    let names = ["a", "b", "c", "d", "e", "f", "g", "h", "x", "i", "r"];
    let planes = run(text, &names, RunOptions::default());
    let image = image();
    let (x, surface) = (image.variable("x").unwrap().planes[0].to_vec(), image.variable("surface").unwrap());
    for row in 0..HEIGHT {
        for column in 0..WIDTH {
            let i = row * WIDTH + column;
            let dx = change(&x, Some(&surface.planes[0]), column, row, 0);
            let near = |k: usize, expected: f32| {
                let found = planes[k][i];
                assert!((found - expected).abs() < 1e-5, "{k} at [{column} {row}]: {found}, not {expected}");
            };
            near(0, dx);
            near(1, dx);
            near(2, planes[9][i] * dx);
            near(3, dx);
            // Elements of the pixel's own range, moved along.
            near(4, ((2.9 + x[i] + 1e-4).floor() + 1.0) * dx);
            near(5, if x[i] > 0.1 { 2.0 } else { 3.0 } * dx);
            near(6, dx);
            near(7, 0.0);
        }
    }
}

/// The result does not depend on how pixels are put together; a program without derivatives has the same values.
#[test]
fn batches_agree() {
    let text = "\
s = 0
for i in [1 .. 4]
    if Noise(i * point) > 0
        s += Noise(i * point + s)
    else if x > 0.3
        continue
    s += filterwidth(s)
w = Noise(3 * x * octaves(x))
color = [s Du(s) Dv(w)]
function octaves(a)
    n = 0
    while n < 8 * a
        n += 1
    return n
";
    let reference =
        run(text, &["color"], RunOptions { batch: Some(1), no_optimize: true, ..Default::default() });
    for batch in [2, 7, 96, 255, 2048, 4096] {
        for (threads, no_optimize) in [(1, false), (2, false), (1, true)] {
            let options =
                RunOptions { batch: Some(batch), threads: Some(threads), no_optimize, ..Default::default() };
            let planes = run(text, &["color"], options);
            for (a, b) in planes.iter().flatten().zip(reference.iter().flatten()) {
                assert!(a.to_bits() == b.to_bits(), "batch {batch}, {threads} threads, {no_optimize}");
            }
        }
    }
}

/// Statements on which no derivative depends are run without shadows: their values are the same.
#[test]
fn what_no_derivative_needs_has_no_shadows() {
    let text = "\
a = 3 * x
seen = 0
if a > 0.2
    seen = Noise(point)
b = filterwidth(a)
c = seen
while c < 2
    c += 0.3 + abs(a)
if b > 0.05
    a += 1
    d = [c b]
else
    d = [0 c]
later = Du(b + a) + c
function f(q)
    return q > 0 ? Dv(q) : q
e = f(a) + seen
color = [d[1] + later c e]
";
    let reference =
        run(text, &["color"], RunOptions { batch: Some(1), no_optimize: true, ..Default::default() });
    for (batch, no_optimize) in [(3, true), (100, false), (2048, false), (2048, true)] {
        let planes =
            run(text, &["color"], RunOptions { batch: Some(batch), no_optimize, ..Default::default() });
        for (a, b) in planes.iter().flatten().zip(reference.iter().flatten()) {
            assert!(a.to_bits() == b.to_bits(), "batch {batch}, {no_optimize}");
        }
    }
    // With everything in one call all of it has shadows.
    let whole = text
        .lines()
        .filter(|l| !l.starts_with("function") && !l.contains("return"))
        .map(|l| format!("    {l}\n"));
    let function = "function f(q)\n    return q > 0 ? Dv(q) : q\n";
    let body: String = whole.collect();
    let all = format!("{function}function all()\n{body}    return color\ncolor = all()\n");
    let planes = run(&all, &["color"], RunOptions::default());
    for (a, b) in planes.iter().flatten().zip(reference.iter().flatten()) {
        assert!(a.to_bits() == b.to_bits(), "in a call");
    }
}

/// What goes wrong in a shadow alone is no error: there the pixel's value stands.
#[test]
fn shadows_do_not_fail() {
    let half = HostFunction::for_pixel("half", &["a"], |args| match args[0].cells()[0] {
        x if x > 0.9 => Err("that is too much".into()),
        x => Ok((x / 2.0).into()),
    });
    let compiler = pse::Compiler::new().function(half);
    let program = compiler.compile("p", "color = x < 0.85 ? [half(x) Du(half(x)) 0] : black\n").unwrap();
    program.run(&image(), &RunOptions::default()).unwrap();
    let program = Program::compile("v = [1 2]\ncolor = Du(v[1 + pixel.x / 16])\n").unwrap();
    let error = program.run(&image(), &RunOptions::default()).unwrap_err().to_string();
    assert!(error.contains("(at pixel [24 0])"), "{error}");
}

/// A pixel alone has no neighbours: nothing changes.
#[test]
fn a_pixel_alone() {
    let program = Program::compile("a = Du(x)\nb = filterwidth(3 * x)\nc = x > 1 ? Dv(x) : 7\n").unwrap();
    let values = program.eval_pixel(&[("x", 4.0.into())], &RunOptions::default()).unwrap();
    let expected = [("a", 0.0), ("b", 0.0), ("c", 0.0)].map(|(n, x)| (n.to_string(), x.into()));
    assert_eq!(values, expected);
}
