//! Runs the programs of the documentation: every block marked `pse` in README.md, docs/*.md and editors/README.md.
//!
//! - A block runs at every pixel of a small donut, which also has `color`, `alpha`, `flame` and an image called `bg`.
//! - A comment `#= value` behind an assignment says what its variable holds in the end, at a pixel of the donut.
//! - A block marked `pse error` must be refused, or fail at some pixel.
//! - A block whose first line is `# name.pse` can be imported by the others of its file.
//! - A block marked `rust` in docs/tutorial.md is a part of examples/embed.rs, line for line.
//!
//! What a user reads (documents, help pages, messages) also does without the phrases in [`AVOIDED`].

use pse::Origin;
use pse::internal::host::{Disk, Memory};
use pse::{Compiler, Error, Host, Image, PixelValue, Program, RunOptions, Shape, Variable, scene};
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A block of code between fences.
struct Block {
    /// For messages: `docs/language.md:12`.
    place: String,
    /// What follows the opening fence.
    mark: String,
    text: String,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The documents that there are.
fn documents() -> Vec<PathBuf> {
    let mut list = vec![root().join("README.md"), root().join("editors/README.md")];
    for entry in fs::read_dir(root().join("docs")).unwrap() {
        list.push(entry.unwrap().path());
    }
    list.retain(|path| path.is_file() && path.extension().is_some_and(|e| e == "md"));
    list.sort();
    list
}

fn blocks(path: &Path) -> Vec<Block> {
    let text = fs::read_to_string(path).unwrap();
    let shown = path.strip_prefix(root()).unwrap().display().to_string();
    let mut list: Vec<Block> = Vec::new();
    let mut open = false;
    for (number, line) in text.lines().enumerate() {
        match line.strip_prefix("```") {
            Some(_) if open => open = false,
            Some(mark) => {
                let place = format!("{shown}:{}", number + 1);
                list.push(Block { place, mark: mark.trim().to_string(), text: String::new() });
                open = true;
            }
            None if open => {
                let block = list.last_mut().unwrap();
                block.text.push_str(line);
                block.text.push('\n');
            }
            None => {}
        }
    }
    assert!(!open, "{shown}: the last block is not closed");
    list
}

/// The name under which a block can be imported.
fn file_name(block: &Block) -> Option<&str> {
    let name = block.text.lines().next()?.strip_prefix("# ")?;
    (name.ends_with(".pse") && !name.contains(' ')).then_some(name)
}

/// A donut with a picture of its own and another image beside it.
fn image() -> Image<'static> {
    let options = scene::Options { width: 32, height: 24, ..scene::Options::default() };
    let mut image = scene::render("donut", &options).unwrap();
    let surface = image.variable("surface").unwrap().planes[0].to_vec();
    let grey: Vec<f32> = surface.iter().map(|s| 0.5 * s).collect();
    let ramp: Vec<f32> = (0..surface.len()).map(|i| i as f32 / surface.len() as f32).collect();
    let mut add = |name: &str, planes: Vec<Vec<f32>>| {
        let shape = if planes.len() == 1 { Shape::Scalar } else { Shape::Vector(planes.len() as u32) };
        image.variables.push(Variable::new(name, shape, planes).unwrap());
    };
    add("color", vec![grey.clone(), grey.clone(), grey]);
    add("alpha", vec![surface]);
    add("bg.color", vec![ramp.clone(), ramp.clone(), ramp.clone()]);
    add("flame", vec![ramp]);
    image
}

/// The middle of the donut's front.
fn column_and_row(image: &Image<'_>) -> (usize, usize) {
    let surface = &image.variable("surface").unwrap().planes[0];
    let column = image.width / 2;
    let row = (0..image.height).rev().find(|row| surface[row * image.width + column] == 1.0).unwrap();
    (column, row - 1)
}

/// The files of a document, and the images of `examples/`.
struct Files(Memory);

impl Files {
    fn images() -> Disk {
        Disk { path: vec![root().join("examples")] }
    }
}

impl Host for Files {
    fn import(&self, importing: &str, path: &str) -> Result<(String, String), pse::HostError> {
        self.0.import(importing, path)
    }

    fn image(&self, program: &str, name: &str) -> Result<Origin, pse::HostError> {
        Files::images().image(program, name)
    }
}

fn compile(block: &Block, files: &Files) -> Result<Program, Error> {
    Compiler::new().host(files).compile(&block.place, &block.text)
}

/// Compares what a block's comments say with what it gives.
fn check_values(block: &Block, program: &Program, image: &Image<'_>) -> Vec<String> {
    let (column, row) = column_and_row(image);
    let values = match program.eval_pixel_of(image, column, row, &RunOptions::default()) {
        Ok(values) => values,
        Err(error) => return vec![format!("{}\n{error}", block.place)],
    };
    let mut failures = Vec::new();
    for line in block.text.lines() {
        let Some((code, expected)) = line.split_once("#=") else { continue };
        let name: String = code.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let expected = value(expected.trim());
        match values.iter().find(|(n, _)| *n == name) {
            Some((_, found)) if close(found, &expected) => {}
            Some((_, found)) => {
                failures.push(format!("{}: {name} is {found}, not {expected}", block.place));
            }
            None => failures.push(format!("{}: {name} has no value", block.place)),
        }
    }
    failures
}

