//! The files for editors: their lists of words are those of the language. `UPDATE=1` writes them anew.

use pse::internal::reference;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

fn file(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "editors", name].iter().collect()
}

fn read(name: &str) -> String {
    fs::read_to_string(file(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Is what stands in a file what should? With `UPDATE=1` it is made so.
fn compare(name: &str, text: &str, expected: &str) {
    if text != expected && std::env::var_os("UPDATE").is_some() {
        return fs::write(file(name), expected).unwrap();
    }
    let odd = text.lines().zip(expected.lines()).find(|(a, b)| a != b);
    assert_eq!(text, expected, "editors/{name} is behind the language at {odd:?}; UPDATE=1 writes it anew");
}

/// The words of the language by kind: how the TextMate grammar and the syntax file call the kind, and the words.
fn words() -> [(&'static str, &'static str, Vec<String>); 4] {
    let groups = reference::names();
    let of = |wanted: &dyn Fn(&str) -> bool| -> Vec<String> {
        let lines = groups.iter().filter(|(title, _)| wanted(title)).flat_map(|(_, lines)| lines);
        lines.map(|(name, _)| name.to_string()).collect()
    };
    let statement = |title: &str| title == "A statement that is written as a call";
    let functions = reference::entries().into_iter().map(|e| e.name);
    [
        ("keyword.control.pse", "pseKeyword", reference::KEYWORDS.iter().map(|k| k.0.to_string()).collect()),
        ("support.function.pse", "pseFunction", functions.chain(of(&statement)).collect()),
        ("constant.language.pse", "pseConstant", of(&|title| title == "Constants")),
        ("variable.language.pse", "pseVariable", of(&|title| title != "Constants" && !statement(title))),
    ]
}

/// The pattern that is called so, anywhere below.
fn pattern<'a>(value: &'a Value, scope: &str) -> Option<&'a str> {
    if value["name"] == scope
        && let Some(pattern) = value["match"].as_str()
    {
        return Some(pattern);
    }
    match value {
        Value::Array(list) => list.iter().find_map(|v| pattern(v, scope)),
        Value::Object(map) => map.values().find_map(|v| pattern(v, scope)),
        _ => None,
    }
}

#[test]
fn the_grammar_has_the_words_of_the_language() {
    let name = "vscode/syntaxes/pse.tmLanguage.json";
    let text = read(name);
    let grammar: Value = serde_json::from_str(&text).unwrap();
    let mut expected = text.clone();
    for (scope, _, words) in words() {
        let old = pattern(&grammar, scope).unwrap_or_else(|| panic!("no {scope}"));
        let behind = if scope.contains("function") { "(?=\\()" } else { "" };
        let new = format!("\\b(?:{})\\b{behind}", words.join("|"));
        let line = |pattern: &str| format!("\"name\": \"{scope}\",\n#\"match\": {}", Value::from(pattern));
        let indent =
            expected.lines().find(|l| l.contains(scope)).unwrap().split('"').next().unwrap().to_string();
        let line = |pattern: &str| line(pattern).replace('#', &indent);
        assert!(expected.contains(&line(old)), "the pattern of {scope} is to stand right below its name");
        expected = expected.replace(&line(old), &line(&new));
    }
    compare(name, &text, &expected);
}

#[test]
fn the_syntax_file_has_the_words_of_the_language() {
    let name = "neovim/syntax/pse.vim";
    let text = read(name);
    let (head, rest) = text.split_once("\" lists begin\n").unwrap();
    let (_, tail) = rest.split_once("\" lists end\n").unwrap();
    let mut lists = String::new();
    for (_, kind, words) in words() {
        for words in words.chunks(10) {
            lists += &format!("syn keyword {kind} {}\n", words.join(" "));
        }
    }
    compare(name, &text, &format!("{head}\" lists begin\n{lists}\" lists end\n{tail}"));
}

#[test]
fn the_files_of_the_extension_fit_together() {
    let package: Value = serde_json::from_str(&read("vscode/package.json")).unwrap();
    let configuration: Value = serde_json::from_str(&read("vscode/language-configuration.json")).unwrap();
    assert_eq!(configuration["comments"]["lineComment"], "#");
    let grammar: Value = serde_json::from_str(&read("vscode/syntaxes/pse.tmLanguage.json")).unwrap();
    let contributed = &package["contributes"];
    assert_eq!(contributed["grammars"][0]["scopeName"], grammar["scopeName"]);
    assert_eq!(contributed["grammars"][0]["language"], contributed["languages"][0]["id"]);
    for path in
        [&package["main"], &contributed["grammars"][0]["path"], &contributed["languages"][0]["configuration"]]
    {
        assert!(file("vscode").join(path.as_str().unwrap()).is_file(), "{path}");
    }
    // Every header of a block is one for the editor, too.
    let increase = configuration["indentationRules"]["increaseIndentPattern"].as_str().unwrap();
    for (word, _) in reference::KEYWORDS {
        let header = pse::internal::syntax::lex(word)[0].token.opens_block();
        assert_eq!(increase.split(|c: char| !c.is_alphabetic()).any(|w| w == *word), header, "{word}");
    }
}
