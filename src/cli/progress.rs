//! How far a run has come: a bar on the terminal, or lines for a farm.

use super::failure::print;
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use pse::internal::program::Progress;
use pse::internal::visible::visible_name;
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long no bar is shown, and how long a farm hears nothing.
const PATIENCE: Duration = Duration::from_secs(1);

/// How progress is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Style {
    /// A bar on the terminal when the run takes longer than a second
    #[default]
    Bar,
    /// `openjd_progress:` and `openjd_status:` lines on standard output, for Open Job Description
    Openjd,
    /// No progress
    None,
}

impl State {
    /// Takes the bar away.
    fn clear(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// What is told of the progress over all frames of a run, with an estimate of the time that is left.
pub(super) struct Meter {
    name: String,
    style: Style,
    /// Frames to run.
    frames: usize,
    start: Instant,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// Frames that are done, of those to run.
    done: usize,
    /// Frames that were there already.
    skipped: usize,
    bar: Option<ProgressBar>,
    told: Option<Instant>,
}

impl Meter {
    /// For a run of so many frames.
    pub fn new(name: &str, style: Style, quiet: bool, frames: usize) -> Meter {
        let seen = style != Style::Bar || !quiet && std::io::stderr().is_terminal();
        let style = if seen { style } else { Style::None };
        Meter { name: name.into(), style, frames, start: Instant::now(), state: Mutex::default() }
    }

    /// Tells how far the frame that is running has come. Any thread may call it.
    pub fn update(&self, progress: Progress) {
        let elapsed = self.start.elapsed();
        if self.style == Style::None || elapsed < PATIENCE {
            return;
        }
        // Whoever comes while another one tells has nothing newer to say.
        let Ok(mut state) = self.state.try_lock() else { return };
        let frames = self.frames - state.skipped;
        let part = progress.done as f64 / progress.total.max(1) as f64;
        let share = ((state.done as f64 + part) / frames.max(1) as f64).min(1.0);
        // The first pixels say little of the others: they also wait for all that is made once.
        let message = match share > 0.01 {
            true => format!("{}{} left", self.which(&state), shown(elapsed.mul_f64((1.0 - share) / share))),
            false => self.which(&state) + "begun",
        };
        if self.style == Style::Openjd {
            if state.told.is_none_or(|told| told.elapsed() >= PATIENCE) {
                state.told = Some(Instant::now());
                // If nobody reads it, the pixels are wanted all the same.
                let _ = print(&format!("openjd_progress: {:.1}\nopenjd_status: {message}\n", 100.0 * share));
            }
            return;
        }
        const STEPS: f64 = 1000.0;
        let bar = state.bar.get_or_insert_with(|| {
            let bar = ProgressBar::new(STEPS as u64);
            // The template is fixed and has no faults; without it the bar has its default look.
            if let Ok(style) = ProgressStyle::with_template("{prefix} {wide_bar} {percent:>3} %  {msg}") {
                bar.set_style(style);
            }
            bar.with_prefix(visible_name(&self.name).into_owned())
        });
        bar.set_position((share * STEPS) as u64);
        bar.set_message(message);
    }

    /// A frame was there already, and is not run.
    pub fn skip(&self) {
        self.lock().skipped += 1;
    }

    /// The frame is done. The bar goes, and comes again with the next frame: there is something to say in between.
    pub fn frame(&self) {
        let mut state = self.lock();
        state.done += 1;
        state.clear();
        if self.style == Style::Openjd {
            let share = state.done as f64 / (self.frames - state.skipped).max(1) as f64;
            let _ = print(&format!("openjd_progress: {:.1}\n", 100.0 * share.min(1.0)));
        }
    }

    /// All ends with a failure, which is told to the farm too.
    pub fn fail(&self, message: &str) {
        self.lock().clear();
        if self.style == Style::Openjd {
            // Without the mark before the message.
            let lines = message
                .lines()
                .map(|line| line.trim_start_matches(|c: char| !c.is_alphanumeric() && c != '`'));
            let line = lines.map(str::trim_end).find(|line| !line.is_empty());
            let _ = print(&format!("openjd_fail: {}\n", line.unwrap_or("it failed")));
        }
    }

    fn which(&self, state: &State) -> String {
        match self.frames {
            1 => String::new(),
            n => format!("frame {} of {n}, ", (state.done + state.skipped + 1).min(n)),
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A time in words: `12 s`, `3 min 20 s`, `2 h 5 min`.
fn shown(time: Duration) -> String {
    let seconds = time.as_secs_f64().ceil() as u64;
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{} min {} s", seconds / 60, seconds % 60),
        _ => format!("{} h {} min", seconds / 3600, seconds / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_in_words() {
        let words = [0.2, 59.5, 61.0, 7500.0].map(|s| shown(Duration::from_secs_f64(s)));
        assert_eq!(words, ["1 s", "1 min 0 s", "1 min 1 s", "2 h 5 min"]);
    }
}
