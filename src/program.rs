//! The embedding interface: compile a program once, run it on any number of images.

#[cfg(any(feature = "flow", feature = "solid"))]
mod ask;

use crate::diagnostic::{Diagnostic, Sources, Style};
use crate::eval::{self, HostFunction};
use crate::host::{Host, NoFiles};
use crate::image::{Frame, Image, Metadata, Variable};
use crate::resolve::{self, HostFunctions, Resolved};
use crate::shape::Shape;
use crate::value::PixelValue;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

pub use crate::eval::{
    BufferView, BufferViewMut, Executor, Failure, Filter, Limits, Options as RunOptions, ParamInfo, Prints,
    Progress, Report, Sampling, Strides, Trace, TraceOptions, Window,
};

/// A compiled program. It has no state: share it between threads, and run it any number of times.
///
/// ```
/// use pse::{Image, Program, RunOptions, Shape, Variable};
///
/// let program = Program::compile("color = white * abs(sin(8 * point.x))")?;
/// let x: Vec<f32> = (0..64).map(|i| i as f32 / 64.0).collect();
/// let zero = vec![0.0; 64];
/// // The host's own planes, borrowed.
/// let point = Variable::new("point", Shape::Vector(3), [&x[..], &zero, &zero])?;
/// let image = Image::new(64, 1, [point])?;
/// let report = program.run(&image, &RunOptions::default())?;
/// assert_eq!(report.image.variable("color").unwrap().planes.len(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Program {
    resolved: Resolved,
}

/// Compiles programs that import files or call functions of the host.
#[derive(Clone)]
pub struct Compiler<'h> {
    host: &'h dyn Host,
    functions: HostFunctions,
    value: Option<String>,
    entrance: Option<resolve::Entrance>,
    doubt: &'h resolve::unknown::Doubt<'h>,
}

impl Default for Compiler<'_> {
    fn default() -> Self {
        Compiler {
            host: &NoFiles,
            functions: HostFunctions::new(),
            value: None,
            entrance: None,
            doubt: &resolve::unknown::usual,
        }
    }
}

impl<'h> Compiler<'h> {
    /// Creates a compiler without files and host functions.
    pub fn new() -> Compiler<'h> {
        Compiler::default()
    }

    /// Sets the host that finds imports and images.
    pub fn host(mut self, host: &'h dyn Host) -> Compiler<'h> {
        self.host = host;
        self
    }

    /// Assigns the value of the last expression statement at the outer level to the variable `name`. By default it is
    /// assigned to `color`, if the program does not assign `color`.
    pub fn value(mut self, name: &str) -> Compiler<'h> {
        self.value = Some(name.to_string());
        self
    }

    /// Compiles one function of the program instead of its statements. The result is a variable with the function's
    /// name. Passes the variables in `arguments`, up to the function's arity. Only the outer statements that the
    /// function depends on run.
    ///
    /// ```
    /// use pse::{Compiler, Image, RunOptions, Shape, Variable};
    ///
    /// let text = "r = 2\nfunction density(p)\n    return r - length(p)\ncolor = white * normal.z";
    /// let program = Compiler::new().entrance("density", &["point"]).compile("ball", text)?;
    /// let point = Variable::new("point", Shape::Vector(3), [vec![0.0, 3.0], vec![0.0; 2], vec![1.0, 4.0]])?;
    /// let points = Image::new(2, 1, [point])?;
    /// let report = program.run(&points, &RunOptions::default())?;
    /// assert_eq!(report.image.variable("density").unwrap().planes[0][..], [1.0, -3.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn entrance(mut self, function: &str, arguments: &[&str]) -> Self {
        let arguments = arguments.iter().map(|a| a.to_string()).collect();
        self.entrance = Some(resolve::Entrance { function: function.to_string(), arguments });
        self
    }

    /// Adds a function to the language. It hides a built-in one of the same name.
    pub fn function(mut self, function: HostFunction) -> Compiler<'h> {
        self.functions.insert(function.name().to_string(), Arc::new(function));
        self
    }

    /// Sets a callback that knows the image to run on. The compiler calls it for the variables that a program with
    /// errors reads but does not assign, so that all mistakes are reported together.
    pub fn doubt(mut self, doubt: &'h resolve::unknown::Doubt<'h>) -> Compiler<'h> {
        self.doubt = doubt;
        self
    }

    /// Compiles a program; `name` is its name in messages.
    ///
    /// # Errors
    /// Every fault that could be found in the text.
    pub fn compile(&self, name: &str, text: &str) -> Result<Program, Error> {
        let mut faults: Vec<Diagnostic> = self
            .functions
            .values()
            .filter_map(|function| Some(Diagnostic::bare("name", function.fault()?)))
            .collect();
        if !faults.is_empty() {
            faults.sort_by(|a, b| a.message.cmp(&b.message));
            return Err(Error { diagnostics: faults, sources: Sources::default(), cancelled: false });
        }
        match resolve::resolve(
            name,
            text,
            self.host,
            &self.functions,
            self.value.as_deref(),
            self.entrance.as_ref(),
            self.doubt,
        ) {
            Ok(resolved) => Ok(Program { resolved }),
            Err((diagnostics, sources)) => Err(Error { diagnostics, sources, cancelled: false }),
        }
    }
}

