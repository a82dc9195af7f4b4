//! C for any covariance over distance, solved block by block.
//!
//! The neighbours along an axis are two pairs, an inner and an outer one, each with a lower and an upper side. (Of
//! three neighbours the inner pair is the middle one and a dummy.) A neighbour's number has, for each axis, a bit for its
//! side and one for its pair; those of sides are the upper ones. The mirror images of a cell are itself, so C does not
//! mix sums over two sides with differences between them: after a butterfly along each axis it falls apart into
//! blocks, one for each of the 2^D choices of sums and differences, as large as the 2^D choices of pairs.

// Loops over axes and sides index several arrays at once.
#![allow(clippy::needless_range_loop)]

use super::super::field::TILE;
use super::super::kind::Unfit;
use super::super::options::Opt;
use super::covariance::Covariance;
use super::solve::Matrix;
use super::table::Table;

/// Sums over sides must have so much variance of their own, that of a lattice point being 1. With less,
/// C⁻¹η is so large that rounding shows: values at lattice points are not kept within 1e-5.
const LEAST_VARIANCE: f64 = 1.0 / 64.0;

/// C, solved, and the covariance to go with it, for neighbours along `D` axes; `SIDE` is 2^D, `COUNT` 4^D.
pub(super) struct Solved<const D: usize, const SIDE: usize, const COUNT: usize> {
    pub table: Table,
    /// How many neighbours there are along an axis, 3 or 4.
    pub points: usize,
    /// The numbers of those that are no dummies.
    pub neighbours: Vec<usize>,
    /// Where the neighbours stand along each axis, as seen from the cell's lattice point.
    pub places: [[f32; COUNT]; D],
    /// The inverses of C's blocks, times the factors that two butterflies lack.
    inverse: [[[f32; SIDE]; SIDE]; SIDE],
    /// Of the variance of the data, how much what is interpolated has on average.
    pub variance: f64,
}

/// Which along an axis, the lowest being 0, is the neighbour with this number? (Of three, dummies are called 2.)
#[inline(always)]
pub(super) fn along<const D: usize>(points: usize, number: usize, axis: usize) -> usize {
    let (side, pair) = (number >> (D + axis) & 1, number >> axis & 1);
    match (pair, side) {
        (0, _) => 1 + side,
        (_, 0) => 0,
        _ => points - 1,
    }
}

/// Is this the middle one of three, or its dummy? Of the number, that of the pairs will do.
#[inline(always)]
fn lone(points: usize, pairs: usize, axis: usize) -> bool {
    points == 3 && pairs >> axis & 1 == 0
}

/// Along each axis, sums of the two sides and their differences, in each lane; twice that doubles, but for what is lone.
#[inline(always)]
fn butterflies<const D: usize, const SIDE: usize, const COUNT: usize>(
    points: usize,
    v: &mut [[f32; TILE]; COUNT],
    work: usize,
) {
    for axis in 0..D {
        for low in 0..COUNT {
            if (low / SIDE) >> axis & 1 == 1 || lone(points, low % SIDE, axis) {
                continue;
            }
            let high = low + (SIDE << axis);
            for i in 0..work.min(TILE) {
                let (a, b) = (v[low][i], v[high][i]);
                (v[low][i], v[high][i]) = (a + b, a - b);
            }
        }
    }
}

/// What a number must be multiplied by that two butterflies have changed and changed back.
fn factor<const D: usize>(points: usize, pairs: usize) -> f64 {
    (0..D).map(|axis| if lone(points, pairs, axis) { 1.0 } else { 0.5 }).product()
}

/// Is it a sum or difference with a dummy? There is none of those.
fn dummy<const D: usize>(points: usize, signs: usize, pairs: usize) -> bool {
    (0..D).any(|axis| lone(points, pairs, axis) && signs >> axis & 1 == 1)
}

impl<const D: usize, const SIDE: usize, const COUNT: usize> Solved<D, SIDE, COUNT> {
    /// Factors C.
    ///
    /// # Errors
    /// If it is not positive definite, or too little.
    pub(super) fn new(points: usize, covariance: &Covariance) -> Result<Self, Unfit> {
        // Squares of distances between lattice points are integers.
        let known: Vec<f64> = (0..=9 * D).map(|square| covariance.at(square as f64, D)).collect();
        let mut inverse = [[[0.0; SIDE]; SIDE]; SIDE];
        let mut exact = Vec::with_capacity(SIDE);
        for (signs, inverse) in inverse.iter_mut().enumerate() {
            let block = Matrix::new(SIDE, |i, j| element::<D, SIDE>(points, &known, signs, i, j));
            let solved = block.inverse(LEAST_VARIANCE).ok_or_else(|| unsolvable::<D>(covariance, &known))?;
            for i in (0..SIDE).filter(|i| !dummy::<D>(points, signs, *i)) {
                for j in (0..SIDE).filter(|j| !dummy::<D>(points, signs, *j)) {
                    let factors = (factor::<D>(points, i) * factor::<D>(points, j)).sqrt();
                    inverse[i][j] = (solved.at[i * SIDE + j] * factors) as f32;
                }
            }
            exact.push(solved);
        }
        let places: [[f32; COUNT]; D] =
            std::array::from_fn(|axis| std::array::from_fn(|n| along::<D>(points, n, axis) as f32 - 1.0));
        let variance = variance::<D, SIDE, COUNT>(points, covariance, &places, &exact);
        let neighbours = (0..COUNT).filter(|n| !dummy::<D>(points, n / SIDE, n % SIDE)).collect();
        Ok(Solved { table: Table::new::<D>(covariance), points, neighbours, places, inverse, variance })
    }

