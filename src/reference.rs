//! All that has a name in every program, as the reference shows it: functions of the table and of the library,
//! constants, what the system provides, what images usually hold, and the words of the language.

use crate::builtin::reference::{self, Entry};
use crate::resolve::{library_entries, names, print};

/// Every function, built-in or of the library, in the order of the documentation.
pub fn entries() -> Vec<Entry> {
    let mut all = reference::entries();
    all.extend(library_entries().map(|e| Entry {
        group: group(e.file),
        name: e.name.clone(),
        signature: e.signature.clone(),
        brief: e.brief.clone(),
        doc: e.doc.clone(),
        examples: e.examples.clone(),
    }));
    all
}

/// `library/waves.pse` as a heading.
fn group(file: &str) -> String {
    let stem = file.trim_start_matches("library/").trim_end_matches(".pse");
    format!("Library: {}", stem.replace('_', " "))
}

/// The words of the language that cannot be names, and what each does.
pub static KEYWORDS: &[(&str, &str)] = &[
    (
        "if",
        "Runs its block where the condition is not 0. `if begin_frame` runs once per frame, before any pixel.",
    ),
    ("else", "Runs its block where the conditions above are 0; `else if` tests another condition."),
    ("while", "Repeats its block while the condition is not 0."),
    ("for", "Runs its block for each element of a vector: `for i in [1 .. 5]`."),
    ("in", "Between a loop's variable and its vector, or a param and the range of its values."),
    ("break", "Leaves the loop."),
    ("continue", "Continues with the next iteration of the loop."),
    ("function", "Defines a function, whose block is below: `function twice(x)`."),
    ("return", "Leaves the function with a value."),
    ("param", "Declares a value that can be set from outside: `param veins = 7 in [0 20]`."),
    ("import", "Makes the functions and params of another file available: `import \"stone.pse\"`."),
];

/// The spaces that images and scenes know, as `transform` names them.
pub static SPACES: &[(&str, &str)] = &[
    ("world", "the space of point"),
    ("camera", "the camera at the origin"),
    ("screen", "the picture: x and y from 0 to 1"),
];

/// What G-buffers usually hold, in the order of `names::USUAL_INPUTS`.
static INPUTS: &[(&str, &str)] = &[
    ("surface", "the number of the visible surface, 0 where there is none"),
    ("point", "the visible point in space"),
    ("normal", "the unit normal of the surface"),
    ("uv", "the surface's texture coordinates"),
    ("depth", "the distance along the view axis"),
    ("color", "the image's own colour, linear"),
    ("alpha", "the covered part of the pixel, 0 to 1"),
    ("albedo", "the surface's colour without lightinging"),
    ("motion", "the motion of the surface in the picture"),
    ("I", "the direction from the eye through the pixel"),
    ("dPdu", "the derivative of point with respect to uv.x"),
    ("dPdv", "the derivative of point with respect to uv.y"),
];

/// The names that are no functions, under their headings, each with what it is.
pub fn names() -> Vec<(&'static str, Vec<(&'static str, String)>)> {
    let own = |list: &'static [(&'static str, &'static str)]| {
        list.iter().map(|(name, brief)| (*name, brief.to_string())).collect()
    };
    let constants = names::CONSTANTS.iter().map(|c| (c.name, format!("{}: {}", value(c), c.brief)));
    vec![
        ("A statement that is written as a call", vec![(print::NAME, print::BRIEF.to_string())]),
        ("Constants", constants.collect()),
        ("What every program can read", own(names::SYSTEM)),
        ("What images usually hold", own(INPUTS)),
    ]
}

fn value(constant: &names::Constant) -> String {
    match constant.value {
        [x] => format!("{x}"),
        vector => format!("[{}]", vector.iter().map(f32::to_string).collect::<Vec<_>>().join(" ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::lex;

    #[test]
    fn the_usual_inputs_are_explained() {
        let explained: Vec<&str> = INPUTS.iter().map(|(n, _)| *n).collect();
        assert_eq!(explained, names::USUAL_INPUTS);
    }

    #[test]
    fn every_keyword_is_explained_and_nothing_else() {
        for (word, _) in KEYWORDS {
            assert!(lex(word)[0].token.is_keyword(), "{word} is no keyword");
        }
        // The lexer's own source is the list that this one is compared with.
        let source = include_str!("syntax/token.rs");
        let (_, rest) = source.split_once("// Keywords.").unwrap();
        let (keywords, _) = rest.split_once("// Operators.").unwrap();
        let listed: Vec<&str> =
            keywords.split("token(\"").skip(1).map(|t| t.split('"').next().unwrap()).collect();
        assert_eq!(listed, KEYWORDS.iter().map(|k| k.0).collect::<Vec<_>>());
    }
}
