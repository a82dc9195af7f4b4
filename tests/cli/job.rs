//! Bundles for render farms: what is in them, and that `openjd` runs them to the same bytes.

use super::{Folder, ended};
use assert_cmd::Command;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

impl Folder {
    fn template(&self, bundle: &str) -> Value {
        serde_json::from_slice(&self.read(&format!("{bundle}/template.json"))).expect("JSON")
    }
}

/// The words of a step's command, joined with blanks.
fn words(template: &Value, step: usize) -> String {
    let words = &template["steps"][step]["script"]["actions"]["onRun"]["args"];
    let words = words.as_array().expect("words");
    words.iter().map(|w| w.as_str().expect("a word")).collect::<Vec<_>>().join(" ")
}

#[test]
fn a_bundle_has_all_that_a_run_needs() {
    let f = Folder::new();
    for folder in ["shaders/lib", "common", "renders"] {
        fs::create_dir_all(f.path(folder)).expect("a folder");
    }
    f.write(
        "shaders/fire.pse",
        "import \"lib/a.pse\"\nimport \"c.pse\"\ncolor = a() + c() + texture(\"sky.#.png\", 0, 0)\n",
    );
    f.write("shaders/lib/a.pse", "import \"b.pse\"\nfunction a()\n    return b()\n");
    f.write("shaders/lib/b.pse", "function b()\n    return white\n");
    f.write("common/c.pse", "function c()\n    return white\n");
    for n in 1..=3 {
        f.good(&format!("run -e white --size 4x4 -o shaders/sky.{n}.png"));
    }
    for n in 1..=3 {
        f.good(&format!("run -e white --size 4x4 -o renders/g.000{n}.exr"));
    }
    f.good("run -e white --size 4x4 -o renders/bg.exr");
    let run = "job shaders/fire.pse --path common --frames 1-3 -i renders/g.####.exr -i bg=renders/bg.exr";
    let told = f.good(&format!("{run} --set veins=6 --threads 2 --vars color --half -o fire.job"));
    for name in ["fire.pse", "lib/a.pse", "lib/b.pse", "path-1/c.pse", "sky.1.png", "sky.3.png"] {
        assert!(f.path("fire.job/program").join(name).exists(), "{name}");
    }
    assert!(told.err.contains("3 tasks"), "{}", told.err);
    let renders = fs::canonicalize(f.path("renders")).expect("a folder");
    assert!(told.text.starts_with("openjd run fire.job/template.json -p InputDir="), "{}", told.text);
    let template = f.template("fire.job");
    assert_eq!(template["specificationVersion"], "jobtemplate-2023-09");
    assert_eq!(
        words(&template, 0),
        "run {{Param.ProgramDir}}/fire.pse --path {{Param.ProgramDir}}/path-1 \
         --input {{Param.InputDir}}/g.####.exr --input bg={{Param.InputDir}}/bg.exr --set veins=6 --vars color \
         --half --threads 2 --frames {{Task.Param.Frame}} --output {{Param.OutputDir}}/fire.####.png --mkdir \
         --progress openjd"
    );
    let values = String::from_utf8(f.read("fire.job/parameter_values.json")).expect("text");
    assert!(values.contains(&renders.display().to_string()), "{values}");
    // Tiles: what says how files are written goes to the join.
    f.good(&format!("{run} --tiles 2x3 --chunk 2 --half --bits 16 --picture a/fire.##.tif -o t.job -q"));
    let template = f.template("t.job");
    assert_eq!(template["extensions"][0], "TASK_CHUNKING");
    let (run, join) = (words(&template, 0), words(&template, 1));
    let tile = "{{Param.OutputDir}}/tiles/a/fire.##.{tile}.exr";
    assert!(run.contains(&format!("--tile {{{{Task.Param.Tile}}}}/2x3 --output {tile} --mkdir")), "{run}");
    assert!(!run.contains("--half") && !run.contains("--bits"), "{run}");
    assert_eq!(
        join,
        format!(
            "join {tile} --tiles 2x3 --frames {{{{Task.Param.Frame}}}} --half --bits 16 \
             --output {{{{Param.OutputDir}}}}/a/fire.##.tif --mkdir"
        )
    );
    assert_eq!(template["steps"][1]["dependencies"][0]["dependsOn"], "Run");
}

