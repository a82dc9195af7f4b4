//! `pse repl`: piped, and at a pseudo-terminal.

use assert_cmd::Command;
use std::path::Path;

/// What comes of these lines: standard output, standard error, and whether it ended well.
fn piped(arguments: &[&str], lines: &str) -> (String, String, bool) {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_pse"));
    command.current_dir(folder.path()).env("PSE_HISTORY", "").args(["repl", "--size", "64x48"]);
    let output = command.args(arguments).write_stdin(lines).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.success())
}

fn good(lines: &str) -> String {
    let (out, err, good) = piped(&[], lines);
    assert!(good, "{err}");
    assert!(!out.contains('\x1b') && !out.contains("pse>"), "no prompts, no colours: {out}");
    out
}

#[test]
fn expressions_are_told_here_and_over_the_image() {
    assert_eq!(good("1 + 2\n[1 2] * 3\n"), "3\n[3 6]\n");
    assert_eq!(
        good(":pixel 10 20\npixel\n"),
        "[10.5 20.5]  at [10 20]\nmin [0.5 0.5]   mean [32 24]   max [63.5 47.5]\n"
    );
    let out = good("surface > 0 ? 1 : 0/0\n");
    assert!(out.contains("NaN or infinity at ") && out.contains("min 1   mean 1   max 1"), "{out}");
}

#[test]
fn statements_build_up_a_program() {
    let out = good(
        "a = 2\nfunction twice(x)\n    return 2 * x\n\ntwice(a)\nif a > 1\n    b = 1\n    b = twice(a)\nelse\n    b = 0\nb\n\
         function twice(x)\n    return 20 * x\ntwice(a) + b\n:list\n:undo\n:clear\n:list\n",
    );
    let expected = "4\n4\n80\n1  a = 2\n2  function twice(x)\n3      return 20 * x\n4  if a > 1\n5      b = 1\n\
                    6      b = twice(a)\n7  else\n8      b = 0\n";
    // `b` follows the new definition, as the program does when it is run.
    assert_eq!(out, expected);
}

#[test]
fn errors_leave_the_session_as_it_was() {
    let (out, err, good) =
        piped(&[], "a = 1\na = wite\nv = [1 2]\nb = v[3]\n(1 +\n)\na + size(v)\n:bogus\n:pixel 900 1\n");
    assert!(!good);
    assert_eq!(out, "3\n");
    for text in ["wite", "no element 3", "there is no command :bogus", "from [0 0] to [63 47]"] {
        assert!(err.contains(text), "{text}: {err}");
    }
}

#[test]
fn commands() {
    let out = good("param k = 3\nc = k * 2\n:set k 5\nc\n:vars\n:doc Noise\n:help\n:show c\n1\n:quit\n2\n");
    for text in ["10\n", "point ", "c            10", "Noise(p", ":pixel [COLUMN ROW]"] {
        assert!(out.contains(text), "{text}: {out}");
    }
    assert!(out.ends_with("1\n"), "nothing after :quit: {out}");
}

#[test]
fn what_is_set_does_not_stand_in_the_way() {
    let lines = "param veins = 4\n:set veins 7\nveins\n:clear\n1+1\nparam veins = 3\nveins\n";
    assert_eq!(good(lines), "7\n2\n3\n");
    let (out, err, ok) = piped(&[], ":set veins 7\n:set veins [1\n2+2\n:save\n:save x.pse\n");
    assert!(!ok && out == "4\n", "{out}");
    assert!(err.contains("no param `veins`") && err.contains("the program is empty"), "{err}");
    assert!(!err.contains("it ="), "{err}");
    let camera = ["--space", "object=translation([0 0 frame])", "--frame", "3"];
    assert_eq!(piped(&camera, "transform(\"object\", [0 0 0])\n").0, "[0 0 3]\n");
}

