//! Where the time of a run went.

use super::failure::warn;
use std::time::Duration;

/// What is known about a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Stats {
    /// Reading or rendering the input.
    pub read: Duration,
    /// Running the program; each time that it ran.
    pub runs: Vec<Duration>,
    /// Writing the outputs.
    pub write: Duration,
    /// All of it, on the clock on the wall: the three overlap.
    pub wall: Duration,
    /// Pixels that it ran at.
    pub pixels: usize,
    /// Pixels that hold NaN or an infinity.
    pub not_finite: usize,
    /// Threads that ran.
    pub threads: usize,
    /// Samples of a pixel.
    pub samples: usize,
    /// Lanes of a batch.
    pub batch: usize,
    /// Rows that are read, run and written at a time.
    pub rows: usize,
    /// Files that are in memory as a whole, and why.
    pub whole: Vec<String>,
    /// The instruction set.
    pub isa: &'static str,
}

impl Stats {
    /// The time of a run: the median of all.
    pub fn run(&self) -> Duration {
        let mut runs = self.runs.clone();
        runs.sort();
        runs.get(runs.len() / 2).copied().unwrap_or_default()
    }

    /// Nanoseconds a pixel.
    pub fn per_pixel(&self) -> f64 {
        self.run().as_nanos() as f64 / self.pixels.max(1) as f64
    }

    /// Millions of pixels a second, of all of it.
    pub fn rate(&self) -> f64 {
        self.pixels as f64 / 1e6 / self.wall.as_secs_f64().max(1e-9)
    }

    /// Tells everything.
    pub fn print(&self) {
        let seconds = |d: Duration| format!("{:.4} s", d.as_secs_f64());
        warn(&format!("read                 {}", seconds(self.read)));
        warn(&format!("run                  {}", seconds(self.run())));
        warn(&format!("write                {}", seconds(self.write)));
        warn(&format!("total                {}, the three overlap", seconds(self.wall)));
        warn(&format!("run                  {:.2} ns/pixel", self.per_pixel()));
        if self.samples > 1 {
            warn(&format!("samples              {}", self.samples));
        }
        warn(&format!("threads              {}", self.threads));
        warn(&format!("batch                {}", self.batch));
        warn(&format!("rows per band        {}", self.rows));
        for file in &self.whole {
            warn(&format!("held in memory       {file}"));
        }
        warn(&format!("instruction set      {}", self.isa));
        warn(&format!("NaN or infinity at   {} pixels", self.not_finite));
        if let Some(peak) = peak_memory() {
            warn(&format!("peak memory          {:.1} MB", peak as f64 / 1e6));
        }
    }
}

/// The most bytes of memory that this process has held, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kb| kb * 1024)
}