#[test]
fn what_no_farm_can_run_is_said() {
    let f = Folder::new();
    f.write("p.pse", "color = white\n");
    f.bad(2, "job p.pse", &["--bundle"]);
    f.bad(1, "job -e color=( -o j", &["never closed"]);
    f.bad(2, "job - -o j", &["standard input"]);
    f.bad(2, "job p.pse -i - -o j", &["standard input"]);
    f.bad(2, "job p.pse --picture ../a.png -o j", &["is outside the job's output folder", "OutputDir"]);
    f.bad(2, "job p.pse --frames 1-9 --picture a.png -o j", &["####"]);
    f.bad(2, "job p.pse --frame 1 --picture a.#.png -o j", &["--frames 1"]);
    f.bad(2, "job p.pse --repeat 3 -o j", &["--repeat", "has no effect in a job"]);
    f.bad(2, "job p.pse --chunk 3 -o j", &["--frames"]);
    f.bad(2, "job p.pse --name {{a}} -o j", &["{{"]);
    f.bad(
        1,
        "job p.pse -i d.##/a.##.exr --frames 1 -o j",
        &["frame 1 of `d.##/a.##.exr` is not there", "`d.01/a.01.exr`"],
    );
    fs::create_dir(f.path("d.01")).expect("a folder");
    f.good("run -e white --size 4x4 -o d.01/a.01.exr");
    f.bad(2, "job p.pse -i d.##/a.##.exr --frames 1 -o j", &["folder", "file name"]);
    fs::create_dir(f.path("s")).expect("a folder");
    f.write("s/q.pse", "import \"../p.pse\"\ncolor = white\n");
    f.bad(1, "job s/q.pse -o j", &["outside the folders that this program may read", "--path"]);
    assert!(!f.path("j/template.json").exists());
    f.write("s/q.pse", "import \"p.pse\"\ncolor = white\n");
    f.good("job s/q.pse --path . -o k");
}

/// `openjd`, if this machine has it; the checks before a change install it.
fn openjd(f: &Folder) -> Option<Command> {
    if std::process::Command::new("openjd").arg("--version").output().is_err() {
        eprintln!("skipped: there is no command openjd; pip install openjd-cli");
        return None;
    }
    let mut command = Command::new("openjd");
    command.current_dir(f.path(""));
    Some(command)
}

/// Checks the bundle and runs all its steps.
fn run(f: &Folder, bundle: &str, parameters: &[&str]) -> Option<String> {
    let template = format!("{bundle}/template.json");
    let checked = ended(openjd(f)?.args(["check", &template]));
    assert_eq!(checked.code, 0, "{}{}", checked.text, checked.err);
    let mut command = openjd(f)?;
    command.args(["run", &template, "-p", &format!("Pse={}", env!("CARGO_BIN_EXE_pse"))]);
    for parameter in parameters {
        command.args(["-p", parameter]);
    }
    let ran = ended(&mut command);
    assert_eq!(ran.code, 0, "{}{}", ran.text, ran.err);
    Some(ran.text)
}

#[test]
fn openjd_runs_bundles_to_the_same_bytes() {
    let f = Folder::new();
    f.write(
        "p.pse",
        "param a = 0.1\ncolor = white * (a * frame + filterwidth(point).x + Noise(8 * point))\n",
    );
    let frames = "p.pse --size 60x44 --frames 1-7x2,20 --set a=0.2";
    f.good(&format!("run {frames} -o p.##.exr -o p.##.png --bits 16"));
    let outputs = "--picture p.##.exr --picture p.##.png --bits 16";
    f.good(&format!("job {frames} {outputs} -o one.job"));
    let Some(told) = run(&f, "one.job", &[]) else { return };
    assert!(told.contains("openjd_progress: 100.0"), "{told}");
    f.good(&format!("job {frames} {outputs} --chunk 3 -o chunks.job"));
    run(&f, "chunks.job", &[]);
    f.good(&format!("job {frames} {outputs} --chunk 2 --tiles 2x3 -o tiles.job"));
    run(&f, "tiles.job", &[]);
    for name in ["p.01.exr", "p.03.png", "p.07.exr", "p.20.png"] {
        for bundle in ["one", "chunks", "tiles"] {
            let path = format!("{bundle}.job/output/{name}");
            assert!(f.read(name) == f.read(&path), "{path}");
        }
    }
    // One picture in tiles, on an image that stays where it is.
    fs::create_dir(f.path("renders")).expect("a folder");
    f.good("scene vase --size 50x70 -o renders/g.exr");
    let still = ["-e", "color = normal * Noise(5 * point)", "-i", "renders/g.exr"];
    let whole = [&["run"], &still[..], &["-o", "whole.png"]].concat();
    assert_eq!(f.pse_with(&whole, b"").code, 0);
    let job =
        [&["job"], &still[..], &["--tiles", "2x2", "--picture", "whole.png", "-o", "still.job"]].concat();
    assert_eq!(f.pse_with(&job, b"").code, 0);
    run(&f, "still.job", &[&format!("InputDir={}", f.path("renders").display())]);
    assert!(f.read("whole.png") == f.read("still.job/output/whole.png"));
}

