//! The pixel stream editor: a small language, run at every pixel of an image.

#![warn(missing_docs)]

pub mod builtin;
pub mod cli;
pub mod diagnostic;
pub mod eval;
pub mod image;
pub mod lanes;
pub mod math;
pub mod noise;
pub mod resolve;
pub mod scene;
pub mod shape;
pub mod syntax;
pub mod value;
