//! The evaluator: a walk over the resolved tree that visits each node once for a batch of pixels.
//!
//! [`run()`] splits an image into batches and gives them to threads; a `Machine` runs one batch
//! after another. A batch has one shape for each value. Where its lanes part ways in shape it is cut and run
//! again in pieces, down to one lane, which defines what a program means.

mod absent;
mod bind;
mod call;
mod dense;
mod drive;
mod expr;
mod fault;
mod flow;
mod frame;
mod grid;
mod host_function;
mod index;
mod input;
mod limits;
mod load;
mod machine;
mod ops;
mod output;
mod passes;
mod pixel;
mod pixels;
mod pixelsize;
mod plan;
mod print;
mod profile;
mod run;
mod samples;
mod session;
mod shadow;
mod spaces;
mod steps;
mod store;
mod stream;
mod target;
mod trace;
mod tracer;
mod worker;

pub use absent::{NO_IMAGE, absent};
pub use bind::Missing;
pub use frame::{ParamInfo, params};
pub use grid::Window;
pub use host_function::{BatchArguments, BatchResult, HostFunction};
pub use input::{BufferView, BufferViewMut, Strides};
pub use limits::Limits;
pub use output::{default_names as default_outputs, keeps_alpha};
pub use pixel::{eval_pixel, trace};
pub use print::{Part, Printed, Prints};
pub use profile::{Profile, Spent};
pub use run::{Executor, Failure, MAX_THREADS, Options, Progress, Report, TEXTURE_MEMORY};
pub use samples::{Filter, Places, Resample, Sampling};
pub use session::Session;
pub use spaces::{has_space, no_eye};
pub use steps::REACH;
pub use stream::{Stream, run};
pub use trace::{Birth, Event, EventKind, NotFinite, Trace, TraceOptions};

/// Lanes of a batch, unless [`Options::batch`] says otherwise. Chosen by `benches/batch.rs`: large enough to
/// spread the cost of a tree's walk, small enough that the planes of a program stay in the cache.
pub const BATCH: usize = 2048;
