//! What the server answers in one document.

use super::*;

/// The text of a hover.
fn hover(editor: &mut Editor, text: &str) -> String {
    let answer = editor.at("textDocument/hover", text);
    answer["contents"]["value"].as_str().unwrap_or_default().to_string()
}

/// The items of a completion by name, each with what it inserts.
fn completed(editor: &mut Editor, text: &str) -> Vec<(String, String)> {
    let answer = editor.at("textDocument/completion", text);
    let text = |v: &Value| v.as_str().unwrap().to_string();
    let items = answer["items"].as_array().unwrap();
    items.iter().map(|i| (text(&i["label"]), text(&i["textEdit"]["newText"]))).collect()
}

fn names(editor: &mut Editor, text: &str) -> Vec<String> {
    completed(editor, text).into_iter().map(|(name, _)| name).collect()
}

#[test]
fn what_check_says_is_told_as_it_is_typed() {
    let mut editor = Editor::new();
    for (text, expected) in [
        (
            "color = white * Nois(point)\n",
            vec![(1, "0:16-0:20", "there is no function `Nois()`\nDid you mean `Noise()`?")],
        ),
        ("color = white\ncolour = 2\n", vec![(2, "1:0-1:6", "`colour` is assigned and never read")]),
        ("color = flame\n", vec![(2, "0:8-0:13", "the program does not assign `flame`")]),
        ("a = (1\nb = 2 +\ncolor = a\n", vec![(1, "0:4-0:5", ""), (1, "1:6-1:7", "")]),
        ("\u{feff}color = white\r\nalpha = [1 2\r\n", vec![(1, "1:8-1:9", "")]),
        ("color = white\n", vec![]),
        ("", vec![]),
    ] {
        editor.open(URI, text);
        let found = editor.found(URI);
        assert_eq!(found.len(), expected.len(), "{text}: {found:#?}");
        for (found, (severity, place, message)) in found.iter().zip(expected) {
            assert_eq!(range(&found["range"]), place, "{text}");
            assert_eq!(found["severity"], severity, "{text}");
            assert!(found["message"].as_str().unwrap().starts_with(message), "{text}: {found:#}");
        }
    }
    editor.open(URI, "function f()\n    return 1\nfunction f()\n    return 2\ncolor = f()\n");
    let found = editor.found(URI);
    let related = &found[0]["relatedInformation"][0];
    assert_eq!(related["message"], "first here");
    assert_eq!(range(&related["location"]["range"]), "0:9-0:10");
    editor.leave();
}

#[test]
fn words_are_explained() {
    let mut editor = Editor::new();
    for (text, words) in [
        ("color = white * No|ise(point)\n", vec!["```pse\nNoise(p", "Perlin"]),
        ("color = marble_color(|0.5)\n", vec![]),
        ("color = marble|_color(0.5)\n", vec!["marble_color(", "marble_color(-1)  # ["]),
        (
            "# Twice as much.\nfunction twice(x)\n    return 2 * x\ncolor = twi|ce(1)\n",
            vec!["twice(x)", "Twice as much."],
        ),
        (
            "# Layers.\nparam veins = 7 in [0 20]\ncolor = vei|ns\n",
            vec!["param veins = 7 in [0 20]", "Layers."],
        ),
        ("co|lor = white\n", vec!["An output"]),
        ("a = 1\ncolor = |a\n", vec!["A variable of the program"]),
        ("color = poi|nt\n", vec!["point in space", "What images usually hold"]),
        ("color = pi|xelsize\n", vec!["What every program can read"]),
        ("color = p|i\n", vec!["3.14159", "Constants"]),
        ("color = flame|x\n", vec!["the image must have it"]),
        ("color = bg.c|olor\n", vec!["image called `bg`"]),
        ("color = white.|x\n", vec!["Element 1"]),
        ("function f(x, by = 2)\n    y = x\n    return |y * by\n", vec!["variable of the function `f()`"]),
        ("function f(x, by = 2)\n    return x * b|y\n", vec!["A parameter of `f(x, by = 2)`", "`2`"]),
        (
            "color = white * Noise(point, ki|nd = \"simplex\")\n",
            vec!["A parameter of `Noise(", "`\"gradient\"`"],
        ),
        ("color = white * Noise(point, kind = \"sim|plex\")\n", vec!["`\"gradient\"`"]),
        ("i|f surface\n    color = white\n", vec!["Runs its block"]),
        // A line that cannot be read.
        ("color = white * Noi|se(point\n", vec!["Noise(p"]),
    ] {
        let said = hover(&mut editor, text);
        assert_eq!(said.is_empty(), words.is_empty(), "{text}: {said}");
        for word in words {
            assert!(said.contains(word), "{text}: no {word} in {said}");
        }
    }
    editor.leave();
}

