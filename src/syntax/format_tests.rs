//! The formatter on texts as they are typed, and on random programs.

use super::*;
use crate::diagnostic::SourceId;
use proptest::prelude::*;

fn formatted(text: &str) -> String {
    let printed = super::format(text).unwrap_or_else(|e| panic!("{text}\n{e:#?}"));
    assert_eq!(super::format(&printed).as_ref(), Ok(&printed), "a second time:\n{printed}");
    for comment in comments(text) {
        assert!(comments(&printed).contains(&comment), "lost {comment:?}:\n{printed}");
    }
    assert_eq!(comments(text).len(), comments(&printed).len(), "{text}\nbecame\n{printed}");
    printed
}

fn comments(text: &str) -> Vec<String> {
    let lexemes = token::lex(text);
    let of = |l: &token::Lexeme| text[l.start..l.end].trim_end().to_string();
    lexemes.iter().filter(|l| l.token == token::Token::Comment).map(of).collect()
}

#[test]
fn blanks_and_operators() {
    for (text, wanted) in [
        ("a=1+2*f(x ,y,k=3)", "a = 1 + 2 * f(x, y, k = 3)\n"),
        ("v=[a - b,c  -d [1 2]]", "v = [a-b c -d [1 2]]\n"),
        ("v=[1..5 a?b:c f (x)]", "v = [1 .. 5 a ? b : c f (x)]\n"),
        ("x = [(a -b) v [i+ 1]]", "x = [(a - b) v [i+1]]\n"),
        ("x = v [i + 1] . x", ""),
        ("a ^= - ( b )", "a ^= -(b)\n"),
        ("x = 1e-3 + .5 + 1.50", "x = 1e-3 + .5 + 1.50\n"),
        ("import   \"a\\\\b\"", "import \"a\\\\b\"\n"),
        ("param p=1   in[0,1]", "param p = 1 in [0 1]\n"),
    ] {
        match wanted {
            "" => assert!(super::format(text).is_err()),
            _ => assert_eq!(formatted(text), wanted),
        }
    }
}

#[test]
fn comments_keep_their_place() {
    let text = "# head\n\n\n\n# about a\na = 1 # one\nif a   # two\n  # inside\n  b = 1\n\n\n  # at the end\n# about else\nelse # three\n  c = 1\n# outer\nfunction f(x) # f\n  return x\nd = 1\n# last";
    let wanted = "# head\n\n# about a\na = 1  # one\nif a  # two\n    # inside\n    b = 1\n\n    # at the end\n# about else\nelse  # three\n    c = 1\n\n# outer\nfunction f(x)  # f\n    return x\n\nd = 1\n# last\n";
    assert_eq!(formatted(text), wanted);
}

#[test]
fn comments_inside_brackets() {
    let text = "v = [ # rows\n [1 0] # first\n # second is\n [0 1]\n # end\n]\nf(a, # one\n b)\nx = (a + # why\n b)\ny = [] # none\nz = [ # nothing\n]\n";
    let wanted = "v = [  # rows\n     [1 0]  # first\n     # second is\n     [0 1]\n     # end\n     ]\nf(a,  # one\n  b)\n# why\nx = (a + b)\ny = []  # none\nz = [  # nothing\n     ]\n";
    assert_eq!(formatted(text), wanted);
}

#[test]
fn long_lines_break_inside_brackets() {
    let row = "[0.125 0.25 0.5]";
    let text = format!("centers = [{}]\n", [row; 12].join(" "));
    let wanted = format!("centers = [{}]\n", [row; 12].join("\n           "));
    assert_eq!(formatted(&text), wanted);
    let text = format!("a = f({})\n", ["some_name * other_name"; 12].join(","));
    assert!(formatted(&text).lines().all(|l| l.chars().count() <= 100));
    let text = format!("a = ({})\n", ["some_name * other_name"; 12].join(" + "));
    assert!(formatted(&text).lines().all(|l| l.chars().count() <= 100));
}

#[test]
fn the_workloads_rows_stay_aligned() {
    let text = "if begin_frame\n    centers = [[0.003033931 0.7367971 -0.6761071]\n               [-0.6323985 -0.3228562 -0.7041562]\n               [0.04208769 0.9378646 -0.3444395]\n               [-0.7153654 0.5647546 0.4114664]]\n";
    assert_eq!(formatted(text), text);
}

