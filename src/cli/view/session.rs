//! What the preview knows: the text, what is set, and the pictures that came of it. Every page shows the same.

use super::disk::OnDisk;
use super::source::Picture;
use super::told;
use crate::cli::failure::Failure;
use crate::cli::frames::Frame;
use crate::cli::run::set;
use pse::image::{Image, Matrix4, same_file, write_program};
use pse::internal::program::{Limits, ParamInfo, Program, RunOptions};
use pse::internal::value::PixelValue;
use serde_json::Value;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Pictures that a page may still fetch after newer ones are told.
const PICTURES: usize = 4;

/// What is drawn soon is drawn to its end for so long, although there may be something newer: a slider that is dragged
/// would otherwise show nothing until it rests.
const GRACE: Duration = Duration::from_millis(200);

/// What stays as it is.
pub(super) struct Fixed {
    /// The program's file.
    pub file: PathBuf,
    /// Folders to look in for imports and textures.
    pub path: Vec<PathBuf>,
    /// Where named spaces are.
    pub spaces: Vec<(String, Matrix4)>,
    /// How far apart pixels lie, if that was given.
    pub pixelsize: Option<f32>,
    /// What a pixel may use up.
    pub limits: Limits,
    /// Bytes that textures may take.
    pub texture_memory: usize,
}

/// A picture to fetch.
pub(super) struct Drawn {
    /// Its number; newer ones have larger ones.
    pub id: u64,
    /// The outputs.
    pub image: Image<'static>,
}

/// A program that ran, and on what: enough to look into its pixels.
pub(super) struct Ran {
    /// The program.
    pub program: Arc<Program>,
    /// What it ran on.
    pub picture: Picture,
    /// What it ran with.
    pub frame: Frame,
    /// Values that were set.
    pub set: Vec<(String, PixelValue)>,
}

/// What changes.
pub(super) struct State {
    /// The text as the pages have it.
    pub text: String,
    /// What is in the file, as it was last seen.
    pub disk: OnDisk,
    /// The text that the file had when it last had one.
    base: Option<String>,
    /// How often the file was seen to change. A page whose text is of an earlier state would undo that change.
    pub saves: u64,
    /// Whether the file's lines end as those of Windows do. The pages' end with a line feed alone.
    windows: bool,
    /// The page that changed the text last.
    pub from: String,
    /// Did the file change while a page had changes of its own?
    pub conflict: bool,
    /// Params that are set: name, text, value.
    pub set: Vec<(String, String, PixelValue)>,
    /// The frame.
    pub frame: Frame,
    /// Variables to show beside the outputs.
    pub also: Vec<String>,
    /// The number of the newest change that asks for a picture.
    pub version: u64,
    /// The number of the newest change of files beside the program.
    pub files: u64,
    /// The params of the last program that could be run.
    pub params: Vec<ParamInfo>,
    /// Variables of the image, and those that the program assigns.
    pub inputs: Vec<String>,
    /// What the program assigns.
    pub assigned: Vec<String>,
    /// Is there anything that changes from frame to frame?
    pub animated: bool,
    /// What is wrong with the text, or went wrong.
    pub error: Option<Value>,
    /// What ran last without a fault.
    pub ran: Option<Arc<Ran>>,
    /// What pages are told of the last picture.
    pub picture: Option<Value>,
    drawn: VecDeque<Arc<Drawn>>,
    drawings: u64,
    pages: Vec<Sender<String>>,
    /// The number of the change that is being drawn, and when that began.
    drawing: u64,
    begun: Option<Instant>,
}

/// A preview.
pub(super) struct Session {
    /// What stays as it is.
    pub fixed: Fixed,
    state: Mutex<State>,
    /// Held while the file is compared and replaced.
    saving: Mutex<()>,
    changed: Condvar,
    /// Set when what runs is out of date.
    pub cancel: AtomicBool,
    /// Set when it is, and has been running for a while.
    pub late: AtomicBool,
}

