//! A session: a program that grows, and an image to try it on.

use super::super::camera::{Camera, CameraRequest};
use super::super::failure::Failure;
use super::super::frames::Frame;
use super::super::input::Inputs;
use super::super::interrupt::CANCEL;
use super::super::known::Known;
use super::super::scene::ViewArgs;
use pse::Disk;
use pse::image::{Image, Matrix4, Variable};
use pse::internal::diagnostic::SourceId;
use pse::internal::program::{Compiler, Limits, Program, RunOptions};
use pse::internal::resolve::tree::{Resolved, Stmt, StmtKind};
use pse::internal::syntax::{self, ast};
use pse::internal::value::PixelValue;
use pse::scene::Renderer;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The variable that has the value of an expression.
pub(super) const VALUE: &str = "it";

/// Lines of `print` that an entry shows at most.
const LINES: usize = 10;

/// What messages call the program.
pub(super) const NAME: &str = "session";

/// What a session knows.
pub(super) struct Session {
    pub image: Image<'static>,
    inputs: Arc<Inputs>,
    /// The view options, if it is an image that is looked at.
    view: Option<ViewArgs>,
    path: Vec<PathBuf>,
    /// The program so far, as it was entered.
    pub pieces: Vec<String>,
    /// Values set from outside.
    pub set: Vec<(String, PixelValue)>,
    /// Where named spaces are.
    pub spaces: Vec<(String, Matrix4)>,
    /// How far apart pixels lie, if that was given.
    pub pixelsize: Option<f32>,
    /// The number of the frame.
    pub frame: Frame,
    /// What a pixel may use up.
    pub limits: Limits,
    /// The file that the program was loaded from, or saved to.
    pub file: Option<PathBuf>,
    /// The pixel whose values are told: column and row of what the image holds.
    pub pixel: [usize; 2],
    /// How long the last run took.
    pub took: Option<Duration>,
    /// Has it come to its end?
    pub ended: bool,
}

/// What a piece of text is.
enum Piece {
    Nothing,
    /// An expression alone.
    Expression,
    /// Statements, perhaps with an expression at the end.
    Statements {
        last_expression: bool,
        function: Option<String>,
    },
}

impl Session {
    pub fn new(image: Image<'static>, inputs: Inputs, view: Option<ViewArgs>, path: Vec<PathBuf>) -> Session {
        let pixel = [image.width / 2, image.height / 2];
        Session {
            image,
            inputs: Arc::new(inputs),
            view,
            path,
            pieces: Vec::new(),
            set: Vec::new(),
            spaces: Vec::new(),
            pixelsize: None,
            frame: Frame::default(),
            limits: Limits::default(),
            file: None,
            pixel,
            took: None,
            ended: false,
        }
    }

    /// What it works on, in a few words.
    pub fn about(&self) -> String {
        let names: Vec<&str> = self.image.variables.iter().map(|v| v.name.as_str()).collect();
        format!("{} x {} pixels with {}", self.image.width, self.image.height, names.join(", "))
    }

    /// The program so far.
    pub fn program(&self) -> String {
        self.pieces.concat()
    }

    /// Does what a text says: a command, an expression, or more of the program. Gives what to print.
    pub fn enter(&mut self, text: &str) -> Result<String, Failure> {
        if let Some(command) = text.trim().strip_prefix(':') {
            return self.command(command);
        }
        let text = format!("{}\n", text.trim_end());
        match piece(&text) {
            Piece::Nothing => Ok(String::new()),
            Piece::Expression => {
                let program = self.compile(&format!("{}{text}", self.program()))?;
                Ok(self.printed(&program)? + &self.value(&program)?)
            }
            Piece::Statements { last_expression, function } => {
                let mut pieces = self.pieces.clone();
                // A function that is defined again takes the place of the old one.
                let same = |piece: &String| function.is_some() && self::function(piece) == function;
                match pieces.iter_mut().find(|piece| same(piece)) {
                    Some(old) => *old = text,
                    None => pieces.push(text),
                }
                let program = self.compile(&pieces.concat())?;
                // What goes wrong at the pixel is told now, and leaves the session as it was.
                self.at_pixel(&program)?;
                let printed = self.printed(&program)?;
                self.pieces = pieces;
                if last_expression { Ok(printed + &self.value(&program)?) } else { Ok(printed) }
            }
        }
    }

