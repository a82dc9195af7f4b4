//! Tables for the documentation, most in `docs/performance.md`, of things that are measured in turns.
//!
//! Criterion measures one thing after another, so that on a machine that is shared a ratio of two follows its mood. Here all
//! take turns, and a ratio is the median of those of single rounds.

use std::time::Instant;

/// What is measured, by name.
pub type Run<'a> = (String, Box<dyn FnMut() + 'a>);

/// What rounds of turns took, in nanoseconds.
pub struct Turns(Vec<(String, Vec<f64>)>);

impl Turns {
    /// Lets all take turns, so many times, after one that does not count.
    pub fn of(rounds: usize, mut runs: Vec<Run<'_>>) -> Turns {
        let mut times: Vec<(String, Vec<f64>)> =
            runs.iter().map(|(name, _)| (name.clone(), Vec::new())).collect();
        runs.iter_mut().for_each(|(_, run)| run());
        for _ in 0..rounds {
            for ((_, run), (_, times)) in runs.iter_mut().zip(&mut times) {
                let start = Instant::now();
                run();
                times.push(start.elapsed().as_nanos() as f64);
            }
        }
        Turns(times)
    }

    fn times(&self, name: &str) -> &[f64] {
        let found = self.0.iter().find(|(n, _)| n == name);
        &found.unwrap_or_else(|| panic!("the table needs {name:?}, which was not measured")).1
    }

    /// The median of one.
    ///
    /// # Panics
    /// If it was not measured.
    pub fn median(&self, name: &str) -> f64 {
        median(self.times(name).to_vec())
    }

    /// The median ratio of one to another in the same round.
    ///
    /// # Panics
    /// If one was not measured.
    pub fn ratio(&self, name: &str, to: &str) -> f64 {
        median(self.times(name).iter().zip(self.times(to)).map(|(a, b)| a / b).collect())
    }
}

fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

/// Are the tables to be written, instead of what criterion measures?
pub fn updating() -> bool {
    std::env::var_os("UPDATE").is_some()
}

/// Puts text between the lines `<!-- NAME begin -->` and `<!-- NAME end -->` of `docs/performance.md`.
///
/// # Panics
/// If the document has no such lines, or can't be read and written.
pub fn update(name: &str, text: &str) {
    update_in("performance", name, text);
}

/// The same of another document in `docs`, by its name.
///
/// # Panics
/// As [`update`].
pub fn update_in(document: &str, name: &str, text: &str) {
    let path = format!("{}/docs/{document}.md", env!("CARGO_MANIFEST_DIR"));
    let document = std::fs::read_to_string(&path).expect(&path);
    let (begin, end) = (format!("<!-- {name} begin -->\n"), format!("<!-- {name} end -->"));
    let parts =
        document.split_once(&begin).and_then(|(before, rest)| Some((before, rest.split_once(&end)?.1)));
    let (before, after) = parts.unwrap_or_else(|| panic!("{path} has no place called {name}"));
    // Blank lines, or Markdown would not see a table between comments.
    let written = format!("{before}{begin}\n{}\n\n{end}{after}", text.trim_end());
    std::fs::write(&path, written).expect(&path);
}
