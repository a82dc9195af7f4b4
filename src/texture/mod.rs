//! Images to look things up in: mip maps, summed-area tables, and the filters over them; pictures of all that is
//! around. Knows nothing of the language.
//!
//! A place in a texture is `s` along its columns and `v` down its rows, both from 0 to 1 over the image; the
//! functions of programs turn `t`, which goes up, into `v`. A *texel* is a pixel of a texture. Numbers that are
//! no finite ones would spread with every average: NaN is read as 0, infinity as the largest half.

mod grid;
mod level;
mod look;
mod number;
mod pyramid;
mod source;
mod sphere;
#[cfg(feature = "exr")]
mod store;
#[cfg(not(feature = "exr"))]
#[path = "no_store.rs"]
mod store;
mod sums;
#[cfg(test)]
mod tests;
mod texels;
mod wanted;

pub use look::{Filter, Look};
pub use source::{Origin, Source};
pub use sphere::turned_z_up;
pub use store::{Near, Tiles};

use crate::image::ImageError;
use crate::shape::Shape;
use level::Level;
use std::sync::Arc;
use store::Store;
use sums::Sums;

/// What stands beyond the edges of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The image again and again.
    Periodic,
    /// Nothing: 0.
    Black,
    /// The texels of the edge.
    Clamp,
    /// The image mirrored, and then again.
    Mirror,
}

/// What the image shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// A plane.
    Plane,
    /// All directions: longitude along the columns, latitude along the rows.
    LatLong,
    /// All directions: the six sides of a cube.
    Cube,
}

/// What a texture is kept ready for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// A mip map.
    pub levels: bool,
    /// A summed-area table.
    pub sums: bool,
}

/// The most components of a texel.
pub const COMPONENTS: usize = 4;

/// A texture, ready to be looked up.
#[derive(Debug)]
pub struct Texture {
    shape: Shape,
    layout: Layout,
    /// The image itself, then its mip map.
    levels: Vec<Level>,
    sums: Option<Sums>,
    /// The file in which it stands, tile by tile, if it is not in memory.
    store: Option<Arc<Store>>,
}

impl Texture {
    /// What a look-up gives: a scalar, or a vector of no more than [`COMPONENTS`].
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// What the image shows.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// Is all ready that is needed?
    fn serves(&self, needs: Needs) -> bool {
        let single = self.levels[0].width * self.levels[0].height == 1;
        (!needs.levels || single || self.levels.len() > 1) && (!needs.sums || self.sums.is_some())
    }

    /// Tells whether all that was looked up could be read.
    ///
    /// # Errors
    /// If it stands in a temporary file, and a part of that could not be read: what was looked up since is void.
    pub fn sound(&self) -> Result<(), ImageError> {
        self.store.as_ref().map_or(Ok(()), |store| store.sound())
    }

    /// The bytes of memory that it takes for itself: none, if its tiles are in a file.
    fn memory(&self) -> u64 {
        let [w, h, c] =
            [self.levels[0].texels.width, self.levels[0].texels.height, self.levels[0].texels.components];
        let needs = Needs { levels: self.levels.len() > 1, sums: self.sums.is_some() };
        if self.store.is_some() { 0 } else { bytes([w, h], c, needs) }
    }
}

/// The bytes that an image of so many texels and components takes, with what is kept ready.
fn bytes(size: [usize; 2], components: usize, needs: Needs) -> u64 {
    let texels = size[0] as u64 * size[1] as u64 * components as u64;
    let levels = if needs.levels { texels / 3 } else { 0 };
    let sums = if needs.sums { (size[0] as u64 + 1) * (size[1] as u64 + 1) * components as u64 } else { 0 };
    4 * (texels + levels) + 8 * sums
}
