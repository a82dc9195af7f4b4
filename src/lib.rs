//! The pixel stream editor: a small language, run at every pixel of an image.

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
    Program, Progress, Report, RunOptions, RunSummary, Sampling, Session, Stream, Strides, Trace,
    TraceOptions, Window,
};
pub use crate::shape::Shape;
pub use crate::texture::Origin;
pub use crate::value::PixelValue;