#[test]
fn a_bundle_is_made_anew() {
    let f = Folder::new();
    for folder in ["a", "b", "e", "mine/program"] {
        fs::create_dir_all(f.path(folder)).expect("a folder");
    }
    f.good("run -e red --size 4x4 -o a/wood.png -q");
    f.good("run -e blue --size 4x4 -o b/wood.png -q");
    f.write("w.pse", "color = texture(\"wood.png\", 0, 0)\n");
    f.good("job w.pse --path a -i a/wood.png -o w.job -q");
    assert!(
        f.path("w.job/program/path-1/wood.png").exists() && f.path("w.job/parameter_values.json").exists()
    );
    f.write("w.job/output/kept.png", "a picture");
    f.good("job w.pse --path e --path b -o w.job -q");
    assert!(
        !f.path("w.job/program/path-1/wood.png").exists() && !f.path("w.job/parameter_values.json").exists()
    );
    assert_eq!(f.read("w.job/program/path-2/wood.png"), f.read("b/wood.png"));
    assert_eq!(f.read("w.job/output/kept.png"), b"a picture");
    // What is no bundle is left alone, and what fails leaves the old one.
    f.bad(1, "job w.pse --path a -o mine", &["is not part of a bundle", "-o fire.job"]);
    let before = f.read("w.job/template.json");
    f.write("up.pse", "color = texture(\"../wood.png\", 0, 0)\n");
    fs::copy(f.path("a/wood.png"), f.path("wood.png")).expect("a copy");
    fs::rename(f.path("up.pse"), f.path("e/up.pse")).expect("moved");
    f.bad(1, "job e/up.pse --path . -o w.job", &["would not find", "without `..`"]);
    assert_eq!(f.read("w.job/template.json"), before);
    let mut left: Vec<_> =
        fs::read_dir(f.path("w.job")).expect("a folder").map(|e| e.expect("a file").file_name()).collect();
    left.sort();
    assert_eq!(left, ["output", "program", "pse-bundle.json", "template.json"]);
    f.bad(2, &format!("job w.pse --path a --name {} -o n.job", "x".repeat(200)), &["1 to 128 characters"]);
}

/// All files and folders below a folder, with what they hold.
fn everything(folder: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("a file").path();
        if path.is_dir() && !path.is_symlink() {
            all.extend(everything(&path));
        }
        all.insert(path.clone(), fs::read(&path).ok());
    }
    all
}

impl Folder {
    /// Expects that it refuses, and that no file comes, goes or changes.
    fn untouched(&self, code: i32, arguments: &str, words: &[&str]) {
        let before = everything(&self.path(""));
        self.bad(code, arguments, words);
        assert!(everything(&self.path("")) == before, "pse {arguments}");
    }
}