/// What to draw.
pub(super) struct Job {
    pub version: u64,
    pub files: u64,
    pub text: String,
    pub set: Vec<(String, PixelValue)>,
    pub frame: Frame,
    pub also: Vec<String>,
}

impl Session {
    /// A preview of this text.
    pub fn new(fixed: Fixed, text: String, frame: Frame, set: Vec<(String, String, PixelValue)>) -> Session {
        let windows = text.contains("\r\n");
        let text = if windows { text.replace("\r\n", "\n") } else { text };
        let disk = OnDisk::read(&fixed.file);
        // It may have changed since the text was read; then that is a change.
        let base = disk.text().map(|_| text.clone());
        let disk = if base.is_some() { OnDisk::Text { text: text.clone(), windows } } else { disk };
        let state = State {
            text,
            disk,
            base,
            saves: 0,
            windows,
            from: String::new(),
            conflict: false,
            set,
            frame,
            also: Vec::new(),
            version: 1,
            files: 0,
            params: Vec::new(),
            inputs: Vec::new(),
            assigned: Vec::new(),
            animated: false,
            error: None,
            ran: None,
            picture: None,
            drawn: VecDeque::new(),
            drawings: 0,
            pages: Vec::new(),
            drawing: 0,
            begun: None,
        };
        Session {
            fixed,
            state: Mutex::new(state),
            saving: Mutex::new(()),
            changed: Condvar::new(),
            cancel: AtomicBool::new(false),
            late: AtomicBool::new(false),
        }
    }

    /// What messages call the program.
    pub fn name(&self) -> String {
        self.fixed.file.display().to_string()
    }

    /// The state. Whoever held it left it whole: nothing in here is changed in two steps.
    pub fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks for a new picture: what runs is out of date.
    fn redraw(&self, state: &mut State) {
        state.version += 1;
        self.cancel.store(true, Ordering::Relaxed);
        self.changed.notify_all();
    }

