//! Lines at a terminal: prompts, history, colours, completion, hints.

use super::super::failure::Failure;
use super::super::state;
use super::commands::COMMANDS;
use super::session::{NAME, Session};
use pse::Disk;
use pse::internal::assist::{Item, Kind, Reading};
use pse::internal::syntax::{Token, is_incomplete, lex};
use rustyline::completion::{Completer, FilenameCompleter, Pair};
use rustyline::error::ReadlineError;
use rustyline::highlight::{CmdKind, Highlighter};
use rustyline::hint::Hinter;
use rustyline::history::FileHistory;
use rustyline::validate::Validator;
use rustyline::{Config, Context, Helper};
use std::borrow::Cow;
use std::path::PathBuf;

/// What a block's lines begin with.
const INDENT: &str = "    ";

/// What was read.
pub(super) enum Read {
    Text(String),
    /// Nothing: what was begun is given up.
    Again,
    End,
}

/// Reads texts of one or more lines.
pub(super) struct Editor {
    editor: rustyline::Editor<Words, FileHistory>,
    history: Option<PathBuf>,
}

impl Editor {
    /// With the history of former sessions.
    pub fn new() -> Result<Editor, Failure> {
        let failed = |e: ReadlineError| Failure::plain(format!("the terminal cannot be used: {e}"));
        let config = Config::builder().history_ignore_space(true).auto_add_history(false).build();
        let mut editor = rustyline::Editor::with_config(config).map_err(failed)?;
        editor.set_helper(Some(Words::default()));
        let history = history();
        if let Some(path) = &history {
            // The first session has none.
            let _ = editor.load_history(path);
        }
        Ok(Editor { editor, history })
    }

    /// Reads a text that is complete.
    pub fn read(&mut self, session: &Session) -> Read {
        if let Some(words) = self.editor.helper_mut() {
            words.learn(session);
        }
        let mut text = String::new();
        let mut begun = false;
        loop {
            let read = match begun {
                false => self.editor.readline("pse> "),
                true => self.editor.readline_with_initial("...  ", (&indent(&text), "")),
            };
            match read {
                Ok(line) => {
                    // The end of the last line is none of the text's: an empty line is what ends a block.
                    if begun {
                        text.push('\n');
                    }
                    begun = true;
                    text += line.trim_end();
                    // A command is one line; an empty line ends a block.
                    if text.trim_start().starts_with(':') || !is_incomplete(&text) {
                        break;
                    }
                }
                Err(ReadlineError::Interrupted) => return Read::Again,
                Err(_) => return Read::End,
            }
        }
        if text.trim().is_empty() {
            return Read::Again;
        }
        let _ = self.editor.add_history_entry(text.trim_end());
        if let Some(path) = &self.history {
            // A history that can't be kept is no reason to stop.
            let _ = path.parent().map(std::fs::create_dir_all);
            let _ = self.editor.save_history(path);
        }
        Read::Text(text)
    }
}

/// Where the history is kept.
fn history() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("PSE_HISTORY") {
        return (!path.is_empty()).then(|| path.into());
    }
    Some(state::folder()?.join("history"))
}

/// What the next line of a text begins with.
fn indent(text: &str) -> String {
    let last = text.lines().next_back().unwrap_or("");
    let own: String = last.chars().take_while(|c| c.is_whitespace()).collect();
    let header = lex(last.trim_start()).first().is_some_and(|l| {
        matches!(l.token, Token::If | Token::Else | Token::While | Token::For | Token::Function)
    });
    if header { own + INDENT } else { own }
}

/// What the session knows, for completion and hints.
#[derive(Default)]
struct Words {
    /// The program so far.
    program: String,
    /// The names of the images' variables.
    inputs: Vec<String>,
    /// Where imports and textures are.
    host: Disk,
    /// The program, read.
    reading: Option<Reading>,
}

