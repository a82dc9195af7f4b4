//! The library without features: language, engine and noises. These tests also run with any features, and with
//! `--no-default-features` they are the integration tests that are left.

use pse::noise::{Kind, Params};
use pse::{Compiler, Image, Memory, Program, RunOptions, Shape, Variable};

/// Columns and rows of the images.
const SIZE: [usize; 2] = [9, 7];

/// The variable `x`, which counts the columns.
fn columns() -> Image<'static> {
    let x: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(|i| (i % SIZE[0]) as f32).collect();
    let x = Variable::new("x", Shape::Scalar, [x]).expect("a plane");
    Image::new(SIZE[0], SIZE[1], [x]).expect("an image")
}

/// The message of a program that fails, when it is compiled or when it runs.
fn message(text: &str) -> String {
    let ran = Program::compile(text).and_then(|program| program.run(&columns(), &RunOptions::default()));
    ran.err().unwrap_or_else(|| panic!("no error of\n{text:.300}")).to_string()
}

#[test]
fn a_program_is_compiled_and_run() {
    let file = ("lib.pse".into(), "function twice(a)\n    return 2 * a\n".into());
    let files = Memory([file].into());
    let text = "import \"lib.pse\"\nparam k = 1\ncolor = [twice(x) k max(x, 3)]\n";
    let program = Compiler::new().host(&files).compile("main.pse", text).expect("a program");
    let options = RunOptions { set: vec![("k".into(), 5.0.into())], ..RunOptions::default() };
    let report = program.run(&columns(), &options).expect("an image");
    let color = report.image.variable("color").expect("a color");
    for (i, x) in (0..SIZE[0] * SIZE[1]).map(|i| (i, (i % SIZE[0]) as f32)) {
        assert_eq!([0, 1, 2].map(|c| color.planes[c][i]), [2.0 * x, 5.0, x.max(3.0)], "pixel {i}");
    }
}

#[test]
fn a_noise_is_called() {
    let program = Program::compile("n = Noise([0.37 * x  0.5  -1.25])\n").expect("a program");
    let options = RunOptions { outputs: Some(vec!["n".into()]), ..RunOptions::default() };
    let report = program.run(&columns(), &options).expect("an image");
    let in_program = report.image.variable("n").expect("a noise").planes[0].to_vec();
    assert!(in_program[1..SIZE[0]].iter().all(|n| *n != 0.0 && n.abs() < 1.5), "{in_program:?}");
    // And without a program.
    let kind = Kind::from_name("gradient").expect("the noise of 1992");
    let field = kind.field(3, &Params::default()).expect("three dimensions");
    let x: Vec<f32> = (0..5).map(|i| 0.37 * i as f32).collect();
    let mut values = [0.0; 5];
    field.noise(pse::internal::lanes::Isa::detect(), &[&x, &[0.5; 5], &[-1.25; 5]], &mut values);
    assert!(values.iter().all(|n| n.is_finite()) && values[0] != values[1], "{values:?}");
}

#[test]
fn errors_name_their_place_and_the_remedy() {
    let unknown = message("a = 1\ncolor = a * whit\n");
    assert!(unknown.contains("whit") && unknown.contains("white"), "{unknown}");
    let syntax = message("a = (1 +\n");
    assert!(syntax.contains('('), "{syntax}");
    let at_pixel = message("v = [1 2]\ncolor = white * v[x + 1]\n");
    assert!(at_pixel.contains("at pixel [2 0]"), "{at_pixel}");
    #[cfg(not(feature = "fancy"))]
    {
        assert!(unknown.contains("2:13") || unknown.contains("line 2"), "{unknown}");
        assert!(!unknown.contains(['│', '╭', '×', '\x1b']), "{unknown}");
    }
}

/// Programs that nest, by what nests in them.
fn nested() -> Vec<(&'static str, String)> {
    let inside = |levels: usize, keyword: &str, last: &str| {
        let lines: String = (1..=levels).map(|n| format!("{}{keyword}\n", " ".repeat(n))).collect();
        format!("{lines}{}{last}\n", " ".repeat(levels + 1))
    };
    let calls = |body: String| format!("function f(a)\n{body}    return 0\ncolor = white * f(x)\n");
    let flat = |body: String| format!("function f(a)\n{body} return 0\ncolor = white * f(x)\n");
    vec![
        ("calls", "function f(a)\n    return 1 + f(a)\ncolor = white * f(x)\n".into()),
        (
            "calls of two functions",
            "function f(a)\n    return [1 g(a)]\nfunction g(a)\n    return sin(f(a)[1])\ncolor = white * f(x)\n".into(),
        ),
        ("calls that are statements", calls("    f(a + 1)\n".into())),
        ("calls in choices", calls("    b = a > 3 ? f(a + 1) : f(a - 1)\n".into())),
        ("calls in indices", calls("    b = [1 2]\n    b[f(a) + 1] = f(b[f(a) + 1])\n".into())),
        ("calls in branches", flat(inside(90, "if a > -1", "f(a)"))),
        ("calls in branches of some pixels", flat(inside(90, "if a > 3", "f(a)"))),
        ("calls in loops", flat(inside(90, "for i in [1 2]", "f(a)"))),
        ("calls in conditions", flat(inside(90, "while a > -1", "f(a)"))),
        ("calls in brackets", calls(format!("    b = {}f(a){}\n", "sin(1 + ".repeat(90), ")".repeat(90)))),
    ]
}

