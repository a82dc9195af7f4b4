//! Mip maps (Williams, "Pyramidal Parametrics", 1983): each level has half the columns and rows of the one before
//! it, rounded up, and every texel is the mean of exactly the area that it covers there. So an image of any
//! size has one, and all levels have the same mean.
//!
//! All levels, and the summed-area table, grow together while the rows of the image come in, so that an image need not
//! be in memory to be prepared.

use super::Needs;
use super::grid::{Rows, stored_bytes};
use super::level::Level;
use super::store::Store;
use super::sums::{Sums, SumsRows};
use crate::image::ImageError;
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

/// For each of the texels in a row of `n` that become `m`: those under it, and the share of each.
fn spans(n: usize, m: usize) -> Vec<(Range<usize>, Vec<f64>)> {
    let ratio = n as f64 / m as f64;
    (0..m)
        .map(|i| {
            let (from, to) = (i as f64 * ratio, (i + 1) as f64 * ratio);
            let under = from as usize..(to.ceil() as usize).min(n);
            let share = |k: usize| (to.min((k + 1) as f64) - from.max(k as f64)) / ratio;
            (under.clone(), under.map(share).collect())
        })
        .collect()
}

/// A texture in the making.
pub(super) struct Growing {
    levels: Vec<GrowingLevel>,
    sums: Option<SumsRows>,
}

/// A level in the making.
struct GrowingLevel {
    width: usize,
    /// Rows of a side.
    height: usize,
    rows: Rows<f32>,
    /// How the next level's texels lie over its columns, and over the rows of a side.
    along: Vec<(Range<usize>, Vec<f64>)>,
    down: Vec<(Range<usize>, Vec<f64>)>,
    /// The last rows of this side, as far as the next level still wants them, and the number of the first.
    last: VecDeque<Vec<f32>>,
    first: usize,
    /// The row of the next level that is to come.
    next: usize,
}

impl Growing {
    /// A texture of so many columns and rows a side, in memory or in a store.
    ///
    /// # Errors
    /// If memory does not suffice.
    pub fn new(
        [width, height]: [usize; 2],
        sides: usize,
        components: usize,
        needs: Needs,
        store: Option<&Arc<Store>>,
    ) -> Result<Growing, ImageError> {
        let mut end = 0;
        let mut place = |bytes: u64| {
            end += bytes;
            store.map(|store| (Arc::clone(store), end - bytes))
        };
        let (mut levels, mut size) = (Vec::new(), Some([width, height]));
        while let Some([w, h]) = size {
            let place = place(stored_bytes::<f32>(w, h * sides, components));
            let rows = Rows::new([w, h * sides], components, place)?;
            size = (needs.levels && (w > 1 || h > 1)).then(|| [w.div_ceil(2), h.div_ceil(2)]);
            let (along, down) = size.map_or_else(Default::default, |[m, n]| (spans(w, m), spans(h, n)));
            let (last, first, next) = (VecDeque::new(), 0, 0);
            levels.push(GrowingLevel { width: w, height: h, rows, along, down, last, first, next });
        }
        let sums = match needs.sums {
            true => {
                let place = place(stored_bytes::<f64>(width + 1, height + 1, components));
                Some(SumsRows::new([width, height], components, place)?)
            }
            false => None,
        };
        Ok(Growing { levels, sums })
    }

    /// Adds a row of the image, from the top.
    ///
    /// # Errors
    /// If it cannot be stored.
    pub fn push(&mut self, row: &[f32]) -> Result<(), ImageError> {
        if let Some(sums) = &mut self.sums {
            sums.push(row)?;
        }
        push(&mut self.levels, row)
    }

    /// The whole texture.
    ///
    /// # Errors
    /// If the last rows cannot be stored.
    pub fn finish(self) -> Result<(Vec<Level>, Option<Sums>), ImageError> {
        let levels = self.levels.into_iter().map(|level| {
            Ok(Level { width: level.width, height: level.height, texels: level.rows.finish()? })
        });
        let levels = levels.collect::<Result<_, ImageError>>()?;
        Ok((levels, self.sums.map(SumsRows::finish).transpose()?))
    }
}

/// Adds a row to the first of these levels, and to the others what becomes of it.
fn push(levels: &mut [GrowingLevel], row: &[f32]) -> Result<(), ImageError> {
    let Some((this, smaller)) = levels.split_first_mut() else { return Ok(()) };
    this.rows.push(row)?;
    if smaller.is_empty() {
        return Ok(());
    }
    this.last.push_back(row.to_vec());
    while let Some(row) = this.next_row() {
        push(smaller, &row)?;
        this.next += 1;
        if this.next == this.down.len() {
            // Another side begins.
            this.last.clear();
            (this.first, this.next) = (0, 0);
            break;
        }
        while this.first < this.down[this.next].0.start && this.last.pop_front().is_some() {
            this.first += 1;
        }
    }
    Ok(())
}

impl GrowingLevel {
    /// The next level's next row, if all rows under it are there.
    fn next_row(&self) -> Option<Vec<f32>> {
        let (under, weights) = &self.down[self.next];
        if self.first + self.last.len() < under.end {
            return None;
        }
        let rows: Vec<&[f32]> = under.clone().map(|y| &*self.last[y - self.first]).collect();
        let components = rows[0].len() / self.width;
        let mut out = Vec::with_capacity(self.along.len() * components);
        for (columns, shares) in &self.along {
            for c in 0..components {
                let mut sum = 0.0;
                for (row, weight) in rows.iter().zip(weights) {
                    for (x, share) in columns.clone().zip(shares) {
                        sum += weight * share * f64::from(row[x * components + c]);
                    }
                }
                out.push(sum as f32);
            }
        }
        Some(out)
    }
}
