//! The `pse` command from outside: what it prints and writes, and how it ends.

use assert_cmd::Command;
use std::fs;
use std::path::{Path, PathBuf};

mod alpha;
mod bands;
mod camera;
#[cfg(unix)]
mod examples;
mod exr;
#[cfg(unix)]
mod faults;
mod files;
mod flow;
mod formats;
mod frames;
mod habits;
mod hostile;
mod job;
mod lsp;
mod many;
mod mesh;
mod messages;
mod names;
mod noise;
mod outputs;
mod repl;
mod run;
mod samples;
mod solid;
mod textures;
mod tiles;
mod trace;
mod view;
mod words;

/// A folder of its own for a test.
struct Folder(tempfile::TempDir);

/// How a command ended.
struct Ended {
    code: i32,
    out: Vec<u8>,
    text: String,
    err: String,
}

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).expect(name);
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pse"));
        command.current_dir(self.0.path()).env_remove("PSE_SIMD").env_remove("NO_COLOR");
        command
    }

    /// Runs `pse` with arguments that are separated by blanks, in this folder.
    fn pse(&self, arguments: &str) -> Ended {
        self.pse_with(&arguments.split_whitespace().collect::<Vec<_>>(), b"")
    }

    fn pse_with(&self, arguments: &[&str], stdin: &[u8]) -> Ended {
        ended(self.command().args(arguments).write_stdin(stdin.to_vec()))
    }

    /// Runs it and expects success.
    fn good(&self, arguments: &str) -> Ended {
        let ended = self.pse(arguments);
        assert_eq!(ended.code, 0, "pse {arguments}\n{}", ended.err);
        ended
    }

    /// Runs it and expects a failure of that status, with these words in its message.
    fn bad(&self, code: i32, arguments: &str, words: &[&str]) {
        let ended = self.pse(arguments);
        assert_eq!(ended.code, code, "pse {arguments}\n{}", ended.err);
        // Long lines are wrapped, so words are looked for in the running text.
        let running = ended.err.split_whitespace().collect::<Vec<_>>().join(" ");
        for word in words {
            assert!(running.contains(word), "pse {arguments}\nno `{word}` in\n{}", ended.err);
        }
    }

    /// A variable of an image that was written.
    fn planes(&self, name: &str, variable: &str) -> Vec<Vec<f32>> {
        let image = load(&self.path(name));
        let variable = image.variable(variable).unwrap_or_else(|| panic!("{name} has no {variable}"));
        variable.planes.iter().map(|p| p.to_vec()).collect()
    }
}

fn ended(command: &mut Command) -> Ended {
    let output = command.output().expect("pse starts");
    Ended {
        code: output.status.code().unwrap_or(-1),
        text: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
        out: output.stdout,
    }
}

fn load(path: &Path) -> pse::Image<'static> {
    let input = pse::image::Input::Path(path.to_path_buf());
    let file = pse::image::read(input, &Default::default()).expect("an image");
    file.load_all().expect("its variables")
}

/// A G-buffer of a renderer, from the tests' own.
fn gbuffer(name: &str) -> String {
    format!("{}/tests/gbuffers/{name}", env!("CARGO_MANIFEST_DIR"))
}
