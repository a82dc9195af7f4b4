//! Which pixels of an image are run: those of a window, or every Nth of them.

use std::ops::Range;

/// Columns and rows of the pixels that an image holds, counted from its top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Window {
    /// The columns.
    pub columns: Range<usize>,
    /// The rows.
    pub rows: Range<usize>,
}

/// The pixels that are run, numbered one after another; a pixel's own number is that in the image's planes.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Columns of the image.
    width: usize,
    window: Window,
    every: usize,
}

impl Grid {
    /// Every Nth column and row of the window (`every`); 0 counts as 1.
    pub fn new(width: usize, window: Window, every: usize) -> Grid {
        Grid { width, window, every: every.max(1) }
    }

    /// How many pixels of a number and after it follow one another in the image.
    pub fn run(&self, number: usize) -> usize {
        let columns = self.window.columns.len();
        if self.every > 1 {
            1
        } else if columns == self.width {
            self.count() - number
        } else {
            columns - number % columns
        }
    }

    /// Columns and rows that are run.
    pub fn size(&self) -> [usize; 2] {
        [&self.window.columns, &self.window.rows].map(|range| range.len().div_ceil(self.every))
    }

    /// Pixels that are run.
    pub fn count(&self) -> usize {
        let [columns, rows] = self.size();
        columns * rows
    }

    /// The pixel of a number.
    #[inline]
    pub fn pixel(&self, number: usize) -> usize {
        let Window { columns, rows } = &self.window;
        if self.every == 1 && columns.len() == self.width {
            return rows.start * self.width + number;
        }
        let [count, _] = self.size();
        let (column, row) = (number % count * self.every, number / count * self.every);
        (rows.start + row) * self.width + columns.start + column
    }

    /// The number of a pixel that is run.
    pub fn number(&self, pixel: usize) -> usize {
        let [count, _] = self.size();
        let (column, row) = (pixel % self.width, pixel / self.width);
        (row - self.window.rows.start) / self.every * count
            + (column - self.window.columns.start) / self.every
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_pixels_belong_together() {
        for columns in [0..13, 2..9, 5..6] {
            for every in [0, 1, 2, 4, 7, 100] {
                let grid = Grid::new(13, Window { columns: columns.clone(), rows: 3..20 }, every);
                assert_eq!(grid.pixel(0), 39 + columns.start);
                assert!((0..grid.count()).all(|number| grid.number(grid.pixel(number)) == number), "{every}");
                assert!(grid.pixel(grid.count() - 1) < 20 * 13);
                for number in 0..grid.count() {
                    let last = number + grid.run(number) - 1;
                    assert!(last < grid.count() && grid.pixel(last) - grid.pixel(number) == last - number);
                }
            }
        }
        assert_eq!(Grid::new(13, Window { columns: 0..13, rows: 0..9 }, 4).size(), [4, 3]);
    }
}
