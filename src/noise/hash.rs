//! Hashes of lattice points: to every point of the integer lattice, and a seed, 32 well mixed bits.
//!
//! There is no table, so nothing repeats: each axis maps its 2^32 keys one to one, by steps that are not
//! linear, before the axes are joined; no shift of the lattice maps the hashes to themselves.

/// Odd multipliers for the axes; bits set and clear about equally, no simple relation between them.
const AXES: [u32; 4] = [0x9E37_79B1, 0x85EB_CA77, 0xC2B2_AE3D, 0x27D4_EB2F];

/// Mixes one coordinate, given as any 32 bits that tell it from others. One to one; 0 stays 0.
#[inline(always)]
pub fn axis(key: u32, axis: usize) -> u32 {
    // The bits of a small integer as f32 are all at the top, where a product would lose them: fold them.
    let h = (key ^ (key >> 16)).wrapping_mul(AXES[axis]);
    // A product mixes upwards only; a shift brings the mixed bits down.
    let h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h ^ (h >> 16)
}

/// The bits of a lattice point, from the exclusive or of its axes' hashes and the seed's.
#[inline(always)]
pub fn point(joined: u32) -> u32 {
    let h = joined.wrapping_mul(0x2974_05C5);
    (h ^ (h >> 15)).wrapping_mul(0x846C_A68B)
}

/// 32 more bits, from those of [`point`].
#[inline(always)]
pub fn more(h: u32) -> u32 {
    (h ^ (h >> 16)).wrapping_mul(0x7FEB_352D)
}

/// Mixes thoroughly, one to one: every bit of the result depends on every bit of the key. (Two rounds of
/// multiplication, after the constants of C. Wellons' search, "lowbias32".)
#[inline(always)]
pub fn mix(key: u32) -> u32 {
    let h = (key ^ (key >> 16)).wrapping_mul(0x7FEB_352D);
    let h = (h ^ (h >> 15)).wrapping_mul(0x846C_A68B);
    h ^ (h >> 16)
}

// The noises of linear functions, which need several numbers for each of the corners of a cell, have a cheaper way.
// A point's numbers are products of two factors: one of x and y, and one of z and w, each mixed well by itself.
// So of the corners of a cell in three dimensions only 4 + 2 want mixing, not 8, and every further number is one
// more multiplication. A product is no exclusive or: that of two points would be the same in every plane.

/// Bits that tell whole numbers from -2^22 to 2^22 - 1 apart; for each they are one more than for the number before.
#[inline(always)]
pub fn whole(x: f32) -> u32 {
    // In this sum the last bit of the mantissa is worth 1.
    (x + 12_582_912.0).to_bits()
}

/// The key of such bits along an axis.
#[inline(always)]
pub fn key(whole: u32, axis: usize) -> u32 {
    whole.wrapping_mul(AXES[axis])
}

/// The factor of x and y, from the exclusive or of their keys.
#[inline(always)]
pub fn column(joined: u32) -> u32 {
    let h = (joined ^ (joined >> 15)).wrapping_mul(0x2C1B_3C6D);
    h ^ (h >> 16)
}

/// The factor of z and w, from the exclusive or of their keys.
#[inline(always)]
pub fn stack(joined: u32) -> u32 {
    let h = (joined ^ (joined >> 15)).wrapping_mul(0x2C1B_3C6D);
    // Odd, so that the product has as many different numbers as the factor of x and y in every plane.
    (h ^ (h >> 16)).wrapping_mul(0x7FEB_352D) | 1
}

/// What makes of the product of the two a further number of the point. (Pairs of numbers fill the square of all pairs
/// evenly, in the sense of the spectral test.)
pub const FURTHER: u32 = 0xEE42_AA4B;

/// What a seed adds to the hashes of a lattice. (0 must not stay 0, or the origin's hash would.)
#[inline(always)]
pub fn seed(seed: u32) -> u32 {
    mix(seed ^ AXES[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The hash of a lattice point as the noises take it.
    fn of(p: [f32; 3]) -> u32 {
        point(axis(p[0].to_bits(), 0) ^ axis(p[1].to_bits(), 1) ^ axis(p[2].to_bits(), 2))
    }

    /// The product of the factors that the noises of linear functions take.
    fn product(p: [f32; 3]) -> u32 {
        let keys: [u32; 3] = std::array::from_fn(|axis| key(whole(p[axis]), axis));
        column(keys[0] ^ keys[1]).wrapping_mul(stack(keys[2]))
    }

    #[test]
    fn neighbours_differ_in_half_of_their_bits() {
        // The lowest bits of a product are 0 too often; what is made of it are numbers in which those hardly count.
        differ_in_half_of_their_bits(of, 0);
        for further in [1, FURTHER] {
            differ_in_half_of_their_bits(|p| product(p).wrapping_mul(further), 6);
        }
    }

    fn differ_in_half_of_their_bits(of: impl Fn([f32; 3]) -> u32, from: usize) {
        for step in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [65536.0, 0.0, 0.0]] {
            let mut flips = [0_u32; 32];
            let n = 20_000;
            for i in 0..n {
                let p = [(i % 27) as f32 - 13.0, (i / 27 % 27) as f32, (i / 729) as f32];
                let q = [p[0] + step[0], p[1] + step[1], p[2] + step[2]];
                let differing = of(p) ^ of(q);
                for (bit, flips) in flips.iter_mut().enumerate() {
                    *flips += differing >> bit & 1;
                }
            }
            for (bit, &flips) in flips.iter().enumerate().skip(from) {
                let share = f64::from(flips) / f64::from(n);
                assert!((share - 0.5).abs() < 0.06, "bit {bit} flips in {share} of steps {step:?}");
            }
        }
    }

    #[test]
    fn rectangles_have_no_common_law() {
        // The exclusive or of the four corners of a rectangle would be 0 if the last step were linear.
        let (mut ones, mut products) = (0, 0);
        for i in 0..4000 {
            let (x, y) = ((i % 63) as f32, (i / 63) as f32);
            let corners = [[x, y, 0.0], [x + 3.0, y, 0.0], [x, y + 5.0, 0.0], [x + 3.0, y + 5.0, 0.0]];
            ones += corners.map(of).iter().fold(0, |a, b| a ^ b).count_ones();
            // In planes of z, where factors are shared.
            let corners = corners.map(|[x, y, _]| [x, 2.0, y]);
            products += (corners.map(product).iter().fold(0, |a, b| a ^ b) >> 6).count_ones();
        }
        let share = f64::from(ones) / (4000.0 * 32.0);
        assert!((share - 0.5).abs() < 0.02, "{share}");
        let share = f64::from(products) / (4000.0 * 26.0);
        assert!((share - 0.5).abs() < 0.02, "{share}");
    }

    #[test]
    fn points_seldom_collide() {
        // 2^18 points of 2^32 hashes: 8 collisions are to be expected.
        let mut all: Vec<u32> = (0..1 << 18)
            .map(|i| of([(i % 64) as f32 - 32.0, (i / 64 % 64) as f32 - 32.0, (i / 4096) as f32]))
            .collect();
        all.sort_unstable();
        all.dedup();
        assert!((1 << 18) - all.len() < 30, "{}", (1 << 18) - all.len());
    }
}
