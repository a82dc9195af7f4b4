//! Random midpoint displacement: Fournier, Fussell and Carpenter 1982 ("Computer rendering of stochastic
//! models"); the steps are those of Saupe 1988 ("Algorithms for random fractals"), and their like in three
//! dimensions. Peachey, "Explicit Noise Algorithms".
//!
//! It begins with one cube for a period (or square, or line), all of whose corners are the same point.
//! Midpoints are put between the points that there are, each at the mean of those about it, and displaced at
//! random: first that of the cube, then those of its faces, then those of its edges. That leaves cubes of
//! half the size, and so on down to the cells of a table, which is filled once, when the field is made.
//!
//! - About a midpoint are the corners of its cube, face or edge, and those new midpoints that are half an
//!   edge away: the middles of the cubes on both sides of a face, of the faces about an edge.
//! - Displacements are Gaussian, of standard deviation d^H, d being the mean distance of the points about.
//!   The roughness is 2^-H, what is left of them at half the scale. On lines and squares that is Saupe's law,
//!   which has the variances of fractional Brownian motion; in space it is within 2 % of those.
//! - The density of power falls as frequency^-(2H + D) in D dimensions.
//! - The table's values are the coefficients of a spline, not points that it goes through: a spline through
//!   them shows the lattice, above all in its derivative, as nothing keeps the finest displacements below the
//!   frequencies that a table can tell apart.
//! - The method is known for its creases: along the lines of coarse lattices it bends more than elsewhere.
//!   With the new midpoints in the means they are weak but not gone. In three dimensions, at points of coarse
//!   lattices, second differences of the table are 2 % larger over one cell, and 7 % over four, than at the
//!   last midpoints; of the noise, in which the spline smooths the last displacements most, 14 % and 9 % (at
//!   roughness 0.6: 5 % and 13 %, 25 % and 14 %). With means of corners only, the noise has 70 % and 35 %.
//! - Saupe's random successive additions, which displace the old points too at every step, were tried: the
//!   noise then has 40 % and 22 %, so they are left out.
//! - Along axes waves have 5 to 10 % more power than along diagonals; squared differences over a distance are
//!   the same within 2 %, over many seeds.

use super::field::{ByTiles, Field};
use super::hash;
use super::kind::{Contract, Kind, Smoothness, Unfit};
use super::lattice::{Endless, Lattice};
use super::options::{Opt, Params};
use super::table::{Table, gaussian, size};
use std::sync::Arc;

/// Midpoint displacement, 1982.
pub static KIND: Kind = Kind {
    name: "midpoint",
    brief: "a table filled by displacing midpoints at random, scale by scale",
    dimensions: 1..=3,
    options: &[Opt::Roughness],
    contract: Contract {
        // Measured: the extremes of 300 seeds (in one dimension 2000), rounded up. A sum of Gaussian numbers
        // has no bounds of use.
        bounds: &[[-1.2, 1.2], [-1.6, 1.6], [-1.7, 1.7]],
        mean: 0.0,
        deviation: 0.3,
        lattice: "Gaussian, as everywhere",
        smoothness: Smoothness::C2,
        cost: 3.5,
        source: "Fournier, Fussell and Carpenter 1982; Saupe 1988; Peachey, \"Explicit Noise Algorithms\"",
        remarks: "It repeats after 512 units in one dimension, 256 in two, 32 in three. Its values are \
                  Gaussian: the bounds are the extremes of 300 seeds. Mean and deviation are those of a \
                  whole period. Most of the power is in the largest forms, so within a few units it varies \
                  less than the deviation says, and what lies some units apart is alike; multiply the \
                  coordinates to see more of it. `roughness` is 0.7 if not given, about that of Brownian \
                  motion (√½); mountains have about 0.6. Where points lie close together it costs as much as \
                  `gradient`; the first use makes a table of 1 MB.",
    },
    make: |d, params| {
        Ok(match d {
            1 => Arc::new(ByTiles(displacement::<1>(params)?)) as Arc<dyn Field>,
            2 => Arc::new(ByTiles(displacement::<2>(params)?)),
            _ => Arc::new(ByTiles(displacement::<3>(params)?)),
        })
    },
};