impl Program {
    /// Compiles a program without imports.
    ///
    /// # Errors
    /// Every fault that could be found in the text.
    pub fn compile(text: &str) -> Result<Program, Error> {
        Compiler::new().compile("program", text)
    }

    /// Runs the program at every pixel of an image.
    ///
    /// # Errors
    /// What does not fit the image, or the first pixel in reading order at which the program goes wrong;
    /// or that the run was cancelled.
    pub fn run(&self, image: &Image<'_>, options: &RunOptions<'_>) -> Result<Report, Error> {
        eval::run(&self.resolved, image, options).map_err(|f| self.error(f))
    }

    /// Starts a run over an image that arrives a few rows at a time, because it is large or still being rendered.
    ///
    /// ```
    /// use pse::{Image, Program, RunOptions, Shape, Variable};
    ///
    /// let program = Program::compile("color = white * pixel.y / resolution.y")?;
    /// let options = RunOptions::default();
    /// let mut stream = program.stream(&options);
    /// for top in [0, 16] {
    ///     let mut band = Image::new(64, 16, [])?;
    ///     band.metadata.origin = [0, top];
    ///     band.metadata.resolution = Some([64, 32]);
    ///     let report = stream.rows(&band, 0..16)?.expect("all rows have colours alike");
    ///     assert_eq!(report.image.variables[0].planes[0][0], (top as f32 + 0.5) / 32.0);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn stream<'p>(&'p self, options: &'p RunOptions<'p>) -> Stream<'p> {
        Stream { program: self, inner: eval::Stream::new(&self.resolved, options) }
    }

    /// Runs the program at one pixel with the given variables, and returns the assigned variables by name.
    ///
    /// ```
    /// use pse::{Program, RunOptions};
    /// let program = Program::compile("twice = 2 * x")?;
    /// let values = program.eval_pixel(&[("x", 4.0.into())], &RunOptions::default())?;
    /// assert_eq!(values, [("twice".to_string(), 8.0.into())]);
    /// # Ok::<(), pse::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Program::run`].
    pub fn eval_pixel(
        &self,
        variables: &[(&str, PixelValue)],
        options: &RunOptions<'_>,
    ) -> Result<Vec<(String, PixelValue)>, Error> {
        let variables = variables.iter().map(|(name, value)| Variable {
            name: name.to_string(),
            shape: value.shape().clone(),
            planes: value.cells().iter().map(|&x| vec![x].into()).collect(),
        });
        let image = Image { width: 1, height: 1, variables: variables.collect(), ..Image::default() };
        self.eval_pixel_of(&image, 0, 0, options)
    }

    /// Runs the program at one pixel of an image, counted from the top left of the stored pixels.
    ///
    /// # Errors
    /// As [`Program::run`].
    ///
    /// # Panics
    /// If the image has no such pixel.
    pub fn eval_pixel_of(
        &self,
        image: &Image<'_>,
        column: usize,
        row: usize,
        options: &RunOptions<'_>,
    ) -> Result<Vec<(String, PixelValue)>, Error> {
        let pixel = index(image, column, row);
        let (values, _) =
            eval::eval_pixel(&self.resolved, image, pixel, options).map_err(|f| self.error(f))?;
        Ok(values)
    }

    /// Runs the program at one pixel, as [`Program::eval_pixel_of`], and returns the lines that it prints there, at
    /// most [`RunOptions::prints`].
    ///
    /// # Errors
    /// As [`Program::run`].
    ///
    /// # Panics
    /// If the image has no such pixel.
    pub fn prints_of(
        &self,
        image: &Image<'_>,
        column: usize,
        row: usize,
        options: &RunOptions<'_>,
    ) -> Result<Prints, Error> {
        let pixel = index(image, column, row);
        let (_, prints) =
            eval::eval_pixel(&self.resolved, image, pixel, options).map_err(|f| self.error(f))?;
        Ok(prints)
    }

    /// Traces the program at one pixel of an image, counted from the top left of the stored pixels. Every value is
    /// exactly that of [`Program::run`]. (Samples are ignored: the centre of the pixel runs.)
    ///
    /// An error at the pixel is part of the trace, after the events before it.
    ///
    /// A program that asks how things change from pixel to pixel has the whole image looked through for neighbours. Three rows
    /// above the pixel and three below it are enough, as an image of their own whose `metadata.origin` says where they lie.
    ///
    /// ```
    /// use pse::{EventKind, Image, Program, RunOptions, TraceOptions};
    ///
    /// let program = Program::compile("x = 2\nwhile x < 9\n    x = x * 2\ncolor = x * white")?;
    /// let image = Image::new(1, 1, [])?;
    /// let trace = program.trace(&image, 0, 0, &RunOptions::default(), &TraceOptions::default())?;
    /// let told: Vec<String> = trace
    ///     .events
    ///     .iter()
    ///     .filter_map(|event| match &event.kind {
    ///         EventKind::Assign { name, value, .. } => {
    ///             let (line, _) = program.sources().line_column(event.span);
    ///             Some(format!("{line}: {name} = {value}, {:?}", event.rounds))
    ///         }
    ///         _ => None,
    ///     })
    ///     .collect();
    /// assert_eq!(told[..3], ["1: x = 2, []", "3: x = 4, [1]", "3: x = 8, [2]"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// What does not fit the image, or goes wrong before the pixels; or that the run was cancelled.
    ///
    /// # Panics
    /// If the image has no such pixel.
    pub fn trace(
        &self,
        image: &Image<'_>,
        column: usize,
        row: usize,
        options: &RunOptions<'_>,
        wanted: &TraceOptions,
    ) -> Result<Trace, Error> {
        let pixel = index(image, column, row);
        eval::trace(&self.resolved, image, pixel, options, wanted).map_err(|f| self.error(f))
    }

    /// The program's params, with their default values and ranges. `image` is the image to run on; only its size
    /// matters.
    ///
    /// ```
    /// use pse::{Image, Program, RunOptions};
    /// let program = Program::compile("param veins = 6 in [1 20]\ncolor = white * veins")?;
    /// let params = program.params(&Image::default(), &RunOptions::default())?;
    /// assert_eq!(params[0].name, "veins");
    /// assert_eq!(params[0].range, Some([1.0, 20.0]));
    /// # Ok::<(), pse::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a param's value cannot be computed.
    pub fn params(&self, image: &Image<'_>, options: &RunOptions<'_>) -> Result<Vec<ParamInfo>, Error> {
        eval::params(&self.resolved, image, options).map_err(|f| self.error(f))
    }

    /// The names of the variables that a run writes by default.
    pub fn default_outputs(&self) -> Vec<String> {
        eval::default_outputs(&self.resolved)
    }

    /// Whether a run passes on the image's `alpha`, because the program has a colour and no alpha.
    pub fn keeps_alpha(&self) -> bool {
        eval::keeps_alpha(&self.resolved)
    }

    /// Shares the textures that another program has already read, where both use the same ones. Their files are not
    /// read again.
    pub fn share_textures(&self, other: &Program) {
        for (own, _) in &self.resolved.textures {
            if let Some((known, _)) = other.resolved.textures.iter().find(|(known, _)| own.same(known)) {
                own.share(known);
            }
        }
    }

    /// The files that the program uses in a frame: its own, its imports, and the images for look-ups. Texts from
    /// other sources have the names that their host gave them.
    pub fn files(&self, frame: impl Into<Frame>) -> Vec<PathBuf> {
        let frame = frame.into();
        let texts = self.resolved.sources.iter().map(|source| source.name.as_str());
        let texts = texts.filter(|name| !name.starts_with("library/")).map(PathBuf::from);
        let textures = self.resolved.textures.iter();
        let images = textures.filter_map(|(source, _)| source.path(frame).ok().flatten());
        texts.chain(images).collect()
    }

    /// Whether the program looks up a different file in each frame.
    pub fn has_texture_sequence(&self) -> bool {
        self.resolved.textures.iter().any(|(source, _)| source.is_sequence())
    }

    /// Whether the program or one of its imports defines a function with this name.
    pub fn defines(&self, function: &str) -> bool {
        let own = |f: &&resolve::tree::Function| {
            !self.resolved.sources.get(f.span.source).name.starts_with("library/")
        };
        self.resolved.functions.iter().filter(own).any(|f| f.name == function)
    }

    /// What an image has to have for a run: the variables that the program reads, and that neither it nor the system
    /// gives. `I` needs `point`, and `pixelsize` makes use of `point` and `surface` where they are there.
    ///
    /// ```
    /// use pse::Program;
    ///
    /// let program = Program::compile("color = white * Noise(point / pixelsize) * sin(pi * depth * frame)")?;
    /// assert_eq!(program.required_inputs(), ["point", "depth"]);
    /// # Ok::<(), pse::Error>(())
    /// ```
    pub fn required_inputs(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        let given = |name: &str| {
            resolve::names::constant(name).is_some()
                || resolve::names::SYSTEM.iter().any(|(own, _)| *own == name)
                || matches!(name, "eye" | "pixelsize" | "pixel_freq")
        };
        for name in self.inputs() {
            let name = if name == "I" { "point" } else { name };
            if !given(name) && !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// The program after name resolution.
    #[doc(hidden)]
    pub fn resolved(&self) -> &Resolved {
        &self.resolved
    }

    /// The source texts that the spans of its errors refer to.
    pub fn sources(&self) -> &Sources {
        &self.resolved.sources
    }

    /// The names of the variables that the program assigns at the pixels.
    pub fn assigned(&self) -> impl Iterator<Item = &str> {
        self.resolved.assigned()
    }

    /// The names that the program reads but does not assign: image variables or constants.
    pub fn inputs(&self) -> impl Iterator<Item = &str> {
        let unassigned = |g: &&resolve::tree::Global| {
            let space = resolve::space_of(&g.name).is_some();
            g.read.is_some() && g.assigned.is_none() && g.framed.is_none() && !g.library && !space
        };
        self.resolved.globals.iter().filter(unassigned).map(|g| g.name.as_str())
    }

    fn error(&self, failure: Failure) -> Error {
        let (diagnostics, cancelled) = match failure {
            Failure::Program(diagnostics) => (diagnostics, false),
            Failure::Cancelled => (vec![Diagnostic::bare("cancelled", "the run was cancelled")], true),
        };
        Error { diagnostics, sources: self.resolved.sources.clone(), cancelled }
    }
}

/// Runs of one program one after another: for each frame, tile or change of a param. It keeps memory, tapes and what was
/// bound, so that a run like the last one allocates nothing and costs hardly more than its pixels.
///
/// A session is used by one thread at a time; give each thread of the host its own.
///
/// ```
/// use pse::{BufferView, BufferViewMut, Program, RunOptions, Session, Shape, Strides};
/// use std::sync::Arc;
///
/// let program = Arc::new(Program::compile("color = 0.5 * color")?);
/// let mut session = Session::new(program);
/// // Two by two pixels of RGBA, the host's own.
/// let framebuffer = [1.0f32; 16];
/// let mut result = [0.0f32; 16];
/// let strides = Strides::interleaved(4, 2);
/// let color = BufferView { name: "color", shape: Shape::Vector(4), data: &framebuffer, strides };
/// let mut out = [BufferViewMut { name: "color", components: 4, data: &mut result, strides }];
/// session.run_into([2, 2], &[color], &mut out, &RunOptions::default())?;
/// assert_eq!(result, [0.5; 16]);
/// # Ok::<(), pse::Error>(())
/// ```
pub struct Session {
    program: Arc<Program>,
    metadata: Metadata,
    inner: eval::Session,
}

impl Session {
    /// A session of a program.
    pub fn new(program: impl Into<Arc<Program>>) -> Session {
        Session { program: program.into(), metadata: Metadata::default(), inner: eval::Session::default() }
    }

    /// The program.
    pub fn program(&self) -> &Arc<Program> {
        &self.program
    }

    /// Where the pixels of [`Session::run_into`] lie in the picture, and what else a file's header would say.
    pub fn metadata_mut(&mut self) -> &mut Metadata {
        &mut self.metadata
    }

    /// Runs the program at every pixel of an image, as [`Program::run`].
    ///
    /// # Errors
    /// As [`Program::run`].
    pub fn run(&mut self, image: &Image<'_>, options: &RunOptions<'_>) -> Result<Report, Error> {
        let outcome = self.inner.run(&self.program.resolved, image, options);
        outcome.map_err(|f| self.program.error(f))
    }

    /// Runs the program on buffers of the host, columns and rows of `size`, and writes into others. A buffer of the outputs
    /// has the size of what is run: with [`RunOptions::window`] that of the window. `color` in a buffer of four
    /// components takes the program's alpha, or that of the input, or 1. The report has no image.
    ///
    /// # Errors
    /// As [`Program::run`]; and if a buffer is too small for its strides, or does not fit the shape of its variable. After an
    /// error the outputs may be written in part.
    pub fn run_into(
        &mut self,
        size: [usize; 2],
        inputs: &[BufferView<'_>],
        outputs: &mut [BufferViewMut<'_>],
        options: &RunOptions<'_>,
    ) -> Result<Report, Error> {
        let resolved = &self.program.resolved;
        let outcome = self.inner.run_into(resolved, size, &self.metadata, inputs, outputs, options);
        outcome.map_err(|f| self.program.error(f))
    }
}

impl fmt::Debug for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Session").field("program", &self.program).finish_non_exhaustive()
    }
}

/// A pixel among those that the image holds.
fn index(image: &Image<'_>, column: usize, row: usize) -> usize {
    assert!(column < image.width && row < image.height, "the image has no pixel [{column} {row}]");
    row * image.width + column
}

/// A run over an image that arrives a few rows at a time, from the top down; see [`Program::stream`].
pub struct Stream<'p> {
    program: &'p Program,
    inner: eval::Stream<'p>,
}

