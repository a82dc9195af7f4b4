//! The solid noises, measured: every kind against the rules for noises, its contract and its limits.
//!
//! What is measured of each kind also makes the table in `docs/noise.md`, and its contracts the text there. After a
//! change rewrite it with `UPDATE=1 cargo test --release --test noise`.

mod contract;
mod convolution;
mod curl;
mod document;
mod limits;
mod measured;
mod sums;

use limits::{EXPECTED, RULES, holds};
use pse::noise::KINDS;

#[test]
fn all_kinds_are_there() {
    let names: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
    let missing: Vec<&str> =
        EXPECTED.iter().map(|limits| limits.name).filter(|n| !names.contains(n)).collect();
    assert!(missing.is_empty(), "there is no {}", missing.join(", "));
    for name in names {
        assert!(
            EXPECTED.iter().any(|limits| limits.name == name),
            "{name} has no limits: list it in limits.rs"
        );
    }
}

#[test]
fn every_kind_keeps_the_rules() {
    let mut wrong = Vec::new();
    for m in measured::all() {
        let limits = limits::of(m.kind.name);
        for rule in RULES {
            let (holds, found) = holds(rule, m, &limits);
            match limits.exception(rule) {
                None if !holds => wrong.push(format!("{:?} is not {rule:?}: {found}", m.kind)),
                Some(why) if holds => {
                    wrong.push(format!(
                        "{:?} is {rule:?} ({found}); it is excepted needlessly: {why}",
                        m.kind
                    ));
                }
                _ => {}
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn energy_lies_where_it_should() {
    let mut wrong = Vec::new();
    for m in measured::all() {
        let limits = limits::of(m.kind.name);
        let shares = [("below 0.3", m.below, limits.below), ("0.3 to 0.7", m.band, limits.band)];
        for (what, share, [least, most]) in shares.into_iter().chain([("above 1", m.above, limits.above)]) {
            if !(least..=most).contains(&share) {
                wrong.push(format!("{:?} {what}: {share:.4}, expected {least} to {most}", m.kind));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