#[test]
fn only_files_of_the_bundle_are_replaced() {
    let f = Folder::new();
    f.write("p.pse", "import \"lib/q.pse\"\ncolor = q()\n");
    fs::create_dir(f.path("lib")).expect("a folder");
    f.write("lib/q.pse", "function q()\n    return white\n");
    // What looks like a bundle, and is somebody's work.
    for (folder, name) in [("a", "template.json"), ("b", "program/notes.txt"), ("c", "parameter_values.json")]
    {
        fs::create_dir_all(f.path(folder).join("program")).expect("a folder");
        f.write(&format!("{folder}/{name}"), "mine");
        f.untouched(1, &format!("job p.pse -o {folder}"), &["is not part of a bundle", "-o fire.job"]);
        f.untouched(1, &format!("job p.pse -o {folder} --force"), &["is not part of a bundle"]);
    }
    f.write("a/pse-bundle.json", "{}");
    f.untouched(1, "job p.pse -o a", &["`a/pse-bundle.json` does not list the files of a bundle"]);
    let list = r#"{"version":1,"files":{"../p.pse":[]},"folders":["program"]}"#;
    f.write("a/pse-bundle.json", list);
    f.untouched(1, "job p.pse -o a", &["does not list"]);
    // Files beside those of a bundle stay, though they lie in its folders.
    f.good("job p.pse -o j -q");
    f.write("j/program/notes.txt", "mine");
    f.write("j/program/lib/more.txt", "mine");
    f.write("j/readme", "mine");
    f.write("p.pse", "color = blue\n");
    f.good("job p.pse -o j -q");
    assert!(!f.path("j/program/lib/q.pse").exists(), "it is no part of the program any more");
    for name in ["j/program/notes.txt", "j/program/lib/more.txt", "j/readme"] {
        assert_eq!(f.read(name), b"mine");
    }
    assert_eq!(f.read("j/program/p.pse"), b"color = blue\n");
    // A file in the way of a new one.
    f.write("p.pse", "import \"lib/more.txt\"\nimport \"lib/q.pse\"\ncolor = q()\n");
    f.write("lib/more.txt", "a = 1\n");
    f.untouched(1, "job p.pse -o j", &["`j/program/lib/more.txt` exists, and is not part of a bundle"]);
    // What was changed by hand is replaced only with --force.
    f.write("p.pse", "color = red\n");
    f.write("j/template.json", "{}");
    f.untouched(1, "job p.pse -o j", &["`j/template.json` was changed after pse wrote it", "--force"]);
    f.good("job p.pse -o j -q --force");
    assert!(!words(&f.template("j"), 0).contains("--force"));
    f.write("j/program/p.pse", "color = green\n");
    f.untouched(1, "job p.pse -o j", &["`j/program/p.pse` was changed"]);
    f.good("job p.pse -o j -q --force");
    // Links lead out of the bundle.
    #[cfg(unix)]
    {
        fs::create_dir(f.path("far")).expect("a folder");
        f.write("far/p.pse", "color = red\n");
        fs::remove_dir_all(f.path("j/program")).expect("a folder");
        std::os::unix::fs::symlink("../far", f.path("j/program")).expect("a link");
        f.untouched(1, "job p.pse -o j", &["`j/program` exists, and is not part of a bundle"]);
        f.untouched(1, "job p.pse -o j --force", &["is not part of a bundle"]);
        std::os::unix::fs::symlink("k.far", f.path("k")).expect("a link");
        fs::create_dir(f.path("k.far")).expect("a folder");
        f.good("job p.pse -o k -q");
        f.good("job p.pse -o k -q");
        assert!(f.path("k").is_symlink() && f.path("k.far/template.json").is_file());
    }
}

#[test]
fn sources_in_the_bundle_are_refused() {
    let f = Folder::new();
    f.write("p.pse", "color = white\n");
    f.write("lib.pse", "function q()\n    return white\n");
    f.good("job p.pse -o j -q");
    f.write("j/program/notes.txt", "mine");
    let inside = ["is in the folder of the bundle", "Give another folder with -o"];
    f.untouched(1, "job j/program/p.pse -o j", &inside);
    f.untouched(1, "job p.pse -o .", &inside);
    f.good("run -e white --size 4x4 -o j/program/t.png -q");
    f.untouched(1, "job -e color=texture(\"t.png\",0,0) --path j/program -o j", &inside);
    f.untouched(1, "job p.pse -i j/program/t.png -o j", &inside);
    // Pictures of an earlier job may be run on, and another bundle may be made of one.
    f.good("run -e white --size 4x4 -o j/output/t.png -q");
    f.good("job p.pse -i j/output/t.png -o j -q");
    f.good("job j/program/p.pse -o k -q");
}

