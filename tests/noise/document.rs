//! What `docs/noise.md` says of the kinds: the numbers that were measured, and the contracts.

use super::measured::{self, Measured};
use std::fmt::Write;

/// The document, and the marks between which it is made.
const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/noise.md");

/// A number of three digits.
fn digits(x: f64) -> String {
    let text = format!("{x:.3}");
    // Nothing is as good as nothing below it.
    if text == "-0.000" { "0.000".into() } else { text }
}

fn percent(share: f64) -> String {
    format!("{:.1}", 100.0 * share)
}

/// The table of what was measured.
fn table() -> String {
    let mut text = String::from(
        "| kind | mean | deviation | range | kurtosis | below 0.3 | 0.3 to 0.7 | above 1 | smooth | steps | by direction | far | repeats | `Dnoise` | cost |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for m in measured::all() {
        let Measured { kind, moments, .. } = m;
        let [least, most] = m.ranges[kind.usual_dimensions() - kind.dimensions.start()];
        let (least, most) = (least.min(moments.least), most.max(moments.most));
        let cells = [
            format!("[{0}](#{0})", kind.name),
            digits(moments.mean),
            digits(moments.deviation),
            format!("{} … {}", digits(f64::from(least)), digits(f64::from(most))),
            digits(moments.kurtosis),
            percent(m.below),
            percent(m.band),
            percent(m.above),
            m.smoothness.to_string(),
            digits(m.slope_jump),
            digits(m.isotropy),
            digits(m.far),
            digits(m.shift),
            if m.derivative.is_finite() { format!("{:.4}", m.derivative) } else { "none".into() },
            kind.contract.cost.to_string(),
        ];
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text
}

/// Puts a text between two marks.
fn replace(document: &str, mark: &str, text: &str) -> String {
    let (open, close) = (format!("<!-- {mark} -->\n"), format!("<!-- end of {mark} -->"));
    let start = document.find(&open).unwrap_or_else(|| panic!("docs/noise.md has no {open}")) + open.len();
    let end = document.find(&close).unwrap_or_else(|| panic!("docs/noise.md has no {close}"));
    format!("{}{text}{}", &document[..start], &document[end..])
}

#[test]
fn the_document_is_up_to_date() {
    let written = std::fs::read_to_string(PATH).expect("docs/noise.md");
    let made = replace(&written, "measured", &table());
    let made = replace(&made, "options", &pse::noise::reference::options());
    let made = replace(&made, "kinds", &pse::noise::reference::markdown());
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(PATH, &made).expect("docs/noise.md can be written");
        return;
    }
    // Line by line, so that the message shows what differs.
    for (number, (old, new)) in written.lines().zip(made.lines()).enumerate() {
        assert_eq!(
            old,
            new,
            "docs/noise.md:{} is stale: UPDATE=1 cargo test --release --test noise",
            number + 1
        );
    }
    assert_eq!(written, made, "docs/noise.md is stale: UPDATE=1 cargo test --release --test noise");
}
