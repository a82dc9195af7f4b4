//! Programs and files that nobody would write: each ends soon, as a result or as an error.
//!
//! `PSE_HOSTILE_SECONDS` says how long to try (4 if it is not set), `PSE_HOSTILE_SEED` where to begin. A failure tells
//! the seed of its input. `cargo test --release --test cli hostile -- --nocapture` tells how many were tried.

use crate::formats;
use pse::Memory;
use pse::image::{ImageError, Input};
use pse::internal::diagnostic::SourceId;
use pse::internal::syntax;
use pse::{Compiler, Image, Limits, RunOptions, scene};
use std::collections::HashMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// No input takes longer: they are small, and so are the limits.
const LONGEST: Duration = Duration::from_secs(20);

/// A generator of numbers, always the same ones from a seed.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ x >> 31) % n.max(1) as u64) as usize
    }

    fn pick<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }
}

fn setting(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().map_or(otherwise, |text| text.parse().expect(name))
}

/// Gives one seed after another to `attempt` until the time is over, and tells of the one that fails.
///
/// `known` are seeds at which something was found once.
fn until_the_time_is_over(what: &str, known: &[u64], mut attempt: impl FnMut(u64) -> String) {
    let begun = Instant::now();
    let time = Duration::from_secs(setting("PSE_HOSTILE_SECONDS", 4));
    let first = setting("PSE_HOSTILE_SEED", 1);
    let mut kinds: HashMap<String, usize> = HashMap::new();
    for (count, seed) in known.iter().copied().chain(first..).enumerate() {
        let start = Instant::now();
        let kind = catch_unwind(AssertUnwindSafe(|| attempt(seed)));
        let kind = kind.unwrap_or_else(|_| panic!("{what}: PSE_HOSTILE_SEED={seed} goes wrong"));
        assert!(start.elapsed() < LONGEST, "{what}: PSE_HOSTILE_SEED={seed} takes {:?}", start.elapsed());
        *kinds.entry(kind).or_default() += 1;
        if begun.elapsed() > time {
            println!("{what}: {} inputs in {:?}: {kinds:?}", count + 1, begun.elapsed());
            break;
        }
    }
}

/// All programs of the package.
fn programs() -> Vec<(String, String)> {
    let mut list = Vec::new();
    for folder in ["examples", "tests/paper", "tests/programs", "benches/workloads", "src/library"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let mut files: Vec<_> = fs::read_dir(path).expect(folder).map(|e| e.expect(folder).path()).collect();
        files.retain(|file| file.extension().is_some_and(|e| e == "pse"));
        files.sort();
        for file in files {
            let name = file.file_name().expect("a name").to_string_lossy().into_owned();
            list.push((name, fs::read_to_string(&file).expect("a program")));
        }
    }
    assert!(list.len() > 30);
    list
}

const PIECES: &[&str] = &[
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    "\"",
    "\n",
    "\r\n",
    "\r",
    " ",
    "    ",
    "\t",
    "#",
    ".",
    ",",
    ";",
    ":",
    "=",
    "==",
    "!=",
    "+=",
    "^=",
    "&&=",
    "<",
    "<=",
    "+",
    "-",
    "*",
    "/",
    "%",
    "^",
    "&&",
    "||",
    "!",
    "? ",
    "..",
    " .. ",
    "if ",
    "else\n",
    "else if ",
    "while 1\n    ",
    "for i in [1 .. 9]\n    ",
    "break\n",
    "continue\n",
    "function f(a, b = 2)\n    ",
    "return ",
    "f(1)",
    "param p = 1 in [0 2]\n",
    "import \"stone.pse\"\n",
    "Noise(",
    "kind = \"gabor\"",
    "texture(\"a.exr\", ",
    "point",
    "normal",
    "surface",
    "color = ",
    "v[3] = ",
    "v.x",
    ".yz",
    "1e",
    "1e38",
    "0x1f",
    "3.4e39",
    ".5",
    "1.",
    "00",
    "infinity",
    "0/0",
    "begin_frame",
    "print(",
    "Du(",
    "random(",
    "size(",
    "[1 .. 1e9]",
    "[1 .. 70000]",
    "while 1\n    x = 1\n",
    "if begin_frame\n    ",
    "ö",
    "\u{1f600}",
    "\u{feff}",
    "\u{0}",
    "\u{202e}",
    "\u{2028}",
    "and ",
    "not ",
    "**",
    "elif ",
    "lambda x: ",
    "/*",
    "//",
    "'",
    "`",
    "\\",
    "transform(\"camera\", ",
    "bg.color",
    "-2^-2",
    "a ? b : c",
    "x = y = z",
    "  # c\n",
    "[[1 2][3]]",
    "1 -1",
];

