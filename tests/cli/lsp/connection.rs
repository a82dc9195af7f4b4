//! How a conversation begins, ends and goes wrong.

use super::*;

#[test]
fn it_ends_as_the_protocol_says() {
    assert_eq!(Editor::new().leave(), 0);
    let mut rude = Editor::new();
    rude.say("exit", Value::Null);
    assert_eq!(rude.ended(), 1);
    // The input simply ends.
    assert_eq!(Editor::new().ended(), 1);
    let mut early = Editor::silent();
    early.say("exit", Value::Null);
    assert_eq!(early.ended(), 1);
}

#[test]
fn wrong_requests_get_the_protocols_errors() {
    let mut editor = Editor::silent();
    assert_eq!(editor.refused("textDocument/hover", place("|")).0, -32002, "before initialize");
    editor.ask("initialize", json!({"processId": null, "rootUri": null, "capabilities": {}}));
    assert_eq!(editor.refused("initialize", json!({"capabilities": {}})).0, -32600, "twice");
    assert_eq!(editor.refused("textDocument/coffee", json!({})).0, -32601, "unknown");
    assert_eq!(editor.refused("textDocument/hover", json!({"position": 7})).0, -32602, "wrong parameters");
    editor.say("textDocument/coffee", json!({"nothing": "of it"}));
    editor.say("textDocument/didChange", json!([1, 2]));
    editor.say("$/cancelRequest", json!({"id": 1}));
    assert_eq!(editor.ask("textDocument/hover", place("|")), Value::Null, "of a document that is not open");
    editor.ask("shutdown", Value::Null);
    assert_eq!(editor.refused("textDocument/hover", place("|")).0, -32600, "after shutdown");
    editor.say("exit", Value::Null);
    assert_eq!(editor.ended(), 0);
}

#[test]
fn columns_are_counted_as_agreed() {
    let text = "öä\u{1f600} = 1 # no name\ncolor = white * nois(point) # ö\n";
    let mut editor = Editor::new();
    editor.open(URI, text);
    assert_eq!(range(&editor.found(URI)[0]["range"]), "0:0-0:2");
    editor.leave();
    let mut editor = Editor::silent();
    let general = json!({"general": {"positionEncodings": ["utf-16", "utf-8"]}});
    let answer = editor.ask("initialize", json!({"processId": 1, "rootUri": null, "capabilities": general}));
    assert_eq!(answer["capabilities"]["positionEncoding"], "utf-8");
    editor.open(URI, text);
    assert_eq!(range(&editor.found(URI)[0]["range"]), "0:0-0:4");
    editor.leave();
}

#[test]
fn the_newest_text_counts() {
    let mut editor = Editor::new();
    editor.open(URI, "color = whit\n");
    for version in 2..200 {
        editor.change(URI, version, &format!("color = whit{version}\n"));
    }
    let part = json!({"range": {"start": {"line": 0, "character": 12}, "end": {"line": 0, "character": 15}}, "text": "e"});
    let more = json!({"range": {"start": {"line": 1, "character": 0}, "end": {"line": 9, "character": 9}}, "text": "# end"});
    let document = json!({"uri": URI, "version": 200});
    editor.say("textDocument/didChange", json!({"textDocument": document, "contentChanges": [part, more]}));
    while !editor.found(URI).is_empty() {}
    let symbols = editor.ask("textDocument/documentSymbol", json!({"textDocument": {"uri": URI}}));
    assert_eq!(symbols[0]["name"], "color");
    editor.leave();
}

/// What comes back for these bytes, message by message, and the exit status.
fn exchange(bytes: &[u8]) -> (Vec<Value>, Option<i32>) {
    use std::io::Write;
    let mut command = Command::new(env!("CARGO_BIN_EXE_pse"));
    let mut server = command.arg("lsp").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut to = server.stdin.take().unwrap();
    let bytes = bytes.to_vec();
    // It may answer before it has read all.
    let writer = std::thread::spawn(move || to.write_all(&bytes));
    let output = server.wait_with_output().unwrap();
    let _ = writer.join().unwrap();
    let mut rest = &output.stdout[..];
    let mut messages = Vec::new();
    while !rest.is_empty() {
        let end = rest.windows(4).position(|w| w == b"\r\n\r\n").expect("headers") + 4;
        let head = std::str::from_utf8(&rest[..end]).unwrap();
        let length: usize = head.trim().strip_prefix("Content-Length: ").expect(head).parse().unwrap();
        messages.push(serde_json::from_slice(&rest[end..end + length]).unwrap());
        rest = &rest[end + length..];
    }
    (messages, output.status.code())
}

fn framed(text: &str) -> Vec<u8> {
    format!("Content-Length: {}\r\n\r\n{text}", text.len()).into_bytes()
}

#[test]
fn any_bytes_are_survived() {
    let initialize = framed(r#"{"jsonrpc":"2.0","id":1,"method":"initialize","params":{"capabilities":{}}}"#);
    let shutdown = framed(r#"{"jsonrpc":"2.0","id":2,"method":"shutdown"}"#);
    let exit = framed(r#"{"jsonrpc":"2.0","method":"exit"}"#);
    let wrong: [&[u8]; 16] = [
        b"Content-Length: 18446744073709551615\r\n\r\n{}",
        b"Content-Length: 9223372036854775807\r\n\r\n{}",
        b"Content-Length: 99999999999999\r\n\r\n",
        b"Content-Length: 99999999999999999999999999999\r\n\r\n{}",
        b"Content-Length: -5\r\n\r\n{}",
        b"Content-Length: 0x10\r\n\r\n{}",
        b"Content-Length: 2\r\n\r\n\xff\xfe",
        b"Content-Type: text\r\n\r\n{}",
        b"\r\n\r\n\r\n",
        b"\0\0\0\0\0\0\0\0",
        b"no header\r\n",
        &framed("no JSON"),
        &framed("[]"),
        &framed(r#"{"id":{}}"#),
        &framed(&"[".repeat(100_000)),
        &framed("\"\\ud800\""),
    ];
    for bytes in wrong {
        let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(50)]).into_owned();
        let (messages, code) = exchange(&[&initialize, bytes, &shutdown, &exit].concat());
        let ids: Vec<&Value> = messages.iter().map(|message| &message["id"]).collect();
        assert!(ids.contains(&&json!(1)) && ids.contains(&&json!(2)), "{shown:?}: {messages:?}");
        let errors = messages.iter().filter(|message| message["error"]["code"].is_i64()).count();
        assert_eq!((errors, code), (1, Some(0)), "{shown:?}: {messages:?}");
    }
    // One that is cut off is the end.
    for bytes in [&b"Content-Length: 5\r\n\r\n{"[..], b"Content-Le", b"Content-Length: 5\r\n"] {
        let (messages, code) = exchange(&[&initialize, bytes].concat());
        assert_eq!((messages.len(), code), (1, Some(1)), "{bytes:?}");
    }
}