impl Stream<'_> {
    /// Runs the next rows: `rows` of the stored rows of `image`. The image can contain more rows; a program with
    /// `pixelsize` or derivatives needs three above and three below. `metadata` gives the position of the image in
    /// the picture.
    ///
    /// Returns `None` if an output has more components here than in the rows before. Then all rows must run again,
    /// from the first, and will have the larger number.
    ///
    /// # Errors
    /// As [`Program::run`].
    pub fn rows(&mut self, image: &Image<'_>, rows: Range<usize>) -> Result<Option<Report>, Error> {
        self.inner.rows(image, rows).map_err(|f| self.program.error(f))
    }
}

/// The errors of a program, as data and as text.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Error {
    /// The diagnostics, at least one, in the order of the text.
    pub diagnostics: Vec<Diagnostic>,
    /// The source texts that their spans refer to.
    pub sources: Sources,
    /// Whether the run was cancelled.
    pub cancelled: bool,
}

impl Error {
    /// An error of these faults, whose places lie in `sources`.
    pub fn new(diagnostics: Vec<Diagnostic>, sources: Sources) -> Error {
        Error { diagnostics, sources, cancelled: false }
    }

    /// Renders all messages, with the source lines and the places underlined.
    pub fn render(&self, style: Style) -> String {
        let mut sorted: Vec<&Diagnostic> = self.diagnostics.iter().collect();
        sorted.sort_by_key(|d| d.span().map(|s| (s.source, s.start)));
        sorted.iter().map(|d| d.render(&self.sources, style)).collect::<Vec<_>>().join("\n")
    }
}

/// The rendered messages, without colours.
impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.render(Style::PLAIN).trim_end())
    }
}

impl std::error::Error for Error {}

// Checked at compile time: hosts share programs between threads.
const _: fn() = || {
    fn shared<T: Send + Sync>() {}
    shared::<Program>();
    shared::<Error>();
    shared::<Shape>();
};
