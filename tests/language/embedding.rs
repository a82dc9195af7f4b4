//! What a host relies on: sessions, buffers with strides, windows, threads of its own, and errors instead of panics.

use pse::{
    BufferView, BufferViewMut, Compiler, Executor, HostFunction, Image, Program, RunOptions, Session, Shape,
    Strides, Variable, Window, scene,
};
use std::borrow::Cow;
use std::sync::Arc;

const MARBLE: &str = "color = [0.9 0.85 0.8] * sin(8 * point.x + 4 * turbulence(point)) + normal.z / 4";

fn donut(width: usize, height: usize) -> Image<'static> {
    scene::render("donut", &scene::Options { width, height, ..scene::Options::default() }).unwrap()
}

fn session(text: &str) -> Session {
    Session::new(Program::compile(text).unwrap())
}

/// A variable of an image as a buffer of interleaved pixels, with `pad` numbers behind each row.
fn interleaved(variable: &Variable<'_>, width: usize, pad: usize, up: bool) -> Vec<f32> {
    let n = variable.planes.len();
    let height = variable.planes[0].len() / width;
    let mut out = vec![-7.0; (n * width + pad) * height];
    for row in 0..height {
        let at = if up { height - 1 - row } else { row } * (n * width + pad);
        for column in 0..width {
            for (c, plane) in variable.planes.iter().enumerate() {
                out[at + column * n + c] = plane[row * width + column];
            }
        }
    }
    out
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|x| x.to_bits()).collect()
}

#[test]
fn buffers_of_any_layout_give_the_bits_of_planes() {
    let (width, height) = (173, 61);
    let image = donut(width, height);
    for text in [MARBLE, "color = Du(point)\nalpha = 0.5 + pixelsize", "color = white * surface"] {
        let program = Arc::new(Program::compile(text).unwrap());
        let options = RunOptions { outputs: Some(vec!["color".into()]), ..RunOptions::default() };
        let expected = program.run(&image, &options).unwrap();
        let expected = expected.image.variable("color").unwrap();
        let mut session = Session::new(Arc::clone(&program));
        *session.metadata_mut() = image.metadata.clone();
        for (pad, up, threads) in [(0, false, 1), (5, false, 2), (0, true, 1), (3, true, 2)] {
            let buffers: Vec<Vec<f32>> =
                image.variables.iter().map(|v| interleaved(v, width, pad, up)).collect();
            let strides = |n: usize| {
                let row = (n * width + pad) as isize;
                let strides = Strides { row, ..Strides::interleaved(n, width) };
                if up { strides.bottom_up(height) } else { strides }
            };
            let inputs: Vec<BufferView<'_>> = image
                .variables
                .iter()
                .zip(&buffers)
                .map(|(v, data)| BufferView {
                    name: &v.name,
                    shape: v.shape.clone(),
                    data,
                    strides: strides(v.planes.len()),
                })
                .collect();
            let mut data = vec![-7.0; (4 * width + pad) * height];
            let outputs =
                &mut [BufferViewMut { name: "color", components: 4, data: &mut data, strides: strides(4) }];
            let options = RunOptions { threads: Some(threads), ..RunOptions::default() };
            let summary = session.run_into([width, height], &inputs, outputs, &options).unwrap();
            assert_eq!(summary.threads.min(1), 1);
            let mut again = data.clone();
            for row in 0..height {
                let at = if up { height - 1 - row } else { row } * (4 * width + pad);
                for column in 0..width {
                    for (c, plane) in expected.planes.iter().enumerate() {
                        let (found, wanted) = (data[at + 4 * column + c], plane[row * width + column]);
                        assert_eq!(found.to_bits(), wanted.to_bits(), "{text}: [{column} {row}] {c}");
                    }
                    again[at + 4 * column..][..4].fill(-7.0);
                }
            }
            assert!(again.iter().all(|x| *x == -7.0), "what belongs to no pixel stays");
        }
    }
}

