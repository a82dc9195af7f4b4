//! Texts that nobody would write, and every question about any place in them.

use super::*;

/// A generator of numbers, always the same ones.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % n.max(1)
    }
}

const PIECES: &[&str] = &[
    "(",
    ")",
    "[",
    "]",
    "\"",
    "\n",
    "\r\n",
    "\r",
    "    ",
    "\t",
    "#",
    ".",
    ",",
    "=",
    "==",
    "if ",
    "else",
    "for i in ",
    "function f(",
    "param a = 1 in [0 1]\n",
    "import \"x.pse\"\n",
    "Noise(",
    "kind = \"",
    "ö",
    "\u{1f600}",
    "\u{feff}",
    "\u{0}",
    "return ",
    "point",
    "color = ",
    "bg.color",
    "1e",
    "..",
    "? ",
    "/*",
    "'",
    "begin_frame",
];

fn mutated(text: &str, random: &mut Random) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    for _ in 0..1 + random.below(6) {
        let at = random.below(chars.len() + 1);
        match random.below(3) {
            0 => {
                let end = (at + random.below(30)).min(chars.len());
                chars.drain(at..end);
            }
            1 => drop(chars.splice(at..at, PIECES[random.below(PIECES.len())].chars())),
            _ => {
                let from = random.below(chars.len() + 1);
                let piece: Vec<char> = chars[from..(from + random.below(40)).min(chars.len())].to_vec();
                chars.splice(at..at, piece);
            }
        }
    }
    chars.into_iter().collect()
}

#[test]
fn no_text_and_no_place_is_too_much() {
    let mut random = Random(7);
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/examples");
    let mut examples: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    examples.retain(|path| path.extension().is_some_and(|e| e == "pse"));
    examples.sort();
    let mut editor = Editor::new();
    for round in 0..300 {
        let text = std::fs::read_to_string(&examples[round % examples.len()]).unwrap();
        let text = mutated(&text, &mut random);
        match round {
            0 => editor.open(URI, &text),
            _ => editor.change(URI, round as i32, &text),
        }
        let document = json!({ "uri": URI });
        let new = ["other", "x", "Noise", "if", ""][random.below(5)];
        let place = json!({
            "textDocument": document,
            "position": {"line": random.below(text.lines().count() + 2), "character": random.below(60)},
            "context": context(),
            "newName": new,
            "options": {"tabSize": 4, "insertSpaces": true},
        });
        for method in [
            "hover",
            "completion",
            "signatureHelp",
            "definition",
            "references",
            "documentHighlight",
            "documentSymbol",
            "formatting",
            "prepareRename",
            "rename",
        ] {
            let answer = editor.request(&format!("textDocument/{method}"), place.clone()).response_result;
            if let Err(error) = answer {
                // Some names can't be had; nothing else may be refused.
                assert!(method.ends_with("ename") && error.code == -32803, "{method}: {error:?} in\n{text}");
            }
        }
        if round % 10 == 0 {
            editor.found(URI);
        }
    }
    assert_eq!(editor.leave(), 0);
}
