//! `pse view` from outside, without a browser: its address, whom it answers, what it draws and when.

use serde_json::{Value, json};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

mod files;
mod requests;

/// A preview of a program in a folder of its own.
struct Preview {
    folder: TempDir,
    child: Child,
    port: u16,
    token: String,
}

impl Drop for Preview {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What pages hear.
struct Events(BufReader<TcpStream>);

impl Events {
    /// The next event of this kind.
    fn next(&mut self, kind: &str) -> Value {
        let mut name = String::new();
        loop {
            let mut line = String::new();
            assert!(self.0.read_line(&mut line).expect("an event comes in time") > 0, "the server is there");
            if let Some(event) = line.strip_prefix("event: ") {
                name = event.trim().into();
            } else if let Some(data) = line.strip_prefix("data: ").filter(|_| name == kind) {
                return serde_json::from_str(data).expect(data);
            }
        }
    }

    /// The next whole picture.
    fn picture(&mut self) -> Value {
        loop {
            let picture = self.next("picture");
            if picture["full"] == true {
                return picture;
            }
        }
    }
}

impl Preview {
    fn new(text: &str, arguments: &[&str]) -> Preview {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("p.pse"), text).unwrap();
        Preview::of(folder, arguments)
    }

    fn of(folder: TempDir, arguments: &[&str]) -> Preview {
        Preview::by(Command::new(env!("CARGO_BIN_EXE_pse")), folder, arguments)
    }

    /// A preview of a command that runs `pse` with the arguments that follow.
    fn by(mut command: Command, folder: TempDir, arguments: &[&str]) -> Preview {
        let mut child = command
            .args(["view", "p.pse", "--size", "32x24"])
            .args(arguments)
            .current_dir(folder.path())
            .env("XDG_STATE_HOME", folder.path().join("state"))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut address = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
        let rest = address.trim().strip_prefix("http://127.0.0.1:").expect(&address);
        let (port, token) = rest.split_once('/').unwrap();
        let (port, token) = (port.parse().unwrap(), token.trim_end_matches('/').to_string());
        assert_eq!(token.len(), 32);
        Preview { folder, child, port, token }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream
    }

    /// Status and body of what comes back.
    fn send(&self, request: &str) -> (u16, Vec<u8>) {
        let mut stream = self.connect();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|w| w == b"\r\n\r\n").expect("a head") + 4;
        let status = String::from_utf8_lossy(&answer[9..12]).parse().unwrap();
        (status, answer[end..].to_vec())
    }

    fn get(&self, path: &str) -> (u16, Vec<u8>) {
        let (token, port) = (&self.token, self.port);
        self.send(&format!("GET /{token}/{path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"))
    }

    fn post(&self, path: &str, body: &Value) -> (u16, String) {
        let (token, port, body) = (&self.token, self.port, body.to_string());
        let (status, body) = self.send(&format!(
            "POST /{token}/{path} HTTP/1.1\r\nHost: localhost:{port}\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        ));
        (status, String::from_utf8(body).unwrap())
    }

    fn events(&self) -> Events {
        let mut stream = self.connect();
        let (token, port) = (&self.token, self.port);
        write!(stream, "GET /{token}/events HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n").unwrap();
        Events(BufReader::new(stream))
    }

    /// The first numbers of an output: those of the top left pixel.
    fn first(&self, picture: &Value, output: &str) -> Vec<f32> {
        let (status, bytes) = self.get(&format!("picture?id={}&output={output}", picture["id"]));
        assert_eq!(status, 200);
        let told = picture["outputs"].as_array().unwrap().iter().find(|o| o["name"] == output).unwrap();
        let components = told["components"].as_u64().unwrap() as usize;
        let size = picture["coarse"][0].as_u64().unwrap() * picture["coarse"][1].as_u64().unwrap();
        assert_eq!(bytes.len(), 2 * components * size as usize);
        bytes.chunks(2).take(components).map(|b| half::f16::from_le_bytes([b[0], b[1]]).to_f32()).collect()
    }

    fn write(&self, name: &str, text: &str) {
        // As editors do.
        let other = self.folder.path().join("new");
        fs::write(&other, text).unwrap();
        fs::rename(other, self.folder.path().join(name)).unwrap();
    }
}

#[test]
fn only_its_own_page_is_answered() {
    let preview = Preview::new("color = white\n", &[]);
    let (port, token) = (preview.port, &preview.token);
    let get = |path: &str, headers: &str| preview.send(&format!("GET {path} HTTP/1.1\r\n{headers}\r\n")).0;
    let own = format!("Host: 127.0.0.1:{port}\r\n");
    assert_eq!(get(&format!("/{token}/"), &own), 200);
    assert_eq!(get("/", &own), 404);
    assert_eq!(get(&format!("/{}/", "0".repeat(32)), &own), 404);
    assert_eq!(get(&format!("/{token}/../../etc/passwd"), &own), 404);
    // A name of somebody else's that leads here, and a page of somebody else's.
    assert_eq!(get(&format!("/{token}/"), "Host: evil.example\r\n"), 403);
    assert_eq!(get(&format!("/{token}/"), ""), 403);
    assert_eq!(get(&format!("/{token}/"), &format!("{own}Origin: http://evil.example\r\n")), 403);
    assert_eq!(preview.send("nonsense\r\n\r\n").0, 400);
    let (status, why) = preview.post("save", &json!({"no": "text"}));
    assert!(status == 400 && why.contains("needs text"), "{why}");
    // It still works.
    assert_eq!(preview.get("words").0, 200);
}

#[test]
fn a_save_a_param_and_a_frame_give_new_pictures() {
    let preview = Preview::new("param grey = 0.25 in [0 1]\ncolor = white * grey + frame\n", &[]);
    let mut events = preview.events();
    let state = events.next("state");
    assert_eq!(state["saved"], true);
    let picture = events.picture();
    assert_eq!(preview.first(&picture, "color"), [0.25; 3]);
    assert_eq!(preview.post("set", &json!({"name": "grey", "value": "1/2"})).0, 200);
    let picture = events.picture();
    assert_eq!(preview.first(&picture, "color"), [0.5; 3]);
    assert_eq!(preview.post("frame", &json!({"frame": 3})).0, 200);
    let picture = events.picture();
    assert_eq!(preview.first(&picture, "color"), [3.5; 3]);
    // What was set is written into the program, and that into the file.
    assert_eq!(preview.post("write", &json!({"name": "grey"})).0, 200);
    let text = loop {
        let state = events.next("state");
        if state["saved"] == false {
            break state["text"].as_str().unwrap().to_string();
        }
    };
    assert!(text.starts_with("param grey = 1/2 in [0 1]\n"), "{text}");
    assert_eq!(preview.post("save", &json!({"text": text, "saves": 0})).0, 200);
    assert_eq!(fs::read_to_string(preview.folder.path().join("p.pse")).unwrap(), text);
    let (status, why) = preview.post("set", &json!({"name": "grey", "value": "1 +"}));
    assert!(status == 400 && why.contains("grey"), "{why}");
}

#[test]
fn all_that_a_picture_is_made_of_is_watched() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("p.pse"), "import \"lib.pse\"\ncolor = tone()\n").unwrap();
    fs::write(folder.path().join("lib.pse"), "function tone()\n    return [0.5 0 0]\n").unwrap();
    let preview = Preview::of(folder, &[]);
    let mut events = preview.events();
    let picture = events.picture();
    assert_eq!(preview.first(&picture, "color"), [0.5, 0.0, 0.0]);
    preview.write("lib.pse", "function tone()\n    return [0 0.5 0]\n");
    let picture = events.picture();
    assert_eq!(preview.first(&picture, "color"), [0.0, 0.5, 0.0]);
    // A mistake is told in the words of the command, in its place; the picture stays.
    preview.write("p.pse", "import \"lib.pse\"\ncolor = tonne()\n");
    let error = loop {
        let state = events.next("state");
        if !state["error"].is_null() {
            break state["error"].clone();
        }
    };
    assert!(error["rendered"].as_str().unwrap().contains("Did you mean `tone()`?"), "{error}");
    assert_eq!((&error["places"][0]["from"], &error["places"][0]["to"]), (&json!(25), &json!(30)));
    assert_eq!(preview.first(&picture, "color"), [0.0, 0.5, 0.0]);
    preview.write("p.pse", "color = [0 0 1]\n");
    let picture = events.picture();
    assert_eq!(preview.first(&picture, "color"), [0.0, 0.0, 1.0]);
}

