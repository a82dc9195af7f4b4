//! The pixel stream editor: a small language for shading, run at every pixel of an image.
//!
//! A program reads the variables of its input (`point`, `normal`, `surface`, `color`, …) and assigns those of its output.
//! It is compiled once and run on any number of images; the same program and input give the same bits on every machine,
//! with any number of threads. The language is described in `docs/language.md` of the repository.
//!
//! ```
//! use pse::{Image, Program, RunOptions, Shape, Variable};
//!
//! let program = Program::compile("color = white * abs(sin(8 * point.x))")?;
//! // Planes of the host, borrowed.
//! let x: Vec<f32> = (0..64).map(|i| i as f32 / 64.0).collect();
//! let zero = vec![0.0; 64];
//! let point = Variable::new("point", Shape::Vector(3), [&x[..], &zero, &zero])?;
//! let image = Image::new(64, 1, [point])?;
//! let report = program.run(&image, &RunOptions::default())?;
//! assert_eq!(report.image.variable("color").unwrap().planes.len(), 3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Many runs
//!
//! A [`Session`] keeps memory and tapes between runs, reads and writes a host's own buffers, interleaved or planar, and
//! allocates nothing in a steady state.
//!
//! ```
//! use pse::{BufferView, BufferViewMut, Program, RunOptions, Session, Shape, Strides};
//!
//! let mut session = Session::new(Program::compile("color = color * [1 0.5 0.25 1]")?);
//! let rgba = [1.0f32; 4 * 6];
//! let mut graded = [0.0f32; 4 * 6];
//! let strides = Strides::interleaved(4, 3);
//! let input = BufferView { name: "color", shape: Shape::Vector(4), data: &rgba, strides };
//! let mut output = [BufferViewMut { name: "color", components: 4, data: &mut graded, strides }];
//! session.run_into([3, 2], &[input], &mut output, &RunOptions::default())?;
//! assert_eq!(graded[..4], [1.0, 0.5, 0.25, 1.0]);
//! # Ok::<(), pse::Error>(())
//! ```
//!
//! # Options
//!
//! [`RunOptions`] has the frame, values of params, the window that is run, threads, limits, cancelling and progress.
//!
//! ```
//! use pse::{Image, Program, RunOptions, Window};
//!
//! let program = Program::compile("param veins = 4 in [1 20]\ncolor = white * veins * frame")?;
//! assert_eq!(program.params(&Image::default(), &RunOptions::default())?[0].name, "veins");
//! let options = RunOptions {
//!     frame: 2.0,
//!     set: vec![("veins".to_string(), 6.0.into())],
//!     window: Some(Window { columns: 1..3, rows: 0..1 }),
//!     threads: Some(1),
//!     ..RunOptions::default()
//! };
//! let report = program.run(&Image::new(4, 4, [])?, &options)?;
//! assert_eq!(report.image.variables[0].planes[0][..], [12.0, 12.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Errors
//!
//! An [`Error`] has facts, one [`Diagnostic`] for each fault, and renders itself with the lines of the program.
//!
//! ```
//! use pse::{Program, Style};
//!
//! let error = Program::compile("color = nosie(point)").unwrap_err();
//! let fault = &error.diagnostics[0];
//! assert_eq!(error.sources.line_column(fault.span().unwrap()), (1, 9));
//! assert!(fault.message.contains("nosie"));
//! assert!(error.render(Style::PLAIN).contains("color = nosie(point)"));
//! ```
//!
//! # Functions of the host
//!
//! ```
//! use pse::{Compiler, HostFunction, RunOptions};
//!
//! let double = HostFunction::for_lanes("double", &[("x", 1)], 1, |inputs, outputs| {
//!     outputs[0].iter_mut().zip(inputs[0]).for_each(|(out, x)| *out = 2.0 * x);
//!     Ok(())
//! });
//! let program = Compiler::new().function(double).compile("host.pse", "a = double(21)")?;
//! assert_eq!(program.eval_pixel(&[], &RunOptions::default())?, [("a".to_string(), 42.0.into())]);
//! # Ok::<(), pse::Error>(())
//! ```
//!
//! # Noise alone
//!
//! ```
//! use pse::Isa;
//! use pse::noise::{Kind, Params};
//!
//! let kind = Kind::from_name("gradient").unwrap();
//! let field = kind.field(2, &Params::seeded(7)).unwrap();
//! let mut noise = [0.0; 2];
//! field.noise(Isa::detect(), &[&[0.5, 1.0], &[0.25, 3.0]], &mut noise);
//! assert_eq!(noise[1], 0.0); // it is zero at lattice points
//! ```
//!
//! # Features
//!
//! The core is the language, its engine and the noises. `threads` runs on several threads; `deep` lets expressions nest
//! without a limit; `fancy` draws error messages; `exr` and `raster` read and write files; `mesh`, `scene`, `solid` and
//! `flow` make G-buffers; `measure` has the statistics of noise; `capi` is the C interface. `cli`, the default, is the
//! command with all of them: a library wants `default-features = false`.

#![warn(missing_docs)]

mod assist;
mod builtin;
#[cfg(feature = "capi")]
pub mod capi;
mod clock;
mod diagnostic;
mod eval;
#[cfg(feature = "exr")]
mod files;
#[cfg(feature = "flow")]
pub mod flow;
#[cfg(feature = "scene")]
pub mod gbuffer;
mod host;
pub mod image;
#[doc(hidden)]
pub mod internal;
mod lanes;
mod math;
#[cfg(feature = "measure")]
pub mod measure;
#[cfg(feature = "mesh")]
pub mod mesh;
pub mod noise;
mod parallel;
mod program;
mod quote;
mod reference;
mod resolve;
#[cfg(feature = "scene")]
pub mod scene;
mod shape;
#[cfg(feature = "solid")]
pub mod solid;
mod spelling;
mod stack;
mod syntax;
mod texture;
mod value;
mod visible;
mod vocabulary;

pub use crate::diagnostic::{Diagnostic, Label, Severity, Source, SourceId, Sources, Span, Style};
pub use crate::eval::{
    BATCH, BatchArguments, BatchResult, Birth, Event, EventKind, HostFunction, NotFinite, Part, Printed,
};
#[cfg(feature = "exr")]
pub use crate::host::Disk;
pub use crate::host::{Host, HostError, Memory, NoFiles};
pub use crate::image::{BuildError, Image, Metadata, Variable};
pub use crate::lanes::Isa;
pub use crate::program::{
    BufferView, BufferViewMut, Compiler, Error, Executor, Failure, Filter, Limits, ParamInfo, Prints,
    Program, Progress, Report, RunOptions, Sampling, Session, Stream, Strides, Trace, TraceOptions, Window,
};
pub use crate::shape::Shape;
pub use crate::texture::Origin;
pub use crate::value::PixelValue;