    /// Takes a program's file for print print the program so far; gives what it prints.
    pub fn load(&mut self, path: &std::path::Path) -> Result<String, Failure> {
        let (_, text) = super::super::source::read(path)?;
        let text = format!("{}\n", text.trim_end());
        let program = self.compile(&text)?;
        self.at_pixel(&program)?;
        self.pieces.clear();
        let printed = self.printed(&program)?;
        self.pieces = vec![text];
        self.file = Some(path.to_path_buf());
        Ok(printed)
    }

    /// Compiles a text, and reads what more it asks of the inputs than is in memory.
    pub fn compile(&mut self, text: &str) -> Result<Program, Failure> {
        let program = self.compile_only(text)?;
        let globals = program.resolved().globals.iter().filter(|g| !g.library && g.read.is_some());
        let missing = globals.map(|g| &g.name).filter(|name| self.image.variable(name).is_none());
        let found = missing.filter(|name| matches!(self.inputs.find(name), Some(Ok(()))));
        let names: Vec<String> = found.cloned().collect();
        if !names.is_empty() {
            let mut reader = self.inputs.reader(None::<&Renderer>, &names.into(), false)?;
            let more = reader.read(0..self.image.height)?;
            self.image.variables.extend(more.variables);
        }
        Ok(program)
    }

    /// Compiles a text.
    fn compile_only(&self, text: &str) -> Result<Program, Failure> {
        let has = self.image.variables.iter().map(|v| v.name.clone()).collect();
        let known = Known::Images { first: Some(("input".into(), has)), inputs: Arc::clone(&self.inputs) };
        let doubt = |program: &Resolved, name: &str, span| known.doubt_before_run(program, name, span);
        Ok(Compiler::new().host(&self.host()).value(VALUE).doubt(&doubt).compile(NAME, text)?)
    }

    /// Where its program finds files.
    pub fn host(&self) -> Disk {
        Disk { path: self.path.clone() }
    }

    /// What every variable holds at the pixel.
    pub fn at_pixel(&self, program: &Program) -> Result<Vec<(String, PixelValue)>, Failure> {
        let missing = |name: &str| self.inputs.missing(name);
        let [column, row] = self.pixel;
        let camera = self.camera(program)?;
        let options = camera.options(self.options(program, &missing));
        Ok(program.eval_pixel_of(&self.image, column, row, &options)?)
    }

    /// What a program prints at the pixel, but for what print print the program so far prints already.
    fn printed(&self, program: &Program) -> Result<String, Failure> {
        let missing = |name: &str| self.inputs.missing(name);
        let [column, row] = self.pixel;
        let prints = |program: &Program, lines: usize| -> Result<_, Failure> {
            let camera = self.camera(program)?;
            let options = RunOptions { prints: lines, ..camera.options(self.options(program, &missing)) };
            Ok(program.prints_of(&self.image, column, row, &options)?)
        };
        let count = prints(program, 1)?.count as usize;
        if count == 0 {
            return Ok(String::new());
        }
        let before = prints(&self.compile_only(&self.program())?, 1)?.count as usize;
        let lines = prints(program, before + LINES)?.lines;
        let mut text: String = lines.iter().skip(before).map(|line| format!("{line}\n")).collect();
        if count > before + LINES {
            text += &format!("… {} more lines\n", count - before - LINES);
        }
        Ok(text)
    }