#[test]
fn what_fits_is_offered() {
    let mut editor = Editor::new();
    let program = "param veins = 7\nfunction f(x, by = 2)\n    local = x\n    return loc\nv = 1\n";
    let has = |list: &[String], wanted: &[&str], unwanted: &[&str]| {
        for name in wanted {
            assert!(list.iter().any(|n| n == name), "no {name}");
        }
        for name in unwanted {
            assert!(!list.iter().any(|n| n == name), "{name}");
        }
    };
    let list = names(&mut editor, &program.replace("return loc", "return loc|"));
    has(
        &list,
        &["local", "x", "by", "v", "veins", "f", "Noise", "marble_color", "point", "pi", "pixelsize"],
        &["in", "if"],
    );
    let list = names(&mut editor, &format!("{program}|"));
    has(&list, &["v", "veins", "f", "if", "param", "color", "Noise"], &["local", "by", "in"]);
    let list = names(&mut editor, &format!("{program}for i |"));
    has(&list, &["in"], &["while"]);
    let list = names(&mut editor, &format!("{program}if v\n    a = 1\nelse |"));
    assert_eq!(list, ["if"]);
    let list = names(&mut editor, "color = white * Noise(point, kind = \"gr|");
    has(&list, &["gradient", "simplex"], &["Noise", "v"]);
    let list = completed(&mut editor, "color = white * Noise(point, seed = 1, |)");
    assert!(
        list.contains(&("kind".into(), "kind = ".into())) && !list.iter().any(|(_, new)| new == "seed = ")
    );
    let list = names(&mut editor, "a = transform(\"|");
    has(&list, &["world", "camera", "screen"], &[]);
    let list = names(&mut editor, "a = point.|");
    assert_eq!(list, ["x", "r", "y", "g", "z", "b", "w", "a"]);
    has(&names(&mut editor, "a = bg.|"), &["color", "x"], &["Noise"]);
    for nothing in ["# wh|", "a = 12|", "function f(a, b|", "param |", "import \"st|"] {
        assert_eq!(names(&mut editor, nothing), [""; 0], "{nothing}");
    }
    // Each comes with what it is.
    let answer = editor.at("textDocument/completion", "color = Noi|");
    let noise = answer["items"].as_array().unwrap().iter().find(|i| i["label"] == "Noise").unwrap();
    assert!(noise["detail"].as_str().unwrap().starts_with("Noise(p"));
    assert!(noise["documentation"]["value"].as_str().unwrap().contains("kind"));
    assert_eq!(
        (range(&noise["textEdit"]["range"]).as_str(), &noise["textEdit"]["newText"]),
        ("0:8-0:11", &json!("Noise"))
    );
    editor.leave();
    let item = json!({"textDocument": {"completion": {"completionItem": {"snippetSupport": true}}}});
    let mut editor = Editor::with(item);
    assert!(completed(&mut editor, "a = Noi|").contains(&("Noise".into(), "Noise($0)".into())));
    assert!(completed(&mut editor, "a = Noi|(point)").contains(&("Noise".into(), "Noise".into())));
    editor.leave();
}

