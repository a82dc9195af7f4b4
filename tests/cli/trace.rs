//! `pse trace` and `pse run` with `print`, from outside.

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

/// Runs `pse` in a folder: exit status, standard output, standard error.
fn pse(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_pse")).current_dir(folder).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// The like, with arguments that are separated by blanks, and success.
fn good(folder: &Path, arguments: &str) -> (String, String) {
    let (code, out, err) = pse(folder, &arguments.split(' ').collect::<Vec<_>>());
    assert_eq!(code, 0, "pse {arguments}\n{err}");
    (out, err)
}

const PROGRAM: &str = "param k = 2 in [1 9]
function half(x)
    return x / 2

a = half(pixel.x) + sin(k)
if a > 3
    b = 1
else if k > 1
    b = 0
for i in [1 2]
    b += i
print(\"b\", b)
c = (b - 3) / b
color = white / (c - c)
";

#[test]
fn the_text() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("p.pse"), PROGRAM).unwrap();
    let (out, err) =
        good(folder.path(), "trace p.pse --pixel 3,4 --size 8x8 --scene vase --frame 2 --set k=1.5");
    assert_eq!(err, "");
    assert!(out.starts_with("pixel 3,4 of p.pse, frame 2\n\nline  round  source  "), "{out}");
    let lines: Vec<&str> = out.lines().collect();
    let width = lines[2].find("what happens").unwrap();
    for line in &lines[3..18] {
        assert_eq!(line.as_bytes()[width - 2..width], *b"  ", "the columns are aligned: {out}");
    }
    for wanted in [
        "   6         if a > 3                    no (0)",
        "   8         else if k > 1               yes (1)",
        "   1         param k = 2 in [1 9]        k = 1.5  (set)",
        "             (input)                     pixel = [3.5 4.5]",
        "   5         a = half(pixel.x) + sin(k)  half(x = 3.5) gives 1.75",
        "  10  2      for i in [1 2]              i = 2",
        "  11  2          b += i                  b = 3",
        "  12         print(\"b\", b)               print: b 3",
        "color = [infinity infinity infinity]",
        "the first infinity came from `white / (c - c)` in line 14: it is [infinity infinity infinity], with white = [1 1 1], \
         c - c = 0",
    ] {
        assert!(lines.contains(&wanted), "no `{wanted}` in\n{out}");
    }
    // A pipe is no terminal.
    assert!(!out.contains('\x1b'));
    let (deep, _) = good(folder.path(), "trace p.pse --pixel 3,4 --size 8x8 --scene vase --calls");
    assert!(deep.contains("\n   3               return x / 2          returns 1.75\n"), "{deep}");
    assert_eq!(good(folder.path(), "trace p.pse --pixel 3,4 --size 8x8 --scene vase --depth 1").0, deep);
    let (short, _) = good(folder.path(), "trace p.pse --size 8x8 --scene vase --limit 4");
    assert!(short.starts_with("pixel 4,4 of") && short.contains("events omitted (--limit 4)"), "{short}");
}

#[test]
fn the_document_shows_what_is() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/trace.md")).unwrap();
    let block = |mark: &str| {
        let after = text.split_once(&format!("```{mark}\n")).unwrap().1;
        after.split_once("```").unwrap().0.to_string()
    };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("veins.pse"), block("pse")).unwrap();
    let shown = block("text");
    let (command, expected) = shown.split_once('\n').unwrap();
    let (out, _) = good(folder.path(), command.strip_prefix("$ pse ").unwrap());
    assert_eq!(out, expected);
    let run = text.split_once("$ pse run").unwrap().1.split_once("```").unwrap().0;
    let (arguments, expected) = run.split_once('\n').unwrap();
    let (_, err) = good(folder.path(), &format!("run{arguments}"));
    // But for the time.
    let same = |text: &str| -> Vec<String> {
        text.lines().filter(|l| !l.starts_with("wrote ")).map(str::to_string).collect()
    };
    assert_eq!(same(&err), same(expected));
}

#[test]
fn the_json() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("p.pse"), PROGRAM).unwrap();
    let (out, _) = good(folder.path(), "trace p.pse --pixel 3,4 --size 8x8 --scene vase --json --calls");
    let events: Vec<Value> = serde_json::from_str(&out).unwrap();
    assert_eq!(events[0]["event"], "pixel");
    assert_eq!(events[0]["pixel"], serde_json::json!([3, 4]));
    let find = |kind: &str| -> Vec<&Value> { events.iter().filter(|e| e["event"] == kind).collect() };
    let call = find("call")[0];
    assert_eq!((&call["name"], &call["line"], &call["value"]), (&"half".into(), &5.into(), &1.75.into()));
    assert_eq!(call["arguments"], serde_json::json!([{"name": "x", "value": 3.5}]));
    assert_eq!(find("return")[0]["depth"], 1);
    assert_eq!(find("param")[0]["once"], true);
    let last = find("assign").into_iter().rfind(|e| e["name"] == "b").unwrap();
    assert_eq!(
        (&last["rounds"], &last["value"], &last["text"]),
        (&vec![2].into(), &3.0.into(), &"b += i".into())
    );
    assert_eq!(find("print")[0]["parts"], serde_json::json!([{"text": "b"}, {"value": 3.0}]));
    assert_eq!(find("branch").len(), 2);
    assert_eq!(find("loop_end")[0]["count"], 2);
    let color = find("result").into_iter().find(|e| e["name"] == "color").unwrap();
    assert_eq!(color["value"], serde_json::json!(["infinity", "infinity", "infinity"]));
    let birth = find("birth")[0];
    assert_eq!(
        (&birth["what"], &birth["line"], &birth["given"]),
        (&"infinity".into(), &14.into(), &false.into())
    );
    assert_eq!(birth["operands"][1], serde_json::json!({"text": "c - c", "value": 0.0}));
    // An error is the last event, and the command fails.
    let (code, out, err) =
        pse(folder.path(), &["trace", "-e", "v = [1 2]", "-e", "v[4] * white", "--size", "4x4", "--json"]);
    let events: Vec<Value> = serde_json::from_str(&out).unwrap();
    let error = events.last().unwrap();
    assert_eq!((code, &error["event"], &error["line"]), (1, &"error".into(), &2.into()));
    assert!(err.contains("no element 4"), "{err}");
}

