//! The drawing: a coarse picture soon, then the whole one; what is out of date is left.

use super::session::{Job, Ran, Session};
use super::source::{Picture, Pictures};
use super::told::{self, Told};
use super::watch::Watcher;
use crate::cli::failure::Failure;
use pse::Disk;
use pse::internal::program::{Compiler, ParamInfo, Program, Progress, RunOptions};
use pse::internal::resolve::tree::Resolved;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Of a coarse picture every so many columns and rows are drawn.
const COARSE: usize = 4;

/// Whole pictures that took no longer than this come alone: a coarse one before them would only flicker.
const SOON: Duration = Duration::from_millis(30);

/// How often the pages are told how far a picture has come.
const NEWS: Duration = Duration::from_millis(100);

/// What the drawing remembers.
struct Drawing {
    pictures: Pictures,
    watcher: Watcher,
    /// The last program, its text, and the state of the files that it was made of.
    compiled: Option<(Arc<Program>, String, u64)>,
    /// How long the last whole picture took.
    took: Option<Duration>,
}

/// Draws whatever is newest, for ever.
pub(super) fn for_ever(session: &Session, pictures: Pictures, watcher: Watcher) -> ! {
    let mut drawing = Drawing { pictures, watcher, compiled: None, took: None };
    let mut done = 0;
    // What was last reported in the terminal.
    let mut said: Option<String> = None;
    loop {
        let job = session.next(done);
        done = job.version;
        match drawing.draw(session, &job) {
            Ok(()) | Err(Failure::Interrupted) => {}
            Err(failure) => {
                let mut state = session.state();
                // Of an older text nobody wants to hear.
                if state.version == job.version {
                    // An empty page is no mistake yet.
                    let begun = !job.text.trim().is_empty();
                    state.error = begun.then(|| told::failure(&failure));
                    session.tell_state(&mut state);
                    drop(state);
                    // What is wrong with a program is on the page, where it is written; a file may be missing before any
                    // page is open.
                    let message = failure.message();
                    if matches!(failure, Failure::Plain(_)) && said.as_ref() != Some(&message) {
                        failure.report();
                        said = Some(message);
                    }
                }
            }
        }
    }
}

impl Drawing {
    fn draw(&mut self, session: &Session, job: &Job) -> Result<(), Failure> {
        self.watcher.watch(&self.files(session, job));
        let program = self.compile(session, job)?;
        self.watcher.watch(&self.files(session, job));
        let picture = self.pictures.read(&program, &job.also, job.frame, job.files)?;
        let missing = |name: &str| picture.inputs.missing(name);
        let options = RunOptions {
            missing: if picture.inputs.list.is_empty() { None } else { Some(&missing) },
            cancel: Some(&session.late),
            ..session.options(job.frame, &job.set, &program)
        };
        let camera = picture.camera(&program, &job.set, &session.fixed.spaces)?;
        let options = camera.options(options);
        let unset = RunOptions { set: Vec::new(), ..options.clone() };
        let params = program.params(&picture.image, &unset)?;
        self.tell(session, job, &program, params);
        let options =
            RunOptions { outputs: outputs(&program, &picture, &job.also), keep_alpha: true, ..options };
        let size = [picture.image.width, picture.image.height];
        let started = Instant::now();
        if self.took.is_none_or(|took| took > SOON) && size[0].min(size[1]) > 8 * COARSE {
            let coarse = RunOptions { every: COARSE, ..options.clone() };
            self.show(session, job, &program, &picture, &coarse, started)?;
        }
        let news = Mutex::new(Instant::now());
        let progress = |progress: Progress| {
            let Ok(mut last) = news.try_lock() else { return ControlFlow::Continue(()) };
            if last.elapsed() > NEWS {
                *last = Instant::now();
                let told = serde_json::json!({"done": progress.done, "total": progress.total});
                session.tell(&mut session.state(), "progress", &told);
            }
            ControlFlow::Continue(())
        };
        let soon = self.took.is_some_and(|took| took <= SOON);
        let cancel = if soon { &session.late } else { &session.cancel };
        let options = RunOptions { progress: Some(&progress), cancel: Some(cancel), ..options };
        self.took = Some(self.show(session, job, &program, &picture, &options, started)?);
        Ok(())
    }

