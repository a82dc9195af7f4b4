//! Mip maps (Williams, "Pyramidal Parametrics", 1983): each level has half the columns and rows of the one before
//! it, rounded up, and every texel is the mean of exactly the area that it covers there. So an image of any
//! size has one, and all levels have the same mean.

use super::level::Level;
use rayon::prelude::*;

/// The image and its levels down to a single texel (of a cube, one a side).
pub(super) fn of(image: Level) -> Vec<Level> {
    let mut levels = vec![image];
    while let Some(last) = levels.last().filter(|l| l.width > 1 || l.height > 1) {
        let next = halved(last);
        levels.push(next);
    }
    levels
}

/// For each of the texels in a row of `n` that become `m`: the first of those under it, and the share of each.
fn spans(n: usize, m: usize) -> Vec<(usize, Vec<f64>)> {
    let ratio = n as f64 / m as f64;
    (0..m)
        .map(|i| {
            let (from, to) = (i as f64 * ratio, (i + 1) as f64 * ratio);
            let first = from as usize;
            let end = (to.ceil() as usize).min(n);
            let share = |k: usize| (to.min((k + 1) as f64) - from.max(k as f64)) / ratio;
            (first, (first..end).map(share).collect())
        })
        .collect()
}

fn halved(level: &Level) -> Level {
    let (w, h, components) = (level.width, level.height, level.components);
    let (width, height) = (w.div_ceil(2), h.div_ceil(2));
    let sides = level.texels.len() / (w * h * components);
    let (along, down) = (spans(w, width), spans(h, height));
    let mut texels = vec![0.0; sides * width * height * components];
    texels.par_chunks_mut(width * components).enumerate().for_each(|(row, out)| {
        let top = row / height * h;
        let (y, weights) = &down[row % height];
        for (texel, (x, shares)) in out.chunks_mut(components).zip(&along) {
            for (c, out) in texel.iter_mut().enumerate() {
                let mut sum = 0.0;
                for (j, weight) in weights.iter().enumerate() {
                    let start = (top + y + j) * w + x;
                    for (i, share) in shares.iter().enumerate() {
                        sum += weight * share * f64::from(level.texels[(start + i) * components + c]);
                    }
                }
                *out = sum as f32;
            }
        }
    });
    Level { width, height, components, texels }
}
