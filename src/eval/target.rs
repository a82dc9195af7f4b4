//! Where the pixels of a run are written: planes of its own, or a host's buffers with strides, cut into stretches that
//! threads can write at the same time.

use smallvec::SmallVec;

use super::input::Strides;

/// A buffer, and which planes of the outputs it takes.
pub(super) struct Target<'p> {
    /// The number of each plane among those of the outputs, and the index of its numbers in a pixel.
    planes: SmallVec<[(usize, usize); 4]>,
    /// What is left to write, from the lowest index on.
    data: &'p mut [f32],
    pixel: usize,
    /// From a row to the next, however the rows are ordered.
    row: usize,
    /// Whether the last row comes first.
    upward: bool,
}

impl<'p> Target<'p> {
    /// A plane of its own.
    pub fn plane(number: usize, data: &'p mut [f32]) -> Target<'p> {
        Target { planes: SmallVec::from_slice(&[(number, 0)]), data, pixel: 1, row: 0, upward: false }
    }

    /// A host's buffer of at least one pixel, which [`Strides::fits`] has found large enough. `None` where its rows overlap one another.
    pub fn buffer(
        planes: SmallVec<[(usize, usize); 4]>,
        data: &'p mut [f32],
        strides: &Strides,
        [width, height]: [usize; 2],
    ) -> Option<Target<'p>> {
        let row = strides.row.unsigned_abs();
        let upward = strides.row < 0;
        let components = planes.iter().map(|(_, at)| at + 1).max().unwrap_or(1);
        let extent = (width - 1) * strides.pixel + (components - 1) * strides.component + 1;
        if height > 1 && row < extent || width > 1 && strides.pixel == 0 {
            return None;
        }
        let lowest = if upward { strides.start - (height - 1) * row } else { strides.start };
        let planes = planes.into_iter().map(|(plane, at)| (plane, at * strides.component)).collect();
        Some(Target { planes, data: &mut data[lowest..], pixel: strides.pixel, row, upward })
    }

    /// Whether the pixels of all rows follow one another evenly.
    fn is_linear(&self, [width, height]: [usize; 2]) -> bool {
        !self.upward && (self.row == 0 || height == 1 || self.row == self.pixel * width)
    }

    /// Cuts off the next `len` pixels of `rows` rows, behind which `left` more rows come.
    fn cut(&mut self, size: [usize; 2], len: usize, rows: usize, left: usize) -> Piece<'p> {
        let data = std::mem::take(&mut self.data);
        let linear = self.is_linear(size);
        let at = if linear {
            len * self.pixel
        } else if self.upward {
            left * self.row
        } else {
            rows * self.row
        };
        let (low, high) = data.split_at_mut(at.min(data.len()));
        let (piece, rest) = if self.upward && !linear { (high, low) } else { (low, high) };
        self.data = rest;
        let width = if linear { len } else { size[0] };
        Piece {
            planes: self.planes.clone(),
            data: piece,
            pixel: self.pixel,
            row: self.row,
            upward: self.upward,
            width,
        }
    }
}

/// All targets of a run, and how far they are written.
pub(super) struct Targets<'p> {
    size: [usize; 2],
    linear: bool,
    targets: SmallVec<[Target<'p>; 8]>,
    next: usize,
}

impl<'p> Targets<'p> {
    /// Targets for `size` columns and rows.
    pub fn new(size: [usize; 2], targets: SmallVec<[Target<'p>; 8]>) -> Targets<'p> {
        let linear = targets.iter().all(|target| target.is_linear(size));
        Targets { size, linear, targets, next: 0 }
    }

    /// The next stretch of about `count` pixels.
    pub fn next(&mut self, count: usize) -> Option<Stretch<'p>> {
        let [width, height] = self.size;
        let left = width * height - self.next;
        if left == 0 {
            return None;
        }
        let (len, rows) = match self.linear {
            true => (count.min(left), 0),
            false => {
                let rows = (count / width).clamp(1, left / width);
                (rows * width, rows)
            }
        };
        let rows_left = if self.linear { 0 } else { left / width - rows };
        let size = self.size;
        let pieces = self.targets.iter_mut().map(|target| target.cut(size, len, rows, rows_left)).collect();
        let start = self.next;
        self.next += len;
        Some(Stretch { start, len, pieces })
    }
}

/// Pixels that one thread runs and writes.
pub(super) struct Stretch<'p> {
    /// The number of the first one among those that are run.
    pub start: usize,
    pub len: usize,
    pub pieces: SmallVec<[Piece<'p>; 8]>,
}

/// A target's share of a stretch.
pub(super) struct Piece<'p> {
    planes: SmallVec<[(usize, usize); 4]>,
    pub data: &'p mut [f32],
    pixel: usize,
    row: usize,
    upward: bool,
    width: usize,
}

impl Piece<'_> {
    /// The plane that it is, if `len` pixels of one component follow one another.
    pub fn plane(&self, len: usize) -> Option<usize> {
        let whole = self.pixel == 1 && !self.upward && self.width >= len;
        self.planes.first().filter(|_| whole && self.planes.len() == 1).map(|&(plane, _)| plane)
    }

    /// Copies a stretch of the outputs' planes.
    pub fn write(&mut self, planes: &[&mut [f32]]) {
        let Some(len) = planes.first().map(|plane| plane.len()) else { return };
        let rows = len / self.width.max(1);
        for row in 0..rows {
            let at = if self.upward { rows - 1 - row } else { row } * self.row;
            let part = row * self.width..(row + 1) * self.width;
            let data = &mut self.data[at..];
            // The usual case as a loop of its own, for which the compiler shuffles registers.
            if let ([(r, 0), (g, 1), (b, 2), (a, 3)], 4) = (&self.planes[..], self.pixel) {
                let [r, g, b, a] = [r, g, b, a].map(|&plane| &planes[plane][part.clone()]);
                let pixels = data.as_chunks_mut::<4>().0.iter_mut();
                for ((((pixel, r), g), b), a) in pixels.zip(r).zip(g).zip(b).zip(a) {
                    *pixel = [*r, *g, *b, *a];
                }
                continue;
            }
            for &(plane, component) in &self.planes {
                let from = planes[plane][part.clone()].iter();
                from.enumerate().for_each(|(i, x)| data[component + i * self.pixel] = *x);
            }
        }
    }
}
