//! What the language promises beyond one pixel and its variables: what the system provides, params, outputs, functions
//! and files of the host, and how a run is watched and ended.

use pse::Memory;
use pse::{
    BatchResult, Compiler, Error, HostFunction, Image, PixelValue, Program, Report, RunOptions, Shape,
    Variable,
};
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// So many columns and rows, and no variables.
fn blank(width: usize, height: usize) -> Image<'static> {
    Image { width, height, ..Image::default() }
}

fn with(mut image: Image<'static>, name: &str, f: impl Fn(usize) -> Vec<f32>) -> Image<'static> {
    let n = image.width * image.height;
    let pixels: Vec<Vec<f32>> = (0..n).map(f).collect();
    let cells = pixels[0].len();
    let shape = if cells == 1 { Shape::Scalar } else { Shape::Vector(cells as u32) };
    let planes: Vec<Vec<f32>> = (0..cells).map(|c| pixels.iter().map(|p| p[c]).collect()).collect();
    image.variables.push(Variable::new(name, shape, planes).unwrap());
    image
}

fn run_with(text: &str, image: &Image<'_>, options: &RunOptions<'_>) -> Result<Report, Error> {
    Program::compile(text).unwrap_or_else(|e| panic!("{e}")).run(image, options)
}

fn run(text: &str, image: &Image<'_>) -> Report {
    run_with(text, image, &RunOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// The planes of an output.
fn planes(report: &Report, name: &str) -> Vec<Vec<f32>> {
    let variable = report.image.variable(name).unwrap_or_else(|| panic!("no output {name}"));
    variable.planes.iter().map(|p| p.to_vec()).collect()
}

/// The only plane of an output.
fn plane(report: &Report, name: &str) -> Vec<f32> {
    let mut planes = planes(report, name);
    assert_eq!(planes.len(), 1, "{name}");
    planes.remove(0)
}

fn names(report: &Report) -> Vec<&str> {
    report.image.variables.iter().map(|v| v.name.as_str()).collect()
}

fn outputs(names: &[&str]) -> RunOptions<'static> {
    RunOptions { outputs: Some(names.iter().map(|n| n.to_string()).collect()), ..RunOptions::default() }
}

#[test]
fn pixel_is_the_centre_of_the_pixel_from_the_top_left() {
    let report = run("at = pixel\nsize = resolution", &blank(3, 2));
    assert_eq!(planes(&report, "at"), [[0.5, 1.5, 2.5, 0.5, 1.5, 2.5], [0.5, 0.5, 0.5, 1.5, 1.5, 1.5]]);
    assert_eq!(planes(&report, "size"), [[3.0; 6], [2.0; 6]]);
}

#[test]
fn pixel_counts_from_the_display_windows_corner() {
    let mut image = blank(2, 2);
    image.metadata.origin = [-1, 10];
    image.metadata.resolution = Some([640, 480]);
    let report = run("at = pixel\nsize = resolution", &image);
    assert_eq!(planes(&report, "at"), [[-0.5, 0.5, -0.5, 0.5], [10.5, 10.5, 11.5, 11.5]]);
    assert_eq!(planes(&report, "size"), [[640.0; 4], [480.0; 4]]);
    let error = run_with("v = [1]\ncolor = v[pixel.y - 9.5]", &image, &RunOptions::default()).unwrap_err();
    assert_eq!(error.diagnostics[0].pixel, Some([-1, 11]));
}

#[test]
fn frame_is_the_hosts() {
    let options = RunOptions { frame: 7.0, ..RunOptions::default() };
    let text = "if begin_frame\n    twice = frame * 2\na = frame\nb = twice\nc = begin_frame";
    let report = run_with(text, &blank(2, 1), &options).unwrap();
    assert_eq!(names(&report), ["a", "b", "c"]);
    assert_eq!((plane(&report, "a"), plane(&report, "b")), (vec![7.0; 2], vec![14.0; 2]));
    assert_eq!(plane(&report, "c"), [0.0; 2]);
}

#[test]
fn pixelsize_comes_from_points_or_from_outside() {
    let image = with(blank(3, 1), "point", |i| vec![i as f32 * 0.25, 0.0, 0.0]);
    let text = "a = pixelsize\nb = pixel_freq";
    let report = run(text, &image);
    assert_eq!((plane(&report, "a"), plane(&report, "b")), (vec![0.25; 3], vec![2.0; 3]));
    let options = RunOptions { pixelsize: Some(0.5), ..RunOptions::default() };
    let report = run_with(text, &image, &options).unwrap();
    assert_eq!((plane(&report, "a"), plane(&report, "b")), (vec![0.5; 3], vec![1.0; 3]));
    // Without points, one pixel of a unit-high image.
    assert_eq!(plane(&run(text, &blank(3, 4)), "a"), [0.25; 12]);
}

#[test]
fn params_are_set_from_outside() {
    let text = "param size = 2 in [0 10]\nparam double = size * 2\nif begin_frame\n    table = [size double]\n\
                a = size\nb = table";
    let report = run(text, &blank(1, 1));
    assert_eq!((plane(&report, "a"), planes(&report, "b")), (vec![2.0], vec![vec![2.0], vec![4.0]]));
    let options = RunOptions { set: vec![("size".into(), 5.0.into())], ..RunOptions::default() };
    let report = run_with(text, &blank(1, 1), &options).unwrap();
    assert_eq!((plane(&report, "a"), planes(&report, "b")), (vec![5.0], vec![vec![5.0], vec![10.0]]));
    // The last of several settings holds, and vectors can be set, too.
    let set =
        vec![("size".into(), PixelValue::from([5.0, 5.0])), ("size".into(), PixelValue::from([1.0, 3.0]))];
    let text = "param size = [2 2]\na = size";
    let report = run_with(text, &blank(1, 1), &RunOptions { set, ..outputs(&["a"]) }).unwrap();
    assert_eq!(planes(&report, "a"), [[1.0], [3.0]]);
}

#[test]
fn outputs_are_color_and_alpha_or_all_that_is_assigned() {
    let image = with(blank(1, 1), "point", |_| vec![1.0, 2.0, 3.0]);
    assert_eq!(names(&run("a = 1\ncolor = white\nb = 2", &image)), ["color"]);
    assert_eq!(names(&run("alpha = 1\ncolor = white\nb = 2", &image)), ["color", "alpha"]);
    assert_eq!(names(&run("a = 1\nb = point", &image)), ["a", "b"]);
    let report =
        run_with("a = 1\ncolor = white\nb = 2", &image, &outputs(&["b", "point", "a", "b"])).unwrap();
    assert_eq!(names(&report), ["b", "point", "a"]);
    assert_eq!(planes(&report, "point"), [[1.0], [2.0], [3.0]]);
    // A frame variable is written like any other.
    let report = run_with("if begin_frame\n    k = [1 2]\ncolor = white", &image, &outputs(&["k"])).unwrap();
    assert_eq!(planes(&report, "k"), [[1.0], [2.0]]);
}

#[test]
fn an_expression_alone_is_the_color() {
    let image = with(blank(2, 1), "x", |i| vec![i as f32]);
    assert_eq!(planes(&run("y = 2 * x\nwhite * y", &image), "color"), [[0.0, 2.0], [0.0, 2.0], [0.0, 2.0]]);
    // The last one; one in a block does not count; an assigned colour wins.
    assert_eq!(planes(&run("1\nx + 3\nif x\n    7", &image), "color")[0], [3.0, 4.0]);
    assert_eq!(planes(&run("color = 5\n1", &image), "color")[0], [5.0, 5.0]);
    // It can be read by what comes after.
    let report = run_with("x + 1\nmore = color * 2", &image, &outputs(&["more"])).unwrap();
    assert_eq!(plane(&report, "more"), [2.0, 4.0]);
}

#[test]
fn a_changed_normal_makes_a_picture() {
    let image = with(blank(1, 1), "normal", |_| vec![0.0, 0.0, 1.0]);
    let report = run("normal += [0 0.5 0]", &image);
    assert!(report.by_normal);
    let color = planes(&report, "color");
    assert!(color.len() == 3 && color[0] == color[1] && color[0][0] > 0.0 && color[0][0] < 1.0, "{color:?}");
    let report = run_with("normal += [0 0.5 0]", &image, &outputs(&["normal"])).unwrap();
    assert!(!report.by_normal);
    assert_eq!(planes(&report, "normal"), [[0.0], [0.5], [1.0]]);
    assert!(!run("normal += [0 0.5 0]\nnormal * 2", &image).by_normal);
}

#[test]
fn colors_are_grey_or_have_three_or_four_components() {
    let image = with(blank(3, 1), "x", |i| vec![i as f32]);
    assert_eq!(planes(&run("color = x", &image), "color"), [[0.0, 1.0, 2.0]; 3]);
    let text =
        "if x == 0\n    color = 0.5\nelse if x == 1\n    color = [1 0 0]\nelse\n    color = [0 0 1 0.25]";
    let expected = [[0.5, 1.0, 0.0], [0.5, 0.0, 0.0], [0.5, 0.0, 1.0], [1.0, 1.0, 0.25]];
    for batch in [1, 2, 512] {
        let options = RunOptions { batch: Some(batch), ..RunOptions::default() };
        assert_eq!(planes(&run_with(text, &image, &options).unwrap(), "color"), expected, "batch {batch}");
    }
}

#[test]
fn a_scalar_fills_the_components_of_other_pixels_outputs() {
    // Neither order nor which pixels are looked at first matters.
    for (text, expected) in [
        ("if pixel.x < 20\n    v = 7\nelse\n    v = [1 2]", [7.0, 1.0]),
        ("if pixel.x < 20\n    v = [1 2]\nelse\n    v = 7", [1.0, 7.0]),
    ] {
        let v = planes(&run(text, &blank(40, 1)), "v");
        assert_eq!(v.len(), 2, "{text}");
        assert_eq!((v[0][0], v[0][39]), (expected[0], expected[1]));
    }
    // A vector at one pixel alone, where nobody looked.
    let v = planes(&run("v = 7\nif pixel.x > 500 && pixel.x < 501\n    v = [1 2 3]", &blank(1000, 1)), "v");
    assert_eq!((v.len(), v[2][500], v[2][499]), (3, 3.0, 7.0));
}

#[test]
fn pixels_without_a_value_are_zero() {
    let report = run("if pixel.x > 1\n    color = white", &blank(3, 1));
    assert_eq!(planes(&report, "color"), [[0.0, 1.0, 1.0]; 3]);
}

#[test]
fn pixels_that_are_not_finite_are_counted() {
    let image = with(blank(4, 1), "x", |i| vec![i as f32 - 1.0]);
    assert_eq!(run("color = [1 / x, sqrt(x), 0]", &image).not_finite, 2);
    assert_eq!(run("color = white", &image).not_finite, 0);
    assert_eq!(run_with("a = 1 / x\nb = 1", &image, &outputs(&["b"])).unwrap().not_finite, 0);
}

#[test]
fn a_run_can_be_cancelled() {
    let cancel = AtomicBool::new(true);
    let options = RunOptions { cancel: Some(&cancel), ..RunOptions::default() };
    let error = run_with("color = white", &blank(100, 100), &options).unwrap_err();
    assert!(error.cancelled);
    // From inside, while it runs.
    cancel.store(false, Ordering::Relaxed);
    let stop = |_| {
        cancel.store(true, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    let options = RunOptions {
        cancel: Some(&cancel),
        progress: Some(&stop),
        threads: Some(1),
        ..RunOptions::default()
    };
    assert!(run_with("color = pixel.x", &blank(1000, 1000), &options).unwrap_err().cancelled);
    let enough =
        |p: pse::Progress| if p.done > 100_000 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let options = RunOptions { progress: Some(&enough), ..RunOptions::default() };
    assert!(run_with("color = pixel.x", &blank(1000, 1000), &options).unwrap_err().cancelled);
    assert!(run_with("color = pixel.x", &blank(100, 100), &options).is_ok());
}

#[test]
fn progress_reaches_the_end() {
    let (calls, seen) = (AtomicUsize::new(0), Mutex::new((0, 0)));
    let progress = |p: pse::Progress| {
        calls.fetch_add(1, Ordering::Relaxed);
        let mut seen = seen.lock().unwrap();
        *seen = (seen.0.max(p.done), p.total);
        ControlFlow::Continue(())
    };
    let options = RunOptions { progress: Some(&progress), ..RunOptions::default() };
    run_with("color = white", &blank(200, 200), &options).unwrap();
    assert_eq!(*seen.lock().unwrap(), (40_000, 40_000));
    assert!(calls.into_inner() > 1);
}

#[test]
fn a_host_may_add_functions_of_a_pixel() {
    let lookup = HostFunction::for_pixel("lookup", &["i", "table"], |args| {
        let i = args[0].as_scalar().ok_or("a number is expected")?;
        let table = args[1].cells();
        table
            .get(i as usize)
            .map(|&x| PixelValue::from([x, i]))
            .ok_or_else(|| format!("nothing at {i}").into())
    });
    let program = Compiler::new()
        .function(lookup)
        .compile("p", "v = lookup(table = [5 6 7], i = x)\nw = lookup(0, [9])")
        .unwrap();
    let image = with(blank(3, 1), "x", |i| vec![i as f32]);
    let report = program.run(&image, &RunOptions::default()).unwrap();
    assert_eq!(planes(&report, "v"), [[5.0, 6.0, 7.0], [0.0, 1.0, 2.0]]);
    assert_eq!(planes(&report, "w"), [[9.0; 3], [0.0; 3]]);
    // Its errors are those of the pixel.
    let image = with(blank(3, 1), "x", |i| vec![i as f32 * 2.0]);
    let error = program.run(&image, &RunOptions::default()).unwrap_err();
    assert_eq!(error.diagnostics[0].pixel, Some([2, 0]));
    assert!(error.to_string().contains("nothing at 4"), "{error}");
}

#[test]
fn a_host_functions_shape_may_change_from_pixel_to_pixel() {
    let count = HostFunction::for_pixel("count", &["n"], |args| {
        let n = args[0].as_scalar().ok_or("a number is expected")?;
        Ok(PixelValue::from(&vec![1.0; n as usize][..]))
    });
    let program =
        Compiler::new().function(count).compile("p", "total = sum(count(x)) + size(count(x))").unwrap();
    let image = with(blank(4, 1), "x", |i| vec![i as f32]);
    let report = program.run(&image, &RunOptions::default()).unwrap();
    assert_eq!(plane(&report, "total"), [0.0, 2.0, 4.0, 6.0]);
}

#[test]
fn a_host_may_add_functions_of_a_batch() {
    let twice = HostFunction::for_batch("twice", &["v"], |args| {
        let shape = args.shape(0).clone();
        let double = |cell| args.plane(0, cell).iter().map(|x| x * 2.0).collect();
        Ok(BatchResult { planes: (0..shape.cells()).map(double).collect(), shape })
    });
    // It hides the built-in function of its name, and is hidden by the program's own.
    let dot = HostFunction::for_batch("dot", &["a", "b"], |args| {
        Ok(BatchResult { shape: Shape::Scalar, planes: vec![vec![42.0; args.lanes()]] })
    });
    let text = "function own(x)\n    return x\nv = twice([x 1])\nd = dot(1, 2)";
    let own = HostFunction::for_pixel("own", &["x"], |_| Err("not this one".into()));
    let compiler = Compiler::new().function(twice).function(dot).function(own);
    let program = compiler.compile("p", &format!("{text}\no = own(3)")).unwrap();
    let image = with(blank(3, 1), "x", |i| vec![i as f32]);
    let report = program.run(&image, &RunOptions::default()).unwrap();
    assert_eq!(planes(&report, "v"), [[0.0, 2.0, 4.0], [2.0; 3]]);
    assert_eq!((plane(&report, "d"), plane(&report, "o")), (vec![42.0; 3], vec![3.0; 3]));
}

#[test]
fn an_inputs_variable_hides_a_constant_and_not_the_system() {
    let image = with(with(blank(2, 1), "pi", |i| vec![i as f32]), "frame", |i| vec![i as f32 + 5.0]);
    let report = run("a = pi * 2\nb = frame\nfunction f()\n    return pi + 1\nc = f()", &image);
    assert_eq!((plane(&report, "a"), plane(&report, "b")), (vec![0.0, 2.0], vec![0.0, 0.0]));
    assert_eq!(plane(&report, "c"), [1.0, 2.0]);
    // The library keeps the system's own: a wave moves with the frame, whatever an image calls so.
    let text = "a = norm(moving_wave([0 0 4], 1))";
    assert_eq!(plane(&run(text, &image), "a"), plane(&run(text, &blank(2, 1)), "a"));
}

#[test]
fn the_library_does_not_see_the_programs_functions() {
    // marble() calls turbulence() and marble_color().
    let image = with(blank(1, 1), "point", |_| vec![0.1, 0.2, 0.3]);
    let plain = planes(&run("color = marble(point)", &image), "color");
    let text = "function marble_color(x)\n    return [7 7 7]\nfunction turbulence(p)\n    return 0\ncolor = marble(point)";
    assert_eq!(planes(&run(text, &image), "color"), plain);
}

#[test]
fn imports_bring_functions_and_params() {
    let files = [
        (
            "waves.pse",
            "import \"shapes.pse\"\nparam height = 2\nheight_seen = 9\nfunction wave_at(x)\n    return height * square(x)\n",
        ),
        ("shapes.pse", "import \"waves.pse\"\nfunction square(x)\n    return x * x\n"),
    ];
    let host = Memory(files.iter().map(|(n, t)| (n.to_string(), t.to_string())).collect());
    let text = "import \"waves.pse\"\nimport \"shapes.pse\"\na = wave_at(3)\nb = square(4)\nc = height";
    let program = Compiler::new().host(&host).compile("main.pse", text).unwrap();
    let report = program.run(&blank(1, 1), &RunOptions::default()).unwrap();
    assert_eq!(names(&report), ["a", "b", "c"]);
    assert_eq!([plane(&report, "a"), plane(&report, "b"), plane(&report, "c")], [[18.0], [16.0], [2.0]]);
    let options = RunOptions { set: vec![("height".into(), 1.0.into())], ..RunOptions::default() };
    assert_eq!(plane(&program.run(&blank(1, 1), &options).unwrap(), "a"), [9.0]);
    // The imported function sees the variables of the program that imports it.
    let host = Memory([("f.pse".to_string(), "function f()\n    return k\n".to_string())].into());
    let program =
        Compiler::new().host(&host).compile("main.pse", "import \"f.pse\"\nk = 5\na = f()").unwrap();
    assert_eq!(plane(&program.run(&blank(1, 1), &RunOptions::default()).unwrap(), "a"), [5.0]);
}

#[test]
fn the_frames_block_runs_once_and_else_at_every_pixel() {
    let calls = std::sync::Arc::new(AtomicUsize::new(0));
    let counter = calls.clone();
    let tick = HostFunction::for_pixel("tick", &[], move |_| {
        counter.fetch_add(1, Ordering::Relaxed);
        Ok(1.0.into())
    });
    let text = "if begin_frame\n    k = tick()\nelse if pixel.x > 1\n    side = 2\nelse\n    side = 1\na = k\nb = side";
    let program = Compiler::new().function(tick).compile("p", text).unwrap();
    let report = program.run(&blank(3, 1), &outputs(&["a", "b"])).unwrap();
    assert_eq!((plane(&report, "a"), plane(&report, "b")), (vec![1.0; 3], vec![1.0, 2.0, 2.0]));
    assert_eq!(calls.load(Ordering::Relaxed), 1);
}

#[test]
fn what_branches_leave_belongs_to_each_pixel() {
    let text = "if pixel.x > 1\n    v = [1 2]\nelse\n    v = 3\nn = 0\nfor e in [v]\n    n += sum(e)\n\
                function f(x)\n    if x > 1\n        return [x]\n    return x\nm = sum(f(pixel.x))\nk = pixel.x > 1 ? v[2] : v";
    let report = run_with(text, &blank(3, 1), &outputs(&["n", "m", "k"])).unwrap();
    assert_eq!(plane(&report, "n"), [3.0, 3.0, 3.0]);
    assert_eq!(plane(&report, "m"), [0.5, 1.5, 2.5]);
    assert_eq!(plane(&report, "k"), [3.0, 2.0, 2.0]);
}

#[test]
fn a_vector_may_grow_differently_at_each_pixel() {
    let text = "v = []\nn = 0\nwhile n < pixel.x\n    n += 1\n    v[n] = n\nlength = size(v)\ntotal = sum(v)";
    let report = run_with(text, &blank(4, 1), &outputs(&["length", "total"])).unwrap();
    assert_eq!(plane(&report, "length"), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(plane(&report, "total"), [1.0, 3.0, 6.0, 10.0]);
}

#[test]
fn errors_are_facts_as_well_as_text() {
    let error = Program::compile("a = Nois(1)\nb = 1 +\n").unwrap_err();
    let codes: Vec<&str> = error.diagnostics.iter().map(|d| d.code).collect();
    assert!(codes.contains(&"name") && codes.contains(&"syntax"), "{codes:?}");
    let image = with(blank(2, 1), "x", |i| vec![i as f32]);
    let text = "function f(v)\n    return v[3]\ncolor = x > 0 ? f([1 2]) : 0";
    let error = run_with(text, &image, &RunOptions::default()).unwrap_err();
    let [d] = &error.diagnostics[..] else { panic!("{error}") };
    assert_eq!((d.code, d.pixel, d.trace.len()), ("index", Some([1, 0]), 1));
    assert_eq!(error.sources.line_column(d.span().unwrap()), (2, 14));
}

#[test]
fn the_generated_parser_is_current() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("grammar");
    let folder = tempfile::tempdir().unwrap();
    lalrpop::Configuration::new()
        .set_in_dir(&root)
        .set_out_dir(folder.path())
        .process()
        .expect("grammar/pse.lalrpop is a correct grammar");
    let expected = std::fs::read_to_string(folder.path().join("pse.rs")).unwrap();
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(root.join("pse.rs"), &expected).unwrap();
    }
    let found = std::fs::read_to_string(root.join("pse.rs")).unwrap();
    assert!(
        found == expected,
        "grammar/pse.rs is stale: UPDATE=1 cargo test --test language the_generated rewrites it"
    );
}
