//! What can be wrong with a solid.

use crate::diagnostic::Diagnostic;
use crate::program::Error;
use crate::scene::SceneError;
use std::fmt;

/// An error of a solid or its view.
#[derive(Clone, Debug)]
pub enum SolidError {
    /// The program has errors, failed at a point, or was cancelled.
    Program(Box<Error>),
    /// The view is invalid.
    View(Box<SceneError>),
    /// The solid is invalid: its box, its density or its size.
    Solid(Box<Diagnostic>),
}

impl SolidError {
    /// With a way to mend it.
    pub(super) fn new(message: impl Into<String>, hint: impl Into<String>) -> SolidError {
        SolidError::Solid(Box::new(Diagnostic::bare("solid", message).hint(hint)))
    }
}

impl From<Error> for SolidError {
    fn from(error: Error) -> SolidError {
        SolidError::Program(Box::new(error))
    }
}

impl From<SceneError> for SolidError {
    fn from(error: SceneError) -> SolidError {
        SolidError::View(Box::new(error))
    }
}

impl fmt::Display for SolidError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SolidError::Program(error) => error.fmt(f),
            SolidError::View(error) => error.fmt(f),
            SolidError::Solid(diagnostic) => {
                f.write_str(&diagnostic.message)?;
                diagnostic.hints.iter().try_for_each(|hint| write!(f, "; {hint}"))
            }
        }
    }
}

impl std::error::Error for SolidError {}