#[test]
fn a_call_shows_what_it_takes() {
    let mut editor = Editor::new();
    let mut active = |text: &str| {
        let answer = editor.at("textDocument/signatureHelp", text);
        let signature = &answer["signatures"][0];
        let label: Vec<u16> = signature["label"].as_str()?.encode_utf16().collect();
        let place = &signature["parameters"][answer["activeParameter"].as_u64()? as usize]["label"];
        let (start, end) = (place[0].as_u64()? as usize, place[1].as_u64()? as usize);
        Some(String::from_utf16(&label[start..end]).unwrap())
    };
    assert_eq!(active("a = clamp(1, |"), Some("low = 0".into()));
    assert_eq!(active("a = clamp(1, high = |)"), Some("high = 1".into()));
    assert_eq!(active("a = max(1, 2, 3, |)"), Some("x, …".into()));
    assert_eq!(active("function f(x, by = 2)\n    return x\na = f(1, [1 |2])"), Some("by = 2".into()));
    assert_eq!(active("a = clamp(1)|"), None);
    assert_eq!(active("a = clamp(1, 2, 3, |"), None, "one too many");
    editor.leave();
}

#[test]
fn names_lead_to_where_they_come_from() {
    let mut editor = Editor::new();
    let program = "param scale = 2\nfunction f(x, by = 2)\n    y = x\n    y += 1\n    return y * by\na = f(1, by = 3)\na = a + scale\n";
    let mut to = |place: &str, marked: &str| {
        let answer = editor.at("textDocument/definition", &program.replace(place, marked));
        if answer == Value::Null { String::new() } else { range(&answer["range"]) }
    };
    assert_eq!(to("a = f(", "a = |f("), "1:9-1:10");
    assert_eq!(to("y * by", "y| * by"), "2:4-2:5");
    assert_eq!(to("y = x", "y = |x"), "1:11-1:12");
    assert_eq!(to("by = 3", "b|y = 3"), "1:14-1:16");
    assert_eq!(to("a + scale", "a + sca|le"), "0:6-0:11");
    assert_eq!(to("a + scale", "|a + scale"), "5:0-5:1");
    assert_eq!(to("a + scale", "No|ise(1)"), "");
    let marked = program.replace("y += 1", "|y += 1");
    let references = editor.at("textDocument/references", &marked);
    let all: Vec<String> = references.as_array().unwrap().iter().map(|l| range(&l["range"])).collect();
    assert_eq!(all, ["2:4-2:5", "3:4-3:5", "4:11-4:12"]);
    let highlights = editor.at("textDocument/documentHighlight", &marked);
    let kinds: Vec<u64> =
        highlights.as_array().unwrap().iter().map(|h| h["kind"].as_u64().unwrap()).collect();
    assert_eq!(kinds, [3, 3, 2]);
    editor.leave();
}

/// The text after a rename of what stands at the `|`.
fn renamed(editor: &mut Editor, text: &str, new: &str) -> Result<String, String> {
    let plain = text.replacen('|', "", 1);
    editor.open(URI, &plain);
    let mut params = place(text);
    params["newName"] = new.into();
    let prepared =
        editor.request("textDocument/prepareRename", place(text)).response_result.map_err(|e| e.message)?;
    assert!(prepared["placeholder"].is_string(), "{text}");
    let edit = editor.request("textDocument/rename", params).response_result.map_err(|e| e.message)?;
    Ok(edited(&plain, edit["changes"][URI].as_array().unwrap()))
}

/// A text after edits; the columns of these tests are bytes.
fn edited(text: &str, edits: &[Value]) -> String {
    let starts: Vec<usize> = std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect();
    let at =
        |p: &Value| starts[p["line"].as_u64().unwrap() as usize] + p["character"].as_u64().unwrap() as usize;
    let mut edits: Vec<(usize, usize, &str)> = edits
        .iter()
        .map(|e| (at(&e["range"]["start"]), at(&e["range"]["end"]), e["newText"].as_str().unwrap()))
        .collect();
    edits.sort_unstable();
    let mut text = text.to_string();
    for (start, end, new) in edits.into_iter().rev() {
        text.replace_range(start..end, new);
    }
    text
}

