//! The commands of a session: lines that begin with a colon.

use super::super::doc;
use super::super::failure::Failure;
use super::session::{Session, VALUE};
use super::{note, picture};
use pse::image::write_program;
use pse::internal::program::Compiler;
use pse::internal::resolve::names;
use pse::internal::value::PixelValue;
use std::path::{Path, PathBuf};

/// Each command, what follows it, and what it does.
pub(super) static COMMANDS: [(&str, &str, &str); 13] = [
    ("show", "[EXPRESSION]", "show color, or an expression, as a picture in the terminal"),
    ("pixel", "[COLUMN ROW]", "go to another pixel; without numbers, print the current one"),
    ("vars", "", "print every variable at the pixel"),
    ("list", "", "print print the program so far"),
    ("undo", "", "remove the last entry"),
    ("clear", "", "remove the whole program"),
    ("load", "FILE", "load a program, and forget the one so far"),
    ("save", "[FILE]", "write the program to a file; :save! replaces a file"),
    ("set", "NAME VALUE", "set a param, as --set does"),
    ("time", "[EXPRESSION]", "time the program on the image"),
    ("doc", "NAME", "explain a function or another name"),
    ("help", "", "print this list"),
    ("quit", "", "end the session, as Ctrl-D does"),
];

impl Session {
    /// Does what a command says; gives what to print.
    pub(super) fn command(&mut self, text: &str) -> Result<String, Failure> {
        let (name, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let rest = rest.trim();
        let needs = |what: &str| match rest.is_empty() {
            true => Err(Failure::plain(format!(":{name} needs {what}"))),
            false => Ok(rest),
        };
        match name {
            "show" => self.show(rest),
            "pixel" => self.look_at(rest),
            "vars" => self.variables(),
            "list" => Ok(self.listing()),
            "undo" => match self.pieces.pop() {
                Some(_) => Ok(String::new()),
                None => Err(Failure::plain("the program is empty")),
            },
            "clear" => {
                self.pieces.clear();
                self.set.clear();
                Ok(String::new())
            }
            "load" => self.load(Path::new(needs("a file")?)),
            "save" | "save!" => self.save(rest, name == "save!"),
            "set" => self.set_param(needs("a name and a value: `:set veins 6`")?),
            "time" => self.time(rest),
            "doc" if rest.is_empty() => Ok(doc::list()),
            "doc" => doc::text(rest),
            "help" => Ok(help()),
            "quit" | "q" | "exit" => {
                self.ended = true;
                Ok(String::new())
            }
            _ => {
                let failure = Failure::plain(format!("there is no command :{name}"));
                Err(match names::nearest(name, COMMANDS.iter().map(|c| c.0)) {
                    Some(near) => failure.hint(format!("Did you mean :{near}?")),
                    None => failure.hint(":help lists them."),
                })
            }
        }
    }

    /// The program with an expression behind it, and the variable that has its value; `color` without one.
    fn wanted(
        &mut self,
        expression: &str,
    ) -> Result<(pse::internal::program::Program, &'static str), Failure> {
        if !expression.is_empty() {
            return Ok((self.compile(&format!("{}{expression}\n", self.program()))?, VALUE));
        }
        let program = self.compile(&self.program())?;
        let name = ["color", VALUE].into_iter().find(|name| program.assigned().any(|n| n == *name));
        match name {
            Some(name) => Ok((program, name)),
            None => Err(Failure::plain("the program has no color yet")
                .hint("Show an expression: `:show white * Noise(8 * point)`.")),
        }
    }

    fn save(&mut self, rest: &str, replace: bool) -> Result<String, Failure> {
        let own = self.file.clone();
        let path = match (rest.is_empty(), &own) {
            (false, _) => PathBuf::from(rest),
            (true, Some(path)) => path.clone(),
            (true, None) => return Err(Failure::plain(":save needs a file: `:save marble.pse`")),
        };
        if self.pieces.is_empty() {
            return Err(Failure::plain("the program is empty"));
        }
        let shown = path.display();
        if path.exists() && own.as_ref() != Some(&path) && !replace {
            return Err(Failure::plain(format!("`{shown}` already exists"))
                .hint(format!("To replace it: `:save! {shown}`.")));
        }
        write_program(&path, &self.program())?;
        note(&format!("wrote {shown}"));
        self.file = Some(path);
        Ok(String::new())
    }

    fn show(&mut self, expression: &str) -> Result<String, Failure> {
        let (program, name) = self.wanted(expression)?;
        let image = self.run(&program, name)?;
        picture::show(&image, name)
    }

    fn time(&mut self, expression: &str) -> Result<String, Failure> {
        let (program, name) = self.wanted(expression)?;
        let mut times: Vec<f64> = Vec::new();
        for _ in 0..5 {
            self.run(&program, name)?;
            times.push(self.took.map_or(0.0, |t| t.as_secs_f64()));
        }
        times.sort_by(f64::total_cmp);
        let pixels = (self.image.width * self.image.height).max(1);
        let median = times[times.len() / 2];
        Ok(format!(
            "{:.2} ms, {:.1} ns/pixel, the median of 5 runs\n",
            median * 1e3,
            median * 1e9 / pixels as f64
        ))
    }

    fn look_at(&mut self, rest: &str) -> Result<String, Failure> {
        let [x, y] = self.image.metadata.origin.map(i64::from);
        let told = |[column, row]: [usize; 2]| format!("[{} {}]\n", column as i64 + x, row as i64 + y);
        if rest.is_empty() {
            return Ok(told(self.pixel));
        }
        let numbers: Vec<i64> = rest
            .split(|c: char| c.is_whitespace() || ",[]".contains(c))
            .filter(|word| !word.is_empty())
            .map(|word| word.parse().ok())
            .collect::<Option<_>>()
            .unwrap_or_default();
        let [column, row] = numbers[..] else {
            return Err(Failure::plain("a pixel is a column and a row: `:pixel 320 200`"));
        };
        let (column, row) = (column - x, row - y);
        let (width, height) = (self.image.width as i64, self.image.height as i64);
        if !(0..width).contains(&column) || !(0..height).contains(&row) {
            let last = told([self.image.width - 1, self.image.height - 1]);
            return Err(Failure::plain("there is no such pixel")
                .hint(format!("The pixels go from [{x} {y}] to {}.", last.trim_end())));
        }
        self.pixel = [column as usize, row as usize];
        Ok(String::new())
    }

    fn variables(&mut self) -> Result<String, Failure> {
        let program = self.compile(&self.program())?;
        let own = self.at_pixel(&program)?;
        let index = self.pixel[1] * self.image.width + self.pixel[0];
        let mut text = String::new();
        for variable in &self.image.variables {
            if own.iter().any(|(name, _)| *name == variable.name) {
                continue;
            }
            let cells = variable.planes.iter().map(|p| p[index]).collect();
            let value = PixelValue::new(variable.shape.clone(), cells);
            text += &format!("{:12} {}\n", variable.name, value.map_or(String::new(), |v| v.to_string()));
        }
        for (name, value) in own.iter().filter(|(name, _)| name != VALUE) {
            text += &format!("{name:12} {value}\n");
        }
        Ok(text)
    }

    fn listing(&self) -> String {
        let program = self.program();
        let width = program.lines().count().to_string().len();
        program.lines().enumerate().map(|(i, line)| format!("{:width$}  {line}\n", i + 1)).collect()
    }

    fn set_param(&mut self, rest: &str) -> Result<String, Failure> {
        let (name, value) = rest
            .split_once(|c: char| c.is_whitespace() || c == '=')
            .ok_or_else(|| Failure::plain(":set needs a name and a value: `:set veins 6`"))?;
        let value = value.trim().trim_start_matches('=').trim();
        let program = Compiler::new().value(VALUE).compile(&format!(":set {name}"), value)?;
        let values = program.eval_pixel(&[], &pse::internal::program::RunOptions::default())?;
        let value = values.into_iter().find(|(n, _)| n == VALUE).map(|(_, value)| value);
        let before = self.set.clone();
        self.set.retain(|(n, _)| n != name);
        self.set.extend(value.map(|value| (name.to_string(), value)));
        let program = self.compile(&self.program())?;
        if !program.resolved().params.iter().any(|param| param.name == name) {
            self.set = before;
            let failure = Failure::plain(format!("the program has no param `{name}` to set"));
            return Err(failure.hint(format!("`param {name} = 1` declares one.")));
        }
        if let Err(failure) = self.at_pixel(&program) {
            self.set = before;
            return Err(failure);
        }
        Ok(String::new())
    }
}

fn help() -> String {
    let mut text = String::from(
        "An expression prints its value at the pixel and its minimum, mean and maximum over the image.\n\
         Other lines are added to the program; an empty line ends a block.\n\n",
    );
    for (name, rest, what) in &COMMANDS {
        text += &format!("  :{:24} {what}\n", format!("{name} {rest}").trim_end());
    }
    let keys =
        "\n  Tab completes, Ctrl-R searches earlier entries, Ctrl-C stops a run, Ctrl-D ends the session.\n";
    text + keys
}
