//! Documents that import each other, open or on disk.

use super::*;
use std::fs;
use std::path::Path;

fn uri(path: &Path) -> String {
    format!("file://{}", path.display())
}

#[test]
fn open_documents_win_over_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let (main, stone) = (folder.path().join("main.pse"), folder.path().join("stone.pse"));
    let text = "import \"stone.pse\"\ncolor = stone(veins)\n";
    fs::write(&main, text).unwrap();
    fs::write(&stone, "param veins = 3\nfunction stone(x)\n    return x * \n").unwrap();
    let mut editor = Editor::new();
    editor.open(&uri(&main), text);
    // The mistake is told of the file that it is in.
    let found = editor.found(&uri(&stone));
    assert_eq!(range(&found[0]["range"]), "2:13-2:14");
    assert_eq!(editor.told[&uri(&main)], Vec::<Value>::new());
    // The editor has it mended, but not saved.
    let mended = "param veins = 3\n# Like stone.\nfunction stone(x)\n    return x * white\n";
    editor.open(&uri(&stone), mended);
    while !editor.found(&uri(&stone)).is_empty() {}
    let mut at = |method: &str, line: u32, character: u32, more: Value| {
        let mut params =
            json!({"textDocument": {"uri": uri(&main)}, "position": {"line": line, "character": character}});
        params.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        editor.ask(method, params)
    };
    let hover = at("textDocument/hover", 1, 10, json!({}));
    assert!(hover["contents"]["value"].as_str().unwrap().contains("Like stone."));
    let definition = at("textDocument/definition", 1, 10, json!({}));
    assert_eq!(
        (definition["uri"].as_str(), range(&definition["range"])),
        (Some(&uri(&stone)[..]), "2:9-2:14".into())
    );
    let file = at("textDocument/definition", 0, 10, json!({}));
    assert_eq!((file["uri"].as_str(), range(&file["range"])), (Some(&uri(&stone)[..]), "0:0-0:0".into()));
    let list = at("textDocument/completion", 1, 8, json!({}));
    for name in ["stone", "veins"] {
        assert!(list["items"].as_array().unwrap().iter().any(|i| i["label"] == name), "{name}");
    }
    // What both have is renamed in both.
    let edit = at("textDocument/rename", 1, 10, json!({"newName": "granite"}));
    let edits = |uri: &str| -> Vec<String> {
        edit["changes"][uri].as_array().unwrap().iter().map(|e| range(&e["range"])).collect()
    };
    assert_eq!(edits(&uri(&main)), ["1:8-1:13"]);
    assert_eq!(edits(&uri(&stone)), ["2:9-2:14"]);
    let references = at("textDocument/references", 1, 16, json!({"context": {"includeDeclaration": false}}));
    assert_eq!(references.as_array().unwrap().len(), 1);
    // A change over there is felt here.
    editor.change(&uri(&stone), 2, &mended.replace("stone(", "marble("));
    while !editor.found(&uri(&main)).iter().any(|d| d["message"].as_str().unwrap().contains("stone")) {}
    // Without the document the disk counts again.
    editor.say("textDocument/didClose", json!({"textDocument": {"uri": uri(&stone)}}));
    while editor.found(&uri(&stone)).is_empty() {}
    fs::write(&stone, mended).unwrap();
    editor.say("workspace/didChangeWatchedFiles", json!({"changes": []}));
    while !editor.found(&uri(&stone)).is_empty() {}
    assert_eq!(editor.told[&uri(&main)], Vec::<Value>::new());
    assert_eq!(editor.leave(), 0);
}

#[test]
fn an_import_that_is_not_there_is_told() {
    let mut editor = Editor::new();
    editor.open(URI, "import \"nowhere.pse\"\ncolor = stone(1)\n");
    let found = editor.found(URI);
    assert_eq!(range(&found[0]["range"]), "0:7-0:20");
    assert!(found[0]["message"].as_str().unwrap().starts_with("cannot import \"nowhere.pse\"\n"));
    // A program that imports itself has no end.
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own file.pse");
    fs::write(&own, "import \"own file.pse\"\ncolor = white\n").unwrap();
    let encoded = uri(&own).replace(' ', "%20");
    editor.open(&encoded, "import \"own file.pse\"\ncolor = white\n");
    assert_eq!(editor.found(&encoded), Vec::<Value>::new());
    editor.leave();
}
