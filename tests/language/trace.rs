//! What happens at a pixel, as data from the library. And `print`, which reports pixels in a run.
// The images are this machine's own on both sides of each comparison.
#![allow(clippy::disallowed_methods)]

mod print;

use pse::Disk;
use pse::{
    Compiler, EventKind, HostFunction, Image, NotFinite, PixelValue, Program, RunOptions, Trace,
    TraceOptions, scene,
};
use std::path::{Path, PathBuf};

const ALL: TraceOptions = TraceOptions { depth: u32::MAX, limit: 100_000 };

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Looks into `examples/` for images.
fn compile(text: &str) -> Program {
    let host = Disk { path: vec![root().join("examples")] };
    Compiler::new().host(&host).compile("program", text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The examples: name, text, and the scene that each says it runs on.
fn examples() -> Vec<(String, String, String)> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(root().join("examples"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "pse"))
        .collect();
    paths.sort();
    paths
        .into_iter()
        .map(|path| {
            let text = std::fs::read_to_string(&path).unwrap();
            let scene = text.lines().find_map(|l| l.split_once("--scene ")).map(|(_, rest)| rest);
            let scene = scene.and_then(|rest| rest.split_whitespace().next()).unwrap_or("donut");
            (path.file_name().unwrap().to_string_lossy().into_owned(), text.clone(), scene.to_string())
        })
        .collect()
}

fn render(scene: &str, width: usize, height: usize) -> Image<'static> {
    scene::render(scene, &scene::Options { width, height, ..scene::Options::default() }).unwrap()
}

fn bits(value: &PixelValue) -> Vec<u32> {
    value.cells().iter().map(|x| x.to_bits()).collect()
}

/// What a run of the whole image has at a pixel.
fn of_run(image: &Image<'_>, name: &str, pixel: usize) -> Option<Vec<u32>> {
    Some(image.variable(name)?.planes.iter().map(|p| p[pixel].to_bits()).collect())
}

/// The last assignment that a trace tells of a variable of the outer level.
fn last<'t>(trace: &'t Trace, wanted: &str) -> Option<&'t PixelValue> {
    trace.events.iter().rev().find_map(|event| match &event.kind {
        EventKind::Assign { name, value, .. } if name == wanted && event.depth == 0 => Some(value),
        _ => None,
    })
}

/// Compares traces at some pixels with a run of all, in batches as usual; gives how many values were compared.
fn compare(what: &str, program: &Program, image: &Image<'_>, options: &RunOptions<'_>) -> usize {
    let Ok(report) = program.run(image, options) else { return 0 };
    let (width, height) = (image.width, image.height);
    let mut compared = 0;
    for pixel in (0..width * height).step_by(width * height / 23) {
        let trace = program.trace(image, pixel % width, pixel / width, options, &ALL);
        let trace = trace.unwrap_or_else(|e| panic!("{what}: {e}"));
        assert!(trace.error.is_none(), "{what}: {:?}", trace.error);
        assert_eq!(trace.pixel, [pixel % width, pixel / width].map(|x| x as i32));
        for (name, value) in &trace.values {
            let Some(expected) = of_run(&report.image, name, pixel) else { continue };
            // A picture repeats a scalar.
            let value = if value.cells().len() < expected.len() {
                vec![value.cells()[0].to_bits(); expected.len()]
            } else {
                bits(value)
            };
            assert_eq!(value, expected, "{what}: {name} at pixel {pixel}");
            if let Some(told) = last(&trace, name) {
                let told = if told.cells().len() < expected.len() {
                    vec![told.cells()[0].to_bits(); 3]
                } else {
                    bits(told)
                };
                assert_eq!(told, expected, "{what}: the last assignment of {name} at pixel {pixel}");
            }
            compared += 1;
        }
    }
    compared
}

#[test]
fn the_values_of_every_example_are_those_of_its_run() {
    let mut compared = Vec::new();
    for (name, text, scene) in examples() {
        let image = render(&scene, 40, 30);
        if compare(&name, &compile(&text), &image, &RunOptions { frame: 3.0, ..RunOptions::default() }) > 0 {
            compared.push(name);
        }
    }
    // Those that are not compared want images of their own.
    assert!(compared.len() >= 35, "only {compared:?}");
    for name in ["marble_vase.pse", "globe.pse", "brick_bump.pse", "marble.pse"] {
        assert!(compared.iter().any(|c| c == name), "{name}");
    }
}

