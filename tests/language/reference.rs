//! The reference of functions: every example in it is run, and `docs/builtins.md` is up to date.
//!
//! After a change of a function's documentation, rewrite the file with `UPDATE=1 cargo test --test language reference`.

use pse::Disk;
use pse::internal::builtin::reference::Entry;
use pse::internal::lanes::Isa;
use pse::{Compiler, Error, Image, PixelValue, Program, RunOptions, Shape, Variable};

/// Compiles an example; its images are those of `examples/`.
fn compile(text: &str) -> Result<Program, Error> {
    let host = Disk { path: vec![concat!(env!("CARGO_MANIFEST_DIR"), "/examples").into()] };
    Compiler::new().host(&host).compile("example", text)
}

fn alike(a: &PixelValue, b: &PixelValue) -> bool {
    let near = |(a, b): (&f32, &f32)| {
        a == b || (a.is_nan() && b.is_nan()) || (a - b).abs() <= 1e-5 * a.abs().max(b.abs()).max(1.0)
    };
    a.shape() == b.shape() && a.cells().iter().zip(b.cells()).all(near)
}

#[test]
fn every_example_is_right() {
    let mut wrong = Vec::new();
    for entry in pse::internal::reference::entries() {
        assert!(!entry.examples.is_empty(), "{} has no example", entry.name);
        for (code, gives) in &entry.examples {
            let text = format!("found = {code}\nwanted = {gives}\n");
            let program = compile(&text).unwrap_or_else(|e| panic!("{}\n{e}", entry.name));
            let values = program.eval_pixel(&[], &RunOptions::default());
            let values = values.unwrap_or_else(|e| panic!("{}\n{e}", entry.name));
            let [(_, found), (_, wanted)] = &values[..] else { panic!("{code}: {values:?}") };
            if !alike(found, wanted) {
                wrong.push(format!("{code} gives {found}, not {wanted}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// An expression with variables `k0`, `k1`, … for the numbers in it, and those numbers.
fn numbers_as_variables(code: &str) -> (String, Vec<f32>) {
    let mut text = String::new();
    let mut numbers = Vec::new();
    let bytes = code.as_bytes();
    let digit = |i: usize| bytes.get(i).is_some_and(u8::is_ascii_digit);
    let (mut i, mut in_string, mut in_name) = (0, false, false);
    while i < bytes.len() {
        let starts = digit(i) || (bytes[i] == b'.' && digit(i + 1));
        if starts && !in_string && !in_name {
            let start = i;
            while digit(i) || (bytes[i..].starts_with(b".") && digit(i + 1)) {
                i += 1;
                if i == bytes.len() {
                    break;
                }
            }
            text.push_str(&format!("k{}", numbers.len()));
            numbers.push(code[start..i].parse().expect("a number"));
            continue;
        }
        in_string ^= bytes[i] == b'"';
        in_name = bytes[i].is_ascii_alphanumeric() || bytes[i] == b'_';
        text.push(bytes[i] as char);
        i += 1;
    }
    (text, numbers)
}

const LANES: usize = 257;

/// The bits of the value at every pixel, or the error.
fn outcome(
    program: &Program,
    image: &Image<'_>,
    set: &[(String, PixelValue)],
    batch: usize,
    isa: Isa,
) -> Result<Vec<Vec<u32>>, String> {
    let outputs = Some(vec!["value".to_string()]);
    let options = RunOptions {
        set: set.to_vec(),
        outputs,
        threads: Some(1),
        batch: Some(batch),
        isa: Some(isa),
        ..RunOptions::default()
    };
    let report = program.run(image, &options).map_err(|e| e.to_string())?;
    let bits = |x: &f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
    Ok(report.image.variables[0].planes.iter().map(|p| p.iter().map(bits).collect()).collect())
}

/// Every example runs with its numbers varied from pixel to pixel, in batches and each pixel alone: the bits must
/// agree, whatever the instruction set, and whichever of the numbers are the same at all pixels.
#[test]
fn a_pixel_does_not_depend_on_its_batch() {
    let mut never = Vec::new();
    for Entry { name, examples, .. } in pse::internal::reference::entries() {
        let mut ran = false;
        for (code, _) in &examples {
            let (text, numbers) = numbers_as_variables(code);
            let program = compile(&format!("value = {text}")).unwrap_or_else(|e| panic!("{e}"));
            for uniform in [0usize, 0x5555, 0xaaaa, 0xfffe, 1] {
                let vary = |x: f32, lane: usize| x + x * 1e-4 * lane as f32;
                let mut set = Vec::new();
                let mut variables = Vec::new();
                for (k, &x) in numbers.iter().enumerate() {
                    if !program.inputs().any(|name| name == format!("k{k}")) {
                        continue;
                    }
                    if uniform >> (k % 16) & 1 == 1 {
                        set.push((format!("k{k}"), vary(x, 3).into()));
                    } else {
                        let plane: Vec<f32> = (0..LANES).map(|lane| vary(x, lane)).collect();
                        variables.push(Variable::new(&format!("k{k}"), Shape::Scalar, [plane]).unwrap());
                    }
                }
                let image = Image { width: LANES, height: 1, variables, ..Image::default() };
                let alone = outcome(&program, &image, &set, 1, Isa::baseline());
                ran |= alone.is_ok();
                for (batch, isa) in [(LANES, Isa::detect()), (LANES, Isa::baseline()), (7, Isa::detect())] {
                    let together = outcome(&program, &image, &set, batch, isa);
                    assert!(together == alone, "{code} in batches of {batch}, uniform {uniform:x}");
                }
            }
        }
        if !ran {
            never.push(name);
        }
    }
    assert!(never.is_empty(), "never compared: {never:?}");
}

#[test]
fn the_documentation_is_up_to_date() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/builtins.md");
    let output = assert_cmd::Command::cargo_bin("pse").unwrap().args(["doc", "--markdown"]).output().unwrap();
    let expected = String::from_utf8(output.stdout).unwrap();
    if std::env::var_os("UPDATE").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, &expected).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == expected,
        "docs/builtins.md is stale: UPDATE=1 cargo test --test language reference rewrites it"
    );
}
