//! Whatever goes wrong around a run: no panic, no half of a file under the final name, no input harmed, no more memory
//! than allowed, and a message that says what happened. What is measured of it is in docs/reliability.md.

use super::{Ended, Folder};
use std::fs;
use std::ops::Deref;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

mod files;
mod memory;
mod named;

/// A folder in which lines of the shell run.
struct Shell(Folder);

impl Deref for Shell {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Shell {
    fn new() -> Shell {
        Shell(Folder::new())
    }

    /// The names of all files, sorted.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.0.path()).expect("a folder");
        let mut names: Vec<String> =
            entries.map(|e| e.expect("a file").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Runs a line of the shell, in which `pse` is the command.
    fn run(&self, line: &str) -> Ended {
        let line = format!("pse() {{ \"$PSE\" \"$@\"; }}\n{line}");
        let mut command = Command::new("sh");
        command.args(["-c", &line]).current_dir(self.0.0.path()).env("PSE", env!("CARGO_BIN_EXE_pse"));
        let output = command.stdin(Stdio::null()).output().expect("a shell");
        let err = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(!err.contains("panicked") && !err.contains("internal error"), "{line}\n{err}");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        Ended { code: output.status.code().unwrap_or(-1), out: output.stdout, text, err }
    }

    fn good(&self, line: &str) -> Ended {
        let ended = self.run(line);
        assert_eq!(ended.code, 0, "{line}\n{}", ended.err);
        ended
    }

    /// Expects a failure that says these words, and that no file comes or goes.
    fn bad(&self, line: &str, words: &[&str]) {
        let before = self.names();
        let ended = self.run(line);
        assert_eq!(ended.code, 1, "{line}\n{}", ended.err);
        for word in words {
            assert!(ended.err.contains(word), "{line}\nno `{word}` in\n{}", ended.err);
        }
        assert_eq!(self.names(), before, "{line}: files have come or gone");
    }

    /// Starts the command itself, so that signals reach it.
    fn start(&self, arguments: &str, stdin: Stdio) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pse"));
        command.args(arguments.split_whitespace()).current_dir(self.0.0.path()).stdin(stdin);
        // Whoever started the tests in the background may have had interrupts ignored, which children inherit.
        let listen = || {
            use nix::sys::signal::{SigHandler, Signal, signal};
            // SAFETY: the default action is no handler that could run at a wrong moment.
            unsafe { signal(Signal::SIGINT, SigHandler::SigDfl) }.map(drop).map_err(Into::into)
        };
        // SAFETY: it calls the system alone, which is allowed between fork and exec.
        unsafe { command.pre_exec(listen) };
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("pse starts")
    }

