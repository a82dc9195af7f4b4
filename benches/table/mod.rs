//! Medians of a run of benchmarks, and a table of them in a document.

use serde_json::Value;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What benchmarks took, by their names.
pub struct Medians(HashMap<String, f64>);

impl Medians {
    /// Those that were measured since then: what earlier runs left is not of the same machine's mood.
    pub fn since(start: SystemTime) -> Medians {
        let mut medians = HashMap::new();
        if let Some(folder) = folder() {
            gather(&folder, start, &mut medians);
        }
        Medians(medians)
    }

    /// Whether nothing was measured.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The median of a benchmark in nanoseconds: of one element, if its group has a throughput of elements, or
    /// else of one call.
    ///
    /// # Panics
    /// If this run did not measure it.
    pub fn of(&self, group: &str, name: &str) -> f64 {
        let id = format!("{group}/{name}");
        *self.0.get(&id).unwrap_or_else(|| panic!("the table needs {id:?}, which this run did not measure"))
    }
}

/// Where criterion keeps its results.
fn folder() -> Option<PathBuf> {
    if let Some(home) = std::env::var_os("CRITERION_HOME") {
        return Some(home.into());
    }
    // The benchmark itself lies in the same target directory, wherever that is.
    let program = std::env::current_exe().ok()?;
    program.ancestors().map(|folder| folder.join("criterion")).find(|folder| folder.is_dir())
}

/// Reads all results in a folder and those below it. Names of folders are not those of the benchmarks (criterion
/// replaces characters, and cuts what is long), but `benchmark.json` has them.
fn gather(folder: &Path, start: SystemTime, medians: &mut HashMap<String, f64>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if !path.is_dir() {
            continue;
        }
        if entry.file_name() == "new" {
            medians.extend(median(&path, start));
        } else {
            gather(&path, start, medians);
        }
    }
}

/// The name of the benchmark of this folder, and its median; nothing if it is older.
fn median(folder: &Path, start: SystemTime) -> Option<(String, f64)> {
    let estimates = folder.join("estimates.json");
    if estimates.metadata().ok()?.modified().ok()? < start {
        return None;
    }
    let read = |path: &Path| serde_json::from_slice::<Value>(&std::fs::read(path).ok()?).ok();
    let (benchmark, estimates) = (read(&folder.join("benchmark.json"))?, read(&estimates)?);
    let elements = benchmark["throughput"]["Elements"].as_f64().unwrap_or(1.0);
    let median = estimates["median"]["point_estimate"].as_f64()?;
    Some((benchmark["full_id"].as_str()?.to_string(), median / elements))
}

/// Puts text between the lines `<!-- NAME begin -->` and `<!-- NAME end -->` of `docs/performance.md`, if `UPDATE=1`
/// asks for it.
///
/// # Panics
/// If the document has no such lines, or can't be read and written.
pub fn update(name: &str, text: impl FnOnce() -> String) {
    if std::env::var_os("UPDATE").is_none() {
        return;
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/performance.md");
    let document = std::fs::read_to_string(path).expect("docs/performance.md");
    let (begin, end) = (format!("<!-- {name} begin -->\n"), format!("<!-- {name} end -->"));
    let parts =
        document.split_once(&begin).and_then(|(before, rest)| Some((before, rest.split_once(&end)?.1)));
    let (before, after) = parts.unwrap_or_else(|| panic!("{path} has no place called {name}"));
    // Blank lines, or Markdown would not see a table between comments.
    let written = format!("{before}{begin}\n{}\n\n{end}{after}", text().trim_end());
    std::fs::write(path, written).expect("docs/performance.md can be written");
}
