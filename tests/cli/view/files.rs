//! What happens to the program's file while a page has text of its own, and what is seen of files behind links.
#![cfg(unix)]

use super::*;
use std::os::unix::fs::symlink;
use std::path::Path;

const OURS: &str = "color = [0 1 0]\n";

/// A page with a text that is not saved, and then something happens to the file. The save is refused, and what is there
/// stays; the page's text is still there.
fn refused(what: &str, change: impl FnOnce(&Path)) -> (Preview, Events, Value) {
    let preview = Preview::new("color = [1 0 0]\n", &[]);
    let mut events = preview.events();
    events.picture();
    assert_eq!(preview.post("text", &json!({"text": OURS, "saves": 0})).0, 200);
    change(&preview.folder.path().join("p.pse"));
    let (status, why) = preview.post("save", &json!({"text": OURS, "saves": 0}));
    assert_eq!(status, 400, "{what}");
    assert!(why.contains("another program"), "{what}: {why}");
    let mut again = preview.events();
    let state = again.next("state");
    assert_eq!((&state["conflict"], &state["saved"]), (&json!(true), &json!(false)), "{what}");
    assert_eq!(state["text"], OURS, "{what}");
    (preview, events, state)
}

#[test]
fn whatever_becomes_of_the_file_is_not_replaced_unasked() {
    let latin = b"color = [0 0 1] # caf\xe9\n";
    let (preview, _, state) = refused("not UTF-8", |path| fs::write(path, latin).unwrap());
    let path = preview.folder.path().join("p.pse");
    assert_eq!(fs::read(&path).unwrap(), latin);
    // There is no text to take, but the user may say that it is to be replaced.
    assert_eq!(preview.post("take", &json!({})).0, 400);
    let (status, why) = preview.post("save", &json!({"text": OURS, "saves": state["saves"]}));
    assert_eq!((status, fs::read_to_string(&path).unwrap().as_str()), (200, OURS), "{why}");

    // Changed once more after it was seen, with the same length.
    let (preview, _, state) = refused("not UTF-8, twice", |path| fs::write(path, latin).unwrap());
    let path = preview.folder.path().join("p.pse");
    std::thread::sleep(Duration::from_millis(50));
    fs::write(&path, b"color = [1 1 1] # caf\xe9\n").unwrap();
    assert_eq!(preview.post("save", &json!({"text": OURS, "saves": state["saves"]})).0, 400);

    let (preview, _, state) = refused("removed", |path| fs::remove_file(path).unwrap());
    let path = preview.folder.path().join("p.pse");
    assert!(!path.exists());
    assert_eq!(preview.post("save", &json!({"text": OURS, "saves": state["saves"]})).0, 200);
    assert_eq!(fs::read_to_string(&path).unwrap(), OURS);

    for (what, change) in [
        (
            "too long",
            Box::new(|path: &Path| fs::File::create(path).unwrap().set_len(17 << 20).unwrap())
                as Box<dyn Fn(&Path)>,
        ),
        ("empty", Box::new(|path: &Path| fs::write(path, "").unwrap())),
        (
            "another text of the same length",
            Box::new(|path: &Path| fs::write(path, "color = [0 0 1]\n").unwrap()),
        ),
    ] {
        let mut before = Vec::new();
        let (preview, ..) = refused(what, |path| {
            change(path);
            before = fs::read(path).unwrap();
        });
        assert!(fs::read(preview.folder.path().join("p.pse")).unwrap() == before, "{what}");
    }
}

#[test]
fn what_is_no_file_is_never_written_to() {
    let replace = |path: &Path, make: &dyn Fn(&Path)| {
        fs::remove_file(path).unwrap();
        make(path);
    };
    let fifo = |path: &Path| assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
    type Replacement<'r> = &'r dyn Fn(&Path);
    let cases: [(&str, Replacement<'_>); 5] = [
        ("a folder", &|path| fs::create_dir(path).unwrap()),
        ("a pipe", &fifo),
        ("an endless device", &|path| symlink("/dev/zero", path).unwrap()),
        ("a device that takes all", &|path| symlink("/dev/null", path).unwrap()),
        ("a link to itself", &|path| symlink("p.pse", path).unwrap()),
    ];
    for (what, make) in cases {
        let (preview, _, state) = refused(what, |path| replace(path, make));
        let path = preview.folder.path().join("p.pse");
        let kind = fs::symlink_metadata(&path).unwrap().file_type();
        // Not even if the page knows of it.
        assert_eq!(preview.post("save", &json!({"text": OURS, "saves": state["saves"]})).0, 400, "{what}");
        assert_eq!(fs::symlink_metadata(&path).unwrap().file_type(), kind, "{what}");
        // It goes on, and saves when there is a place for the file again.
        if kind.is_dir() {
            fs::remove_dir(&path).unwrap()
        } else {
            fs::remove_file(&path).unwrap()
        }
        let (_, why) = preview.post("save", &json!({"text": OURS, "saves": state["saves"]}));
        assert!(why.contains("removed"), "{what}: {why}");
        let saves = preview.events().next("state")["saves"].clone();
        assert_eq!(preview.post("save", &json!({"text": OURS, "saves": saves})).0, 200, "{what}");
        assert_eq!(fs::read_to_string(&path).unwrap(), OURS);
    }
}

#[test]
fn a_program_that_is_no_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let fifo = folder.path().join("fifo.pse");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    for path in [fifo.as_path(), Path::new("/dev/zero"), folder.path()] {
        let output = Command::new("timeout")
            .args(["20", env!("CARGO_BIN_EXE_pse"), "view"])
            .arg(path)
            .env("XDG_STATE_HOME", folder.path().join("state"))
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(1), "{}: {output:?}", path.display());
    }
}