    /// Waits until an unfinished output is there.
    fn wait_for_output(&self) {
        let begun = Instant::now();
        while !self.names().iter().any(|name| name.starts_with(".pse-")) {
            assert!(begun.elapsed().as_secs() < 120, "the output has not begun");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Sends a signal.
fn signal(child: &Child, name: &str) {
    let line = format!("kill -{name} {}", child.id());
    assert!(Command::new("sh").args(["-c", &line]).status().expect("a shell").success());
}

/// A generator of numbers, always the same ones.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % n.max(1)
    }
}

/// A program that takes its time.
const SLOW: &str = "i = 0\nwhile i < 60\n    i += 1 + 0 * Noise(i * point)\ncolor = white * i * point\n";

#[test]
fn killed_at_any_moment() {
    let f = Shell::new();
    f.write("p.pse", "color = white * Noise(8 * point) + 0 * fractalsum(point)\nalpha = surface\n");
    f.good("pse scene donut -q -o g.exr --size 500x1200");
    let outputs = ["a.exr", "a.png"];
    let arguments = "run p.pse -q -i g.exr -o a.exr -o a.png";
    let begun = Instant::now();
    f.good(&format!("pse {arguments}"));
    let whole = begun.elapsed();
    let (input, expected) = (f.read("g.exr"), outputs.map(|o| f.read(o)));
    let (mut random, mut killed) = (Random(1), 0);
    for round in 0..50 {
        outputs.iter().for_each(|o| f.write(o, "old"));
        let mut child = f.start(arguments, Stdio::null());
        std::thread::sleep(whole * random.below(1000) as u32 / 1000);
        child.kill().expect("it can be killed");
        let killed_now = !child.wait().expect("it ends").success();
        killed += usize::from(killed_now);
        for (output, expected) in outputs.iter().zip(&expected) {
            let found = f.read(output);
            assert!(found == *b"old" || found == *expected, "round {round}: half of {output}");
            assert!(killed_now || found == *expected, "round {round}: {output} is not written");
        }
        assert!(f.read("g.exr") == input, "round {round}: the input is harmed");
        // What stays of a killed run is told by its name.
        let rest = |name: &String| name.starts_with(".pse-") && name.ends_with(".tmp");
        f.names()
            .iter()
            .filter(|name| rest(name))
            .for_each(|name| fs::remove_file(f.path(name)).expect(name));
        assert_eq!(f.names(), ["a.exr", "a.png", "g.exr", "p.pse"]);
    }
    assert!(killed >= 10, "{killed} of 50 were killed before their end");
}

#[test]
fn signals_clean_up() {
    let f = Shell::new();
    f.write("slow.pse", SLOW);
    for name in ["INT", "TERM", "HUP"] {
        let mut child = f.start("run slow.pse --size 1000x3000 -o out.exr", Stdio::null());
        f.wait_for_output();
        signal(&child, name);
        assert_eq!(child.wait().expect("it ends").code(), Some(130), "{name}");
        assert_eq!(f.names(), ["slow.pse"], "{name}: nothing is left behind");
    }
    // Where standard input does not end, nothing is there to clean up, and the first signal is enough.
    let mut child = f.start("run slow.pse -i - -o out.exr", Stdio::piped());
    std::thread::sleep(Duration::from_millis(300));
    signal(&child, "INT");
    let begun = Instant::now();
    while child.try_wait().expect("a state").is_none() {
        assert!(begun.elapsed().as_secs() < 20, "it waits for standard input");
        std::thread::sleep(Duration::from_millis(10));
    }
    assert_eq!(f.names(), ["slow.pse"]);
}

#[test]
fn a_full_disk() {
    let f = Shell::new();
    f.write("p.pse", "color = white * Noise(99 * point)\n");
    for output in ["a.exr", "a.png", "a.tif", "a.hdr", "a.bmp", "a.webp"] {
        f.write(output, "old");
        let limited = format!("ulimit -f 20; pse run -q p.pse --size 700x600 -o {output}");
        f.bad(&limited, &[&format!("cannot write `{output}`"), "exceed the file size limit"]);
        assert_eq!(f.read(output), b"old");
    }
    f.bad(
        "ulimit -f 20; pse scene donut -q --size 700x600 -o b.exr",
        &["cannot write `b.exr`", "exceed the file size limit"],
    );
    f.write("out", "");
    f.bad("ulimit -f 20; pse run -q p.pse --size 700x600 -o - > out", &["cannot write `standard output`"]);
    f.good("pse run -q p.pse --size 700x600 -o t.exr");
    f.write("t.pse", "color = texture(\"t.exr\", uv)\n");
    let tiles = "pse run -q t.pse --size 9x9 -o c.exr --texture-memory 0";
    f.bad(&format!("export TMPDIR=.; ulimit -f 20; {tiles}"), &["temporary file for textures", "TMPDIR"]);
    if Path::new("/dev/full").exists() {
        f.bad("pse run -q p.pse --size 9x9 -o - > /dev/full", &["`standard output`", "the disk is full"]);
        f.good("ln -s /dev/full full.exr; ln -s /dev/full full.png");
        for output in ["full.exr", "full.png"] {
            let line = format!("pse run -q p.pse --size 9x9 -o {output}");
            f.bad(&line, &[&format!("cannot write `{output}`: the disk is full")]);
        }
    }
}

#[test]
fn targets_that_cannot_be_written() {
    let f = Shell::new();
    f.write("kept.exr", "old");
    f.write("kept.png", "old");
    f.good("chmod 444 kept.exr kept.png; mkdir closed open.exr; chmod 555 closed");
    for line in ["pse run -e white --size 4x4 -o kept.exr", "pse scene card --size 4x4 -o kept.exr"] {
        f.bad(line, &["cannot write `kept.exr`: the file is write-protected", "chmod u+w"]);
    }
    f.good("printf 'a=1' > p.pse; chmod 444 p.pse");
    f.bad("pse fmt p.pse", &["cannot write `p.pse`: the file is write-protected"]);
    f.bad("pse run -e white --size 4x4 -o ok.png -o kept.png", &["cannot write `kept.png`"]);
    assert_eq!(f.read("kept.exr"), b"old");
    f.bad("pse run -e white --size 4x4 -o open.exr", &["it is a directory"]);
    f.bad("pse run -e white --size 4x4 -o none/a.exr", &["there is no directory `none`", "mkdir -p"]);
    // Who may do everything may write there too.
    match fs::write(f.path("closed/probe"), "") {
        Err(_) => {
            f.bad("pse run -e white --size 4x4 -o closed/a.exr", &["`closed/a.exr`: permission denied"])
        }
        Ok(()) => drop(f.good("rm closed/probe; pse run -q -e white --size 4x4 -o closed/a.exr")),
    }
    f.good("chmod 755 closed; pse run -q -e white --size 4x4 -o g.exr; chmod 000 g.exr");
    if fs::read(f.path("g.exr")).is_err() {
        f.bad("pse run -e color -i g.exr -o a.exr", &["cannot read `g.exr`: permission denied"]);
    }
    f.bad("pse run -e color -i closed -o a.exr", &["cannot read `closed`: it is a directory"]);
    f.bad("pse run -e color -i - -o a.exr <&-", &["standard input"]);
}

#[test]
fn a_closed_pipe() {
    let f = Shell::new();
    let ended =
        f.good("{ pse run -q -e 'white * Noise(9 * point)' -o - --size 900x700; echo $? > code; } | true");
    assert_eq!((f.read("code"), ended.err.as_str()), (b"0\n".to_vec(), ""));
}

#[test]
fn an_input_that_changes_while_it_is_read() {
    let f = Shell::new();
    f.write("point.pse", SLOW);
    f.write("color.pse", SLOW.replace("point", "color"));
    f.good("pse scene donut -q -o g.exr --size 512x6000");
    f.good("pse run -q -e 'white * Noise(pixel)' -o g.png --size 512x6000");
    for (name, program) in [("g.exr", "point"), ("g.png", "color")] {
        let whole = f.read(name);
        let mut other = whole.clone();
        other.iter_mut().skip(5000).for_each(|byte| *byte ^= 0x55);
        for bytes in [&whole[..whole.len() / 2], &other] {
            let child = f.start(&format!("run {program}.pse -i {name} -o a.exr"), Stdio::null());
            f.wait_for_output();
            f.write(name, bytes);
            let output = child.wait_with_output().expect("it ends");
            let err = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(1), "{name}: {err}");
            assert!(err.contains("changed while it was read"), "{name}: {err}");
            assert!(
                !f.names().iter().any(|n| n.starts_with(".pse-") || n == "a.exr"),
                "{name}: {:?}",
                f.names()
            );
            f.write(name, &whole);
        }
    }
}

#[test]
fn a_program_reads_nothing_that_it_was_not_given() {
    let f = Shell::new();
    f.good("mkdir -p a/lib b");
    f.write("secret.pse", "function secret(p)\n    return 7\n");
    f.write("b/lib.pse", "function twice(p)\n    return 2 * p\n");
    f.write("a/lib/inner.pse", "import \"../climb.pse\"\n");
    f.write("a/climb.pse", "function climb(p)\n    return p\n");
    let run = "pse run -q a/p.pse --size 4x4 -o o.exr";
    let import = |path: &str| f.write("a/p.pse", format!("import \"{path}\"\ncolor = white\n"));
    let absolute = f.path("secret.pse").display().to_string();
    for path in ["../secret.pse", "lib/../../secret.pse", &absolute, "/etc/hostname", "lib/inner.pse"] {
        import(path);
        let words = &["cannot import", "outside the folders that this program may read", "`--path`"];
        f.bad(run, words);
        f.bad("pse check a/p.pse", words);
    }
    for (path, more) in [
        ("lib/../climb.pse", ""),
        ("lib.pse", "--path b"),
        ("../b/lib.pse", "--path b"),
        ("lib/inner.pse", "--path a"),
        (&absolute, "--path ."),
    ] {
        import(path);
        f.good(&format!("{run} {more}"));
    }
    // An endless file is read no further than a program may be long.
    if Path::new("/dev/zero").exists() {
        f.good("ln -s /dev/zero a/endless.pse");
        import("endless.pse");
        f.bad(&format!("ulimit -v 2000000; {run}"), &["links lead to `/dev/zero`"]);
        f.bad(&format!("ulimit -v 2000000; {run} --path /dev"), &["it is a device"]);
        f.bad("ulimit -v 2000000; pse check a/endless.pse", &["longer than 16 MiB"]);
        f.bad("ulimit -v 2000000; pse check - < /dev/zero", &["longer than 16 MiB"]);
    }
}

/// Waits until a process has ended.
fn wait_for(child: &mut Child, seconds: u64) -> Option<i32> {
    let begun = Instant::now();
    while begun.elapsed().as_secs() < seconds {
        if let Some(status) = child.try_wait().expect("a state") {
            return Some(status.code().unwrap_or(-1));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let _ = child.kill();
    None
}

#[test]
fn one_request_ends_what_waits_for_nobody() {
    let f = Shell::new();
    f.good("mkfifo unread.exr empty.exr");
    for (name, arguments) in [
        ("TERM", "run -e white --size 64x64 -o unread.exr"),
        ("HUP", "scene card --size 64x64 -o unread.exr"),
        ("INT", "noise value --size 64 -o unread.exr"),
        ("TERM", "run -e color -i empty.exr -o a.exr"),
    ] {
        let mut child = f.start(arguments, Stdio::null());
        std::thread::sleep(Duration::from_millis(700));
        assert!(child.try_wait().expect("a state").is_none(), "{arguments} does not wait");
        signal(&child, name);
        // Two seconds, and what a busy machine adds.
        assert_eq!(wait_for(&mut child, 20), Some(130), "pse {arguments}");
        assert_eq!(f.names(), ["empty.exr", "unread.exr"], "pse {arguments}");
    }
}

#[test]
fn requests_at_any_moment_leave_nothing() {
    let f = Shell::new();
    let long: String = (0..3000).map(|i| format!("a{i}   =  {i}\n")).collect();
    f.write("p.pse", "color = white\n");
    f.write("t.pse", "color = texture(\"t.exr\", 0, 0, channel = \"point\")\n");
    f.write("long.pse", &long);
    f.good("pse scene card --size 900x900 -o t.exr -q");
    f.good("cp long.pse other.pse; pse fmt other.pse");
    let formatted = f.read("other.pse");
    let (mut random, mut ended_early) = (Random(7), 0);
    for round in 0..48 {
        let name = ["TERM", "HUP", "INT"][round % 3];
        let arguments = [
            "noise value --size 64 -q -o n.png",
            "job t.pse -o j -q",
            "fmt long.pse",
            "run t.pse --size 400x400 -q -o r.exr",
        ][round / 3 % 4];
        f.write("long.pse", &long);
        let mut child = f.start(arguments, Stdio::null());
        std::thread::sleep(Duration::from_micros(random.below(60_000) as u64));
        signal(&child, name);
        let code = wait_for(&mut child, 60);
        ended_early += usize::from(code != Some(0));
        // Before it listens, a signal ends it as any process.
        assert!(matches!(code, Some(0 | 130 | -1)), "{name} pse {arguments}: {code:?}");
        let left: Vec<String> = f.names().into_iter().filter(|name| name.starts_with(".pse-")).collect();
        assert!(left.is_empty(), "{name} pse {arguments}: {left:?}");
        let text = f.read("long.pse");
        assert!(text == long.as_bytes() || text == formatted, "{name}: half of a program");
        if f.path("j").exists() {
            assert!(!f.path("j/.pse-staged").exists(), "{name} pse {arguments}");
            assert!(f.path("j/template.json").exists() && f.path("j/program/t.exr").exists(), "{name}");
        }
    }
    assert!(ended_early >= 8, "{ended_early} of 48 were ended before their end");
}

#[test]
fn signals_that_were_ignored_stay_ignored() {
    let f = Shell::new();
    f.write("slow.pse", SLOW);
    let mut command = Command::new("sh");
    let line = "trap '' HUP; exec \"$PSE\" run slow.pse --size 300x300 -q -o out.exr";
    command.args(["-c", line]).current_dir(f.0.0.path()).env("PSE", env!("CARGO_BIN_EXE_pse"));
    let mut child = command.stdin(Stdio::null()).spawn().expect("a shell");
    f.wait_for_output();
    signal(&child, "HUP");
    assert!(child.wait().expect("it ends").success());
    assert_eq!(f.names(), ["out.exr", "slow.pse"]);
}
