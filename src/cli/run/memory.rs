//! How much memory a run takes, judged before it begins: that decides how many rows are taken at a time.

use super::RunArgs;
use super::input::FrameInput;
use super::plan::{Output, Plan};
use crate::cli::failure::Failure;
use pse::image::Format;
use pse::internal::program::{RunOptions, Stream};
use std::ops::Range;

/// The process itself, its threads and the program.
const BASE: u64 = 16 << 20;

/// Of what is judged so much more is taken: allocators do not give all back.
const SLACK: f64 = 1.15;

/// Bytes that textures may take, and the values of each thread: of what `--memory` allows no more than
/// a quarter and an eighth.
pub(super) fn shares(args: &RunArgs, threads: usize) -> (usize, usize) {
    let (textures, values) = (args.limits.textures(), args.limits.limits().memory);
    match args.memory {
        None => (textures, values),
        Some(most) => {
            let most = (most as usize) << 20;
            (textures.min(most / 4), values.min(most / 8 / threads.max(1)))
        }
    }
}

/// How many rows are taken at a time; `None`: as many as is usual.
///
/// # Errors
/// If the run does not fit in what `--memory` allows.
pub(super) fn rows(
    args: &RunArgs,
    plan: &Plan,
    input: &FrameInput,
    outputs: &[Output],
    options: &RunOptions<'_>,
    stream: &mut Stream<'_>,
) -> Result<Option<usize>, Failure> {
    let Some(most) = args.memory else { return Ok(None) };
    // The first row tells how many numbers a pixel has, before and after.
    let band = input.reader(plan)?.read(input.first_row())?;
    let planes = |image: &pse::image::Image<'_>| -> u64 {
        image.variables.iter().map(|variable| variable.planes.len() as u64).sum()
    };
    let report = loop {
        // A second time where an output is wider here than those before it.
        if let Some(report) = stream.rows(&band.image, band.rows.clone())? {
            break report;
        }
    };
    let threads = options.threads.unwrap_or_else(rayon::current_num_threads) as u64;
    let (textures, values) = shares(args, threads as usize);
    let textures = if plan.program.resolved().textures.is_empty() { 0 } else { textures as u64 };
    let values = threads * values as u64;
    let about = input.about()?;
    let whole = about.resolution().iter().product::<usize>() as u64;
    let written = |output: &Output| match output.format {
        Format::Exr | Format::Png => 0,
        Format::Hdr => whole * 24,
        // The codes, and what the encoder makes of them.
        _ => whole * 4 * u64::from(args.bits.unwrap_or(8) / 8) * 2,
    };
    let pictures: u64 = outputs.iter().map(written).sum();
    let judged = Judged {
        columns: band.image.width as u64,
        around: 2 * input.around() as u64,
        inputs: planes(&band.image),
        outputs: planes(&report.image),
        sampled: options.samples.is_some(),
        pictures: outputs.iter().any(|output| output.format != Format::Exr),
        fixed: BASE + textures + values + input.fixed() + pictures,
    };
    let most_bytes = (most as u64) << 20;
    let one = input.bands(None).first().map_or(1, Range::len) as u64;
    // What runs several times runs in one piece.
    let least = if args.repeat.is_some() { one } else { 1 };
    match judged.rows(most_bytes).filter(|rows| *rows >= least) {
        Some(rows) => Ok(Some(rows.min(one) as usize)),
        None => {
            let needed = judged.bytes(least).div_ceil(1 << 20);
            let failure =
                Failure::plain(format!("the run needs about {needed} MB, and --memory allows {most}"));
            // Textures and values get a share of what there is, so that they need more of more.
            let enough = (needed as f64 * 1.7).ceil();
            let mut failure = failure.hint(format!("Allow more: --memory {enough}."));
            if pictures > 0 || input.inputs.list.iter().any(|opened| !opened.file.streams()) {
                failure = failure.hint("Only EXR and PNG are read and written row by row.");
            }
            Err(failure)
        }
    }
}

/// What the memory of a run depends on.
struct Judged {
    columns: u64,
    /// Rows that are read beside those of a band.
    around: u64,
    /// Numbers of a pixel that are read, and that are written.
    inputs: u64,
    outputs: u64,
    sampled: bool,
    /// Is anything but EXR written?
    pictures: bool,
    /// Bytes that are there whatever the height.
    fixed: u64,
}

impl Judged {
    /// Bytes, with bands of so many rows.
    fn bytes(&self, rows: u64) -> u64 {
        // Of a band: one is being read, beside what the file's blocks hold more; one waits; one runs, with what is made
        // of it for the pixels; and as many outputs, of which one is packed.
        let read = 4 * self.inputs * (rows + self.around + BLOCK) + 4 * rows;
        let sampled = if self.sampled { self.inputs + 4 * self.outputs } else { 0 };
        let written = 6 * self.outputs + if self.pictures { 10 } else { 0 };
        let numbers = self.columns * (read + (sampled + written) * rows);
        ((self.fixed + 4 * numbers) as f64 * SLACK) as u64
    }

    /// The most rows that stay within so many bytes; `None` if not even one does.
    fn rows(&self, bytes: u64) -> Option<u64> {
        let one = self.bytes(1);
        let more = (self.bytes(1025) - one).div_ceil(1024).max(1);
        let rows = 1 + bytes.checked_sub(one)? / more;
        // Whole blocks, where there are any.
        Some(if rows > BLOCK { rows / BLOCK * BLOCK } else { rows })
    }
}

/// Rows of a block of most EXR files.
const BLOCK: u64 = 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_memory_is_more_rows() {
        let judged = Judged {
            columns: 1000,
            around: 4,
            inputs: 7,
            outputs: 3,
            sampled: false,
            pictures: true,
            fixed: BASE,
        };
        let least = judged.bytes(1);
        assert_eq!(judged.rows(least - 1), None);
        assert_eq!(judged.rows(least), Some(1));
        let mut before = 1;
        for more in 1..200 {
            let bytes = least + (more << 20);
            let rows = judged.rows(bytes).expect("it fits");
            assert!(rows >= before && judged.bytes(rows) <= bytes, "{rows} rows in {bytes}");
            before = rows;
        }
        assert!(before > 500 && before % BLOCK == 0, "{before}");
    }
}