    /// Waits for something newer to draw.
    pub fn next(&self, done: u64) -> Job {
        let mut state = self.state();
        while state.version == done {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        self.cancel.store(false, Ordering::Relaxed);
        self.late.store(false, Ordering::Relaxed);
        (state.drawing, state.begun) = (state.version, Some(Instant::now()));
        Job {
            version: state.version,
            files: state.files,
            text: state.text.clone(),
            set: state.set.iter().map(|(name, _, value)| (name.clone(), value.clone())).collect(),
            frame: state.frame,
            also: state.also.clone(),
        }
    }

    /// Ends, for ever, what is still being drawn although it is out of date and its time is over.
    pub fn end_what_is_late(&self) -> ! {
        let mut state = self.state();
        loop {
            let begun = state.begun.filter(|_| state.version != state.drawing);
            let rest = begun.map(|begun| GRACE.saturating_sub(begun.elapsed()));
            state = match rest {
                Some(Duration::ZERO) => {
                    self.late.store(true, Ordering::Relaxed);
                    state.begun = None;
                    state
                }
                Some(rest) => {
                    let woken = self.changed.wait_timeout(state, rest);
                    woken.unwrap_or_else(PoisonError::into_inner).0
                }
                None => self.changed.wait(state).unwrap_or_else(PoisonError::into_inner),
            };
        }
    }

    /// A page that hears what happens from now on, the state and the last picture first.
    pub fn join(&self) -> Receiver<String> {
        let (sender, receiver) = channel();
        let mut state = self.state();
        // A receiver that was just made is there.
        let _ = sender.send(told::event("state", &told::state(self, &state)));
        if let Some(picture) = &state.picture {
            let _ = sender.send(told::event("picture", picture));
        }
        state.pages.push(sender);
        receiver
    }

    /// Tells every page that is still there.
    pub fn tell(&self, state: &mut State, name: &str, value: &Value) {
        let event = told::event(name, value);
        state.pages.retain(|page| page.send(event.clone()).is_ok());
    }

    /// Tells every page the state.
    pub fn tell_state(&self, state: &mut State) {
        let told = told::state(self, state);
        self.tell(state, "state", &told);
    }

    /// Keeps a picture for the pages to fetch, and gives its number.
    pub fn keep(&self, state: &mut State, image: Image<'static>) -> Arc<Drawn> {
        state.drawings += 1;
        let drawn = Arc::new(Drawn { id: state.drawings, image });
        state.drawn.push_back(Arc::clone(&drawn));
        while state.drawn.len() > PICTURES {
            state.drawn.pop_front();
        }
        drawn
    }

    /// A picture of that number, while it is kept.
    pub fn drawn(&self, id: u64) -> Option<Arc<Drawn>> {
        self.state().drawn.iter().find(|drawn| drawn.id == id).cloned()
    }

    /// A page has another text, made of what the file was after so many saves.
    pub fn edit(&self, text: String, from: &str, saves: u64) {
        let mut state = self.state();
        if state.text != text {
            state.conflict |= saves != state.saves && state.disk.text() != Some(&text);
            (state.text, state.from) = (text, from.to_string());
            self.redraw(&mut state);
            self.tell_state(&mut state);
        }
    }

    /// Writes the text into the file, if that is what it was when the page last heard of it.
    pub fn save(&self, text: String, from: &str, saves: u64) -> Result<(), Failure> {
        let _one_at_a_time = self.saving.lock().unwrap_or_else(PoisonError::into_inner);
        // The file may have changed a moment ago, and the event has not arrived yet.
        let disk = OnDisk::read(&self.fixed.file);
        self.edit(text.clone(), from, saves);
        let windows = {
            let mut state = self.state();
            self.see(&mut state, disk);
            let other = state.disk.text() != Some(&text);
            if matches!(state.disk, OnDisk::NoFile { .. }) || saves != state.saves && other {
                state.conflict = true;
                self.tell_state(&mut state);
                return Err(Failure::plain(state.disk.trouble()));
            }
            state.windows
        };
        let written = if windows { text.replace('\n', "\r\n") } else { text.clone() };
        write_program(&self.fixed.file, &written)?;
        let mut state = self.state();
        state.saves += u64::from(state.disk.text() != Some(&text));
        state.base = Some(text.clone());
        state.disk = OnDisk::Text { text, windows };
        state.conflict = false;
        self.tell_state(&mut state);
        Ok(())
    }

    /// Takes the file's text for that of the pages.
    pub fn take(&self) -> Result<(), Failure> {
        let mut state = self.state();
        match state.disk.text().map(str::to_string) {
            Some(text) => {
                (state.text, state.from, state.conflict) = (text, String::new(), false);
                self.redraw(&mut state);
                self.tell_state(&mut state);
                Ok(())
            }
            None => Err(Failure::plain(state.disk.trouble())),
        }
    }

    /// The pages' text is to stay, whatever the file says.
    pub fn keep_text(&self) {
        let mut state = self.state();
        state.conflict = false;
        self.tell_state(&mut state);
    }

    /// The program's file has changed, or something beside it.
    pub fn files_changed(&self, paths: &[PathBuf]) {
        let own = |path: &&PathBuf| same_file(path, &self.fixed.file) || **path == self.fixed.file;
        // Editors may take the file away before they put the new one there: a later event reports that.
        let disk = paths.iter().any(|path| own(&path)).then(|| OnDisk::read(&self.fixed.file));
        let mut state = self.state();
        if paths.iter().any(|path| !own(&path)) {
            state.files += 1;
            self.redraw(&mut state);
        }
        if let Some(disk) = disk.filter(|disk| *disk != OnDisk::Missing) {
            self.see(&mut state, disk);
        }
    }

    /// Takes notice of what the file holds now.
    fn see(&self, state: &mut State, disk: OnDisk) {
        if let OnDisk::Text { windows, .. } = disk {
            state.windows = windows;
        }
        let same_text = disk.text().is_some() && disk.text() == state.disk.text();
        if same_text || disk == state.disk {
            return;
        }
        state.saves += 1;
        state.disk = disk;
        match state.disk.text().map(str::to_string) {
            Some(text) => {
                // Where there was no file, all text is the pages' own.
                let untouched = state.base.as_deref().unwrap_or_default() == state.text;
                state.base = Some(text.clone());
                state.conflict = !untouched && state.text != text;
                if !state.conflict && state.text != text {
                    (state.text, state.from) = (text, String::new());
                    self.redraw(state);
                }
            }
            None => state.conflict = true,
        }
        self.tell_state(state);
    }

    /// Sets a param to what an expression gives, or lets the program say what it is.
    pub fn set(&self, name: &str, text: Option<&str>) -> Result<(), Failure> {
        let frame = self.state().frame.value;
        let value = match text {
            Some(text) => Some((text.trim().to_string(), set(&format!("{name}={text}"), frame)?.1)),
            None => None,
        };
        let mut state = self.state();
        state.set.retain(|(other, ..)| other != name);
        if let Some((text, value)) = value {
            state.set.push((name.to_string(), text, value));
        }
        self.redraw(&mut state);
        self.tell_state(&mut state);
        Ok(())
    }

    /// Goes to another frame.
    pub fn go(&self, frame: f64) -> Result<(), Failure> {
        if !(frame as f32).is_finite() {
            return Err(Failure::plain(format!("{frame} is not a frame")));
        }
        let mut state = self.state();
        state.frame = frame.into();
        self.redraw(&mut state);
        self.tell_state(&mut state);
        Ok(())
    }

    /// Shows a variable beside the outputs, or no more.
    pub fn show(&self, name: &str) {
        let mut state = self.state();
        match state.also.iter().position(|other| other == name) {
            Some(place) => drop(state.also.remove(place)),
            None => state.also.push(name.to_string()),
        }
        self.redraw(&mut state);
        self.tell_state(&mut state);
    }

    /// Writes what a param is set to into the program.
    pub fn write_back(&self, name: &str) -> Result<(), Failure> {
        let mut state = self.state();
        let set = state.set.iter().position(|(other, ..)| other == name);
        let Some(place) = set else {
            return Err(Failure::plain(format!("{name} already has this value in the program")));
        };
        let ran = state.ran.clone().filter(|ran| {
            // Places are those of the text that ran.
            *ran.program.sources().get(pse::internal::diagnostic::SourceId::default()).text == *state.text
        });
        let Some(ran) = ran else {
            return Err(
                Failure::plain("this version of the program has not run yet").hint("Correct it first.")
            );
        };
        let param = ran.program.resolved().params.iter().find(|param| param.name == name);
        let span = param.map(|param| param.value.span).filter(|span| span.source.0 == 0);
        let Some(span) = span else {
            return Err(Failure::plain(format!("{name} is not declared in this file")));
        };
        let value = state.set[place].1.clone();
        state.text.replace_range(span.start as usize..span.end as usize, &value);
        state.from.clear();
        state.set.remove(place);
        self.redraw(&mut state);
        self.tell_state(&mut state);
        Ok(())
    }

    /// How programs are run.
    pub fn options<'a>(
        &'a self,
        frame: Frame,
        set: &[(String, PixelValue)],
        program: &Program,
    ) -> RunOptions<'a> {
        // What was set stays so, also while the program has no such param.
        let has = |name: &str| program.resolved().slot(name).is_some();
        RunOptions {
            frame: frame.value,
            frame_number: frame.number,
            set: set.iter().filter(|(name, _)| has(name)).cloned().collect(),
            spaces: self.fixed.spaces.clone(),
            pixelsize: self.fixed.pixelsize,
            limits: self.fixed.limits,
            texture_memory: Some(self.fixed.texture_memory),
            ..RunOptions::default()
        }
    }
}