/// Kills the command at each of its calls to the system that change the disk, one after the other.
#[cfg(target_os = "linux")]
#[test]
fn killed_at_any_moment_a_bundle_is_whole() {
    if std::process::Command::new("strace").arg("-V").output().is_err() {
        eprintln!("skipped: there is no command strace");
        return;
    }
    let f = Folder::new();
    let texts = [
        ("color = white\n", "function a()\n    return 1\n"),
        ("import \"a.pse\"\ncolor = a() * red\n", "function a()\n    return 2\n"),
    ];
    let write = |(program, import): (&str, &str)| {
        f.write("p.pse", program);
        f.write("a.pse", import);
    };
    let job = |kill: Option<(&str, usize)>, options: &[&str]| {
        let mut command = match kill {
            Some((call, n)) => {
                let mut command = std::process::Command::new("strace");
                let inject = format!("inject={call}:signal=KILL:when={n}");
                command.args(["-f", "-qq", "-o", "/dev/null", "-e", &inject, env!("CARGO_BIN_EXE_pse")]);
                command
            }
            None => std::process::Command::new(env!("CARGO_BIN_EXE_pse")),
        };
        command
            .args(["job", "p.pse", "-o", "j", "-q", "--size", "8x8"])
            .args(options)
            .current_dir(f.path(""));
        command.output().expect("it starts").status.success()
    };
    let mut kills = 0;
    for call in ["rename", "unlink", "link,linkat", "mkdir", "openat", "rmdir,unlinkat"] {
        for n in 1.. {
            if f.path("j").exists() {
                fs::remove_dir_all(f.path("j")).expect("a folder");
            }
            write(texts[0]);
            assert!(job(None, &[]));
            let before = everything(&f.path("j"));
            write(texts[1]);
            let done = job(Some((call, n)), &["--samples", "2"]);
            kills += usize::from(!done);
            // The program that the template names is there, and fits the template: of before, or of after.
            let template = f.template("j");
            let parameters = template["parameterDefinitions"].as_array().expect("parameters");
            let folder =
                parameters.iter().find(|p| p["name"] == "ProgramDir").expect("a folder")["default"].clone();
            let folder = f.path("j").join(folder.as_str().expect("text"));
            let after = words(&template, 0).contains("--samples 2");
            let program = fs::read_to_string(folder.join("p.pse")).expect("the program");
            assert_eq!(program, texts[usize::from(after)].0, "{call} {n}");
            let import = fs::read_to_string(folder.join("a.pse")).ok();
            assert!(if after { import.as_deref() == Some(texts[1].1) } else { true }, "{call} {n}");
            // The next time nothing is left of it.
            assert!(job(None, &["--samples", "2"]), "{call} {n}");
            let names = |all: &BTreeMap<PathBuf, _>| all.keys().cloned().collect::<Vec<_>>();
            let mut expected = names(&before);
            expected.push(f.path("j/program/a.pse"));
            expected.sort();
            assert_eq!(names(&everything(&f.path("j"))), expected, "{call} {n}");
            if done || call == "openat" && n >= 200 {
                break;
            }
        }
    }
    eprintln!("{kills} kills");
    assert!(kills > 20, "{kills} kills");
}

#[cfg(unix)]
#[test]
fn the_printed_line_can_be_pasted() {
    let f = Folder::new();
    f.write("p.pse", "color = white\n");
    for folder in ["x';touch PWNED;'", "b$(touch PWNED)", "a b", "`touch PWNED`", "-n", "ü&é", "it's"] {
        fs::create_dir(f.path(folder)).expect("a folder");
        f.good("run -e white --size 4x4 -o i.exr -q");
        fs::rename(f.path("i.exr"), f.path(folder).join("i.exr")).expect("moved");
        let bundle = format!("{folder}.job");
        let input = format!("./{folder}/i.exr");
        let told = f.pse_with(&["job", "p.pse", "-i", &input, &format!("--bundle={bundle}")], b"");
        assert_eq!(told.code, 0, "{}", told.err);
        // The shell gives the command the very words, and does nothing else.
        let line = told.text.replacen("openjd", "printf '%s\\n'", 1);
        let mut shell = Command::new("sh");
        let heard = ended(shell.args(["-c", &line]).current_dir(f.path(""))).text;
        let whole = fs::canonicalize(f.path(folder)).expect("a folder");
        let plain = if bundle.starts_with('-') { format!("./{bundle}") } else { bundle };
        let expected = format!("run\n{plain}/template.json\n-p\nInputDir={}\n", whole.display());
        assert_eq!(heard, expected, "{line}");
        assert!(!f.path("PWNED").exists());
    }
}

