//! A bar on the terminal for runs that take a while.

use crate::program::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// How long nothing is shown.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar that comes after a second, if anybody sees it.
pub(super) struct Bar {
    start: Instant,
    seen: bool,
    name: String,
    bar: OnceLock<ProgressBar>,
}

impl Bar {
    /// A bar for the run of a program; none if `quiet`.
    pub fn new(name: &str, quiet: bool) -> Bar {
        let seen = !quiet && std::io::stderr().is_terminal();
        Bar { start: Instant::now(), seen, name: name.into(), bar: OnceLock::new() }
    }

    /// Shows how far it has come. Any thread may call it.
    pub fn update(&self, progress: Progress) {
        if !self.seen || self.start.elapsed() < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_init(|| {
            let bar = ProgressBar::new(progress.total as u64);
            // The template is fixed and has no faults; without it the bar has its default look.
            if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} %  {eta} left") {
                bar.set_style(style);
            }
            bar.with_message(self.name.clone())
        });
        bar.set_position(progress.done as u64);
    }

    /// Takes it away.
    pub fn clear(&self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}
