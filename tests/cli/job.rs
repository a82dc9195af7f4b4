//! Bundles for render farms: what is in them, and that `openjd` runs them to the same bytes.

use super::{Folder, ended};
use assert_cmd::Command;
use serde_json::Value;
use std::fs;

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
    f.bad(2, "job p.pse --picture ../a.png -o j", &["does not lie in the folder", "OutputDir"]);
    f.bad(2, "job p.pse --frames 1-9 --picture a.png -o j", &["####"]);
    f.bad(2, "job p.pse --frame 1 --picture a.#.png -o j", &["--frames 1"]);
    f.bad(2, "job p.pse --repeat 3 -o j", &["--repeat", "a job has no use for it"]);
    f.bad(2, "job p.pse --chunk 3 -o j", &["--frames"]);
    f.bad(2, "job p.pse --name {{a}} -o j", &["{{"]);
    f.bad(2, "job p.pse -i d.##/a.exr --frames 1 -o j", &["folder", "name of the file"]);
    fs::create_dir(f.path("s")).expect("a folder");
    f.write("s/q.pse", "import \"../p.pse\"\ncolor = white\n");
    f.bad(1, "job s/q.pse -o j", &["outside of the folders that this program may read", "--path"]);
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
    f.bad(1, "job w.pse --path a -o mine", &["of no bundle", "-o fire.job"]);
    let before = f.read("w.job/template.json");
    f.write("up.pse", "color = texture(\"../wood.png\", 0, 0)\n");
    fs::copy(f.path("a/wood.png"), f.path("wood.png")).expect("a copy");
    fs::rename(f.path("up.pse"), f.path("e/up.pse")).expect("moved");
    f.bad(1, "job e/up.pse --path . -o w.job", &["would not find", "without `..`"]);
    assert_eq!(f.read("w.job/template.json"), before);
    let mut left: Vec<_> =
        fs::read_dir(f.path("w.job")).expect("a folder").map(|e| e.expect("a file").file_name()).collect();
    left.sort();
    assert_eq!(left, ["output", "program", "template.json"]);
    f.bad(2, &format!("job w.pse --path a --name {} -o n.job", "x".repeat(200)), &["1 to 128 characters"]);
}
