//! Numbers by column and row: in memory, or in tiles of a file.

use super::number::Number;
use super::store::{Near, Store};
use crate::image::{ErrorKind, ImageError};
use std::sync::Arc;

/// Columns and rows of a tile.
pub(super) const TILE: usize = 32;

/// A rectangle of places with some numbers each.
#[derive(Debug)]
pub(super) struct Grid<T> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Numbers of a place.
    pub components: usize,
    numbers: Numbers<T>,
}

#[derive(Debug)]
enum Numbers<T> {
    /// Rows from the top.
    Memory(Vec<T>),
    /// Tiles row by row, those at the edges filled up; the first one begins there in the file.
    Stored(Arc<Store>, u64),
}

impl<T: Number> Grid<T> {
    /// All numbers, rows from the top, if they are in memory.
    #[inline]
    pub fn memory(&self) -> Option<&[T]> {
        match &self.numbers {
            Numbers::Memory(numbers) => Some(numbers),
            Numbers::Stored(..) => None,
        }
    }

    /// The numbers of a place.
    #[inline]
    pub fn at<const C: usize>(&self, x: usize, y: usize, near: &mut Near) -> [T; C] {
        match &self.numbers {
            Numbers::Memory(numbers) => {
                let start = (y * self.width + x) * C;
                std::array::from_fn(|c| numbers[start + c])
            }
            Numbers::Stored(store, start) => {
                let size = tile_bytes::<T>(C);
                let tile = y / TILE * self.width.div_ceil(TILE) + x / TILE;
                let bytes = store.tile(start + (tile * size) as u64, size, near);
                let place = &bytes[(y % TILE * TILE + x % TILE) * C * T::SIZE..];
                std::array::from_fn(|c| T::get(&place[c * T::SIZE..]))
            }
        }
    }
}

/// The bytes of a tile with so many numbers a place.
fn tile_bytes<T: Number>(components: usize) -> usize {
    TILE * TILE * components * T::SIZE
}

/// The bytes that a grid takes in a file.
pub(super) fn stored_bytes<T: Number>(width: usize, height: usize, components: usize) -> u64 {
    (width.div_ceil(TILE) * height.div_ceil(TILE)) as u64 * tile_bytes::<T>(components) as u64
}

/// A grid in the making, row by row from the top.
pub(super) struct Rows<T> {
    width: usize,
    components: usize,
    /// The rows so far; in tiles, those of the tiles that are not full yet.
    rows: Vec<T>,
    count: usize,
    stored: Option<(Arc<Store>, u64)>,
}

impl<T: Number> Rows<T> {
    /// A grid of rows to come: in memory, or in a file from a place on.
    ///
    /// # Errors
    /// If memory does not suffice.
    pub fn new(
        [width, height]: [usize; 2],
        components: usize,
        stored: Option<(Arc<Store>, u64)>,
    ) -> Result<Rows<T>, ImageError> {
        let held = if stored.is_some() { TILE } else { height };
        let mut rows = Vec::new();
        match width.checked_mul(held).and_then(|n| n.checked_mul(components)) {
            Some(count) if rows.try_reserve_exact(count).is_ok() => {}
            _ => return Err(ImageError::new(ErrorKind::TooLarge, "a texture does not fit in memory")),
        }
        Ok(Rows { width, components, rows, count: 0, stored })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn push(&mut self, row: &[T]) -> Result<(), ImageError> {
        self.rows.extend_from_slice(row);
        self.count += 1;
        if self.stored.is_some() && self.count.is_multiple_of(TILE) { self.write() } else { Ok(()) }
    }

    /// Writes the tiles of the rows that are held.
    fn write(&mut self) -> Result<(), ImageError> {
        let Some((store, start)) = &self.stored else { return Ok(()) };
        let (c, across) = (self.components, self.width.div_ceil(TILE));
        let size = tile_bytes::<T>(c);
        let first = (self.count - 1) / TILE * across;
        let mut bytes = Vec::with_capacity(size);
        for tile in 0..across {
            bytes.clear();
            let columns = tile * TILE * c..((tile + 1) * TILE).min(self.width) * c;
            for (y, row) in self.rows.chunks(self.width * c).enumerate() {
                bytes.resize(y * TILE * c * T::SIZE, 0);
                row[columns.clone()].iter().for_each(|number| number.put(&mut bytes));
            }
            bytes.resize(size, 0);
            store.put(start + ((first + tile) * size) as u64, &bytes)?;
        }
        self.rows.clear();
        Ok(())
    }

    /// The grid of all rows.
    ///
    /// # Errors
    /// If the last ones cannot be written.
    pub fn finish(mut self) -> Result<Grid<T>, ImageError> {
        if !self.rows.is_empty() {
            self.write()?;
        }
        let numbers = match self.stored {
            Some((store, start)) => Numbers::Stored(store, start),
            None => Numbers::Memory(self.rows),
        };
        Ok(Grid { width: self.width, height: self.count, components: self.components, numbers })
    }
}
