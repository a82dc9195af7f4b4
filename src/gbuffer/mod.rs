//! What the points of a G-buffer say about its rendering: the camera that saw them, and whether they are noisy.
//!
//! ```
//! use pse::gbuffer;
//!
//! let mut image = pse::scene::render("donut", &pse::scene::Options::default())?;
//! // A file of a renderer that does not write its camera.
//! image.metadata.attributes = Default::default();
//! let found = gbuffer::resect(&image)?;
//! assert!(found.residual < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod jumps;
mod points;
mod projection;
mod resection;

#[cfg(test)]
mod tests;

pub use jumps::{JumpCounter, Jumps};
pub use points::PointSampler;
#[cfg(any(test, feature = "flow"))]
pub(crate) use points::surfaces;
pub use projection::Projection;
pub use resection::{Resection, ResectionError, resect};