#[test]
fn text_for_a_new_file_survives_one_that_appears() {
    let preview = Preview::of(tempfile::tempdir().unwrap(), &[]);
    let mut events = preview.events();
    events.next("state");
    preview.post("text", &json!({"text": OURS, "saves": 0}));
    events.picture();
    preview.write("p.pse", "color = [0 0 1]\n");
    let state = loop {
        let state = events.next("state");
        if state["conflict"] == true {
            break state;
        }
    };
    assert_eq!(state["text"], OURS);
    assert_eq!(preview.post("save", &json!({"text": OURS, "saves": 0})).0, 400);
}

#[test]
fn changes_behind_links_are_seen() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("far/away")).unwrap();
    fs::create_dir_all(at("other")).unwrap();
    fs::write(at("far/away/p.pse"), "import \"lib/tone.pse\"\ncolor = tone()\n").unwrap();
    let tone = |x: f32| format!("function tone()\n    return [{x} 0 0]\n");
    fs::write(at("far/tone.pse"), tone(0.5)).unwrap();
    fs::write(at("other/tone.pse"), tone(0.125)).unwrap();
    symlink("far/away/p.pse", at("step.pse")).unwrap();
    symlink("step.pse", at("p.pse")).unwrap();
    symlink("far", at("lib")).unwrap();
    let preview = Preview::of(folder, &["--path", "far", "--path", "other"]);
    let at = |name: &str| preview.folder.path().join(name);
    let mut events = preview.events();
    let mut red = || preview.first(&events.picture(), "color")[0];
    assert_eq!(red(), 0.5);
    // The import lies behind a link to a folder.
    preview.write("far/tone.pse", &tone(0.25));
    assert_eq!(red(), 0.25);
    // That link leads elsewhere.
    fs::remove_file(at("lib")).unwrap();
    symlink("other", at("lib")).unwrap();
    while red() != 0.125 {}
    preview.write("other/tone.pse", &tone(0.75));
    while red() != 0.75 {}
    // The program's own file lies behind two.
    preview.write("far/away/p.pse", "color = [1 0 0]\n");
    while red() != 1.0 {}
    fs::write(at("other/q.pse"), "color = [2 0 0]\n").unwrap();
    fs::remove_file(at("step.pse")).unwrap();
    symlink("other/q.pse", at("step.pse")).unwrap();
    while red() != 2.0 {}
    preview.write("other/q.pse", "color = [3 0 0]\n");
    while red() != 3.0 {}
    // A save goes through the links.
    let saves = preview.events().next("state")["saves"].clone();
    assert_eq!(preview.post("save", &json!({"text": OURS, "saves": saves})).0, 200);
    assert_eq!(fs::read_to_string(at("other/q.pse")).unwrap(), OURS);
    assert!(fs::symlink_metadata(at("p.pse")).unwrap().file_type().is_symlink());
}

#[test]
fn a_picture_from_a_pipe_is_read_once_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("p.pse"), "c = point\ncolor = [0.5 0 0]\n").unwrap();
    let scene = Command::new(env!("CARGO_BIN_EXE_pse"))
        .args(["scene", "card", "-q", "--size", "8x8", "-o", "g.exr"])
        .current_dir(folder.path())
        .status();
    assert!(scene.unwrap().success());
    let mut shell = Command::new("sh");
    let line = "mkfifo p.exr; cat g.exr > p.exr & exec \"$0\" view p.pse -i p.exr";
    shell.args(["-c", line, env!("CARGO_BIN_EXE_pse")]);
    let preview = Preview::by(shell, folder, &[]);
    let mut events = preview.events();
    assert_eq!(preview.first(&events.picture(), "color")[0], 0.5);
    // A program that reads more of it.
    preview.write("p.pse", "color = [1 0 0] * (1 + 0 * normal.x + 0 * uv.x)\n");
    assert_eq!(preview.first(&events.picture(), "color")[0], 1.0);
}
