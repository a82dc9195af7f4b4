//! `print`: what it tells in a run, in which order, and that it changes nothing else.

use super::{compile, examples, render};
use pse::{Image, RunOptions, Sampling};

/// The lines that a run prints, and how many there were.
fn printed(text: &str, image: &Image<'_>, options: RunOptions<'_>) -> (Vec<String>, u64) {
    let report = compile(text).run(image, &options).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let line = |l: &pse::Printed| match l.pixel {
        Some([x, y]) => format!("{x},{y} {l}"),
        None => format!("frame {l}"),
    };
    let mut lines: Vec<String> = report.frame_prints.lines.iter().map(line).collect();
    lines.extend(report.prints.lines.iter().map(line));
    (lines, report.frame_prints.count + report.prints.count)
}

fn lines(n: usize) -> RunOptions<'static> {
    RunOptions { prints: n, ..RunOptions::default() }
}

#[test]
fn the_first_pixels_print_whatever_the_batches_and_threads() {
    // Branches, loops that end sooner or later, calls, and work that is worth gathering lanes for.
    let text = "function heavy(x)\n    for i in [1 .. 20]\n        x = sin(x) + fBm([x x x])\n    print(\"h\", x)\n    return x\n\
                c = pixel.x - 0.5\nif mod(c, 3) == 1\n    print(\"c\", c, [c 1])\n    d = heavy(c)\n    e = d + heavy(c + 1)\n\
                i = 0\nwhile i < mod(c, 4)\n    i += 1\n    if i == 2\n        continue\n    print(i)\ncolor = white\n";
    let image = Image::new(97, 61, []).unwrap();
    let whole = printed(text, &image, lines(500));
    assert_eq!(whole.0.len(), 500);
    assert_eq!(whole.0[0], "1,0 c 1 [1 1]");
    assert!(whole.0[1].starts_with("1,0 h ") && whole.0[2].starts_with("1,0 h "));
    assert_eq!(whole.0[3..6], ["1,0 1", "2,0 1", "3,0 1"]);
    assert_eq!(whole.0[6], "3,0 3");
    for (batch, threads) in [(1, 1), (7, 2), (300, 3), (2048, 2), (6000, 1)] {
        for no_optimize in [false, true] {
            let options =
                RunOptions { batch: Some(batch), threads: Some(threads), no_optimize, ..lines(500) };
            assert_eq!(printed(text, &image, options), whole, "{batch} {threads} {no_optimize}");
        }
    }
    // Fewer are the first of more.
    let few = printed(text, &image, lines(4));
    assert_eq!((&few.0[..], few.1), (&whole.0[..4], whole.1));
    assert_eq!(printed(text, &image, lines(0)), (Vec::new(), 0));
}

#[test]
fn each_pixel_prints_once_for_each_time() {
    let image = Image::new(3, 1, []).unwrap();
    let print = |text: &str| printed(text, &image, lines(100)).0;
    // What depends on the frame alone is kept, but for those who print.
    let kept = "function f(x)\n    print(x)\n    return x\ncolor = white * f(2)";
    assert_eq!(print(kept), ["0,0 2", "1,0 2", "2,0 2"]);
    assert_eq!(print("if begin_frame\n    k = 3\n    print(\"k\", k)\nprint()\ncolor = white * k").len(), 4);
    // Where all pixels go wrong in shape they are run apart.
    let cut =
        "print(\"a\")\nif pixel.x > 1\n    v = [1 2]\nelse\n    v = 1\nprint(v)\ncolor = white * size([v v])";
    assert_eq!(print(cut), ["0,0 a", "0,0 1", "1,0 a", "1,0 [1 2]", "2,0 a", "2,0 [1 2]"]);
    // Shadows are silent.
    assert_eq!(
        print("x = pixel.x\nprint(x, Du(x))\ncolor = Du(x) * white"),
        ["0,0 0.5 1", "1,0 1.5 1", "2,0 2.5 1"]
    );
    // Of several samples the first one prints.
    let samples = RunOptions { samples: Some(Sampling::of(4)), ..lines(100) };
    let (lines, count) = printed("print(pixel)\ncolor = white", &image, samples);
    assert_eq!((lines.len(), count), (3, 3));
    assert!(lines[1].starts_with("1,0 [1."), "{lines:?}");
}

#[test]
fn only_the_wanted_columns_print() {
    let image = Image::new(5, 2, []).unwrap();
    let options = RunOptions { print_columns: Some(3..4), ..lines(10) };
    let expected = (vec!["3,0 ".to_string(), "3,1 ".to_string()], 2);
    assert_eq!(printed("print()\ncolor = white", &image, options), expected);
}

#[test]
fn the_last_value_is_the_color_and_no_print() {
    let image = Image::new(1, 1, []).unwrap();
    let report = compile("white / 2\nprint(\"done\")").run(&image, &RunOptions::default()).unwrap();
    assert_eq!(report.image.variable("color").unwrap().planes[0][0], 0.5);
    // A function of the program's own hides it.
    let own = "function print(x)\n    return 3 * x\ncolor = white * print(2)";
    let report = compile(own).run(&image, &lines(10)).unwrap();
    assert_eq!((report.image.variable("color").unwrap().planes[0][0], report.prints.count), (6.0, 0));
}

/// The program with a `print` behind every assignment.
fn chatty(text: &str) -> (String, usize) {
    let (mut out, mut added, mut open) = (String::new(), 0, 0);
    for line in text.lines() {
        out += line;
        out.push('\n');
        let code = line.split('#').next().unwrap_or_default();
        let before = open;
        open += code.matches(['(', '[']).count();
        open -= code.matches([')', ']']).count();
        let indent: String = code.chars().take_while(|c| *c == ' ').collect();
        let name: String = code.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let rest = code.trim().strip_prefix(&name).unwrap_or_default();
        let assigns = [" = ", " += ", " -= ", " *= ", " /= "].iter().any(|op| rest.starts_with(op));
        if before == 0 && open == 0 && assigns && !name.is_empty() {
            out += &format!("{indent}print(\"{name}\", {name})\n");
            added += 1;
        }
    }
    (out, added)
}

#[test]
fn images_of_programs_that_print_are_the_same() {
    let (mut all, mut compared) = (0, 0);
    for (name, text, scene) in examples() {
        let image = render(&scene, 60, 45);
        let (chatty, added) = chatty(&text);
        let Ok(silent) = compile(&text).run(&image, &RunOptions::default()) else { continue };
        let report = compile(&chatty).run(&image, &lines(5)).unwrap_or_else(|e| panic!("{name}: {e}"));
        // What plans leave behind is what is printed.
        let walk = RunOptions { no_optimize: true, ..lines(5000) };
        let (walked, planned) = (printed(&chatty, &image, walk), printed(&chatty, &image, lines(5000)));
        assert!(walked == planned, "{name}");
        for (a, b) in silent.image.variables.iter().zip(&report.image.variables) {
            let bits = |v: &pse::Variable<'_>| -> Vec<Vec<u32>> {
                v.planes.iter().map(|p| p.iter().map(|x| x.to_bits()).collect()).collect()
            };
            assert!(a.name == b.name && bits(a) == bits(b), "{name}: {}", a.name);
        }
        assert!(added == 0 || report.prints.count + report.frame_prints.count > 0, "{name} prints nothing");
        (all, compared) = (all + added, compared + 1);
    }
    assert!(compared >= 35 && all > 150, "{compared} programs with {all} prints");
}