    /// The program of the job's text.
    fn compile(&mut self, session: &Session, job: &Job) -> Result<Arc<Program>, Failure> {
        if let Some((program, text, files)) = &self.compiled
            && *text == job.text
            && *files == job.files
        {
            return Ok(Arc::clone(program));
        }
        let host = Disk { path: session.fixed.path.clone() };
        let known = self.pictures.known();
        let doubt = |program: &Resolved, name: &str, span| known.doubt_before_run(program, name, span);
        let program = Compiler::new().host(&host).doubt(&doubt).compile(&session.name(), &job.text)?;
        // Textures that are read already need not be read for each letter that is typed.
        if let Some((old, _, files)) = &self.compiled
            && *files == job.files
        {
            program.share_textures(old);
        }
        let program = Arc::new(program);
        self.compiled = Some((Arc::clone(&program), job.text.clone(), job.files));
        Ok(program)
    }

    /// All that a picture is made of.
    fn files(&self, session: &Session, job: &Job) -> Vec<PathBuf> {
        let mut files = vec![session.fixed.file.clone()];
        files.extend(self.pictures.files(job.frame));
        if let Some((program, ..)) = &self.compiled {
            files.extend(program.files(job.frame));
        }
        files
    }

    /// Tells the pages what the program is about.
    fn tell(&self, session: &Session, job: &Job, program: &Program, params: Vec<ParamInfo>) {
        let mut state = session.state();
        if state.version != job.version {
            return;
        }
        let reads_frame = program.resolved().globals.iter().any(|g| g.name == "frame" && g.read.is_some());
        // What was wrong was wrong with another text.
        state.error = None;
        state.params = params;
        state.inputs = self.pictures.names();
        state.assigned = program.assigned().map(str::to_string).collect();
        state.animated = reads_frame || self.pictures.animated() || program.has_texture_sequence();
        session.tell_state(&mut state);
    }

    /// Runs the program and tells of its picture.
    fn show(
        &self,
        session: &Session,
        job: &Job,
        program: &Arc<Program>,
        picture: &Picture,
        options: &RunOptions<'_>,
        started: Instant,
    ) -> Result<Duration, Failure> {
        let begin = Instant::now();
        let report = program.run(&picture.image, options)?;
        let took = begin.elapsed();
        let size = [picture.image.width, picture.image.height];
        // Perhaps there is something newer to draw; this is newer than what is on the screen.
        let mut state = session.state();
        let full = options.every <= 1;
        let drawn = session.keep(&mut state, report.image);
        let told = Told {
            id: drawn.id,
            full,
            size,
            milliseconds: 1000.0 * if full { took } else { started.elapsed() }.as_secs_f64(),
            odd: report.not_finite,
            frame: job.frame,
        };
        let told = told::picture(&told, &drawn.image);
        session.tell(&mut state, "picture", &told);
        state.picture = Some(told);
        state.ran = Some(Arc::new(Ran {
            program: Arc::clone(program),
            picture: picture.clone(),
            frame: job.frame,
            set: job.set.clone(),
        }));
        Ok(took)
    }
}

/// The outputs of the program, and what else is to be shown. `None`: the program's own.
fn outputs(program: &Program, picture: &Picture, also: &[String]) -> Option<Vec<String>> {
    if also.is_empty() {
        return None;
    }
    let mut names = program.default_outputs();
    let known =
        |name: &&String| program.assigned().any(|n| n == *name) || picture.image.variable(name).is_some();
    for name in also.iter().filter(known) {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    Some(names)
}
