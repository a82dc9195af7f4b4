//! Reading, running and writing at the same time: each band of rows goes from one to the next.

use super::RunArgs;
use super::digest::Digest;
use super::input::{Band, FrameInput};
use super::memory;
use super::plan::{Output, Plan};
use crate::cli::failure::Failure;
use crate::cli::output;
use crate::cli::stats::Stats;
use pse::image::{Format, Image, WriteOptions, Writer};
use pse::internal::eval::{Prints, Profile};
use pse::internal::program::{RunOptions, Stream};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// What a run of all bands gave, but for the pixels.
#[derive(Default)]
pub(super) struct Outcome {
    pub stats: Stats,
    pub by_normal: bool,
    /// What was printed, band after band.
    pub prints: Prints,
    pub profile: Option<Profile>,
    /// Of the numbers that were computed, if it is wanted.
    pub digest: Option<String>,
}

/// Runs all bands and writes the outputs. `done` counts the pixels of the bands that are run.
pub(super) fn run(
    args: &RunArgs,
    plan: &Plan,
    input: &FrameInput,
    outputs: &[Output],
    stamp: Option<&str>,
    options: &RunOptions<'_>,
    done: &AtomicUsize,
) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let mut stream = plan.program.stream(options);
    loop {
        done.store(0, Ordering::Relaxed);
        let most = memory::rows(args, plan, input, outputs, options, &mut stream)?;
        let bands = input.bands(most);
        let attempt = Attempt { args, plan, input, bands: &bands, outputs, stamp, done };
        if let Some(mut outcome) = attempt.run(&mut stream)? {
            outcome.stats.wall = start.elapsed();
            outcome.stats.rows = bands.first().map_or(0, |rows| rows.len());
            outcome.stats.whole = whole(input, outputs);
            return Ok(outcome);
        }
        // An output has become wider on the way: all bands again.
    }
}

/// What is in memory as a whole, and why.
fn whole(input: &FrameInput, outputs: &[Output]) -> Vec<String> {
    let mut list = Vec::new();
    for file in input.inputs.list.iter().map(|opened| &opened.file) {
        list.extend(file.whole().map(|why| format!("{}: {why}", file.name())));
    }
    for output in outputs.iter().filter(|o| !matches!(o.format, Format::Exr | Format::Png)) {
        list.push(format!("{}: only EXR and PNG are written row by row", output::shown(&output.path)));
    }
    list
}

/// One way through all bands.
struct Attempt<'a> {
    args: &'a RunArgs,
    plan: &'a Plan,
    input: &'a FrameInput,
    /// The rows of each band.
    bands: &'a [Range<usize>],
    outputs: &'a [Output],
    stamp: Option<&'a str>,
    done: &'a AtomicUsize,
}

impl<'a> Attempt<'a> {
    /// `None`: to be begun again.
    fn run(&self, stream: &mut Stream<'_>) -> Result<Option<Outcome>, Failure> {
        // A place in each of the two queues: while a band runs, the next is read and the last one written.
        let (read, bands) = sync_channel(1);
        let (run, images) = sync_channel(1);
        let (ran, read, written) = thread::scope(|scope| {
            let reader = scope.spawn(move || self.read(&read));
            let writer = scope.spawn(move || self.write(&images));
            let ran = self.run_bands(stream, bands, run);
            (ran, reader.join(), writer.join())
        });
        let (Ok(read), Ok(written)) = (read, written) else {
            return Err(Failure::plain("internal error: a thread ended early"));
        };
        // Where writing fails the bands after are not run; the writer says why.
        let (writers, digest, mut write) = match (written, &ran) {
            (Err(failure), Ok(_) | Err(None)) => return Err(failure),
            (Ok(written), _) => written,
            (Err(_), Err(Some(_))) => Default::default(),
        };
        let Some(mut outcome) = ran.map_err(|failure| failure.unwrap_or(Failure::Said))? else {
            return Ok(None);
        };
        let start = Instant::now();
        for writer in writers {
            writer.finish()?;
        }
        write += start.elapsed();
        (outcome.stats.read, outcome.stats.write) = (read, write);
        outcome.digest = digest;
        Ok(Some(outcome))
    }