#[test]
fn derivatives_sizes_spaces_and_frames_are_those_of_the_run() {
    let program = compile(
        "param k = 3\nif begin_frame\n    m = k * frame\n\nfunction wave(x)\n    s = 0\n    for i in [1 2 3]\n        \
         if x > i / 3\n            s += Du(sin(i * x)) + filterwidth(x * m)\n        else\n            s -= Dv(x)\n    return s\n\n\
         a = wave(4 * point.x) + pixelsize\nb = norm(transform(\"camera\", point)) + norm(calculatenormal(point))\n\
         if surface\n    c = texture(\"earth.png\", uv)\nelse\n    c = [0 0 0]\nd = dot(I, normal)\ncolor = [a b d] + c\n",
    );
    let options = RunOptions {
        frame: 5.0,
        set: vec![("k".into(), 0.25.into())],
        outputs: Some(["a", "b", "c", "d", "color"].map(String::from).to_vec()),
        ..RunOptions::default()
    };
    assert_eq!(compare("derivatives", &program, &render("sphere", 48, 36), &options), 24 * 5);
}

/// The trace of a program without an image, as short lines.
fn told(text: &str, options: &TraceOptions) -> Vec<String> {
    let program = compile(text);
    let image = Image::new(1, 1, []).unwrap();
    let trace = program.trace(&image, 0, 0, &RunOptions::default(), options).unwrap();
    let line = |event: &pse::Event| {
        let (line, _) = program.sources().line_column(event.span);
        let what = match &event.kind {
            EventKind::Input { name, value } => format!("input {name} {value}"),
            EventKind::Param { name, value, set } => format!("param {name} {value} {set}"),
            EventKind::Assign { name, value, kept } => {
                format!("{name} = {value}{}", if *kept { " kept" } else { "" })
            }
            EventKind::Kept { value } => format!("kept {value}"),
            EventKind::Value { value } => format!("value {value}"),
            EventKind::Branch { value, taken } => format!("branch {value} {taken}"),
            EventKind::Round { element: None } => "round".into(),
            EventKind::Round { element: Some((name, value)) } => format!("round {name} = {value}"),
            EventKind::LoopEnd { rounds } => format!("end {rounds}"),
            EventKind::Break => "break".into(),
            EventKind::Continue => "continue".into(),
            EventKind::Return { value } => format!("return {value}"),
            EventKind::Call { name, arguments, result } => {
                let list: Vec<String> = arguments.iter().map(|(n, v)| format!("{n}={v}")).collect();
                format!(
                    "{name}({}) {}",
                    list.join(" "),
                    result.as_ref().map_or("-".into(), PixelValue::to_string)
                )
            }
            EventKind::Print { parts } => format!("print {parts:?}"),
            EventKind::Omitted { events } => format!("omitted {events}"),
        };
        let once = if event.frame { "frame " } else { "" };
        format!("{once}{line} {:?} {}: {what}", event.rounds, event.depth)
    };
    trace.events.iter().map(line).collect()
}