#[test]
fn a_probe_is_a_trace() {
    let preview = Preview::new("t = point.x\nif surface\n    color = [t t t]\nelse\n    color = 0\n", &[]);
    preview.events().picture();
    let (status, probe) = preview.get("probe?x=16&y=4");
    assert_eq!(status, 200);
    let trace = Command::new(env!("CARGO_BIN_EXE_pse"))
        .args([
            "trace", "p.pse", "--size", "32x24", "--scene", "donut", "--pixel", "16,4", "--calls", "--json",
        ])
        .current_dir(preview.folder.path())
        .output()
        .unwrap();
    assert_eq!(String::from_utf8_lossy(&probe), String::from_utf8_lossy(&trace.stdout));
    assert_eq!(preview.get("probe?x=32&y=0").0, 404);
}

#[test]
fn a_change_elsewhere_is_not_replaced_unasked() {
    let preview = Preview::new("color = [1 0 0]\n", &[]);
    let mut events = preview.events();
    events.picture();
    preview.post("text", &json!({"text": "color = [0 1 0]\n", "saves": 0}));
    events.picture();
    preview.write("p.pse", "color = [0 0 1]\n");
    let state = loop {
        let state = events.next("state");
        if state["conflict"] == true {
            break state;
        }
    };
    assert_eq!(state["text"], "color = [0 1 0]\n");
    let (status, why) = preview.post("save", &json!({"text": "color = [0 1 0]\n", "saves": 0}));
    assert!(status == 400 && why.contains("changed by another program"), "{why}");
    assert_eq!(fs::read_to_string(preview.folder.path().join("p.pse")).unwrap(), "color = [0 0 1]\n");
    assert_eq!(preview.post("save", &json!({"text": "color = [0 1 0]\n", "saves": state["saves"]})).0, 200);
    assert_eq!(fs::read_to_string(preview.folder.path().join("p.pse")).unwrap(), "color = [0 1 0]\n");
}

#[test]
fn a_program_that_does_not_exist_yet() {
    let preview = Preview::of(tempfile::tempdir().unwrap(), &[]);
    let mut events = preview.events();
    assert_eq!(events.next("state")["saved"], false);
    preview.post("text", &json!({"text": "color = [1 0 0]\n", "saves": 0}));
    let picture = events.picture();
    assert_eq!(preview.first(&picture, "color"), [1.0, 0.0, 0.0]);
    assert_eq!(preview.post("save", &json!({"text": "color = [1 0 0]\n", "saves": 0})).0, 200);
    assert_eq!(fs::read_to_string(preview.folder.path().join("p.pse")).unwrap(), "color = [1 0 0]\n");
}