#[test]
fn the_alpha_of_a_colour_is_the_programs_the_inputs_or_one() {
    let alpha = Variable::new("alpha", Shape::Scalar, [vec![0.25; 4]]).unwrap();
    let strides = Strides::interleaved(4, 2);
    let run = |text: &str, with: bool| {
        let inputs = [BufferView {
            name: "alpha",
            shape: Shape::Scalar,
            data: &alpha.planes[0],
            strides: Strides::planar(2, 2),
        }];
        let mut data = [0.0; 16];
        let outputs = &mut [BufferViewMut { name: "color", components: 4, data: &mut data, strides }];
        let inputs = if with { &inputs[..] } else { &[] };
        session(text).run_into([2, 2], inputs, outputs, &RunOptions::default()).unwrap();
        data[..4].to_vec()
    };
    assert_eq!(run("color = [1 2 3]", false), [1.0, 2.0, 3.0, 1.0]);
    assert_eq!(run("color = [1 2 3]", true), [1.0, 2.0, 3.0, 0.25]);
    assert_eq!(run("color = [1 2 3]\nalpha = 0.5", true), [1.0, 2.0, 3.0, 0.5]);
    assert_eq!(run("color = [1 2 3 4]", true), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(run("color = 7", false), [7.0, 7.0, 7.0, 1.0]);
}

#[test]
fn a_session_runs_as_its_program_does_whatever_changes_between_runs() {
    let text =
        "param veins = 4 in [1 20]\ncolor = white * sin(veins * point.x + frame)\nn = turbulence(point)";
    let program = Arc::new(Program::compile(text).unwrap());
    let mut session = Session::new(Arc::clone(&program));
    let small = donut(40, 30);
    let large = donut(200, 90);
    for (image, frame, veins, outputs) in [
        (&small, 1.0, 4.0, None),
        (&small, 1.0, 4.0, None),
        (&small, 1.0, 9.0, None),
        (&large, 1.0, 9.0, None),
        (&large, 2.0, 9.0, Some(vec!["n".to_string(), "color".to_string()])),
        (&large, 2.0, 9.0, Some(vec!["n".to_string(), "color".to_string()])),
        (&small, 2.0, 9.0, None),
    ] {
        let options =
            RunOptions { frame, set: vec![("veins".into(), veins.into())], outputs, ..RunOptions::default() };
        let expected = program.run(image, &options).unwrap().image;
        let found = session.run(image, &options).unwrap().image;
        assert_eq!(expected.variables.len(), found.variables.len());
        for (a, b) in expected.variables.iter().zip(&found.variables) {
            assert_eq!((&a.name, &a.shape), (&b.name, &b.shape));
            assert!(a.planes.iter().zip(&b.planes).all(|(a, b)| bits(a) == bits(b)), "{}", a.name);
        }
    }
}

#[test]
fn a_session_goes_on_after_an_error() {
    let mut session = session("v = [1 2 3]\ncolor = white * v[x]");
    let image =
        |x: f32| Image::new(2, 1, [Variable::new("x", Shape::Scalar, [vec![1.0, x]]).unwrap()]).unwrap();
    let options = RunOptions::default();
    assert!(session.run(&image(2.0), &options).is_ok());
    assert!(session.run(&image(9.0), &options).is_err());
    let report = session.run(&image(3.0), &options).unwrap();
    assert_eq!(report.image.variables[0].planes[0][..], [1.0, 3.0]);
}

#[test]
fn windows_are_cut_out_of_the_whole_picture() {
    let image = donut(90, 70);
    let program = Program::compile("color = turbulence(4 * point) + Du(point)\np = pixel").unwrap();
    let outputs = Some(vec!["color".to_string(), "p".to_string()]);
    let whole =
        program.run(&image, &RunOptions { outputs: outputs.clone(), ..RunOptions::default() }).unwrap();
    for window in [
        Window { columns: 0..90, rows: 10..11 },
        Window { columns: 13..60, rows: 0..70 },
        Window { columns: 89..90, rows: 69..70 },
        Window { columns: 5..5, rows: 0..7 },
    ] {
        for every in [1, 3] {
            let options = RunOptions {
                window: Some(window.clone()),
                outputs: outputs.clone(),
                every,
                batch: Some(100),
                ..RunOptions::default()
            };
            let part = program.run(&image, &options).unwrap().image;
            let size = [&window.columns, &window.rows].map(|r| r.len().div_ceil(every));
            assert_eq!([part.width, part.height], size);
            let origin = [window.columns.start as i32, window.rows.start as i32];
            assert_eq!((part.metadata.origin, part.resolution()), (origin, [90, 70]));
            for (part, whole) in part.variables.iter().zip(&whole.image.variables) {
                for (part, whole) in part.planes.iter().zip(&whole.planes) {
                    let rows = window.rows.clone().step_by(every);
                    let pixels =
                        rows.flat_map(|y| window.columns.clone().step_by(every).map(move |x| y * 90 + x));
                    let cut: Vec<f32> = pixels.map(|i| whole[i]).collect();
                    assert_eq!(bits(part), bits(&cut), "{window:?} {every}");
                }
            }
        }
    }
    let outside = RunOptions { window: Some(Window { columns: 3..91, rows: 0..1 }), ..RunOptions::default() };
    let error = program.run(&image, &outside).unwrap_err();
    assert_eq!(error.diagnostics[0].message, "the image has no columns 3 to 91: it holds 90");
}

#[test]
fn a_host_may_lend_its_threads() {
    struct Two;
    impl Executor for Two {
        fn run(&self, work: &(dyn Fn() + Sync)) {
            std::thread::scope(|scope| {
                scope.spawn(work);
                work();
            });
        }
    }
    let image = donut(200, 200);
    let program = Program::compile(MARBLE).unwrap();
    let expected = program.run(&image, &RunOptions::default()).unwrap();
    let options = RunOptions { executor: Some(&Two), ..RunOptions::default() };
    let found = program.run(&image, &options).unwrap();
    assert_eq!(found.threads, 2);
    assert_eq!(bits(&found.image.variables[0].planes[1]), bits(&expected.image.variables[0].planes[1]));
}

#[test]
fn images_for_look_ups_can_be_replaced() {
    struct Ramp(Arc<Image<'static>>);
    impl pse::Host for Ramp {
        fn import(&self, _: &str, _: &str) -> Result<(String, String), pse::HostError> {
            Err("no files".into())
        }
        fn image(&self, _: &str, _: &str) -> Result<pse::Origin, pse::HostError> {
            Ok(pse::Origin::Image(self.0.clone()))
        }
    }
    let grey = |x: f32| {
        Arc::new(Image::new(1, 1, [Variable::new("grey", Shape::Scalar, [vec![x]]).unwrap()]).unwrap())
    };
    let host = Ramp(grey(0.25));
    let program =
        Arc::new(Compiler::new().host(&host).compile("p", "color = texture(\"ramp\", 0.5, 0.5)").unwrap());
    let mut session = Session::new(Arc::clone(&program));
    let image = Image::new(1, 1, []).unwrap();
    let mut value = |textures| {
        let options = RunOptions { textures, ..RunOptions::default() };
        session.run(&image, &options).map(|report| report.image.variables[0].planes[0][0])
    };
    let other = grey(0.75);
    assert_eq!(value(vec![]).unwrap(), 0.25);
    assert_eq!(value(vec![("ramp".into(), other.clone())]).unwrap(), 0.75);
    assert_eq!(value(vec![("ramp".into(), other)]).unwrap(), 0.75);
    assert_eq!(value(vec![]).unwrap(), 0.25);
    let error = value(vec![("rmap".into(), grey(0.0))]).unwrap_err();
    assert_eq!(error.diagnostics[0].message, "the program looks nothing up in an image `rmap`");
}

#[test]
fn images_and_buffers_that_do_not_fit_are_errors() {
    let message = |error: pse::Error| error.diagnostics[0].message.clone();
    let program = Program::compile("color = white * x").unwrap();
    let options = RunOptions::default();
    let x = |planes: Vec<Cow<'static, [f32]>>| Variable { name: "x".into(), shape: Shape::Scalar, planes };
    let image = |variable| Image { width: 2, height: 2, variables: vec![variable], ..Image::default() };
    let short = program.run(&image(x(vec![vec![1.0].into()])), &options).unwrap_err();
    assert_eq!(message(short), "a plane of `x` holds 1 numbers for 4 pixels");
    let none = program.run(&image(x(vec![])), &options).unwrap_err();
    assert_eq!(message(none), "`x` is a scalar and has 0 planes instead of 1");
    let huge = Image { width: usize::MAX / 2 + 1, height: 2, ..Image::default() };
    assert!(message(program.run(&huge, &options).unwrap_err()).ends_with("pixels is too large"));
    assert!(Image::new(usize::MAX / 2 + 1, 2, [x(vec![vec![].into()])]).is_err());
    let good = image(x(vec![vec![1.0; 4].into()]));
    let mut stream = program.stream(&options);
    assert_eq!(message(stream.rows(&good, 0..9).unwrap_err()), "the image has no rows 0 to 9: it holds 2");

    let data = [1.0; 8];
    let run = |input: Strides, components: usize, output: Strides, size: [usize; 2]| {
        let mut out = [0.0; 12];
        let views = [BufferView { name: "x", shape: Shape::Scalar, data: &data, strides: input }];
        let outputs = &mut [BufferViewMut { name: "color", components, data: &mut out, strides: output }];
        session("color = white * x").run_into(size, &views, outputs, &options).map(|_| out).map_err(message)
    };
    let (plane, rgb) = (Strides::planar(2, 2), Strides::interleaved(3, 2));
    assert_eq!(run(plane, 3, rgb, [2, 2]).unwrap(), [1.0; 12]);
    assert!(
        run(Strides { start: 5, ..plane }, 3, rgb, [2, 2]).unwrap_err().contains("too few for its strides")
    );
    assert!(
        run(plane, 3, Strides { start: 1, ..rgb }, [2, 2]).unwrap_err().contains("too few for its strides")
    );
    assert!(run(plane, 3, Strides { row: 1, ..rgb }, [2, 2]).unwrap_err().contains("overlap"));
    assert!(run(plane, 2, rgb, [2, 2]).unwrap_err().contains("has 2 components"));
    assert!(run(Strides { row: isize::MIN, ..plane }, 3, rgb, [2, 2]).is_err());
    assert!(run(plane, 3, rgb, [usize::MAX, usize::MAX]).is_err());
}

#[test]
fn names_and_values_from_outside_are_checked() {
    let compile = |name: &str, params: &[&str]| {
        let function = HostFunction::for_pixel(name, params, |_| Ok(0.0.into()));
        Compiler::new().function(function).compile("p", "color = white")
    };
    assert!(compile("fine", &["a", "b"]).is_ok());
    for (name, params) in
        [("if", &["a"][..]), ("my fun", &["a"]), ("f", &["a", "a"]), ("f", &["1"]), ("", &[])]
    {
        assert!(compile(name, params).is_err(), "{name} {params:?}");
    }
    let program = Program::compile("param k = 2 in [1 20]\nparam c = [1 2 3]\ncolor = c * k").unwrap();
    let set = |name: &str, value: pse::PixelValue| {
        let options = RunOptions { set: vec![(name.into(), value)], ..RunOptions::default() };
        program.run(&Image::new(1, 1, []).unwrap(), &options).map_err(|e| e.diagnostics[0].message.clone())
    };
    assert!(set("k", 200.0.into()).is_ok(), "a range is for sliders and limits nothing");
    assert_eq!(set("k", f32::NAN.into()).unwrap_err(), "`k` is set to NaN, which is no number");
    assert_eq!(
        set("c", 1.0.into()).unwrap_err(),
        "`c` is a vector of 3 in the program, and is set to a scalar"
    );
    assert!(set("k", [1.0, 2.0].into()).is_err());
}

#[test]
fn pixels_beyond_the_largest_32_bit_number() {
    // 2^33 pixels, of which 8 by 8 are run.
    let image = Image::new(131_072, 65_536, []).unwrap();
    let program = Program::compile("color = pixel.y").unwrap();
    let options = RunOptions { every: 8192, ..RunOptions::default() };
    let report = program.run(&image, &options).unwrap();
    let rows: Vec<f32> = report.image.variables[0].planes[0].chunks(16).map(|row| row[15]).collect();
    let expected: Vec<f32> = (0..8).map(|row| row as f32 * 8192.0 + 0.5).collect();
    assert_eq!(rows, expected);
    let window = Window { columns: 131_070..131_072, rows: 65_535..65_536 };
    let options = RunOptions { window: Some(window), ..RunOptions::default() };
    let report = program.run(&image, &options).unwrap();
    assert_eq!(report.image.variables[0].planes[0][..], [65_535.5; 2]);
}