    /// Reads band after band, and says how long it took.
    fn read(&self, bands: &SyncSender<Result<Band<'a>, Failure>>) -> Duration {
        let start = Instant::now();
        let mut waited = Duration::ZERO;
        let mut send = |band| {
            let start = Instant::now();
            let sent = bands.send(band).is_ok();
            waited += start.elapsed();
            sent
        };
        match self.input.reader(self.plan) {
            Err(failure) => {
                send(Err(failure));
            }
            Ok(mut reader) => {
                // Nobody takes a band any more when something else has failed.
                self.bands.iter().cloned().all(|rows| {
                    let band = reader.read(rows);
                    let good = band.is_ok();
                    send(band) && good
                });
            }
        }
        start.elapsed() - waited
    }

    /// Writes band after band to all outputs, which are still to be finished.
    fn write(
        &self,
        images: &Receiver<Image<'static>>,
    ) -> Result<(Vec<Writer>, Option<String>, Duration), Failure> {
        let mut took = Duration::ZERO;
        let mut writers = Vec::new();
        let mut digest: Option<Digest> = None;
        let options = WriteOptions { stamp: self.stamp.map(String::from), ..self.args.write_options() };
        for image in images {
            let start = Instant::now();
            if self.args.hash {
                let height = self.input.about()?.height;
                digest.get_or_insert_with(|| Digest::new(&image, height)).rows(&image);
            }
            for (i, output) in self.outputs.iter().enumerate() {
                if writers.len() == i {
                    let height = self.input.about()?.height;
                    writers.push(Writer::create(&output.path, height, &options)?);
                }
                match &self.plan.shown {
                    Some(name) if output.format != Format::Exr => {
                        writers[i].rows(&output::picture(&image, name)?)?;
                    }
                    _ => writers[i].rows(&image)?,
                }
            }
            took += start.elapsed();
        }
        Ok((writers, digest.map(|d| d.finish()), took))
    }

    /// Runs band after band. `None` as the failure: the writer has ended.
    fn run_bands(
        &self,
        stream: &mut Stream<'_>,
        bands: Receiver<Result<Band<'a>, Failure>>,
        images: SyncSender<Image<'static>>,
    ) -> Result<Option<Outcome>, Option<Failure>> {
        let mut outcome = Outcome::default();
        let repeat = self.args.repeat.unwrap_or(1);
        outcome.stats.runs = vec![Duration::ZERO; repeat];
        let alone = self.bands.len() == 1;
        for band in bands {
            let Band { image, rows } = band.map_err(Some)?;
            let mut last = None;
            for run in &mut outcome.stats.runs {
                let start = Instant::now();
                let report = stream.rows(&image, rows.clone()).map_err(|e| Some(e.into()))?;
                let Some(report) = report else { return Ok(None) };
                // Beside reading and writing the clock on the wall tells little.
                *run += if alone { start.elapsed() } else { report.time };
                last = Some(report);
            }
            let Some(mut report) = last else { continue };
            let held = report.image.width * report.image.height;
            report.image = self.input.cut(report.image).map_err(Some)?;
            let pixels = report.image.width * report.image.height;
            if pixels != held {
                // What passes through from the input is not the program's.
                let shown = report.by_normal;
                let assigned = |name: &str| self.plan.program.assigned().any(|n| n == name);
                let own = |name: &str| shown && name == "color" || assigned(name);
                report.not_finite = report.image.not_finite(own);
            }
            let once = outcome.stats.pixels == 0;
            let stats = &mut outcome.stats;
            stats.pixels += pixels;
            stats.not_finite += report.not_finite;
            stats.threads = stats.threads.max(report.threads);
            // What runs once a frame is run for each band, and prints each time.
            for prints in once.then_some(&report.frame_prints).into_iter().chain([&report.prints]) {
                outcome.prints.count += prints.count;
                outcome.prints.lines.extend(prints.lines.iter().cloned());
            }
            outcome.by_normal |= report.by_normal;
            match (&mut outcome.profile, report.profile) {
                (Some(all), Some(more)) => {
                    more.iter().for_each(|(place, spent)| all.entry(*place).or_default().add(spent));
                }
                (all, more) => *all = more,
            }
            self.done.fetch_add(held, Ordering::Relaxed);
            images.send(report.image).map_err(|_| None)?;
        }
        Ok(Some(outcome))
    }
}