    /// Runs the program on the whole image, for one variable.
    pub fn run(&mut self, program: &Program, name: &str) -> Result<Image<'static>, Failure> {
        let missing = |name: &str| self.inputs.missing(name);
        let camera = self.camera(program)?;
        let options = camera.options(self.options(program, &missing));
        let options = RunOptions { outputs: Some(vec![name.into()]), ..options };
        let start = Instant::now();
        let report = program.run(&self.image, &options)?;
        self.took = Some(start.elapsed());
        Ok(report.image)
    }

    /// The camera, found from the points of the inputs if the program reads it and nothing else tells it.
    fn camera(&self, program: &Program) -> Result<Camera<'_>, Failure> {
        let variables: Vec<String> = self.image.variables.iter().map(|v| v.name.clone()).collect();
        let request = CameraRequest {
            program,
            view: self.view.as_ref(),
            inputs: &self.inputs,
            about: &self.image,
            variables: &variables,
            set: &self.set,
            spaces: &self.spaces,
        };
        let camera = request.find()?;
        camera.report();
        Ok(camera)
    }

    fn options<'a>(
        &'a self,
        program: &Program,
        missing: &'a (dyn Fn(&str) -> Vec<String> + Sync),
    ) -> RunOptions<'a> {
        // What was set stays so, also while the program has no such param.
        let set = self.set.iter().filter(|(name, _)| program.resolved().slot(name).is_some());
        RunOptions {
            frame: self.frame.value,
            frame_number: self.frame.number,
            set: set.cloned().collect(),
            spaces: self.spaces.clone(),
            pixelsize: self.pixelsize,
            limits: self.limits,
            cancel: Some(&CANCEL),
            missing: if self.inputs.list.is_empty() { None } else { Some(missing) },
            ..RunOptions::default()
        }
    }

    /// The value of the expression at the end: at the pixel, and over the image.
    fn value(&mut self, program: &Program) -> Result<String, Failure> {
        // `print` gives none.
        if matches!(program.resolved().body.last(), Some(Stmt { kind: StmtKind::Print(_), .. })) {
            return Ok(String::new());
        }
        let values = self.at_pixel(program)?;
        let here = values.into_iter().find(|(name, _)| name == VALUE).map(|(_, value)| value);
        let image = self.run(program, VALUE)?;
        let here = here.map_or("no value".to_string(), |value| value.to_string());
        let Some(variable) = image.variable(VALUE) else { return Ok(format!("{here}\n")) };
        let alike = variable.planes.iter().all(|p| p.iter().all(|x| x.to_bits() == p[0].to_bits()));
        if alike {
            return Ok(format!("{here}\n"));
        }
        let [column, row] = self.pixel;
        let [x, y] = image.metadata.origin;
        let (column, row) = (column as i64 + i64::from(x), row as i64 + i64::from(y));
        Ok(format!("{here}  at [{column} {row}]\n{}", over_image(variable)))
    }
}

/// Least, mean and largest of each component over an image.
fn over_image(variable: &Variable<'_>) -> String {
    let column = |f: &dyn Fn(&[f32]) -> f64| {
        let numbers: Vec<String> =
            variable.planes.iter().map(|p| pse::internal::value::number(f(p) as f32)).collect();
        if variable.shape.is_scalar() { numbers.concat() } else { format!("[{}]", numbers.join(" ")) }
    };
    let finite = |p: &[f32]| p.iter().filter(|x| x.is_finite()).map(|&x| f64::from(x)).collect::<Vec<f64>>();
    let least = column(&|p| finite(p).into_iter().fold(f64::INFINITY, f64::min));
    let largest = column(&|p| finite(p).into_iter().fold(f64::NEG_INFINITY, f64::max));
    let mean = column(&|p| {
        let finite = finite(p);
        finite.iter().sum::<f64>() / finite.len().max(1) as f64
    });
    let count = variable.planes.first().map_or(0, |p| p.len());
    let odd = (0..count).filter(|&i| variable.planes.iter().any(|p| !p[i].is_finite())).count();
    if odd == count {
        return "NaN or infinity at every pixel\n".to_string();
    }
    let odd = if odd == 0 { String::new() } else { format!("   NaN or infinity at {odd} pixels") };
    format!("min {least}   mean {mean}   max {largest}{odd}\n")
}

/// The name of the function that a piece defines, if that is all it does.
fn function(text: &str) -> Option<String> {
    let parsed = syntax::parse(SourceId::default(), text);
    match &parsed.module.body[..] {
        [ast::Stmt { kind: ast::StmtKind::Function(f), .. }] => Some(f.name.text.clone()),
        _ => None,
    }
}

fn piece(text: &str) -> Piece {
    let parsed = syntax::parse(SourceId::default(), text);
    let last = parsed.module.body.last();
    let last_expression = last.is_some_and(|s| matches!(s.kind, ast::StmtKind::Expr(_)));
    match parsed.module.body.len() {
        0 if parsed.errors.is_empty() => Piece::Nothing,
        1 if last_expression && parsed.errors.is_empty() => Piece::Expression,
        _ => Piece::Statements { last_expression, function: function(text) },
    }
}