/// A text from a seed: a soup of pieces, or a program with faults.
fn text(random: &mut Random, programs: &[(String, String)]) -> String {
    if random.below(5) == 0 {
        return (0..random.below(60)).map(|_| *random.pick(PIECES)).collect();
    }
    let mut chars: Vec<char> = random.pick(programs).1.chars().collect();
    for _ in 0..1 + random.below(2) * random.below(6) {
        let at = random.below(chars.len() + 1);
        match random.below(7) {
            0 => drop(chars.drain(at..(at + random.below(30)).min(chars.len()))),
            1 | 2 => drop(chars.splice(at..at, random.pick(PIECES).chars())),
            3 => {
                // A piece of another program.
                let other: Vec<char> = random.pick(programs).1.chars().collect();
                let from = random.below(other.len());
                let end = (from + random.below(120)).min(other.len());
                chars.splice(at..at, other[from..end].iter().copied());
            }
            4 => {
                // The same again, and again.
                let end = (at + random.below(12)).min(chars.len());
                let piece: Vec<char> =
                    chars[at..end].iter().copied().cycle().take((end - at) * random.below(60)).collect();
                chars.splice(at..at, piece);
            }
            5 => {
                // Another number.
                let number = *random.pick(&["0", "-1", "1e9", "3e38", "0.5", "2", "65536", "1e-40"]);
                if let Some(digit) = (at..chars.len()).find(|&i| chars[i].is_ascii_digit()) {
                    chars.splice(digit..=digit, number.chars());
                }
            }
            _ => {
                if let Some(one) = chars.get_mut(at) {
                    *one = char::from_u32(random.below(0x3000) as u32).unwrap_or('?');
                }
            }
        }
    }
    chars.into_iter().collect()
}

/// Reads, formats and runs a text.
fn all_the_way(text: &str, host: &Memory, image: &Image<'_>, random: &mut Random) -> &'static str {
    let source = SourceId::default();
    assert!(syntax::lex(text).iter().all(|l| l.start <= l.end && text.get(l.start..l.end).is_some()));
    syntax::is_incomplete(text);
    let parsed = syntax::parse(source, text);
    if let Ok(formatted) = syntax::format(text) {
        let again = syntax::parse(source, &formatted);
        assert!(again.errors.is_empty(), "formatted it is no program:\n{text}\n----\n{formatted}");
        assert!(
            syntax::tree(&parsed.module) == syntax::tree(&again.module),
            "formatted it means something else:\n{text}\n----\n{formatted}"
        );
        assert!(syntax::format(&formatted).as_ref() == Ok(&formatted), "twice:\n{text}\n----\n{formatted}");
    } else {
        assert!(!parsed.errors.is_empty(), "not formatted, and without an error:\n{text}");
    }
    let program = match Compiler::new().host(host).compile("hostile.pse", text) {
        Ok(program) => program,
        Err(error) => {
            let said = error.render(pse::Style::PLAIN);
            assert!(!said.trim().is_empty() && !said.contains("internal error"), "{text}\n{said}");
            return "refused";
        }
    };
    let limits = Limits { steps: 3000, depth: 40, cells: 2000, memory: 16 << 20 };
    let run = |batch, no_optimize| {
        let options =
            RunOptions { limits, batch: Some(batch), no_optimize, prints: 3, ..RunOptions::default() };
        program.run(image, &options).map(|report| {
            let bits = |v: &pse::Variable<'_>| -> Vec<Vec<u32>> {
                v.planes.iter().map(|p| p.iter().map(|x| x.to_bits()).collect()).collect()
            };
            report.image.variables.iter().map(|v| (v.name.clone(), bits(v))).collect::<Vec<_>>()
        })
    };
    let first = run(2048, false);
    if random.below(4) == 0 {
        // The same one pixel at a time, without plans.
        let alone = run(1, true);
        match (&first, &alone) {
            (Ok(a), Ok(b)) => assert!(a == b, "batches differ from pixels:\n{text}"),
            (Err(a), Err(b)) => {
                let (a, b) = (a.render(pse::Style::PLAIN), b.render(pse::Style::PLAIN));
                assert!(a == b || a.contains("memory"), "{text}\n{a}\n----\n{b}");
            }
            (a, b) => panic!("{} and {}:\n{text}", a.is_ok(), b.is_ok()),
        }
    }
    if first.is_ok() { "ran" } else { "stopped" }
}

