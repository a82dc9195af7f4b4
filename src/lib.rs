//! The pixel stream editor: a small language, run at every pixel of an image.

#![warn(missing_docs)]

mod assist;
mod builtin;
mod diagnostic;
mod eval;
mod files;
pub mod flow;
pub mod gbuffer;
mod host;
pub mod image;
#[doc(hidden)]
pub mod internal;
mod lanes;
mod math;
pub mod measure;
pub mod mesh;
pub mod noise;
mod program;
mod quote;
mod reference;
mod resolve;
pub mod scene;
mod shape;
pub mod solid;
mod spelling;
mod syntax;
mod texture;
mod value;
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