impl Words {
    /// Learns the names of the session.
    fn learn(&mut self, session: &Session) {
        self.program = session.program();
        self.inputs = session.image.variables.iter().map(|v| v.name.clone()).collect();
        self.host = session.host();
        self.reading = Some(self.read(""));
    }

    /// The program with this line at its end.
    fn read(&self, line: &str) -> Reading {
        let mut reading = Reading::new(NAME, &format!("{}{line}", self.program), &self.host);
        reading.inputs.clone_from(&self.inputs);
        reading
    }
}

impl Completer for Words {
    type Candidate = Pair;

    fn complete(&self, line: &str, pos: usize, ctx: &Context<'_>) -> rustyline::Result<(usize, Vec<Pair>)> {
        let before = &line[..pos];
        if before.starts_with(":load ") || before.starts_with(":save ") {
            return FilenameCompleter::new().complete(line, pos, ctx);
        }
        let pair = |name: &str, display: String| Pair { display, replacement: name.to_string() };
        if let Some(command) = before.strip_prefix(':').filter(|c| !c.contains(' ')) {
            let fitting = COMMANDS.iter().filter(|c| c.0.starts_with(command));
            let pairs = fitting.map(|c| pair(&format!(":{}", c.0), format!(":{} {}", c.0, c.1)));
            return Ok((0, pairs.collect()));
        }
        let found = self.read(line).complete(self.program.len() + pos, &self.host);
        let start = found.word.start - self.program.len();
        let word = &before[start..];
        // Without a beginning everything fits; what a string may be is little enough to show.
        let all = |item: &Item| !word.is_empty() || item.kind == Kind::Choice;
        let fitting = found.items.iter().filter(|item| all(item) && item.name.starts_with(word));
        let candidates = fitting.map(|item| match item.kind {
            Kind::Function => pair(&format!("{}(", item.name), item.detail.clone()),
            Kind::Argument => pair(&format!("{} = ", item.name), item.detail.clone()),
            _ => pair(&item.name, item.name.clone()),
        });
        Ok((start, candidates.collect()))
    }
}

impl Hinter for Words {
    type Hint = String;

    fn hint(&self, line: &str, pos: usize, _: &Context<'_>) -> Option<String> {
        // What there is to call is asked for only where something is called.
        if pos < line.len() || !line.contains('(') || line.starts_with(':') {
            return None;
        }
        let (function, _) = self.read(line).call(self.program.len() + pos)?;
        Some(format!("   {}", function.entry.signature))
    }
}

impl Highlighter for Words {
    fn highlight<'l>(&self, line: &'l str, _: usize) -> Cow<'l, str> {
        if std::env::var_os("NO_COLOR").is_some() || line.starts_with(':') {
            return line.into();
        }
        let mut out = String::new();
        let mut end = 0;
        for lexeme in lex(line) {
            let text = &line[lexeme.start..lexeme.end];
            let code = match lexeme.token {
                Token::Number => "36",
                Token::Text => "32",
                Token::Name => match self.reading.as_ref().is_some_and(|r| r.is_function(text)) {
                    true => "34",
                    false => "0",
                },
                Token::Unknown => "31",
                _ if text.starts_with('#') => "90",
                _ if text.starts_with(char::is_alphabetic) => "35",
                _ => "0",
            };
            out += &line[end..lexeme.start];
            out += &if code == "0" { text.to_string() } else { format!("\x1b[{code}m{text}\x1b[0m") };
            end = lexeme.end;
        }
        (out + &line[end..]).into()
    }

    fn highlight_hint<'h>(&self, hint: &'h str) -> Cow<'h, str> {
        match std::env::var_os("NO_COLOR") {
            Some(_) => hint.into(),
            None => format!("\x1b[90m{hint}\x1b[0m").into(),
        }
    }

    fn highlight_char(&self, _: &str, _: usize, _: CmdKind) -> bool {
        true
    }
}

impl Validator for Words {}
impl Helper for Words {}
