//! What a user reads after a mistake: every program below `tests/errors/` is wrong in the way its file name says,
//! and stands beside the messages that it gets. The folders are the stages that find the fault.
//!
//! After a change on purpose, rewrite the messages with `INSTA_UPDATE=always cargo test --test language errors`, and read them.

use pse::Origin;
use pse::internal::diagnostic::{Sources, Style};
use pse::internal::host::{Disk, Host};
use pse::internal::syntax;
use pse::{Compiler, Error, HostFunction, Image, Program, RunOptions, Shape, Variable};
use std::path::Path;

/// Snapshots the messages of every program in a folder; `check` gives the rendered errors of one.
fn messages(folder: &str, check: fn(&str, &str) -> String) {
    insta::glob!("../errors", &format!("{folder}/*.pse"), |path| {
        let name = path.file_name().expect("a file").to_string_lossy();
        let text = std::fs::read_to_string(path).expect("the file can be read");
        let rendered = check(&name, &text);
        assert!(!rendered.is_empty(), "{name} has no error");
        assert!(!rendered.contains(env!("CARGO_MANIFEST_DIR")), "{name} names a folder of this machine");
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path(path.parent().expect("a folder"));
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        settings.remove_snapshot_suffix();
        settings.remove_input_file();
        settings.bind(|| insta::assert_snapshot!(name.trim_end_matches(".pse"), rendered));
    });
}

fn parse_errors(name: &str, text: &str) -> String {
    let mut sources = Sources::default();
    let source = sources.add(name, text);
    let errors = syntax::parse(source, text).errors;
    let rendered: Vec<String> = errors.iter().map(|e| e.render(&sources, Style::PLAIN)).collect();
    rendered.join("\n")
}

#[test]
fn lex() {
    messages("lex", parse_errors);
}

#[test]
fn parse() {
    messages("parse", parse_errors);
}

/// Where the programs' imports are found: `errors/imports`, then as the command finds them. Images are those of
/// `errors/images`.
struct Files;

fn images() -> Disk {
    // The tests run in the package's folder.
    Disk { path: vec!["tests/errors/images".into()] }
}

impl Host for Files {
    fn import(&self, importing: &str, path: &str) -> Result<(String, String), pse::HostError> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors/imports");
        match std::fs::read_to_string(folder.join(path)) {
            Ok(text) => Ok((path.into(), text)),
            Err(_) => Disk::default().import(importing, path),
        }
    }

    fn hint(&self) -> Option<String> {
        Disk::default().hint()
    }

    fn image(&self, program: &str, name: &str) -> Result<Origin, pse::HostError> {
        images().image(program, name)
    }

    fn images(&self, program: &str, name: &str) -> Vec<String> {
        images().images(program, name)
    }

    fn image_hint(&self) -> Option<String> {
        images().image_hint()
    }
}

/// A function of the embedding program that does not like dark places.
fn lamp() -> HostFunction {
    HostFunction::for_pixel("lamp", &["x"], |args| match args[0].as_scalar() {
        Some(x) if x > 0.5 => Ok(x.into()),
        Some(x) => Err(format!("the lamp is out at {x}").into()),
        None => Err(format!("a number is expected, not {}", args[0]).into()),
    })
}

fn compile(name: &str, text: &str) -> Result<Program, Error> {
    Compiler::new().host(&Files).function(lamp()).compile(name, text)
}

/// What a comment such as `# image: none` at the beginning of a program says.
fn directive<'t>(text: &'t str, word: &str) -> Option<&'t str> {
    text.lines().find_map(|line| line.strip_prefix(&format!("# {word}:"))).map(str::trim)
}

/// Four columns and three rows, with the variables that the program asks for.
fn image(text: &str) -> Image<'static> {
    const WIDTH: usize = 4;
    const HEIGHT: usize = 3;
    let plane = |f: &dyn Fn(f32, f32) -> f32| -> Vec<f32> {
        (0..WIDTH * HEIGHT).map(|i| f((i % WIDTH) as f32 / 4.0, (i / WIDTH) as f32 / 4.0)).collect()
    };
    let scalar = |planes| Variable::new("surface", Shape::Scalar, planes).unwrap();
    let vector = |name, planes| Variable::new(name, Shape::Vector(3), planes).unwrap();
    let all = [
        scalar([plane(&|x, _| if x < 0.5 { 1.0 } else { 2.0 })]),
        vector("point", [plane(&|x, _| x), plane(&|_, y| y), plane(&|_, _| 0.5)]),
        vector("normal", [plane(&|_, _| 0.0), plane(&|_, _| 0.0), plane(&|_, _| 1.0)]),
    ];
    let wanted = directive(text, "image").unwrap_or("surface point normal");
    let variables = all.into_iter().filter(|v| wanted.split(' ').any(|w| w == v.name));
    Image::new(WIDTH, HEIGHT, variables).unwrap()
}

fn run(name: &str, text: &str) -> Result<(), Error> {
    let program = compile(name, text)?;
    let set = directive(text, "set").map(|line| {
        let (name, value) = line.split_once(" = ").expect("name = value");
        (name.to_string(), value.parse::<f32>().expect("a number").into())
    });
    let outputs = directive(text, "outputs").map(|names| names.split(' ').map(String::from).collect());
    let number = |word| directive(text, word).map(|n| n.parse::<usize>().expect("a number"));
    let options = RunOptions {
        set: set.into_iter().collect(),
        outputs,
        frame: number("frame").unwrap_or(0) as f32,
        ..RunOptions::default()
    };
    program.run(&image(text), &options).map(drop)
}

#[test]
fn resolve() {
    messages("resolve", |name, text| compile(name, text).expect_err(name).render(Style::PLAIN));
}

#[test]
fn run_time() {
    messages("run", |name, text| {
        compile(name, text).unwrap_or_else(|e| panic!("{name} must compile:\n{e}"));
        run(name, text).expect_err(name).render(Style::PLAIN)
    });
}