#[test]
fn what_no_template_can_hold_is_said() {
    let f = Folder::new();
    f.write("p.pse", "color = white\n");
    let said = |arguments: &[&str], words: &[&str]| {
        let ended = f.pse_with(arguments, b"");
        let running = ended.err.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(ended.code, 2, "{running}");
        assert!(words.iter().all(|word| running.contains(word)), "{running}");
        assert!(!running.contains('\u{1b}') && !f.path("j").exists(), "{running:?}");
    };
    said(&["job", "-e", "color = white # }}", "-o", "j"], &["`}}`", "into a file"]);
    said(&["job", "-e", "color = white # \ta", "-o", "j"], &["control character", "\\ta", "into a file"]);
    said(&["job", "p.pse", "--picture", "a\u{1b}.png", "-o", "j"], &["control character"]);
    said(&["job", "p.pse", "--picture", "a}}.png", "-o", "j"], &["`}}`"]);
    said(&["job", "p.pse", "--name", "a}}b", "-o", "j"], &["`}}`"]);
    said(&["job", "p.pse", "--name", "a\nb", "-o", "j"], &["no control characters"]);
    let long = "x".repeat(129) + ".pse";
    fs::copy(f.path("p.pse"), f.path(&long)).expect("a copy");
    said(&["job", &long, "-o", "j"], &["1 to 128 characters", "--name"]);
    f.good(&format!("job {long} --name x -o k -q"));
    // Two lines in one argument are allowed.
    assert_eq!(f.pse_with(&["job", "-e", "a = 1\ncolor = a * white", "-o", "l", "-q"], b"").code, 0);
    for bundle in ["k", "l"] {
        let Some(mut command) = openjd(&f) else { return };
        let checked = ended(command.args(["check", &format!("{bundle}/template.json")]));
        assert_eq!(checked.code, 0, "{}{}", checked.text, checked.err);
    }
}

#[test]
fn jobs_have_no_frames_that_are_not_there() {
    let f = Folder::new();
    f.write("p.pse", "color = white * frame\n");
    for n in [-1, 0, 1, 3] {
        f.good(&format!("run -e white --size 4x4 -o g.{n}.exr -q"));
    }
    f.untouched(
        1,
        "job p.pse -i g.#.exr --frames 1-10 -o j",
        &["frames 2,4-10 of `g.#.exr` are not there", "--frames 1,3"],
    );
    f.untouched(1, "job p.pse -i h.#.exr --frames 1-10 -o j", &["frames 1-10 of `h.#.exr`", "`h.1.exr`"]);
    f.untouched(2, "job p.pse -i g.#.exr -o j", &["none is given"]);
    f.untouched(1, "job p.pse -i none.exr -o j", &["`none.exr`: there is no such file"]);
    f.untouched(1, "job p.pse --mesh m.#.obj --frames 1 -o j", &["frame 1 of `m.#.obj` is not there"]);
    f.write("t.pse", "color = texture(\"g.#.exr\", 0, 0)\n");
    f.untouched(1, "job t.pse --frames 1-3 -o j", &["frame 2 of `g.#.exr` is not there", "--frames 1,3"]);
    let told = f.good("job p.pse -i g.#.exr --frames -1-1 -o j");
    assert!(told.err.contains("3 tasks"), "{}", told.err);
    assert_eq!(f.template("j")["parameterDefinitions"][1]["default"], "-1-1");
    let Some(_) = run(&f, "j", &[&format!("InputDir={}", f.path("").display())]) else { return };
    assert!(f.path("j/output/p.-001.png").exists() && f.path("j/output/p.0001.png").exists());
    // A single file of a frame: the task finds its number too.
    f.good("job p.pse -i g.3.exr --picture o.exr -o k -q");
    run(&f, "k", &[&format!("InputDir={}", f.path("").display())]);
    assert_eq!(f.planes("k/output/o.exr", "color")[0][0], 3.0);
}

