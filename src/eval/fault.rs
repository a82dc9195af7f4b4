//! Why a batch could not be run to its end.

use crate::diagnostic::Diagnostic;
use crate::value::Mask;

/// What stops a batch.
#[derive(Debug)]
pub(super) enum Fault {
    /// The program is wrong at a lane; lanes before it may be wrong elsewhere.
    Error(Box<Diagnostic>, usize),
    /// The lanes of the mask need another shape than the rest: run the two parts apart.
    Split(Mask),
    /// This lane, or another one, may have used up its steps: count for each lane by itself.
    Count(usize),
    /// Whoever runs it does not want it any more.
    Cancelled,
}

pub(super) type Result<T> = std::result::Result<T, Fault>;