#[test]
fn assignments_branches_and_rounds() {
    let text = "param k = 2\nif begin_frame\n    m = 2 * k\nv = [1 2]\nv[2] = pixel.x\nif v[2] > 1\n    a = 1\n\
                else if k > 1\n    a = m + pixel.x * (k + 1)\nwhile a < 12\n    a *= 2\n    for i in [1 .. 3]\n        \
                if i == 2\n            continue\n        if i == 3\n            break\npixel.x + 1\ncolor = a * white\n";
    let expected = [
        "frame 1 [] 0: param k 2 false",
        "frame 3 [] 0: m = 4",
        "5 [] 0: input pixel [0.5 0.5]",
        "4 [] 0: v = [1 2] kept",
        "5 [] 0: v = [1 0.5]",
        "6 [] 0: branch 0 false",
        "8 [] 0: branch 1 true",
        "9 [] 0: kept 3",
        "9 [] 0: a = 5.5",
        "10 [1] 0: round",
        "11 [1] 0: a = 11",
        "12 [1, 1] 0: round i = 1",
        "13 [1, 1] 0: branch 0 false",
        "15 [1, 1] 0: branch 0 false",
        "12 [1, 2] 0: round i = 2",
        "13 [1, 2] 0: branch 1 true",
        "14 [1, 2] 0: continue",
        "12 [1, 3] 0: round i = 3",
        "13 [1, 3] 0: branch 0 false",
        "15 [1, 3] 0: branch 1 true",
        "16 [1, 3] 0: break",
        "12 [1] 0: end 3",
        "10 [2] 0: round",
        "11 [2] 0: a = 22",
        "12 [2, 1] 0: round i = 1",
    ];
    let told = told(text, &TraceOptions::default());
    assert_eq!(told[..expected.len()], expected);
    assert_eq!(
        told[told.len() - 4..],
        ["12 [2] 0: end 3", "10 [] 0: end 2", "17 [] 0: value 1.5", "18 [] 0: color = [22 22 22]"]
    );
}

#[test]
fn calls_are_one_event_or_unfolded() {
    let text = "function f(x, y = 2)\n    while x > 1\n        x -= 1\n    return g(x) + y\nfunction g(x)\n    return 10 * x\n\
                function h(x)\n    y = x\nfor i in [1 2]\n    a = f(i * pixel.x * 2)\nh(pixel.x)\n";
    let folded = [
        "10 [] 0: input pixel [0.5 0.5]",
        "9 [1] 0: round i = 1",
        "10 [1] 0: f(x=1 y=2) 12",
        "10 [1] 0: a = 12",
        "9 [2] 0: round i = 2",
        "10 [2] 0: f(x=2 y=2) 12",
        "10 [2] 0: a = 12",
        "9 [] 0: end 2",
        "11 [] 0: h(x=0.5) -",
    ];
    assert_eq!(told(text, &TraceOptions::default()), folded);
    let one = told(text, &TraceOptions { depth: 1, ..TraceOptions::default() });
    let inside =
        ["2 [1] 1: round", "3 [1] 1: x = 1", "2 [] 1: end 1", "4 [] 1: g(x=1) 10", "4 [] 1: return 12"];
    let at = one.iter().position(|l| l == "10 [2] 0: f(x=2 y=2) 12").unwrap();
    assert_eq!(one[at + 1..][..5], inside);
    let all = told(text, &ALL);
    assert_eq!(all.iter().filter(|l| **l == "6 [] 2: return 10").count(), 2);
    assert_eq!(all.len(), one.len() + 2);
}

#[test]
fn of_many_events_the_first_and_the_last_are_kept() {
    let text = "a = 0\nwhile a < 1000\n    a += 1\ncolor = a * white\n";
    let told = told(text, &TraceOptions { limit: 8, ..TraceOptions::default() });
    let expected = [
        "1 [] 0: a = 0",
        "2 [1] 0: round",
        "3 [1] 0: a = 1",
        "2 [2] 0: round",
        "2 [] 0: omitted 1995",
        "2 [1000] 0: round",
        "3 [1000] 0: a = 1000",
        "2 [] 0: end 1000",
        "4 [] 0: color = [1000 1000 1000]",
    ];
    // Where the gap is has no meaning but that it is near.
    let told: Vec<String> =
        told.iter().map(|l| if l.contains("omitted") { expected[4].into() } else { l.clone() }).collect();
    assert_eq!(told, expected);
    assert_eq!(self::told(text, &TraceOptions { limit: 0, ..TraceOptions::default() }).len(), 1);
    // A vector that grows: all its values would be two thousand million numbers.
    let large = self::told("v = [1 .. 60000]\nfor i in [1 .. 300]\n    v[i] = 0\nn = size(v)", &ALL);
    assert!(large.iter().any(|l| l.contains("omitted")) && large.last().unwrap().contains("n = 60000"));
}

