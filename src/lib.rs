//! The pixel stream editor: a small language, run at every pixel of an image.

#![warn(missing_docs)]

pub mod assist;
pub mod builtin;
pub mod cli;
pub mod diagnostic;
pub mod eval;
pub mod files;
pub mod flow;
pub mod gbuffer;
pub mod host;
pub mod image;
pub mod lanes;
pub mod math;
pub mod measure;
pub mod mesh;
pub mod noise;
mod program;
mod quote;
pub mod reference;
pub mod resolve;
pub mod scene;
pub mod shape;
pub mod solid;
mod spelling;
pub mod syntax;
pub mod texture;
pub mod value;
mod visible;
mod vocabulary;

pub use crate::diagnostic::{Diagnostic, Style};
pub use crate::eval::{
    BATCH, BatchArguments, BatchResult, Birth, Event, EventKind, HostFunction, NotFinite, Part, Printed,
};
pub use crate::host::Host;
pub use crate::image::{Image, Variable};
pub use crate::program::{
    Compiler, Error, Failure, Filter, Limits, Prints, Program, Progress, Report, RunOptions, Sampling,
    Stream, Trace, TraceOptions,
};
pub use crate::shape::Shape;
pub use crate::value::PixelValue;