/// Random expressions, spaced at random where that changes nothing.
fn expression() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        "[a-d]{1,9}",
        Just("1".to_string()),
        Just(".5".to_string()),
        Just("1e-3".to_string()),
        Just("v.x".to_string()),
        Just("\"s\"".to_string()),
        Just("[]".to_string()),
    ];
    leaf.prop_recursive(5, 60, 5, |inner| {
        let op = prop::sample::select(vec!["+", "-", "*", "/", "%", "^", "&&", "||"]);
        let vector = prop::collection::vec(
            (inner.clone(), prop::sample::select(vec![" ", ", ", "\n  ", " # c\n"])),
            1..6,
        );
        prop_oneof![
            (inner.clone(), op, inner.clone(), prop::bool::ANY).prop_map(|(a, op, b, wide)| {
                let blank = if wide { " " } else { "" };
                format!("{a}{blank}{op}{blank}{b}")
            }),
            (inner.clone(), prop::sample::select(vec!["==", "<", ">="]), inner.clone())
                .prop_map(|(a, op, b)| format!("(({a}) {op} ({b}))")),
            inner.clone().prop_map(|a| format!("({a})")),
            inner.clone().prop_map(|a| format!("(\n# g\n{a}\n)")),
            (prop::sample::select(vec!["-", "!"]), inner.clone()).prop_map(|(op, a)| format!("({op}{a})")),
            (inner.clone(), inner.clone(), inner.clone()).prop_map(|(a, b, c)| format!("({a} ? {b} : {c})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("ff({a}, k = {b})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("ff({a}, # f\n  {b},)")),
            inner.clone().prop_map(|a| format!("v[({a})]")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("[{a} .. {b}]")),
            vector.prop_map(|v| format!(
                "[{}]",
                v.into_iter().map(|(e, blank)| e + blank).collect::<String>().trim_end_matches(", ")
            )),
        ]
    })
}

fn program() -> impl Strategy<Value = String> {
    let simple = prop_oneof![
        expression().prop_map(|e| format!("x = {e}")),
        expression().prop_map(|e| format!("x[1].y += {e}")),
        expression(),
        Just("break".to_string()),
        expression().prop_map(|e| format!("return {e}")),
    ];
    let line = (simple, prop::sample::select(vec!["\n", " # t\n", "\n\n", "\n\n\n# own\n", "\n# own\n\n"]))
        .prop_map(|(s, end)| s + end);
    let block = prop::collection::vec(line, 1..5).prop_map(|lines| lines.concat());
    block.prop_recursive(3, 20, 3, |inner| {
        let header = prop_oneof![
            Just("while a\n".to_string()),
            Just("for c in v # h\n".to_string()),
            Just("if a\n".to_string()),
            Just("function f(a, b = 1)\n".to_string()),
            expression().prop_map(|e| format!("if {e}\n")),
        ];
        (inner.clone(), header, inner.clone(), prop::option::of(inner)).prop_map(
            |(before, header, block, after)| {
                let indent = |b: &str| b.lines().map(|l| format!("  {l}\n")).collect::<String>();
                let otherwise = match after {
                    Some(after) if header.starts_with("if") => format!("# e\nelse\n{}", indent(&after)),
                    _ => String::new(),
                };
                format!("{before}{header}{}{otherwise}", indent(&block))
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn formatting_keeps_the_tree_and_is_a_fixed_point(text in program()) {
        let before = parse(SourceId::default(), &text);
        prop_assume!(before.errors.is_empty());
        let printed = formatted(&text);
        let after = parse(SourceId::default(), &printed);
        prop_assert!(after.errors.is_empty());
        prop_assert_eq!(tree(&before.module), tree(&after.module));
    }

    #[test]
    fn most_random_programs_are_correct(text in program()) {
        // `a ^ b` with a sign or a chain before it, and the like, are the only texts that fail.
        let errors = parse(SourceId::default(), &text).errors;
        prop_assert!(errors.len() < MAX_ERRORS);
    }

    #[test]
    fn no_text_panics(text in "\\PC{0,80}") {
        let _ = super::format(&text);
        is_incomplete(&text);
    }

    #[test]
    fn no_soup_of_tokens_panics(words in prop::collection::vec(prop::sample::select(vec![
        "if", "else", "while", "for", "in", "function", "return", "param", "import", "break", "=", "+=", "?", ":",
        "||", "==", "<", "+", "-", "*", "^", "!", ".", "..", ",", "(", ")", "[", "]", "\n", "\n    ", "\n\t", "\r\n  ",
        " ", "# c\n", "\"", "\"s\"", "a", "1", ".5", "2x", "'", "&", ";", "{", "}", "//", "/*", "é", "“", "elif", "and",
    ]), 0..60), blank in prop::bool::ANY) {
        let text = words.join(if blank { " " } else { "" });
        if let Ok(printed) = super::format(&text) {
            prop_assert_eq!(super::format(&printed), Ok(printed.clone()));
        } else {
            for error in parse(SourceId::default(), &text).errors {
                prop_assert!(error.span().is_some_and(|s| s.end as usize <= text.len() && s.start <= s.end));
                let mut sources = crate::diagnostic::Sources::default();
                sources.add("t", text.as_str());
                error.render(&sources, crate::diagnostic::Style::PLAIN);
            }
        }
    }
}