fn value(text: &str) -> PixelValue {
    let program = Program::compile(&format!("expected = {text}")).unwrap_or_else(|e| panic!("{e}"));
    let values = program.eval_pixel(&[], &RunOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    values.into_iter().next().unwrap().1
}

fn close(a: &PixelValue, b: &PixelValue) -> bool {
    let near = |(a, b): (&f32, &f32)| {
        a == b || (a.is_nan() && b.is_nan()) || (a - b).abs() <= 1e-6 * (1.0 + b.abs())
    };
    a.shape() == b.shape() && a.cells().iter().zip(b.cells()).all(near)
}

#[test]
fn programs_in_the_documentation_do_what_it_says() {
    let image = image();
    let mut failures = Vec::new();
    let (mut ran, mut refused, mut compared) = (0, 0, 0);
    for path in documents() {
        let blocks = blocks(&path);
        let named = blocks.iter().filter_map(|b| Some((file_name(b)?.to_string(), b.text.clone())));
        let files = Files(Memory(named.collect::<HashMap<_, _>>()));
        for block in &blocks {
            match block.mark.as_str() {
                "pse" => {
                    let program = match compile(block, &files) {
                        Ok(program) => program,
                        Err(error) => {
                            failures.push(format!("{}\n{error}", block.place));
                            continue;
                        }
                    };
                    ran += 1;
                    // A file of functions has no picture.
                    if program.assigned().next().is_some()
                        && let Err(error) = program.run(&image, &RunOptions::default())
                    {
                        failures.push(format!("{}\n{error}", block.place));
                        continue;
                    }
                    if block.text.contains("#=") {
                        compared += block.text.matches("#=").count();
                        failures.extend(check_values(block, &program, &image));
                    }
                }
                "pse error" => {
                    refused += 1;
                    let run = compile(block, &files).and_then(|p| p.run(&image, &RunOptions::default()));
                    if run.is_ok() {
                        failures.push(format!("{}: this should be an error\n{}", block.place, block.text));
                    }
                }
                mark if mark.starts_with("pse") => {
                    failures.push(format!("{}: what is a `{mark}`?", block.place));
                }
                _ => {}
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(ran > 45 && refused > 12 && compared > 50, "{ran} ran, {refused} refused, {compared} compared");
}

#[test]
fn rust_in_the_tutorial_is_quoted_from_the_example() {
    let lines = |text: &str| text.lines().map(str::trim).collect::<Vec<_>>().join("\n");
    let example = lines(&fs::read_to_string(root().join("examples/embed.rs")).unwrap());
    let blocks = blocks(&root().join("docs/tutorial.md"));
    let quotes: Vec<&Block> = blocks.iter().filter(|b| b.mark == "rust").collect();
    assert!(!quotes.is_empty());
    for block in quotes {
        assert!(example.contains(lines(&block.text).trim()), "{} is not in examples/embed.rs", block.place);
    }
}

#[test]
fn links_in_the_documentation_lead_somewhere() {
    for path in documents() {
        let text = fs::read_to_string(&path).unwrap();
        let shown = path.display();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link) {
            if link.contains("://") || link.starts_with('#') || link.contains(char::is_whitespace) {
                continue;
            }
            let file = link.split('#').next().unwrap_or(link);
            assert!(path.parent().unwrap().join(file).exists(), "{shown}: there is no {link}");
        }
    }
}

/// Words and phrases of this project's older texts that say less than a plain verb: "tells of" for "describes", "so many"
/// for a number, "the like" for a list. The command, its messages and the documents do without them.
const AVOIDED: [&str; 10] =
    ["told", "tells", "so many", "the like", "nobody", "wanted", "is asked", "goes on", "left out", "anew"];

/// Where an avoided phrase stands in a text, as whole words, whatever the case and the line breaks between its words.
fn avoided(text: &str) -> impl Iterator<Item = &'static str> {
    let word = |c: char| c.is_alphanumeric() || "_`{}".contains(c);
    let words: Vec<String> = text.split_whitespace().map(str::to_lowercase).collect();
    let text = format!(" {} ", words.join(" "));
    AVOIDED.into_iter().filter(move |phrase| {
        text.match_indices(phrase)
            .any(|(at, _)| !text[..at].ends_with(word) && !text[at + phrase.len()..].starts_with(word))
    })
}

/// A document without its code.
fn prose(text: &str) -> String {
    let fences = text.split("```").step_by(2).flat_map(|part| part.split('`').step_by(2));
    fences.collect::<Vec<_>>().join(" ")
}

/// The help of the command and of its subcommands, each with its name.
fn help_pages() -> Vec<(String, String)> {
    let help = |words: &[&str]| {
        let run = std::process::Command::new(env!("CARGO_BIN_EXE_pse")).args(words).arg("--help").output();
        String::from_utf8(run.expect("the command runs").stdout).expect("text")
    };
    let main = help(&[]);
    let commands =
        main.split("Commands:").nth(1).and_then(|rest| rest.split("Options:").next()).expect("commands");
    // A name is indented by two; what goes on below a description is indented by more.
    let names = commands.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names: Vec<&str> = names.filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.contains(&"run") && names.contains(&"man"), "{names:?}");
    let pages = names
        .iter()
        .filter(|name| **name != "help")
        .map(|name| (format!("pse {name} --help"), help(&[name])));
    pages.chain([("pse --help".to_string(), main.clone())]).collect()
}

/// The files below a folder with that extension.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut list = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            list.extend(files(&path, extension));
        } else if path.extension().is_some_and(|e| e == extension) {
            list.push(path);
        }
    }
    list.sort();
    list
}