#[test]
fn renaming_keeps_what_the_program_means() {
    let mut editor = Editor::new();
    let program = "x = 3\nfunction f(x, by = 2)\n    return x * by\na = f(x, by = 3)\ncolor = f(a)\n";
    let mut to =
        |place: &str, marked: &str, new: &str| renamed(&mut editor, &program.replacen(place, marked, 1), new);
    assert_eq!(to("a = f", "a = |f", "scaled").unwrap(), program.replace("f(", "scaled("));
    assert_eq!(
        to("(x, by = 2", "(|x, by = 2", "v").unwrap(),
        program.replace("f(x, by = 2)", "f(v, by = 2)").replace("return x", "return v")
    );
    assert_eq!(to("by = 3", "b|y = 3", "k").unwrap(), program.replace("by", "k"));
    assert_eq!(
        to("x = 3", "|x = 3", "z").unwrap(),
        program.replace("x = 3", "z = 3").replace("a = f(x", "a = f(z")
    );
    for (place, marked, new, why) in [
        ("a = f", "|a = f", "x", "something else"),
        ("a = f", "|a = f", "point", "a variable of images"),
        ("a = f", "|a = f", "while", "cannot be a name"),
        ("a = f", "|a = f", "and", "cannot be a name"),
        ("a = f", "|a = f", "2b", "cannot be a name"),
        ("a = f", "|a = f", "b\nc", "cannot be a name"),
        ("(x, by = 2", "(|x, by = 2", "by", "something else"),
        ("color", "|color", "picture", "a variable of images"),
        ("a = f(x", "a = No|ise(x", "Other", "part of the language"),
        ("a = f(x", "a = f(flam|e", "fire", "comes from the image"),
        ("a = f(x", "a = (f(|x", "y", "mistakes"),
    ] {
        let said = to(place, marked, new).unwrap_err();
        assert!(said.contains(why), "{marked} to {new}: {said}");
    }
    // A function that takes the name of a built-in one that is called elsewhere.
    let text = "function |f(x)\n    return x\na = f(1) + sin(1)\n";
    assert!(renamed(&mut editor, text, "sin").unwrap_err().contains("something else"));
    editor.leave();
}

#[test]
fn documents_are_formatted_and_outlined() {
    let mut editor = Editor::new();
    let options = json!({"textDocument": {"uri": URI}, "options": {"tabSize": 8, "insertSpaces": false}});
    let mut formatted = |text: &str| {
        editor.open(URI, text);
        edited(text, editor.ask("textDocument/formatting", options.clone()).as_array().unwrap())
    };
    let rough = "a=1\n\n\n\nif a\n  color=[1,0,0]\nb = 2\n";
    assert_eq!(formatted(rough), pse::internal::syntax::format(rough).unwrap());
    assert_eq!(formatted("a=1"), "a = 1\n");
    assert_eq!(formatted("a=1\r\nb=2\r\n"), "a = 1\r\nb = 2\r\n");
    for same in ["a=(1\n", "a = 1\n", "a = 1\r\n", ""] {
        assert_eq!(formatted(same), same);
    }
    let program = "param veins = 7 in [0 20]\nfunction f(x)\n    y = x\n    return y\nif veins\n    color = f(1)\nhelp = 2\nalpha = 1\n";
    editor.open(URI, program);
    let symbols = editor.ask("textDocument/documentSymbol", json!({"textDocument": {"uri": URI}}));
    let list: Vec<(&str, &str, String)> = symbols
        .as_array()
        .unwrap()
        .iter()
        .map(|s| (s["name"].as_str().unwrap(), s["detail"].as_str().unwrap(), range(&s["range"])))
        .collect();
    let expected = [
        ("veins", "param veins = 7 in [0 20]", "0:0-0:25"),
        ("f", "f(x)", "1:0-3:12"),
        ("color", "written", "5:4-5:9"),
        ("alpha", "written", "7:0-7:5"),
    ];
    assert_eq!(list, expected.map(|(a, b, c)| (a, b, c.to_string())));
    editor.leave();
}