#[test]
fn texts() {
    let programs = programs();
    let host = Memory(programs.iter().cloned().collect());
    let options = scene::Options { width: 13, height: 7, ..scene::Options::default() };
    let image = scene::render("donut", &options).expect("a scene");
    until_the_time_is_over("texts", &[], |seed| {
        let mut random = Random(seed);
        let text = text(&mut random, &programs);
        all_the_way(&text, &host, &image, &mut random).to_string()
    });
}

#[test]
fn files() {
    let mut list = formats::samples();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gbuffers");
    let mut real: Vec<_> =
        fs::read_dir(folder).expect("a folder").map(|e| e.expect("a file").path()).collect();
    real.retain(|path| path.extension().is_some_and(|e| e == "exr"));
    real.sort();
    let kinds = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/kinds");
    let mut kinds: Vec<_> =
        fs::read_dir(kinds).expect("a folder").map(|e| e.expect("a file").path()).collect();
    kinds.retain(|path| !path.extension().is_some_and(|e| e == "txt" || e == "py"));
    kinds.sort();
    for path in real.into_iter().chain(kinds) {
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        list.push((name, fs::read(&path).expect("an image")));
    }
    until_the_time_is_over("files", &[2626, 119_718], |seed| {
        let mut random = Random(seed);
        let (name, bytes) = random.pick(&list);
        let mut bytes = bytes.clone();
        for _ in 0..1 + random.below(6) {
            // More often near the beginning, where the sizes are.
            let length = bytes.len().min(*random.pick(&[60, 400, 2000, usize::MAX]));
            let at = random.below(length);
            let end = (at + random.below(40)).min(bytes.len());
            match random.below(6) {
                0 | 1 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
                2 if at < bytes.len() => bytes[at] = *random.pick(&[0, 1, 0x7f, 0x80, 0xff]),
                3 => drop(bytes.drain(at..end)),
                4 => drop(
                    bytes.splice(at..at, (0..random.below(16)).map(|i| i as u8 * 17).collect::<Vec<_>>()),
                ),
                5 => bytes.truncate(random.below(bytes.len() + 1)),
                _ => {}
            }
        }
        match formats::read_all(name, &bytes) {
            Ok(()) => "read".into(),
            Err(ImageError { kind, .. }) => format!("{kind:?}"),
        }
    });
    assert!(pse::image::read(Input::from_bytes("none", *b""), &Default::default()).is_err());
}

