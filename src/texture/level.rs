//! An image of a mip map, and its texels by column and row, also beyond its edges.

use super::Wrap;
use super::grid::Grid;
use super::sphere;
use super::store::Near;

/// Texels of one size: the image itself, or a level of its mip map.
#[derive(Debug)]
pub(super) struct Level {
    /// Columns.
    pub width: usize,
    /// Rows; of a cube those of one side.
    pub height: usize,
    /// Rows from the top; of a cube the sides one below the other.
    pub texels: Grid<f32>,
}

/// What lies beyond the edges of an image.
#[derive(Clone, Copy, Debug)]
pub(super) enum Edges {
    /// Along the columns, and along the rows.
    Plane([Wrap; 2]),
    /// The other side of the globe.
    Poles,
    /// The neighbours of this side of a cube.
    Side(usize),
}

/// Which of `n` texels in a row stands at place `i`.
fn wrapped(i: i64, n: i64, wrap: Wrap) -> Option<i64> {
    match wrap {
        _ if (0..n).contains(&i) => Some(i),
        Wrap::Periodic => Some(i.rem_euclid(n)),
        Wrap::Black => None,
        Wrap::Clamp => Some(i.clamp(0, n - 1)),
        Wrap::Mirror => {
            let i = i.rem_euclid(2 * n);
            Some(if i < n { i } else { 2 * n - 1 - i })
        }
    }
}

impl Level {
    /// The column and the row of the grid for those of the image; `None` where there is only black.
    #[inline]
    fn place(&self, x: i64, y: i64, edges: Edges) -> Option<[usize; 2]> {
        let (w, h) = (self.width as i64, self.height as i64);
        let (x, y) = match edges {
            Edges::Plane([along, down]) => (wrapped(x, w, along)?, wrapped(y, h, down)?),
            Edges::Poles => {
                // Over a pole one comes down on the opposite meridian.
                let over = !(0..h).contains(&y);
                let x = if over { x + w / 2 } else { x };
                (x.rem_euclid(w), wrapped(y, h, Wrap::Mirror)?)
            }
            Edges::Side(side) => {
                if (0..w).contains(&x) && (0..h).contains(&y) {
                    (x, side as i64 * h + y)
                } else {
                    let at = |i: i64, n: i64| (i as f64 + 0.5) / n as f64;
                    let (side, s, v) = sphere::side_of(sphere::on_side(side, at(x, w), at(y, h)));
                    let near = |s: f64, n: i64| ((s * n as f64) as i64).clamp(0, n - 1);
                    (near(s, w), side as i64 * h + near(v, h))
                }
            }
        };
        Some([x as usize, y as usize])
    }

    fn texel<const C: usize>(&self, x: i64, y: i64, edges: Edges, near: &mut Near) -> [f32; C] {
        self.place(x, y, edges).map_or([0.0; C], |[x, y]| self.texels.at(x, y, near))
    }

    /// The texel that holds a place.
    #[inline]
    pub fn nearest<const C: usize>(&self, s: f64, v: f64, edges: Edges, near: &mut Near) -> [f32; C] {
        let at = |s: f64, n: usize| whole(s * n as f64);
        self.texel(at(s, self.width), at(v, self.height), edges, near)
    }

    /// Between the four texels whose centres are around.
    #[inline]
    pub fn bilinear<const C: usize>(&self, s: f64, v: f64, edges: Edges, near: &mut Near) -> [f32; C] {
        let (x, fx) = whole_and_rest(s * self.width as f64 - 0.5);
        let (y, fy) = whole_and_rest(v * self.height as f64 - 0.5);
        let (w, h) = (self.width as i64, self.height as i64);
        if let (true, Some(texels)) = (x >= 0 && y >= 0 && x < w - 1 && y < h - 1, self.texels.memory()) {
            // Nearly always all four are there, two and two in a row.
            let side = if let Edges::Side(side) = edges { side } else { 0 };
            let start = ((side as i64 * h + y) * w + x) as usize * C;
            let row = |start: usize| {
                let pair = &texels[start..start + 2 * C];
                mix(std::array::from_fn::<_, C, _>(|c| pair[c]), std::array::from_fn(|c| pair[C + c]), fx)
            };
            return mix(row(start), row(start + self.width * C), fy);
        }
        let mut row = |y| mix(self.texel(x, y, edges, near), self.texel(x + 1, y, edges, near), fx);
        mix(row(y), row(y + 1), fy)
    }

    /// The uniform cubic B-spline over the sixteen texels around: smooth, and a little softer than the image.
    pub fn cubic<const C: usize>(&self, s: f64, v: f64, edges: Edges, near: &mut Near) -> [f32; C] {
        let (x, fx) = whole_and_rest(s * self.width as f64 - 0.5);
        let (y, fy) = whole_and_rest(v * self.height as f64 - 0.5);
        let (along, down) = (spline(fx), spline(fy));
        let mut sum = [0.0; C];
        for (j, wy) in (-1..).zip(down) {
            for (i, wx) in (-1..).zip(along) {
                let texel = self.texel::<C>(x + i, y + j, edges, near);
                for c in 0..C {
                    sum[c] += wx * wy * texel[c];
                }
            }
        }
        sum
    }
}

/// The whole number at or below a number that is not too large for one. (Without the instruction for it `floor` is
/// a call.)
#[inline]
pub(super) fn whole(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero - i64::from(towards_zero as f64 > x)
}

#[inline]
fn whole_and_rest(x: f64) -> (i64, f32) {
    let whole = whole(x);
    (whole, (x - whole as f64) as f32)
}

/// The weights of four neighbours in a cubic B-spline.
fn spline(f: f32) -> [f32; 4] {
    let g = 1.0 - f;
    let middle = |f: f32| (3.0 * f - 6.0) * f * f + 4.0;
    [g * g * g, middle(f), middle(g), f * f * f].map(|w| w * (1.0 / 6.0))
}

/// From a to b; exactly a if both are the same.
#[inline]
pub(super) fn mix<const C: usize>(a: [f32; C], b: [f32; C], f: f32) -> [f32; C] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * f)
}
