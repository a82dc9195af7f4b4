//! Programs through all of the stages.

use super::*;
use crate::diagnostic::SourceId;

/// The tree of a correct program.
fn ok(text: &str) -> String {
    let parsed = parse(SourceId::default(), text);
    assert!(parsed.errors.is_empty(), "{text}\n{:#?}", parsed.errors);
    tree(&parsed.module)
}

/// The messages of a faulty one.
fn faults(text: &str) -> Vec<String> {
    parse(SourceId::default(), text).errors.into_iter().map(|e| e.message).collect()
}

/// Two expressions of the same meaning, one of them with brackets for all that is understood.
fn same(a: &str, b: &str) {
    let plain = |text: &str| ok(text).replace("( )\n", "").replace(' ', "");
    assert_eq!(plain(a), plain(b), "{a}  and  {b}");
}

/// How many elements a vector has.
fn elements(text: &str) -> usize {
    let parsed = parse(SourceId::default(), text);
    assert!(parsed.errors.is_empty(), "{text}: {:?}", parsed.errors);
    match &parsed.module.body[0].kind {
        ast::StmtKind::Expr(e) => match &*e.kind {
            ast::ExprKind::Vector(v) => v.len(),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

/// The programs that the paper prints.
const PAPER: &[&str] = &[
    "if surface == 1\n    color = [1 0 0] * max(0.1, dot(normal, [1 0 0]))\nelse\n    color = [0 0 0.1]\n",
    "color = white * Noise(point)\n",
    "color = Colorful(Noise(k * point))\n",
    "normal += Dnoise(point)\n",
    "f = 1\nwhile f < pixel_freq\n    normal += Dnoise(f * point)\n    f *= 2\n",
    "function boring_marble(point)\n    x = point[1]\n    return marble_color(sin(x))\n",
    "function marble(point)\n    x = point[1] + turbulence(point)\n    return marble_color(sin(x))\n",
    "smooth_corona(point - center)\n\nfunction smooth_corona(v)\n    radius = norm(v)\n    return color_of_emission(radius)\n",
    "function moving_corona(v)\n    radius = norm(v)\n    dr = turbulence(v - frame * direction(v))\n    return color_of_corona(radius + dr)\n",
    "normal += wave(point - center)\n\nfunction wave(v)\n    return direction(v) * cycloid(norm(v))\n",
    "function makewaves(n)\n    for i in [1 .. n]\n        center[i] = direction(Dnoise(i * [100 0 0]))\n    return center\n",
    "if begin_frame\n    center = makewaves(20)\n    for c in center\n        normal += wave(point - c)\n",
    "normal += wave((point - c) * f) / f\n",
    "function moving_wave(v, Dphase)\n    return direction(v) * cycloid(norm(v) - frame * Dphase)\n",
    "color *= 1 + sin([rfreq gfreq bfreq] * turbulence(point))\n",
    "function turbulence(p)\n    t = 0\n    scale = 1\n    while (scale > pixelsize)\n        t += abs(Noise(p / scale)) * scale\n        scale /= 2\n    return t\n",
];

#[test]
fn the_papers_programs_parse_and_are_in_canonical_form() {
    for text in PAPER {
        let tree = ok(text);
        assert_eq!(tree, ok(&text.replace('\n', "\r\n")));
        assert_eq!(tree, ok(&text.replace("    ", "\t")));
        assert_eq!(format(text).as_deref(), Ok(*text));
        assert_eq!(format(&text.replace('\n', "\r\n")).as_deref(), Ok(*text));
        assert_eq!(format(&text.replace("    ", "\t")).as_deref(), Ok(*text));
    }
}

#[test]
fn precedence() {
    same("a ? b : c ? d : e", "a ? b : (c ? d : e)");
    same("a || b && c", "a || (b && c)");
    same("a && b == c", "a && (b == c)");
    same("a == b < c", "a == (b < c)");
    same("a < b + c", "a < (b + c)");
    same("a - b - c * d / e", "(a - b) - ((c * d) / e)");
    same("-a ^ b", "-(a ^ b)");
    same("a ^ -b ^ c", "a ^ (-(b ^ c))");
    same("-a * b", "(-a) * b");
    same("!a == b", "(!a) == b");
    same("-v[1].x ^ 2", "-((v[1].x) ^ 2)");
}

#[test]
fn blanks_inside_square_brackets() {
    for (text, count) in [
        ("[]", 0),
        ("[a - b]", 1),
        ("[a-b]", 1),
        ("[a -b]", 2),
        ("[a- b]", 1),
        ("[a !b]", 2),
        ("[a, -b,]", 2),
        ("[f(x)]", 1),
        ("[f (x)]", 2),
        ("[a[1]]", 1),
        ("[a [1]]", 2),
        ("[(1 -2)]", 1),
        ("[a .. b]", 1),
        ("[1..5 7]", 2),
        ("[a ? b : c d]", 2),
        ("[a ? -b : -c]", 1),
        ("[a * -b]", 1),
        ("[a\n b # c\n -d]", 3),
        ("[\n  a\n  - b\n]", 1),
        ("[1 .5]", 2),
        ("[a.x .5]", 2),
        ("[max(1, 2 -3) 4]", 2),
        ("[[1 -2] -[3 4]]", 2),
    ] {
        assert_eq!(elements(text), count, "{text}");
    }
}

#[test]
fn blanks_outside_mean_nothing() {
    same("f (x) [1]", "f(x)[1]");
    same("a -b", "a - b");
}

#[test]
fn statements() {
    ok(
        "param veins = 4 in [1 20]\nimport \"marble.pse\"\nfunction f(a, b, c = 1,)\n  return a\nx[1].y += f(1, c = 2,)\n",
    );
    ok("\u{feff}# only\n\n   # comments\n");
    ok("");
    ok("if a\n    # first\n\n  # odd\n    b = 1\n# outer\n    c = 2\nelse if d\n\te = 1\nelse\n f = 1");
}

#[test]
fn one_message_a_fault() {
    for (text, count) in [
        ("a = )\nb = @\nc = 1", 2),
        ("if a = b\n    c = 1\nelse\n    d = \n", 2),
        ("iff a\n    b = 1\nelse\n    c = 1", 1),
        ("a = (1, 2\nb = 2\nif (c\n    d = 1", 2),
        ("f(a,\n  kind = 1)", 0),
        ("f(a,\nkind = 1)", 0),
        ("v = [1 2\nw = 3", 1),
        ("a = \"x\nf(\"y)\nb = 1", 2),
        ("if a\n    b = 1\n  c = 2\n  d = 3\ne = 4", 1),
        ("if a\n    b = 1\n   c = 2\n    d = 3\n   e = 4", 1),
        ("if\n    b = 1", 1),
        ("if a\n    b = 1\n  else\n    c = 1", 1),
        ("if a: b = 1\nc = 2", 1),
        ("a = b +\n    c\nd = 1", 1),
        ("x = a && (b\n    || c) d", 1),
        ("a = [1 2)\nb = (1]\nc = ([1)", 3),
        ("a = 'x' ** 2 // y", 3),
    ] {
        assert_eq!(faults(text).len(), count, "{text}\n{:#?}", faults(text));
    }
}

#[test]
fn errors_are_limited() {
    assert_eq!(faults(&"a = *\n".repeat(1000)).len(), MAX_ERRORS);
}

#[test]
fn incomplete() {
    for (text, expected) in [
        ("", false),
        ("a = 1", false),
        ("a = (1 +", true),
        ("a = [1 2\n", true),
        ("a = [1 2\n\n", true),
        ("if a", true),
        ("if a\n", true),
        ("if a\n\n", false),
        ("if a\n    b = 1", true),
        ("if a\n    b = 1\n", false),
        ("function f(x)", true),
        ("a = )", false),
        ("else", true),
        ("a = \"x", false),
    ] {
        assert_eq!(is_incomplete(text), expected, "{text:?}");
    }
}

/// A thread with the smallest stack that the tree must fit.
fn on_small_stack(work: impl FnOnce() + Send + 'static) {
    std::thread::Builder::new().stack_size(2 << 20).spawn(work).unwrap().join().unwrap();
}

#[test]
fn depth_is_limited() {
    on_small_stack(|| {
        let n = 100_000;
        let chains = ["1 + ", "2 ^ ", "- ", "!", "a ? b : ", "a || ", "f(", "[", "(", "a[", "-("];
        for chain in chains {
            for n in [n, 1_000, MAX_DEPTH as usize / 3, MAX_BRACKETS, 100, 20] {
                let text = "x = ".to_string() + &chain.repeat(n) + "1\ny = 1 1";
                let errors = parse(SourceId::default(), &text).errors;
                assert!((1..3).contains(&errors.len()), "{chain} {n}: {errors:?}");
            }
        }
        for tail in ["[1]", ".x", "(1)", " - 1"] {
            let text = "x = a".to_string() + &tail.repeat(n);
            assert_eq!(parse(SourceId::default(), &text).errors.len(), 1, "{tail}");
        }
        let mut nested = String::new();
        for depth in 0..5_000 {
            nested += &" ".repeat(depth);
            nested += "if a\n";
        }
        assert!(faults(&nested)[0].contains("nested"));
    });
}

#[test]
fn deep_programs_within_the_limits_are_walked() {
    on_small_stack(|| {
        let deep = "(1 + ".repeat(MAX_BRACKETS - 1) + "1" + &")".repeat(MAX_BRACKETS - 1);
        let chain = "1 + ".repeat(MAX_DEPTH as usize - 1) + "1";
        let mut blocks = String::new();
        for depth in 0..MAX_BLOCKS {
            blocks += &" ".repeat(4 * depth);
            blocks += "if a\n";
        }
        blocks += &" ".repeat(4 * MAX_BLOCKS);
        for text in [format!("{deep}\n"), format!("{chain}\n"), format!("{blocks}{chain}\n")] {
            ok(&text);
            let printed = super::format(&text).unwrap();
            assert_eq!(super::format(&printed).unwrap(), printed);
        }
    });
}

#[test]
fn long_texts_take_bounded_time() {
    for unit in [
        "1 ",
        "a",
        "\"",
        "# ",
        "\n",
        "(\n",
        "[\n\n",
        "x = 1 ",
        "@",
        "é",
        "a\n",
        "a = [1 2\n",
        "{",
        "' ",
        "\t \n",
        "if a\n",
    ] {
        let text = unit.repeat(1_000_000 / unit.len());
        let started = std::time::Instant::now();
        parse(SourceId::default(), &text);
        is_incomplete(&text);
        assert!(started.elapsed().as_secs() < 20, "{unit:?}: {:?}", started.elapsed());
    }
    assert_eq!(faults(&" ".repeat(MAX_TEXT + 1)).len(), 1);
}