/// The value of `color` that a trace tells at a pixel, as bits.
fn traced(folder: &Path, arguments: &str, pixel: [usize; 2]) -> Vec<u32> {
    let (out, _) = good(folder, &format!("trace {arguments} --pixel {},{} --json", pixel[0], pixel[1]));
    let events: Vec<Value> = serde_json::from_str(&out).unwrap();
    let color = events.iter().find(|e| e["event"] == "result" && e["name"] == "color").expect("a color");
    // Shortest digits: read back they are the same float.
    color["value"].as_array().unwrap().iter().map(|x| (x.as_f64().unwrap() as f32).to_bits()).collect()
}

#[test]
fn values_are_those_that_a_run_writes() {
    let folder = tempfile::tempdir().unwrap();
    let root = env!("CARGO_MANIFEST_DIR");
    let near = "p = turbulence(4 * point) + filterwidth(7 * point.x) + Du(normal.z)\ncolor = white * p + [pixelsize Dv(p) 0]\n";
    std::fs::write(folder.path().join("near.pse"), near).unwrap();
    let cropped = format!("{root}/tests/gbuffers/donut_320x180_plain_datawindow_crop.exr");
    let runs = [
        format!("{root}/examples/marble.pse --scene vase --size 64x48"),
        format!("{root}/examples/globe.pse --scene sphere --size 64x48"),
        format!("{root}/examples/brick_bump.pse --scene card --size 64x48"),
        "near.pse --scene donut --size 64x48".to_string(),
        format!("near.pse -i {cropped}"),
    ];
    for run in &runs {
        good(folder.path(), &format!("run {run} -o out.exr -q --force"));
        let file =
            pse::image::read(pse::image::Input::Path(folder.path().join("out.exr")), &Default::default())
                .unwrap();
        let image = file.load_all().unwrap();
        let color = image.variable("color").unwrap();
        let [x, y] = image.metadata.origin.map(|o| o as usize);
        for (column, row) in
            [(0, 0), (31, 20), (image.width / 2, image.height / 2), (image.width - 1, image.height - 1)]
        {
            let expected: Vec<u32> =
                color.planes.iter().map(|p| p[row * image.width + column].to_bits()).collect();
            assert_eq!(
                traced(folder.path(), run, [column + x, row + y]),
                expected,
                "{run} at {column},{row}"
            );
        }
    }
    let (code, _, err) = pse(folder.path(), &["trace", "near.pse", "-i", &cropped, "--pixel", "0,0"]);
    assert!(
        code == 2 && err.contains("there is no pixel 0,0") && err.contains("The pixels go from "),
        "{err}"
    );
    let (code, _, err) = pse(folder.path(), &["trace", "near.pse", "--pixel", "12"]);
    assert!(code == 2 && err.contains("a pixel is a column and a row: 320,200"), "{err}");
}

#[test]
fn a_run_prints_the_first_lines() {
    let folder = tempfile::tempdir().unwrap();
    let program = "if begin_frame\n    print(\"once\", frame)\nif pixel.y > 1\n    print(\"x\", pixel.x)\ncolor = white * Du(pixel.x)\n";
    std::fs::write(folder.path().join("p.pse"), program).unwrap();
    let run = |more: &str| -> Vec<String> {
        let (_, err) = good(folder.path(), &format!("run p.pse --scene vase -o a.exr {more}"));
        err.lines().filter(|l| !l.starts_with("wrote ")).map(str::to_string).collect()
    };
    let few = ["line 2: once 0", "pixel 0,1 line 4: x 0.5", "pixel 1,1 line 4: x 1.5"];
    let rest = "print: 1 more line not shown; --print N shows more";
    assert_eq!(run("--size 3x2 --print 3"), [&few[..], &[rest]].concat());
    assert_eq!(run("--size 3x2").len(), 4);
    assert!(run("--size 3x2 --print 0").is_empty());
    assert!(run("--size 3x2 -q").is_empty());
    // A region prints for its own pixels alone, and large pictures, which are read in bands, once a frame.
    assert_eq!(
        run("--size 9x9 --region 4,3,6,4"),
        ["line 2: once 0", "pixel 4,3 line 4: x 4.5", "pixel 5,3 line 4: x 5.5"]
    );
    let large = run("--size 1000x900 --print 2");
    assert_eq!(large[..2], ["line 2: once 0", "pixel 0,1 line 4: x 0.5"]);
    assert_eq!(large[2], "print: 898999 more lines not shown; --print N shows more");
    let (_, err) = good(folder.path(), "run p.pse --scene vase -o f.#.exr --frames 1-2 --size 2x2 --print 5");
    let lines: Vec<&str> = err.lines().filter(|l| !l.starts_with("wrote ")).collect();
    let expected = [
        "frame 1 line 2: once 1",
        "frame 1 pixel 0,1 line 4: x 0.5",
        "frame 1 pixel 1,1 line 4: x 1.5",
        "frame 2 line 2: once 2",
        "frame 2 pixel 0,1 line 4: x 0.5",
        "print: 1 more line not shown; --print N shows more",
    ];
    assert_eq!(lines, expected);
}
