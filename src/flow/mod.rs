//! Flow: what happens to points that a program's `velocity(p)` carries along.
//!
//! A solid noise as a force field gives trajectories that part and join like fur, or like flames (J. P. Lewis, "Algorithms for
//! solid noise synthesis", SIGGRAPH 1989, section 5.4, figures 12 and 13). Here a [`Flow`] moves seeds along `p' = velocity(p)`,
//! by the classical Runge-Kutta method of fourth order with a step that is stated; [`draw()`] shows the
//! trajectories as lines, sorted by depth, and [`to_ply`] hands them on as points.
//!
//! ```
//! use pse::flow::{self, Flow};
//! use pse::NoFiles;
//! use pse::RunOptions;
//!
//! // Round and round the z axis, once in 2 pi.
//! let flow = Flow::compile(&NoFiles, "swirl", "function velocity(p)\n    return [-p.y p.x 0]")?;
//! let step = std::f64::consts::TAU / 100.0;
//! let round = flow.trajectories(&[[1.0, 0.0, 0.0]], step, 100, &RunOptions::default())?;
//! let [start, end] = [round.line(0)[0], round.line(0)[100]];
//! assert!((0..3).all(|i| (start[i] - end[i]).abs() < 1e-5));
//! # Ok::<(), pse::Error>(())
//! ```

mod divergence;
mod draw;
mod field;
mod points;
mod seeds;
mod trajectories;

#[cfg(test)]
mod tests;

pub use divergence::Divergence;
pub use draw::{Pen, draw};
pub use points::to_ply;
pub use seeds::{ball, grid, visible};
pub use trajectories::Trajectories;

use crate::host::Host;
use crate::image::Frame;
use crate::program::{Error, Program, RunOptions};
use field::Field;

/// A point or direction in space.
type Vector = [f32; 3];

/// The maximum number of points of all trajectories together, about two gigabytes.
pub const MAX_POINTS: usize = 1 << 27;

/// A program as a flow: its function `velocity(p)`, and `color(p, age, along, line)` if it has one.
///
/// `velocity` takes a point and gives a vector of 3, in units of space a unit of time. `color` may take fewer of its
/// arguments: the point, its age (0 at the seed, 1 at the end of the line), the unit vector along the line, and
/// the number of the line from 0. It gives a
/// colour, or a vector of 4 whose last number is how opaque the line is. Functions read what every program can read of a frame:
/// params, `frame`, what `if begin_frame` assigns.
pub struct Flow {
    velocity: Field,
    color: Option<Field>,
}

impl Flow {
    /// Compiles a program; `name` is its name in messages, and `host` finds its imports.
    ///
    /// # Errors
    /// What is wrong with the program; also if it has no function `velocity(p)`.
    pub fn compile(host: &dyn Host, name: &str, text: &str) -> Result<Flow, Error> {
        let velocity = Field::compile(host, name, text, "velocity", &["point"])?;
        let color = match velocity.program().defines("color") {
            true => Some(Field::compile(host, name, text, "color", &["point", "age", "along", "line"])?),
            false => None,
        };
        Ok(Flow { velocity, color })
    }

    /// Follows each seed for `steps` steps of `step` units of time; backwards if that is negative.
    ///
    /// Of the options those of the frame and of the machine count: `frame`, `set`, `limits`, `threads`, `progress`, `cancel` and
    /// `pixelsize`, which is how fine a detail of the velocity may be.
    ///
    /// # Errors
    /// An error of the program; a velocity that is no vector of 3, or not finite; more than [`MAX_POINTS`] points.
    pub fn trajectories(
        &self,
        seeds: &[[f32; 3]],
        step: f64,
        steps: usize,
        options: &RunOptions<'_>,
    ) -> Result<Trajectories, Error> {
        trajectories::follow(&self.velocity, seeds, step, steps, options)
    }

    /// Computes the colour and opacity of each point of the trajectories, in order; `None` if the program has no
    /// function `color`.
    ///
    /// # Errors
    /// An error of the program, or a colour that is none.
    pub fn colors(
        &self,
        trajectories: &Trajectories,
        options: &RunOptions<'_>,
    ) -> Result<Option<Vec<[f32; 4]>>, Error> {
        self.color.as_ref().map(|color| trajectories::colors(color, trajectories, options)).transpose()
    }

    /// The programs of the flow: that of the velocity, and that of the colours if it exists.
    pub fn programs(&self) -> impl Iterator<Item = &Program> {
        std::iter::once(self.velocity.program()).chain(self.color.iter().map(|color| color.program()))
    }

    /// The files that its program is made of in a frame: the program itself, imports, images that it looks up.
    pub fn files(&self, frame: Frame) -> Vec<std::path::PathBuf> {
        let color = self.color.iter().flat_map(|color| color.program().files(frame));
        self.velocity.program().files(frame).into_iter().chain(color).collect()
    }

    /// Measures the divergence of the velocity at some points, by differences over twice `distance`.
    ///
    /// # Errors
    /// An error of the program.
    pub fn divergence(
        &self,
        points: &[[f32; 3]],
        distance: f64,
        options: &RunOptions<'_>,
    ) -> Result<Divergence, Error> {
        divergence::measure(&self.velocity, points, distance, options)
    }
}
