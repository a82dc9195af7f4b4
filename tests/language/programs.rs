//! Runs `tests/programs/*.pse`. A comment `#= value` behind an assignment says what its variable holds in the
//! end, as an expression of the language; it is compared to within a millionth.

use pse::Disk;
use pse::{Compiler, PixelValue, Program, RunOptions};
use std::path::Path;

/// What the one pixel of these programs has.
fn inputs() -> Vec<(&'static str, PixelValue)> {
    vec![
        ("surface", 1.0.into()),
        ("point", [0.5, 0.25, -1.0].into()),
        ("normal", [0.0, 0.0, 1.0].into()),
        ("bg.color", [0.1, 0.2, 0.3].into()),
    ]
}

fn close(a: &PixelValue, b: &PixelValue) -> bool {
    let near = |(a, b): (&f32, &f32)| {
        a == b || (a.is_nan() && b.is_nan()) || (a - b).abs() <= 1e-6 * (1.0 + b.abs())
    };
    a.shape() == b.shape() && a.cells().iter().zip(b.cells()).all(near)
}

fn value(text: &str) -> PixelValue {
    let program = Program::compile(&format!("expected = {text}")).unwrap_or_else(|e| panic!("{e}"));
    let mut values = program.eval_pixel(&inputs(), &RunOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    values.pop().unwrap().1
}

#[test]
fn programs_give_what_their_comments_say() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs");
    let mut checked = 0;
    let mut failures = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "pse") {
            continue;
        }
        let name = path.file_name().unwrap().to_string_lossy().to_string();
        let text = std::fs::read_to_string(&path).unwrap();
        let compiler = Compiler::new().host(&Disk::default()).compile(&path.to_string_lossy(), &text);
        let program = compiler.unwrap_or_else(|e| panic!("{name}\n{e}"));
        let values =
            program.eval_pixel(&inputs(), &RunOptions::default()).unwrap_or_else(|e| panic!("{name}\n{e}"));
        for (number, line) in text.lines().enumerate() {
            let Some((code, expected)) = line.split_once("#=") else { continue };
            let variable = code.trim().split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap();
            let expected = value(expected);
            match values.iter().find(|(n, _)| n == variable) {
                Some((_, found)) if close(found, &expected) => {}
                Some((_, found)) => {
                    failures.push(format!("{name}:{}: {variable} is {found}, not {expected}", number + 1));
                }
                None => failures.push(format!("{name}:{}: {variable} has no value", number + 1)),
            }
            checked += 1;
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(checked > 50, "only {checked} values were checked");
}
