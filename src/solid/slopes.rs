//! How steep the density is at most: stated, or else estimated block by block.

use super::cuboid::Cuboid;
use super::error::SolidError;
use super::field::{Field, MANY, parts};
use glam::{DVec3, UVec3};

/// Cells along the longest side of the box, at whose corners the density is looked at.
const CELLS: f64 = 64.0;

/// Cells along the side of a block. A bound is for a block.
const BLOCK: u32 = 4;

/// The steepest slope that was seen may be steeper where nobody looked: by so much, it is supposed.
const SAFETY: f64 = 1.5;

/// Bounds of the slope of the density.
pub(super) enum Slopes {
    /// Given by the user.
    Stated(f64),
    /// The steepest in each block and the blocks about it, with the safety.
    Estimated {
        cuboid: Cuboid,
        /// Blocks along each axis.
        blocks: UVec3,
        /// A block's sides.
        side: DVec3,
        bounds: Vec<f64>,
        /// Farther inside than anything is outside: beyond, the density does not matter.
        ceiling: f64,
    },
}

impl Slopes {
    /// Looks at the corners of a grid, and a little way from each along the three axes.
    pub fn estimate(field: &Field<'_>, cuboid: &Cuboid, spacing: f64) -> Result<Slopes, SolidError> {
        let size = cuboid.size();
        let cells = (size / size.max_element() * CELLS / f64::from(BLOCK)).ceil().max(DVec3::ONE);
        let blocks = cells.as_uvec3();
        let count = blocks * BLOCK;
        let cell = size / count.as_dvec3();
        let corners = count + UVec3::ONE;
        let place = |i: usize| {
            let i = i as u32;
            UVec3::new(i % corners.x, i / corners.x % corners.y, i / (corners.x * corners.y))
        };
        let index = |c: UVec3| ((c.z * corners.y + c.y) * corners.x + c.x) as usize;
        // Not so near that the rounding of the points would be a slope.
        let near = spacing.max(size.max_element() / 4096.0);
        // Towards the inside of the box.
        let way = |c: UVec3, axis: usize| if c[axis] < count[axis] { near } else { -near };

        let all = corners.element_product() as usize;
        let mut values = Vec::with_capacity(all);
        let mut beside = Vec::with_capacity(all);
        for part in parts(0..all, MANY / 4) {
            let points: Vec<DVec3> = part
                .clone()
                .flat_map(|i| {
                    let corner = cuboid.low + place(i).as_dvec3() * cell;
                    let moved = |axis: usize| corner + DVec3::AXES[axis] * way(place(i), axis);
                    [corner, moved(0), moved(1), moved(2)]
                })
                .collect();
            for around in field.density(&points, spacing)?.as_chunks::<4>().0 {
                values.push(around[0]);
                beside.push([around[1], around[2], around[3]]);
            }
        }
        let ceiling = values.iter().fold(f64::MIN_POSITIVE, |most, v| most.max(-v));

        let mut own = vec![0.0f64; blocks.element_product() as usize];
        let block_index = |b: UVec3| ((b.z * blocks.y + b.y) * blocks.x + b.x) as usize;
        for i in 0..all {
            let (corner, value) = (place(i), values[i].min(ceiling));
            let near_slope =
                DVec3::from_array(std::array::from_fn(|a| (beside[i][a].min(ceiling) - value) / near));
            let far_slope = DVec3::from_array(std::array::from_fn(|a| {
                let mut next = corner;
                next[a] = if corner[a] < count[a] { corner[a] + 1 } else { corner[a] - 1 };
                (values[index(next)].min(ceiling) - value) / cell[a]
            }));
            let steepest = near_slope.length().max(far_slope.length());
            // A corner between blocks belongs to all of them.
            let first = (corner.max(UVec3::ONE) - UVec3::ONE) / BLOCK;
            let last = (corner / BLOCK).min(blocks - UVec3::ONE);
            each(first, last, |b| {
                let bound = &mut own[block_index(b)];
                *bound = bound.max(steepest);
            });
        }
        let mut bounds = vec![0.0f64; own.len()];
        each(UVec3::ZERO, blocks - UVec3::ONE, |b| {
            let mut most = 0.0f64;
            let (low, high) = (b.max(UVec3::ONE) - UVec3::ONE, (b + UVec3::ONE).min(blocks - UVec3::ONE));
            each(low, high, |near| most = most.max(own[block_index(near)]));
            bounds[block_index(b)] = most * SAFETY;
        });
        // Where it was found flat it may still have a slope.
        let steepest = bounds.iter().fold(0.0f64, |most, b| most.max(*b));
        let least = (1e-3 * steepest).max(1e-6 * ceiling / size.max_element()).max(f64::MIN_POSITIVE);
        bounds.iter_mut().for_each(|bound| *bound = bound.max(least));
        let side = cell * f64::from(BLOCK);
        Ok(Slopes::Estimated { cuboid: *cuboid, blocks, side, bounds, ceiling })
    }

    /// The density's excess over the level as far as it matters.
    pub fn cap(&self, value: f64) -> f64 {
        match self {
            Slopes::Stated(_) => value,
            Slopes::Estimated { ceiling, .. } => value.min(*ceiling),
        }
    }

    /// The bound at a point, and how far it holds along a direction.
    pub fn at(&self, point: DVec3, direction: DVec3) -> (f64, f64) {
        match self {
            Slopes::Stated(bound) => (*bound, f64::INFINITY),
            Slopes::Estimated { cuboid, blocks, side, bounds, .. } => {
                let most = (*blocks - UVec3::ONE).as_dvec3();
                let block = ((point - cuboid.low) / side).floor().clamp(DVec3::ZERO, most);
                let b = block.as_uvec3();
                let bound = bounds[((b.z * blocks.y + b.y) * blocks.x + b.x) as usize];
                let low = cuboid.low + (block - DVec3::ONE) * side;
                let ring = Cuboid { low, high: low + 3.0 * side };
                (bound, ring.leave(point, direction))
            }
        }
    }

    /// The least and the greatest of the bounds.
    pub fn range(&self) -> [f64; 2] {
        match self {
            Slopes::Stated(bound) => [*bound; 2],
            Slopes::Estimated { bounds, .. } => {
                bounds.iter().fold([f64::INFINITY, 0.0], |[low, high], b| [low.min(*b), high.max(*b)])
            }
        }
    }
}

/// All between two corners, both included.
fn each(low: UVec3, high: UVec3, mut f: impl FnMut(UVec3)) {
    for z in low.z..=high.z {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                f(UVec3::new(x, y, z));
            }
        }
    }
}