/// The places where NaN and infinity come up: what, text, line, operands, calls.
fn births(text: &str, image: &Image<'_>) -> Vec<String> {
    let inverse = HostFunction::for_pixel("inverse_of", &["x"], |args| {
        args[0].as_scalar().map(|x| (1.0 / x).into()).ok_or("a scalar".into())
    });
    let program =
        Compiler::new().function(inverse).compile("program", text).unwrap_or_else(|e| panic!("{e}"));
    let options = RunOptions::default();
    let trace = program.trace(image, 0, 0, &options, &TraceOptions::default()).unwrap();
    let sources = program.sources();
    let birth = |b: &pse::Birth| {
        let operands: Vec<String> =
            b.operands.iter().map(|(span, value)| format!(" {}={value}", sources.text(*span))).collect();
        let calls: Vec<String> = b
            .calls
            .iter()
            .map(|(name, span)| format!(" in {name} {}", sources.line_column(*span).0))
            .collect();
        let what = if b.what == NotFinite::Nan { "NaN" } else { "infinity" };
        let given = if b.given { " given" } else { "" };
        let (line, text) = (sources.line_column(b.span).0, sources.text(b.span));
        format!("{what}{given} {line} {:?} `{text}`{}{}", b.rounds, operands.concat(), calls.concat())
    };
    trace.births.iter().map(birth).collect()
}

#[test]
fn where_nan_and_infinity_are_born() {
    let variable = |name: &str, x: f32| pse::Variable::new(name, pse::Shape::Scalar, [vec![x]]).unwrap();
    let image = Image::new(1, 1, [variable("hole", f32::NAN), variable("far", f32::INFINITY)]).unwrap();
    let cases: &[(&str, &[&str])] = &[
        ("a = 1\nb = pixel.x + 1", &[]),
        ("a = pixel.x - 1\nb = 2 * sqrt(a) + 1", &["NaN 2 [] `sqrt(a)` a=-0.5"]),
        ("a = 0\nb = [1 a / a]", &["NaN 2 [] `a / a` a=0 a=0"]),
        ("a = 3\na /= 0", &["infinity 2 [] `a /= 0` a=3"]),
        (
            "a = 1 / 0\nb = a - a\nc = 0 / 0",
            &["infinity 1 [] `1 / 0`", "NaN 2 [] `a - a` a=infinity a=infinity"],
        ),
        ("a = infinity\nb = min(a, 3)\na -= 1", &[]),
        ("a = 2 * hole", &["NaN given 1 [] `hole`"]),
        ("a = 1\nb = far > 3 ? hole : 1", &["infinity given 2 [] `far`", "NaN given 2 [] `hole`"]),
        ("hole += 1", &["NaN given 1 [] `hole`"]),
        // What is not computed is not looked at.
        ("a = pixel.x > 0 ? 1 : hole", &[]),
        ("a = isnan(0 / 0)", &["NaN 1 [] `0 / 0`"]),
        ("a = inverse_of(0)", &["infinity 1 [] `inverse_of(0)`"]),
        (
            "function f(x)\n    for i in [2 1 0]\n        y = x / i\n    return y\nfunction g(x)\n    return f(x) + 1\na = g(pixel.x)",
            &["infinity 3 [3] `x / i` x=0.5 i=0 in f 6 in g 7"],
        ),
        ("if begin_frame\n    k = 1 / frame\ncolor = k * white", &["infinity 2 [] `1 / frame` frame=0"]),
        ("m = Du(hole)", &["NaN given 1 [] `hole`"]),
    ];
    for (text, expected) in cases {
        assert_eq!(births(text, &image), *expected, "{text}");
    }
}

#[test]
fn an_error_comes_after_what_happened_before_it() {
    let program = compile("a = 3\nv = [1 2]\nb = v[a]\ncolor = white\n");
    let image = Image::new(1, 1, []).unwrap();
    let trace = program.trace(&image, 0, 0, &RunOptions::default(), &TraceOptions::default()).unwrap();
    assert_eq!(trace.events.len(), 2);
    assert!(trace.values.is_empty());
    let error = trace.error.unwrap();
    assert_eq!((error.code, error.pixel), ("index", Some([0, 0])));
    // What is wrong before any pixel is no trace.
    let missing = compile("color = white * nowhere");
    let error = missing.trace(&image, 0, 0, &RunOptions::default(), &TraceOptions::default()).unwrap_err();
    assert!(error.to_string().contains("there is no variable `nowhere`"), "{error}");
}