/// The string literals of a Rust source with more than one word, up to its tests: messages, help and documentation.
fn sentences(source: &str) -> Vec<String> {
    let source = source.split("#[cfg(test)]\nmod ").next().unwrap_or(source);
    let mut list = Vec::new();
    let mut rest = source;
    while let Some(at) = rest.find(['"', '/', '\'']) {
        let (before, here) = rest.split_at(at);
        let end = |text: &str, mark: &str| text.find(mark).map_or(text.len(), |end| end + mark.len());
        let length = if here.starts_with("//") {
            end(here, "\n")
        } else if here.starts_with("/*") {
            end(here, "*/")
        } else if here.starts_with("'\"'") || here.starts_with("'\\") {
            1 + end(&here[2..], "'") + 1
        } else if let Some(inside) = here.strip_prefix('"') {
            let hashes = before.len() - before.trim_end_matches('#').len();
            let raw = before.trim_end_matches('#').ends_with('r');
            let close = match raw {
                true => inside.find(&format!("\"{}", "#".repeat(hashes))).expect("a closed literal"),
                false => {
                    let mut escaped = false;
                    let ends = |&(_, c): &(usize, char)| {
                        let ends = c == '"' && !escaped;
                        escaped = c == '\\' && !escaped;
                        ends
                    };
                    inside.char_indices().find(ends).expect("a closed literal").0
                }
            };
            let text = inside[..close].replace("\\\n", "").replace("\\n", " ");
            if text.contains(' ') {
                list.push(text);
            }
            close + 2
        } else {
            1
        };
        rest = &here[length..];
    }
    list
}

#[test]
fn what_a_user_reads_is_plain_english() {
    let root = root();
    let mut texts = help_pages();
    let mut named = |path: &Path, text: String| {
        texts.push((path.strip_prefix(root).unwrap_or(path).display().to_string(), text));
    };
    let written = [root.join("CONTRIBUTING.md"), root.join("CHANGELOG.md")];
    for path in documents().iter().chain(&written) {
        named(path, prose(&fs::read_to_string(path).unwrap()));
    }
    for path in files(&root.join("tests/errors"), "snap") {
        named(&path, fs::read_to_string(&path).unwrap());
    }
    // The folder of the checkout may have any name.
    let is_test =
        |path: &Path| path.strip_prefix(root).is_ok_and(|own| own.to_string_lossy().contains("tests"));
    for path in files(&root.join("src"), "rs").iter().filter(|path| !is_test(path)) {
        let source = fs::read_to_string(path).unwrap();
        sentences(&source).into_iter().for_each(|text| named(path, text));
    }
    for path in files(&root.join("src/library"), "pse").iter().chain(&files(&root.join("examples"), "pse")) {
        let text = fs::read_to_string(path).unwrap();
        let comments = text.lines().filter_map(|line| line.split_once('#')).map(|(_, comment)| comment);
        named(path, comments.collect::<Vec<_>>().join(" "));
    }
    assert!(texts.len() > 2000, "only {} texts were found", texts.len());
    let found: Vec<String> = texts
        .iter()
        .flat_map(|(name, text)| {
            avoided(text).map(move |phrase| format!("{name}: \"{phrase}\" in {text:.300}"))
        })
        .collect();
    assert!(found.is_empty(), "write it more plainly:\n{}", found.join("\n"));
}

#[test]
fn avoided_phrases_are_found_as_whole_words() {
    let found = |text: &str| avoided(text).collect::<Vec<_>>();
    assert_eq!(found("The rest is\ntold in so  Many words."), ["told", "so many"]);
    assert_eq!(found("`{wanted}` is unwanted, retold_by `told`"), [] as [&str; 0]);
    assert_eq!(
        sentences("let a = ('\"', \"one // two\"); // \"no \\n comment\"\nr#\"a \"b\"\"#;"),
        ["one // two", "a \"b\""]
    );
    assert_eq!(prose("a `told` b\n```pse\n# told\n```\nc"), "a   b\n \nc");
}