#[test]
fn programs_are_loaded_and_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("a.pse"), "s = 3\ncolor = [s s s]\n").unwrap();
    let (out, err, ok) =
        piped(&[&path("a.pse")], &format!("s\n:save {}\n:load {}\ns + 1\n", path("b.pse"), path("b.pse")));
    assert!(ok, "{err}");
    assert_eq!(out, "3\n4\n");
    assert_eq!(std::fs::read_to_string(path("b.pse")).unwrap(), "s = 3\ncolor = [s s s]\n");
}

/// At a terminal: prompts, blocks with their indentation, completion, an interrupt that ends a run and not the session,
/// a history that the next session has.
#[cfg(target_os = "linux")]
#[test]
fn at_a_terminal() {
    use rexpect::session::{PtySession, spawn_command};
    let folder = tempfile::tempdir().unwrap();
    let begin = |folder: &Path| -> PtySession {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_pse"));
        command.args(["repl", "--size", "64x48"]).env("PSE_HISTORY", folder.join("history"));
        command.env("NO_COLOR", "1").env("TERM", "xterm");
        spawn_command(command, Some(20_000)).unwrap()
    };
    let mut session = begin(folder.path());
    session.exp_string("64 x 48 pixels").unwrap();
    session.exp_string("pse> ").unwrap();
    session.send_line("function half(x)").unwrap();
    session.exp_string("...  ").unwrap();
    session.send_line("return x / 2").unwrap();
    session.exp_string("...  ").unwrap();
    session.send_line("").unwrap();
    session.exp_string("pse> ").unwrap();
    session.send_line("half(90)").unwrap();
    session.exp_regex("\r\n45\r\n").unwrap();
    session.send("smootherst\t").unwrap();
    session.flush().unwrap();
    session.exp_string("smootherstep(").unwrap();
    session.send_line("0, 2, 1)").unwrap();
    session.exp_regex("\r\n0.5\r\n").unwrap();
    let slow = folder.path().join("slow.pse");
    std::fs::write(
        &slow,
        "function slow(x)\n    i = 0\n    while i < 90000\n        i += 1 + 0 * Noise(i * x)\n    return i\n\
         function half(x)\n    return x / 2\n",
    )
    .unwrap();
    session.exp_string("pse> ").unwrap();
    session.send_line(&format!(":load {}", slow.display())).unwrap();
    session.exp_string("pse> ").unwrap();
    session.send_line("slow(point) + 12345").unwrap();
    session.exp_string("12345").unwrap();
    std::thread::sleep(std::time::Duration::from_millis(500));
    session.send_control('c').unwrap();
    session.exp_string("cancelled").unwrap();
    session.exp_string("pse> ").unwrap();
    session.send_line("half(8)").unwrap();
    session.exp_regex("\r\n4\r\n").unwrap();
    session.exp_string("pse> ").unwrap();
    session.send_line(":quit").unwrap();
    session.exp_eof().unwrap();
    let mut session = begin(folder.path());
    session.exp_string("pse> ").unwrap();
    // Up, twice: the line before the last.
    session.send("\x1b[A\x1b[A").unwrap();
    session.flush().unwrap();
    session.exp_string("half(8)").unwrap();
    session.send_control('c').unwrap();
    session.exp_string("pse> ").unwrap();
    session.send_control('d').unwrap();
    session.exp_eof().unwrap();
}

#[test]
fn print_tells_what_is_new() {
    let out = good(
        "a = 3\nprint(\"a\", a)\nb = a\nprint(b)\nb\nfunction f(x)\n    print(\"in f\", x)\n    return x\n\nf(2) + f(3)\n\
         for i in [1 .. 12]\n    print(i)\n\nc = f(5)\n:doc print\n",
    );
    let count: String = (1..=10).map(|i| format!("{i}\n")).collect();
    let expected = format!("a 3\n3\n3\nin f 2\nin f 3\n5\n{count}… 2 more lines\nin f 5\nprint(e, …)\n");
    assert!(out.starts_with(&expected), "{out}");
}
