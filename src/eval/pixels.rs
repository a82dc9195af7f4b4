//! Which pixels a batch is.

use crate::value::{Lanes, Plane};

/// The pixels of a batch, as indices into an image's planes: in a row, or any.
#[derive(Clone, Copy, Debug)]
pub(super) enum Pixels<'a> {
    /// The first, and how many follow each other.
    Run(usize, usize),
    /// Ascending.
    List(&'a [usize]),
}

impl Pixels<'_> {
    pub fn len(self) -> usize {
        match self {
            Pixels::Run(_, n) => n,
            Pixels::List(list) => list.len(),
        }
    }

    /// The pixel of a lane.
    pub fn at(self, lane: usize) -> usize {
        match self {
            Pixels::Run(start, _) => start + lane,
            Pixels::List(list) => list[lane],
        }
    }

    /// What a plane of the image holds at these pixels.
    pub fn gather(self, plane: &[f32]) -> Plane {
        let n = self.len();
        Plane::Varying(Lanes::filled(n, |out| match self {
            Pixels::Run(start, n) => out.copy_from_slice(&plane[start..start + n]),
            Pixels::List(list) => {
                for (out, &pixel) in out.iter_mut().zip(list) {
                    *out = plane[pixel];
                }
            }
        }))
    }

    /// What `f` of the pixel's index gives.
    pub fn map(self, f: impl Fn(usize) -> f32) -> Plane {
        let n = self.len();
        Plane::filled(n, |out| {
            for (lane, out) in out.iter_mut().enumerate() {
                *out = f(self.at(lane));
            }
        })
    }
}

/// The like, kept.
pub(super) enum Batch {
    Run(usize, usize),
    List(Box<[usize]>),
}