/// Runs a program as a command, in bounded memory, and gives its message.
fn refused(name: &str, program: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.pse");
    fs::write(&path, program).expect("a program");
    let begun = Instant::now();
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -v 4000000; exec \"$PSE\" run -q p.pse --size 8x8 -o o.exr"]);
    let output =
        command.current_dir(folder.path()).env("PSE", env!("CARGO_BIN_EXE_pse")).output().expect("a shell");
    let err = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{name}\n{err}");
    assert!(!err.contains("panicked") && err.len() < 20_000, "{name}: {} bytes\n{:.2000}", err.len(), err);
    assert!(begun.elapsed() < LONGEST, "{name} takes {:?}", begun.elapsed());
    assert!(!folder.path().join("o.exr").exists(), "{name}");
    err
}

#[cfg(unix)]
#[test]
fn giants() {
    let many = 100_000;
    let nested = |open: &str, close: &str| format!("color = {}1{}\n", open.repeat(many), close.repeat(many));
    let ifs = |deep: usize| {
        let lines = (0..deep).map(|depth| " ".repeat(depth) + "if 1\n");
        lines.collect::<String>() + &" ".repeat(deep) + "color = 1\n"
    };
    let calls: String = (0..3000).map(|i| format!("function f{i}(x)\n    return f{}(x)\n", i + 1)).collect();
    for (name, program, words) in [
        ("brackets", nested("(", ")"), "brackets"),
        ("vectors", nested("[", "]"), "brackets"),
        ("open brackets", "(".repeat(many), "brackets"),
        ("closed brackets", ")".repeat(many), ""),
        ("calls in calls", nested("sin(", ")"), "brackets"),
        ("indices", format!("v = [1]\ncolor = v{}\n", "[1]".repeat(many)), ""),
        ("signs", format!("color = {}1\n", "-".repeat(many)), ""),
        ("nots", format!("color = {}1\n", "!".repeat(many)), ""),
        ("powers", format!("color = 2{}\n", "^2".repeat(many)), ""),
        ("choices", format!("color = {}1\n", "1 ? 2 : ".repeat(many)), ""),
        ("ifs", ifs(3000), "blocks"),
        ("ifs beyond any length", ifs(10_000), "longer than 16 MiB"),
        ("a long line", format!("color = {}\n", "1 + ".repeat(1 << 20)), ""),
        ("a long name", format!("color = {}\n", "a".repeat(4 << 20)), ""),
        ("a long number", format!("color = {}\n", "1".repeat(4 << 20)), ""),
        ("a long string", format!("color = texture(\"{}\", 0, 0)\n", "a".repeat(4 << 20)), ""),
        ("an open string", format!("color = \"{}\n", "a".repeat(4 << 20)), ""),
        ("many errors", "color = = 1\n".repeat(200_000), ""),
        ("unknown names", (0..many).map(|i| format!("color = u{i}\n")).collect(), ""),
        ("unknown functions", (0..many).map(|i| format!("color = u{i}(1)\n")).collect(), ""),
        ("no end of file", "\0".repeat(1 << 20), ""),
        ("recursion", "function f(x)\n    return 1 + f(x)\ncolor = white * f(1)\n".into(), "256"),
        ("long recursion", calls + "function f3000(x)\n    return x\ncolor = white * f0(1)\n", "256"),
        ("an endless loop", "while 1\n    x = 1\ncolor = white * x\n".into(), "100000"),
        ("a giant range", "color = white * size([1 .. 1e9])\n".into(), "65536"),
        ("a growing vector", "v = [1]\nwhile 1\n    v = [v v]\ncolor = white\n".into(), "65536"),
        ("growing one by one", "i = 0\nwhile 1\n    i += 1\n    v[i] = 1\ncolor = white\n".into(), ""),
        ("once a frame", "if begin_frame\n    while 1\n        x = 1\ncolor = white\n".into(), "100000"),
        (
            "import of itself",
            "import \"p.pse\"\nimport \"./p.pse\"\nimport \"none.pse\"\ncolor = white\n".into(),
            "none.pse",
        ),
    ] {
        let said = refused(name, &program);
        assert!(said.contains(words), "{name}: no `{words}` in\n{:.3000}", said);
    }
}
