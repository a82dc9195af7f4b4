//! Which pixels of an image are run: all of some rows, or every so many.

use std::ops::Range;

/// The pixels that are run, numbered one after another; a pixel's own number is that in the image's planes.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Columns of the image.
    width: usize,
    rows: Range<usize>,
    every: usize,
}

impl Grid {
    /// Every so many columns and rows of these rows; 0 is as good as 1.
    pub fn new(width: usize, rows: Range<usize>, every: usize) -> Grid {
        Grid { width, rows, every: every.max(1) }
    }

    /// Are these all pixels of the rows?
    pub fn all(&self) -> bool {
        self.every == 1
    }

    /// Columns and rows that are run.
    pub fn size(&self) -> [usize; 2] {
        [self.width.div_ceil(self.every), self.rows.len().div_ceil(self.every)]
    }

    /// Pixels that are run.
    pub fn count(&self) -> usize {
        let [columns, rows] = self.size();
        columns * rows
    }

    /// The pixel of a number.
    #[inline]
    pub fn pixel(&self, number: usize) -> usize {
        if self.every == 1 {
            return self.rows.start * self.width + number;
        }
        let [columns, _] = self.size();
        let (column, row) = (number % columns * self.every, number / columns * self.every);
        (self.rows.start + row) * self.width + column
    }

    /// The number of a pixel that is run.
    pub fn number(&self, pixel: usize) -> usize {
        let [columns, _] = self.size();
        let (column, row) = (pixel % self.width, pixel / self.width - self.rows.start);
        row / self.every * columns + column / self.every
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_pixels_belong_together() {
        for every in [0, 1, 2, 4, 7, 100] {
            let grid = Grid::new(13, 3..20, every);
            assert_eq!(grid.pixel(0), 39);
            assert!((0..grid.count()).all(|number| grid.number(grid.pixel(number)) == number), "{every}");
            assert!(grid.pixel(grid.count() - 1) < 20 * 13);
        }
        assert_eq!(Grid::new(13, 0..9, 4).size(), [4, 3]);
    }
}
