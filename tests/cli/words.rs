//! The commands about programs and about the language, and help.

use super::Folder;

#[test]
fn help_has_examples() {
    let f = Folder::new();
    let help = f.good("--help").text;
    assert_eq!(f.good("").text, help);
    assert!(help.contains("Examples:") && help.contains("Exit status"), "{help}");
    for command in [
        "run",
        "job",
        "join",
        "repl",
        "trace",
        "scene",
        "noise",
        "info",
        "check",
        "fmt",
        "doc",
        "ast",
        "completions",
        "man",
    ] {
        assert!(help.contains(&format!("  {command} ")), "{command}");
        let own = f.good(&format!("help {command}")).text;
        assert!(own.contains("Examples:"), "{own}");
    }
    assert!(f.good("--version").text.starts_with("pse "));
    f.bad(2, "chek", &["similar", "check"]);
    f.bad(2, "run -e white --sise 4x4", &["--size"]);
}

#[test]
fn checking() {
    let f = Folder::new();
    f.write("good.pse", "color = white * point.x + normal\n");
    f.write("bad.pse", "color = white * pont.x\n");
    f.write("own.pse", "color = white * temperature\n");
    f.write("worse.pse", "color = (1\n");
    let ended = f.good("check good.pse");
    assert_eq!((ended.text.as_str(), ended.err.as_str()), ("", ""));
    assert!(f.good("check -v good.pse good.pse").err.contains("2 programs checked"));
    f.bad(1, "check good.pse bad.pse worse.pse", &["bad.pse:1:17", "Did you mean `point`?", "worse.pse:1"]);
    let ended = f.good("check own.pse");
    assert!(ended.err.contains("the program does not assign `temperature`"), "{}", ended.err);
    f.good("check good.pse --scene donut");
    f.bad(1, "check own.pse --scene donut", &["no variable `temperature`", "The scene donut has surface"]);
    f.good("scene card -o c.exr --size 4x4 -q");
    f.good("check good.pse -i c.exr");
    f.bad(1, "check own.pse -i c.exr", &["no variable `temperature`", "`point`"]);
    f.bad(1, "check none.pse", &["there is no such file"]);
    f.bad(2, "check", &["PROGRAM"]);
    assert_eq!(f.pse_with(&["check", "-"], b"color = white").code, 0);
}

#[test]
fn formatting() {
    let f = Folder::new();
    f.write("a.pse", "color=white*2\n");
    f.write("b.pse", "color = white\n");
    f.write("c.pse", "color = (\n");
    let ended = f.pse("fmt --check a.pse b.pse");
    assert_eq!((ended.code, ended.text.as_str()), (1, "a.pse\n"));
    assert_eq!(f.read("a.pse"), b"color=white*2\n");
    f.good("fmt a.pse b.pse");
    assert_eq!(f.read("a.pse"), b"color = white * 2\n");
    f.good("fmt --check a.pse b.pse");
    f.bad(1, "fmt c.pse", &["c.pse:1"]);
    assert_eq!(f.read("c.pse"), b"color = (\n");
    assert_eq!(f.pse_with(&["fmt"], b"x=1").text, "x = 1\n");
    assert_eq!(f.pse_with(&["fmt", "-"], b"x=1").text, "x = 1\n");
    f.bad(1, "fmt none.pse", &["there is no such file"]);
}

#[test]
fn documentation() {
    let f = Folder::new();
    let list = f.good("doc").text;
    for name in ["Noise", "smoothstep", "diffuse", "pi", "pixelsize", "point"] {
        assert!(list.lines().any(|l| l.trim_start().starts_with(&format!("{name} "))), "{name}");
        assert!(f.good(&format!("doc {name}")).text.starts_with(name), "{name}");
    }
    assert_eq!(f.good("doc Noise()").text, f.good("doc Noise").text);
    f.bad(1, "doc nois", &["Did you mean Noise?"]);
    f.bad(1, "doc voronoi", &["Noise(p, kind = \"cellular\")"]);
    f.bad(1, "doc qqqqqq", &["pse doc lists them all"]);
    let markdown = f.good("doc --markdown").text;
    assert!(markdown.starts_with("# ") && markdown.contains("### Noise") && markdown.contains("### diffuse"));
}

#[test]
fn trees() {
    let f = Folder::new();
    let tree = f.pse_with(&["ast", "-e", "color = -x ^ 2"], b"");
    assert!(tree.text.starts_with("assign ="), "{}", tree.text);
    assert_eq!(f.pse_with(&["ast", "-"], b"color = -x ^ 2").text, tree.text);
    f.bad(1, "ast -e (", &["<command line>:1:1"]);
}

#[test]
fn completions() {
    let f = Folder::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = f.good(&format!("completions {shell}")).text;
        assert!(script.contains("frames"), "{shell}");
        // Scripts for these shells hold the values of options; that for fish has none of arguments without a name.
        if ["bash", "zsh", "fish"].contains(&shell) {
            assert!(script.contains("donut"), "{shell}");
            assert!(script.contains("smoothstep") || shell == "fish", "{shell}");
        }
    }
    f.bad(2, "completions csh", &["bash"]);
}

#[test]
fn manual_pages() {
    let f = Folder::new();
    let page = f.good("man").text;
    assert!(page.contains(".TH pse 1") && page.contains("pse\\-run(1)"), "{page}");
    f.good("man -o pages");
    let run = String::from_utf8(f.read("pages/pse-run.1")).expect("UTF-8");
    assert!(run.contains(".TH pse-run 1") && run.contains("\\fB\\-\\-frames\\fR"), "{run}");
    assert!(f.path("pages/pse.1").exists());
    // Pages replace pages, and nothing else.
    f.good("man -o pages");
    f.write("pages/pse-run.1", "mine\n");
    f.bad(1, "man -o pages", &["pse-run.1` exists", "--force"]);
    assert_eq!(f.read("pages/pse-run.1"), b"mine\n");
    f.good("man -o pages --force");
}

/// What is known of the camera is known to `check` too.
#[test]
fn check_knows_where_the_eye_may_be() {
    let f = Folder::new();
    f.write("eye.pse", "color = direction(point - eye) - I\n");
    f.good("scene donut -o g.exr --size 8x6");
    f.write("blind.pse", "point = [pixel.x 0 0]\n");
    let told = f.good("check eye.pse --scene donut").err + &f.good("check eye.pse -i g.exr").err;
    assert!(told.is_empty(), "{told}");
    f.good("run eye.pse -i g.exr -o a.exr");
    assert!(String::from_utf8_lossy(&f.good("doc eye").out).contains("camera"));
    // A picture has no camera; a run may yet be told of one.
    f.good("run blind.pse -i g.exr --vars point -o plain.png");
    f.write("only.pse", "color = direction(point - eye)\n");
    let told = f.good("check only.pse -i plain.png --map point=R,G,B").err;
    assert!(told.contains("position of the eye") && told.contains("worldToCamera"), "{told}");
}
