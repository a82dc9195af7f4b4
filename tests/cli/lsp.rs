//! `pse lsp`: a client that speaks to it as an editor does.

use lsp_server::{Message, Notification, Request, Response};
use serde_json::{Value, json};
use std::io::BufReader;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

mod connection;
mod features;
mod imports;
mod random;

/// An editor.
struct Editor {
    server: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    next: i32,
    /// What the server told last of each document, by URI.
    told: std::collections::HashMap<String, Vec<Value>>,
}

impl Editor {
    /// Starts the server and says nothing yet.
    fn silent() -> Editor {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pse"));
        let mut server = command.arg("lsp").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let (to, from) = (server.stdin.take().unwrap(), BufReader::new(server.stdout.take().unwrap()));
        Editor { server, to, from, next: 0, told: Default::default() }
    }

    /// An editor with these capabilities.
    fn with(capabilities: Value) -> Editor {
        let mut editor = Editor::silent();
        let answer = editor
            .ask("initialize", json!({"processId": null, "rootUri": null, "capabilities": capabilities}));
        assert_eq!(answer["serverInfo"]["name"], "pse");
        editor.say("initialized", json!({}));
        editor
    }

    fn new() -> Editor {
        Editor::with(json!({}))
    }

    fn send(&mut self, message: Message) {
        message.write(&mut self.to).unwrap();
    }

    fn say(&mut self, method: &str, params: Value) {
        self.send(Notification::new(method.into(), params).into());
    }

    fn read(&mut self) -> Message {
        Message::read(&mut self.from).unwrap().expect("the server is there")
    }

    /// The next message; what it tells of documents is kept.
    fn hear(&mut self) -> Option<Response> {
        match self.read() {
            Message::Response(response) => Some(response),
            Message::Notification(note) => {
                assert_eq!(note.method, "textDocument/publishDiagnostics");
                let uri = note.params["uri"].as_str().unwrap().to_string();
                self.told.insert(uri, note.params["diagnostics"].as_array().unwrap().clone());
                None
            }
            Message::Request(request) => panic!("{request:?}"),
        }
    }

    fn request(&mut self, method: &str, params: Value) -> Response {
        self.next += 1;
        let id = self.next.into();
        self.send(Request { id, method: method.into(), params }.into());
        loop {
            if let Some(response) = self.hear() {
                assert_eq!(response.id, self.next.into());
                return response;
            }
        }
    }

    /// A request that is granted.
    fn ask(&mut self, method: &str, params: Value) -> Value {
        self.request(method, params).response_result.unwrap_or_else(|e| panic!("{method}: {e:?}"))
    }

    /// A request that is refused: code and message.
    fn refused(&mut self, method: &str, params: Value) -> (i32, String) {
        let error = self.request(method, params).response_result.expect_err(method);
        (error.code, error.message)
    }

    fn open(&mut self, uri: &str, text: &str) {
        let document = json!({"uri": uri, "languageId": "pse", "version": 1, "text": text});
        self.say("textDocument/didOpen", json!({ "textDocument": document }));
    }

    /// A whole new text.
    fn change(&mut self, uri: &str, version: i32, text: &str) {
        let document = json!({"uri": uri, "version": version});
        self.say(
            "textDocument/didChange",
            json!({"textDocument": document, "contentChanges": [{"text": text}]}),
        );
    }

    /// What the server finds in a document, the next time that it tells.
    fn found(&mut self, uri: &str) -> Vec<Value> {
        self.told.remove(uri);
        loop {
            assert!(self.hear().is_none());
            if let Some(found) = self.told.get(uri) {
                return found.clone();
            }
        }
    }

    /// Asks about the place of the `|` in a text, in a document of its own.
    fn at(&mut self, method: &str, text: &str) -> Value {
        self.open(URI, &text.replacen('|', "", 1));
        self.ask(method, place(text))
    }

    /// Says good-bye; the exit status.
    fn leave(mut self) -> i32 {
        assert_eq!(self.ask("shutdown", Value::Null), Value::Null);
        self.say("exit", Value::Null);
        self.ended()
    }

    fn ended(self) -> i32 {
        let Editor { mut server, to, from, .. } = self;
        drop((to, from));
        server.wait().unwrap().code().unwrap()
    }
}

const URI: &str = "untitled:Untitled-1";

/// The place of the `|` in a text, in UTF-16.
fn position(text: &str) -> Value {
    let before = &text[..text.find('|').expect("a place")];
    let line = before.matches('\n').count();
    let column = before.rsplit('\n').next().unwrap().encode_utf16().count();
    json!({"line": line, "character": column})
}

fn place(text: &str) -> Value {
    json!({"textDocument": {"uri": URI}, "position": position(text), "context": context()})
}

/// What several requests want to know beside the place.
fn context() -> Value {
    json!({"includeDeclaration": true, "triggerKind": 1, "isRetrigger": false})
}

/// A range as `line:column-line:column`.
fn range(range: &Value) -> String {
    let place = |p: &Value| format!("{}:{}", p["line"], p["character"]);
    format!("{}-{}", place(&range["start"]), place(&range["end"]))
}