#[test]
fn files_of_others_among_the_staged_ones_stay() {
    let f = Folder::new();
    f.write("p.pse", "color = white\n");
    f.good("job p.pse -o j -q");
    // As a command that was killed leaves it, with something of the user's beside.
    fs::create_dir_all(f.path("j/.pse-staged/program/mine")).expect("a folder");
    let names = "{\"version\": 1, \"files\": {\"program/p.pse\": []}, \"folders\": [\"program\"]}";
    for (name, text) in [
        ("pse-bundle.json", names),
        ("template.json", "{}"),
        ("interim.json", "{}"),
        ("program/p.pse", "x"),
        ("program/notes.txt", "mine"),
        ("program/mine/a", "mine"),
        ("my.txt", "mine"),
    ] {
        f.write(&format!("j/.pse-staged/{name}"), text);
    }
    for (mine, next) in
        [("my.txt", "program/notes.txt"), ("program/notes.txt", "program/mine"), ("program/mine", "")]
    {
        let _ = next;
        let ended = f.pse("job p.pse -o j");
        assert_eq!(ended.code, 1, "{}", ended.err);
        assert!(ended.err.contains("is not a file that pse put there"), "{}", ended.err);
        assert!(f.path("j/.pse-staged").join(mine).exists(), "{mine}");
        assert!(!f.path("j/.pse-staged/program/p.pse").exists(), "what is listed is removed");
        fs::rename(f.path("j/.pse-staged").join(mine), f.path(&mine.replace('/', "-"))).expect("moved");
    }
    f.good("job p.pse -o j -q");
    assert!(!f.path("j/.pse-staged").exists());
    assert_eq!(f.read("program-mine/a"), b"mine");
}

#[test]
fn a_refused_bundle_leaves_nothing() {
    let f = Folder::new();
    f.write("p.pse", "color = white\n");
    f.write("p.job", "mine");
    f.untouched(1, "job p.pse -o p.job", &["`p.job` is not a folder", "-o fire.job"]);
    f.untouched(1, "job p.pse -o p.job/a", &["p.job"]);
    // The program would not find its import in a bundle, which is found out late.
    fs::create_dir(f.path("lib")).expect("a folder");
    f.write("lib/q.pse", "function q()\n    return white\n");
    f.write("lib/r.pse", "import \"../lib/q.pse\"\ncolor = q()\n");
    for bundle in ["new", "new/output", "new/a/b", "lib/../new/c"] {
        f.untouched(1, &format!("job lib/r.pse --path . -o {bundle}"), &["would not find all of its files"]);
    }
    f.good("job p.pse -o new/a/b -q");
    // A list with a name that no file has.
    let list = String::from_utf8(f.read("new/a/b/pse-bundle.json")).expect("text");
    f.write("new/a/b/pse-bundle.json", list.replace("\"files\": {", "\"files\": {\"\\u0000\": [],"));
    f.untouched(1, "job p.pse -o new/a/b", &["does not list the files of a bundle"]);
}

#[cfg(unix)]
#[test]
fn names_that_a_terminal_does_not_show_are_quoted_or_refused() {
    let f = Folder::new();
    f.write("p.pse", "color = white\n");
    let job = |folder: &str, bundle: &str| {
        fs::create_dir_all(f.path(folder)).expect("a folder");
        f.good("run -e white --size 4x4 -o i.exr -q --force");
        fs::rename(f.path("i.exr"), f.path(folder).join("i.exr")).expect("moved");
        f.pse_with(&["job", "p.pse", "-i", &format!("./{folder}/i.exr"), &format!("--bundle={bundle}")], b"")
    };
    let told = job("a\u{2028}b", "c\u{200b}d");
    assert_eq!(told.code, 0, "{}", told.err);
    assert!(told.text.contains("$'c\\xe2\\x80\\x8bd/template.json'"), "{}", told.text);
    assert!(told.text.contains("a\\xe2\\x80\\xa8b'") && !told.text.contains("u{"), "{}", told.text);
    for name in ["a\nb", "a\tb"] {
        let told = job(name, "j");
        assert!(told.code == 2 && told.err.contains("control character"), "{name:?}: {}", told.err);
        assert!(!f.path("j").exists());
    }
}
