//! `--profile`: what each line took.

use crate::cli::failure::warn;
use pse::internal::diagnostic::{Sources, Span};
use pse::internal::eval::{Profile, Spent};
use std::collections::BTreeMap;

/// Shorter shares are not shown for lines of other files.
const LEAST: f64 = 0.005;

/// Tells the lines of the program that took time, in its order, and those of other files that took most.
pub(super) fn print(profile: &Profile, sources: &Sources, pixels: usize) {
    let total: f64 = profile.values().map(|spent| spent.time.as_secs_f64()).sum::<f64>().max(1e-12);
    let mut lines: BTreeMap<(u32, usize), (Span, Spent)> = BTreeMap::new();
    let mut rest = Spent::default();
    for (span, spent) in profile {
        if *span == Span::default() {
            rest.add(spent);
            continue;
        }
        let line = sources.line_column(*span).0;
        lines.entry((span.source.0, line)).or_insert((*span, Spent::default())).1.add(spent);
    }
    warn(" share  ns/pixel  active  line");
    let share = |spent: &Spent| spent.time.as_secs_f64() / total;
    let each = |spent: &Spent| spent.time.as_secs_f64() * 1e9 / pixels.max(1) as f64;
    for ((source, line), (span, spent)) in &lines {
        let first = sources.get(span.source).text.lines().nth(line - 1).unwrap_or_default();
        let file = if *source == 0 { String::new() } else { format!("{}:", sources.get(span.source).name) };
        if *source != 0 && share(spent) < LEAST {
            continue;
        }
        let active = if spent.lanes == 0 {
            String::new()
        } else {
            format!("{:.0} %", 100.0 * spent.active as f64 / spent.lanes as f64)
        };
        warn(&format!(
            "{:4.1} %  {:8.2}  {active:>6}  {file}{line}: {}",
            100.0 * share(spent),
            each(spent),
            first.trim_end()
        ));
    }
    warn(&format!(
        "{:4.1} %  {:8.2}          reading variables and writing the outputs",
        100.0 * share(&rest),
        each(&rest)
    ));
}