fn displacement<const D: usize>(params: &Params) -> Result<Table<D>, Unfit> {
    let roughness = params.number(Opt::Roughness, 0.7, 0.0..=1.0)?;
    Ok(Table::smoothed(&displaced::<D>(params.seed, f64::from(roughness))))
}

/// The values at the points of the table.
fn displaced<const D: usize>(seed: u32, roughness: f64) -> Vec<f64> {
    let lattice = Lattice::<_, D>::new(seed, Endless);
    // Infinite for roughness 0: then all but the first displacement are 0.
    let exponent = -libm::log2(roughness);
    let mut values = vec![0.0; size(D).pow(D as u32)];
    let index = |p: [usize; D]| (0..D).fold(0, |i, k| i + (p[k] % size(D)) * size(D).pow(k as u32));
    let mut half = size(D) / 2;
    while half > 0 {
        // A midpoint lies half an edge from the lattice along some of the axes, each bit one: of cubes all,
        // of faces two, of edges one.
        let mut kinds: Vec<usize> = (1..1 << D).collect();
        kinds.sort_by_key(|axes| std::cmp::Reverse(axes.count_ones()));
        for axes in kinds {
            let (about, distance) = about::<D>(axes, half);
            // As a part of the first, for which it is 1.
            let displacement =
                libm::pow(distance / (D as f64).sqrt() * (2 * half) as f64 / size(D) as f64, exponent);
            let cubes = size(D) / (2 * half);
            for cube in 0..cubes.pow(D as u32) {
                let p: [usize; D] = std::array::from_fn(|k| {
                    2 * half * (cube / cubes.pow(k as u32) % cubes) + half * (axes >> k & 1)
                });
                let sum = about
                    .iter()
                    .fold(0.0, |sum, step| sum + values[index(std::array::from_fn(|k| p[k] + step[k]))]);
                let joined = (0..D).fold(0, |joined, k| joined ^ lattice.key(k, p[k] as f32));
                values[index(p)] = sum / about.len() as f64 + displacement * gaussian(hash::point(joined))[0];
            }
        }
        half /= 2;
    }
    values
}

