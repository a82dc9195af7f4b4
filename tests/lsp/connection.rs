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