    /// C⁻¹ times the vector of each lane.
    #[inline(always)]
    pub(super) fn solve(&self, v: &mut [[f32; TILE]; COUNT], work: usize) {
        butterflies::<D, SIDE, COUNT>(self.points, v, work);
        for block in 0..SIDE {
            let v = &mut v[block * SIDE..][..SIDE];
            let mut sums = [[0.0; TILE]; SIDE];
            for row in 0..SIDE {
                for k in 0..SIDE {
                    let factor = self.inverse[block][row][k];
                    for i in 0..work.min(TILE) {
                        sums[row][i] += v[k][i] * factor;
                    }
                }
            }
            v.copy_from_slice(&sums);
        }
        butterflies::<D, SIDE, COUNT>(self.points, v, work);
    }
}

/// C between two sums over sides (or differences, where the bit of `signs` is set), each of length 1.
fn element<const D: usize, const SIDE: usize>(
    points: usize,
    known: &[f64],
    signs: usize,
    i: usize,
    j: usize,
) -> f64 {
    if dummy::<D>(points, signs, i) || dummy::<D>(points, signs, j) {
        return f64::from(u8::from(i == j));
    }
    // From one side of the first to all of the second: the other sides are their mirror images.
    let covariance = |sides: usize| {
        let mut square = 0;
        for axis in 0..D {
            if lone(points, j, axis) && sides >> axis & 1 == 1 {
                return 0.0;
            }
            let apart = along::<D>(points, i, axis).abs_diff(along::<D>(points, sides * SIDE + j, axis));
            square += apart * apart;
        }
        if (signs & sides).count_ones().is_multiple_of(2) { known[square] } else { -known[square] }
    };
    let sum: f64 = (0..SIDE).map(covariance).sum();
    sum * (factor::<D>(points, j) / factor::<D>(points, i)).sqrt()
}

/// The mean over the cell of the sum of the squares of the weights C⁻¹c.
fn variance<const D: usize, const SIDE: usize, const COUNT: usize>(
    points: usize,
    covariance: &Covariance,
    places: &[[f32; COUNT]; D],
    inverse: &[Matrix],
) -> f64 {
    // Gauss' rule of 4 points on 0 … ½; the rest of the cell is its mirror image.
    const RULE: [(f64, f64); 4] = [
        (0.034_715_922_101_486_85, 0.173_927_422_568_726_92),
        (0.165_004_739_103_785_24, 0.326_072_577_431_273_1),
        (0.334_995_260_896_214_74, 0.326_072_577_431_273_1),
        (0.465_284_077_898_513_1, 0.173_927_422_568_726_92),
    ];
    let mut mean = 0.0;
    for point in 0..RULE.len().pow(D as u32) {
        let rule: [(f64, f64); D] = std::array::from_fn(|axis| RULE[point >> (2 * axis) & 3]);
        let along = |axis: usize, n: usize| rule[axis].0 - f64::from(places[axis][n]);
        let c: [f64; COUNT] = std::array::from_fn(|n| {
            covariance.at((0..D).map(|axis| along(axis, n) * along(axis, n)).sum(), D)
        });
        let mut squares = 0.0;
        for (signs, inverse) in inverse.iter().enumerate() {
            let sums: Vec<f64> = (0..SIDE)
                .map(|pairs| {
                    let sign = |sides: usize| f64::from(1 - 2 * ((signs & sides).count_ones() as i32 % 2));
                    let sided = |sides: &usize| !dummy::<D>(points, *sides, pairs);
                    let sum: f64 =
                        (0..SIDE).filter(sided).map(|sides| sign(sides) * c[sides * SIDE + pairs]).sum();
                    let unit = if dummy::<D>(points, signs, pairs) {
                        0.0
                    } else {
                        factor::<D>(points, pairs).sqrt()
                    };
                    sum * unit
                })
                .collect();
            squares += inverse.times(&sums).iter().map(|a| a * a).sum::<f64>();
        }
        mean += squares * rule.iter().map(|(_, weight)| weight).product::<f64>();
    }
    mean
}

/// What to say if C can't be solved for.
fn unsolvable<const D: usize>(covariance: &Covariance, known: &[f64]) -> Unfit {
    let (second, apart) = if D == 1 { (known[4], "2") } else { (known[2], "√2") };
    let message = format!(
        "this covariance can't be solved for: between lattice points 0, 1 and {apart} apart it is 1, {:.2} and {second:.2}, a \
         matrix that is not positive definite, or hardly so",
        known[1]
    );
    match covariance {
        Covariance::Knots(_) => Unfit::of(Opt::Knots, message)
            .hint("Let it fall faster, to about 0.1 at distance 1; the last of knots is at distance 2."),
        _ => Unfit::of(Opt::Width, message).hint("Make width smaller, or frequency higher."),
    }
}