/// The steps, modulo the size of the table, from a midpoint to the points about it, and their mean length in
/// half edges.
fn about<const D: usize>(axes: usize, half: usize) -> (Vec<[usize; D]>, f64) {
    let step = |up: bool| if up { half } else { size(D) - half };
    let mut about = Vec::new();
    for ups in (0..1 << D).filter(|ups| ups & !axes == 0) {
        about.push(std::array::from_fn(|k| if axes >> k & 1 == 1 { step(ups >> k & 1 == 1) } else { 0 }));
    }
    let corners = about.len() as f64;
    for axis in (0..D).filter(|axis| axes >> axis & 1 == 0) {
        for up in [false, true] {
            about.push(std::array::from_fn(|k| if k == axis { step(up) } else { 0 }));
        }
    }
    let length = f64::from(axes.count_ones()).sqrt();
    let count = about.len() as f64;
    (about, (corners * length + (count - corners)) / count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Isa;

    fn made(d: usize, roughness: &[f32]) -> Result<(), String> {
        KIND.field(d, &Params::default().with(Opt::Roughness, roughness)).map(|_| ()).map_err(|u| u.message)
    }

    /// The mean squares of what midpoints differ by from the points about them, for the midpoints that lie
    /// half an edge from the lattice along as many axes; found by looking at all that are at the right
    /// distance.
    fn displacements<const D: usize>(values: &[f64], half: usize, axes: usize) -> f64 {
        let n = size(D) as i64;
        let h = half as i64;
        let at = |p: [i64; D]| {
            values[(0..D).map(|k| (p[k].rem_euclid(n) * n.pow(k as u32)) as usize).sum::<usize>()]
        };
        let odd = |p: [i64; D]| (0..D).filter(|&k| p[k] / h % 2 != 0).count();
        let (mut squares, mut count) = (0.0, 0.0);
        for i in 0..values.len() / half.pow(D as u32) {
            let p: [i64; D] = std::array::from_fn(|k| (i as i64 / (n / h).pow(k as u32)) % (n / h) * h);
            if odd(p) != axes {
                continue;
            }
            let (mut sum, mut about) = (0.0, 0.0);
            for step in 0..3_i64.pow(D as u32) {
                let q: [i64; D] = std::array::from_fn(|k| p[k] + (step / 3_i64.pow(k as u32) % 3 - 1) * h);
                let steps = (0..D).filter(|&k| q[k] != p[k]).count();
                let corner = odd(q) == 0;
                let before = odd(q) > axes && steps == 1;
                if corner && steps == axes || before {
                    sum += at(q);
                    about += 1.0;
                }
            }
            squares += (at(p) - sum / about) * (at(p) - sum / about);
            count += 1.0;
        }
        squares / count
    }

    fn check<const D: usize>(distances: &[f64]) {
        let roughness: f64 = 0.6;
        let values = displaced::<D>(5, roughness);
        // Enough of them for means that can be told from others.
        let largest = [16, 16, 4][D - 1];
        let unit = displacements::<D>(&values, 1, 1).sqrt();
        for level in 0..=libm::log2(f64::from(largest)) as i32 {
            for (axes, distance) in (1..=D).zip(distances) {
                let rms = displacements::<D>(&values, 1 << level, axes).sqrt() / unit;
                let known = libm::pow(distance / distances[0], -libm::log2(roughness))
                    * libm::pow(roughness, -f64::from(level));
                assert!((rms / known - 1.0).abs() < 0.15, "{D}-D {level} {axes}: {rms} {known}");
            }
        }
    }

    #[test]
    fn midpoints_are_displaced_by_their_law() {
        let (s2, s3) = (2_f64.sqrt(), 3_f64.sqrt());
        check::<1>(&[1.0]);
        check::<2>(&[1.0, s2]);
        check::<3>(&[1.0, (4.0 * s2 + 2.0) / 6.0, s3]);
    }

    #[test]
    fn without_roughness_one_displacement_is_spread() {
        // In one dimension: a roof over the period.
        let values = displaced::<1>(2, 0.0);
        for (i, value) in values.iter().enumerate() {
            let known = values[512] * (1.0 - (i as f64 - 512.0).abs() / 512.0);
            assert!((value - known).abs() < 1e-12, "{i}: {value} {known}");
        }
        let finite = |values: Vec<f64>| values.iter().all(|v| v.is_finite());
        assert!(finite(displaced::<2>(2, 0.0)) && finite(displaced::<3>(2, 0.0)));
    }

    #[test]
    fn options() {
        assert!(made(2, &[1.0]).is_ok());
        assert_eq!(made(2, &[1.5]).unwrap_err(), "roughness must be from 0 to 1, found 1.5");
        assert!(made(2, &[f32::NAN]).is_err() && made(1, &[0.5, 0.5]).is_err() && made(4, &[0.5]).is_err());
    }

    #[test]
    fn known_values() {
        // Pinned: a change of these changes every picture.
        let p = [[0.3, -700.2], [5.5, 41.9], [-3.25, 10.0]];
        let got: Vec<f32> = (1..=3)
            .flat_map(|d| {
                let p: Vec<&[f32]> = p[..d].iter().map(|p| &p[..]).collect();
                let mut out = vec![0.0; 2];
                KIND.field(d, &Params::seeded(d as u32 - 1)).unwrap().noise(Isa::detect(), &p, &mut out);
                out
            })
            .collect();
        let known = [0x3f0871dc, 0x3e60a35c, 0xbf097c66, 0xbe2dd78e, 0xbebe93e7, 0xbf2a31af];
        let bits: Vec<u32> = got.iter().map(|v| v.to_bits()).collect();
        assert_eq!(bits, known, "{got:?}");
    }
}