/// Runs in a thread whose stack has that size.
fn on_stack<T: Send>(bytes: usize, run: impl FnOnce() -> T + Send) -> T {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(bytes).spawn_scoped(scope, run);
        thread.expect("a thread").join().expect("no panic")
    })
}

#[test]
fn nesting_ends_with_an_error_on_small_stacks() {
    for mebibytes in [2, 1] {
        for (name, text) in nested() {
            let message = on_stack(mebibytes << 20, || message(&text));
            let limit = if cfg!(feature = "deep") { "more than 256 deep" } else { "too deep for the stack" };
            let limits = [limit, "nested too deep", "steps"];
            assert!(limits.iter().any(|l| message.contains(l)), "{name}\n{message:.3000}");
        }
    }
}

/// As deep as texts may nest, and with the longest chain of operators.
#[test]
fn the_deepest_texts_fit_on_small_stacks() {
    let nest = |open: &str, close: &str, n: usize| format!("{}x{}", open.repeat(n), close.repeat(n));
    let blocks: String = (0..100).map(|n| " ".repeat(n) + "if x > -1\n").collect();
    for (name, text) in [
        ("brackets", format!("color = white * {}\n", nest("(1 + ", ")", 199))),
        ("calls", format!("color = white * {}\n", nest("sin(", ")", 199))),
        ("a chain", format!("color = white * ({}1)\n", "x + ".repeat(490))),
        ("signs", format!("color = white * {}x\n", "-".repeat(490))),
        ("powers", format!("color = white * (x{})\n", "^1".repeat(490))),
        ("choices", format!("color = white * ({}0)\n", "x > 3 ? 1 : ".repeat(240))),
        ("vectors", format!("color = white * size({})\n", nest("[1 ", "]", 60))),
        ("blocks", format!("color = white\n{blocks}{}color = white * x\n", " ".repeat(100))),
    ] {
        for mebibytes in [2, 1] {
            let ran = on_stack(mebibytes << 20, || {
                let ran = Program::compile(&text).and_then(|p| p.run(&columns(), &RunOptions::default()));
                ran.map(drop).map_err(|error| error.to_string())
            });
            if let Err(message) = ran {
                let limit = ["nested too deep", "too deep for the stack", "operators or is nested"];
                assert!(limit.iter().any(|l| message.contains(l)), "{name}\n{message:.3000}");
            }
        }
    }
}

/// A function whose second parameter has that default.
fn with_default(name: &str, default: &str) -> String {
    format!("function {name}(a, b = {default})\n    return b\n")
}

/// Defaults are resolved in each call that leaves an argument out, so they must not need themselves.
#[test]
fn defaults_end() {
    let color = |functions: &str, call: &str| format!("{functions}color = white * {call}\n");
    let [own, given] = ["f(1)", "f(1, 3)"].map(|default| color(&with_default("f", default), "f(x)"));
    let mutual = with_default("f", "g(1)") + &with_default("g", "f(1)");
    let through_a_body = with_default("f", "g()") + "function g()\n    return f(1)\n";
    let sums = |of: fn(usize) -> String, n: usize| {
        let functions: String = (1..n).map(|n| with_default(&format!("f{n}"), &of(n - 1))).collect();
        color(&(with_default("f0", "1") + &functions), &format!("f{}(x)", n - 1))
    };
    for (text, words) in [
        (own, "needs itself"),
        (color(&mutual, "f(x)"), "needs itself"),
        (color(&through_a_body, "f(x)"), "deep"),
        (sums(|n| format!("f{n}(1) + f{n}(1)"), 40), "more than 10000 defaults"),
        (sums(|n| format!("1 + f{n}(1)"), 900), "nested too deep"),
    ] {
        for mebibytes in [2, 1] {
            let message = on_stack(mebibytes << 20, || message(&text));
            assert!(message.contains(words), "{text:.200}\n{message:.3000}");
            let count = message.matches("needs itself").count();
            assert_eq!(count, usize::from(words == "needs itself"), "{message:.3000}");
        }
    }
    let ran = Program::compile(&given).and_then(|p| p.run(&columns(), &RunOptions::default()));
    assert!(ran.is_ok(), "{}", ran.unwrap_err());
}
