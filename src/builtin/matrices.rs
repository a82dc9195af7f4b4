//! Matrices, as vectors of rows. Points are columns: a point p goes to `m p`, so the matrix that is applied
//! first stands last in a product, and a translation is the last column of a matrix of 4 rows.

use super::apply::{each, vector_of};
use super::call::{Call, Fault};
use super::vectors::{direction_planes, dot_planes, rodrigues};
use super::{Builtin, Kernel, Param, ex};
use crate::math;
use crate::shape::Shape;
use crate::value::{Plane, Planes, Value};

/// A matrix argument: its numbers of rows and columns, and its cells, row by row.
struct Matrix<'v> {
    rows: usize,
    columns: usize,
    cells: &'v [Plane],
}

impl<'v> Matrix<'v> {
    /// Any matrix.
    fn any(name: &str, arg: usize, value: &'v Value) -> Result<Matrix<'v>, Fault> {
        if let Shape::Nested(rows) = &value.shape
            && let Some(columns) = rows[0].len()
            && columns > 0
            && rows.iter().all(|r| *r == Shape::Vector(columns as u32))
        {
            return Ok(Matrix { rows: rows.len(), columns, cells: &value.planes });
        }
        Err(Fault::of(arg, format!("{name} needs a matrix, found {}", value.shape))
            .hint("A matrix is a vector of rows of one length, such as `[[1 0] [0 1]]`."))
    }

    /// One of 2 × 2, 3 × 3 or 4 × 4.
    fn square(name: &str, arg: usize, value: &'v Value) -> Result<Matrix<'v>, Fault> {
        let m = Matrix::any(name, arg, value)?;
        if m.rows == m.columns && (2..=4).contains(&m.rows) {
            return Ok(m);
        }
        Err(Fault::of(
            arg,
            format!("{name} needs a matrix of 2, 3 or 4 rows and columns, found {}", value.shape),
        ))
    }

    fn row(&self, i: usize) -> &'v [Plane] {
        &self.cells[i * self.columns..(i + 1) * self.columns]
    }

    fn column(&self, j: usize) -> Planes {
        (0..self.rows).map(|i| self.cells[i * self.columns + j].clone()).collect()
    }

    /// The first `n` of `n` rows.
    fn corner(&self, n: usize) -> Planes {
        (0..n).flat_map(|i| self.row(i)[..n].iter().cloned()).collect()
    }
}

/// A matrix value of so many columns.
fn matrix(columns: usize, cells: &[Plane]) -> Value {
    Value::vector_of(cells.chunks(columns).map(|row| Value::vector(row.iter().cloned().collect())))
}

/// A square matrix of `n` rows that is 1 on the diagonal and 0 elsewhere.
fn unit(n: usize) -> Planes {
    (0..n * n).map(|k| Plane::Uniform(f32::from(k % (n + 1) == 0))).collect()
}

/// The inverse of a matrix of 2 rows, and its determinant.
#[inline(always)]
fn inverse2([a, b, c, d]: [f32; 4]) -> ([f32; 4], f32) {
    let det = a * d - b * c;
    ([d / det, -b / det, -c / det, a / det], det)
}

/// The inverse of a matrix of 3 rows, and its determinant.
#[inline(always)]
fn inverse3(m: [f32; 9]) -> ([f32; 9], f32) {
    let minor = |a: usize, b: usize, c: usize, d: usize| m[a] * m[d] - m[b] * m[c];
    let adjoint = [
        minor(4, 5, 7, 8),
        minor(2, 1, 8, 7),
        minor(1, 2, 4, 5),
        minor(5, 3, 8, 6),
        minor(0, 2, 6, 8),
        minor(2, 0, 5, 3),
        minor(3, 4, 6, 7),
        minor(1, 0, 7, 6),
        minor(0, 1, 3, 4),
    ];
    let det = m[0] * adjoint[0] + m[1] * adjoint[3] + m[2] * adjoint[6];
    (adjoint.map(|x| x / det), det)
}

/// The inverse of a matrix of 4 rows, and its determinant, by the minors of its upper and lower halves.
#[inline(always)]
fn inverse4(m: [f32; 16]) -> ([f32; 16], f32) {
    let upper = |i: usize, j: usize| m[i] * m[4 + j] - m[j] * m[4 + i];
    let lower = |i: usize, j: usize| m[8 + i] * m[12 + j] - m[8 + j] * m[12 + i];
    let (s01, s02, s03, s12, s13, s23) =
        (upper(0, 1), upper(0, 2), upper(0, 3), upper(1, 2), upper(1, 3), upper(2, 3));
    let (c01, c02, c03, c12, c13, c23) =
        (lower(0, 1), lower(0, 2), lower(0, 3), lower(1, 2), lower(1, 3), lower(2, 3));
    let det = s01 * c23 - s02 * c13 + s03 * c12 + s12 * c03 - s13 * c02 + s23 * c01;
    let adjoint = [
        m[5] * c23 - m[6] * c13 + m[7] * c12,
        -m[1] * c23 + m[2] * c13 - m[3] * c12,
        m[13] * s23 - m[14] * s13 + m[15] * s12,
        -m[9] * s23 + m[10] * s13 - m[11] * s12,
        -m[4] * c23 + m[6] * c03 - m[7] * c02,
        m[0] * c23 - m[2] * c03 + m[3] * c02,
        -m[12] * s23 + m[14] * s03 - m[15] * s02,
        m[8] * s23 - m[10] * s03 + m[11] * s02,
        m[4] * c13 - m[5] * c03 + m[7] * c01,
        -m[0] * c13 + m[1] * c03 - m[3] * c01,
        m[12] * s13 - m[13] * s03 + m[15] * s01,
        -m[8] * s13 + m[9] * s03 - m[11] * s01,
        -m[4] * c12 + m[5] * c02 - m[6] * c01,
        m[0] * c12 - m[1] * c02 + m[2] * c01,
        -m[12] * s12 + m[13] * s02 - m[14] * s01,
        m[8] * s12 - m[9] * s02 + m[10] * s01,
    ];
    (adjoint.map(|x| x / det), det)
}

/// The inverse of a square matrix of `n` rows, 1 to 4.
fn inverted(call: &Call<'_>, n: usize, cells: &[Plane]) -> Planes {
    let of = |k: usize| &cells[k];
    match n {
        1 => [call.lane([of(0)], |[x]| 1.0 / x)].into_iter().collect(),
        2 => call.lanes(std::array::from_fn(of), |m| inverse2(m).0).into_iter().collect(),
        3 => call.lanes(std::array::from_fn(of), |m| inverse3(m).0).into_iter().collect(),
        _ => call.lanes(std::array::from_fn(of), |m| inverse4(m).0).into_iter().collect(),
    }
}

fn inverse(call: &Call<'_>) -> Result<Value, Fault> {
    let m = Matrix::square("inverse", 0, &call.args[0])?;
    Ok(matrix(m.rows, &inverted(call, m.rows, m.cells)))
}

fn determinant(call: &Call<'_>) -> Result<Value, Fault> {
    let m = Matrix::square("determinant", 0, &call.args[0])?;
    let of = |k: usize| &m.cells[k];
    Ok(Value::scalar(match m.rows {
        2 => call.lane(std::array::from_fn(of), |m| inverse2(m).1),
        3 => call.lane(std::array::from_fn(of), |m| inverse3(m).1),
        _ => call.lane(std::array::from_fn(of), |m| inverse4(m).1),
    }))
}

fn transpose(call: &Call<'_>) -> Result<Value, Fault> {
    let m = Matrix::any("transpose", 0, &call.args[0])?;
    Ok(Value::vector_of((0..m.columns).map(|j| Value::vector(m.column(j)))))
}

/// Rows of the largest matrix that is multiplied.
const LARGEST: usize = 32;

fn multiply(call: &Call<'_>) -> Result<Value, Fault> {
    let mut product = call.args[0].clone();
    if let Some(k) = call.args.iter().position(|m| m.shape.len().is_some_and(|rows| rows > LARGEST)) {
        // The work grows with the cube of the rows: without a bound one call could take minutes.
        return Err(Fault::of(k, format!("multiply takes matrices of at most {LARGEST} rows")));
    }
    for (k, next) in call.args.iter().enumerate().skip(1) {
        let m = Matrix::any("multiply", k - 1, &product)?;
        let fits = |rows: usize| {
            if rows == m.columns {
                return Ok(());
            }
            Err(Fault::of(
                k,
                format!(
                    "multiply of a matrix of {} columns needs {} rows, found {rows}",
                    m.columns, m.columns
                ),
            ))
        };
        product = if let Shape::Vector(n) = next.shape {
            fits(n as usize)?;
            Value::vector((0..m.rows).map(|i| dot_planes(call, m.row(i), &next.planes)).collect())
        } else {
            let other = Matrix::any("multiply", k, next)?;
            fits(other.rows)?;
            call.room(m.rows.saturating_mul(other.columns))?;
            let columns: Vec<Planes> = (0..other.columns).map(|j| other.column(j)).collect();
            let row =
                |i: usize| Value::vector(columns.iter().map(|c| dot_planes(call, m.row(i), c)).collect());
            Value::vector_of((0..m.rows).map(row))
        };
    }
    Ok(product)
}

/// What is done to a vector: as many components as the matrix has rows, or one less.
fn transforming(
    call: &Call<'_>,
    name: &'static str,
    f: impl Fn(&Matrix<'_>, &Planes) -> Planes,
) -> Result<Value, Fault> {
    let m = Matrix::square(name, 0, &call.args[0])?;
    each([&call.args[1]], &mut |[p]| {
        let planes = vector_of(name, 1, p, &[m.rows - 1, m.rows])?;
        Ok(Value::vector(f(&m, planes)))
    })
}

fn transform(call: &Call<'_>) -> Result<Value, Fault> {
    transforming(call, "transform", |m, p| {
        let mut homogeneous = p.clone();
        if p.len() < m.rows {
            homogeneous.push(Plane::Uniform(1.0));
        }
        let mut out: Planes = (0..m.rows).map(|i| dot_planes(call, m.row(i), &homogeneous)).collect();
        if p.len() < m.rows
            && let Some(w) = out.pop()
        {
            out = out.iter().map(|x| call.lane([x, &w], |[x, w]| x / w)).collect();
        }
        out
    })
}

fn vtransform(call: &Call<'_>) -> Result<Value, Fault> {
    transforming(call, "vtransform", |m, v| {
        (0..v.len()).map(|i| dot_planes(call, &m.row(i)[..v.len()], v)).collect()
    })
}

fn ntransform(call: &Call<'_>) -> Result<Value, Fault> {
    transforming(call, "ntransform", |m, v| {
        let n = v.len();
        let inverse = inverted(call, n, &m.corner(n));
        let inverse = Matrix { rows: n, columns: n, cells: &inverse };
        (0..n).map(|j| dot_planes(call, &inverse.column(j), v)).collect()
    })
}

fn identity(call: &Call<'_>) -> Result<Value, Fault> {
    let n = call.same_everywhere(0)?;
    let rows = math::round(n);
    if !(1.0..=4096.0).contains(&rows) {
        return Err(Fault::of(
            0,
            format!("identity needs a number of rows from 1, found {}", crate::value::number(n)),
        ));
    }
    let rows = rows as usize;
    call.room(rows * rows)?;
    Ok(matrix(rows, &unit(rows)))
}

fn translation(call: &Call<'_>) -> Result<Value, Fault> {
    let t = vector_of("translation", 0, &call.args[0], &[2, 3])?;
    let n = t.len() + 1;
    let mut cells = unit(n);
    for (i, t) in t.iter().enumerate() {
        cells[i * n + n - 1] = t.clone();
    }
    Ok(matrix(n, &cells))
}

fn scaling(call: &Call<'_>) -> Result<Value, Fault> {
    let s = &call.args[0];
    let factors: Planes = if s.shape.is_scalar() {
        std::iter::repeat_n(s.planes[0].clone(), 3).collect()
    } else {
        vector_of("scaling", 0, s, &[2, 3])?.clone()
    };
    let n = factors.len() + 1;
    let mut cells = unit(n);
    for (i, factor) in factors.iter().enumerate() {
        cells[i * n + i] = factor.clone();
    }
    Ok(matrix(n, &cells))
}

fn rotation(call: &Call<'_>) -> Result<Value, Fault> {
    let angle = call.scalar(0)?;
    let (sin, cos) = (call.map1(angle, math::sin_lanes), call.map1(angle, math::cos_lanes));
    let axis = direction_planes(call, vector_of("rotation", 1, &call.args[1], &[3])?);
    let mut cells = unit(4);
    for j in 0..3 {
        // Column j is where the unit vector along axis j goes.
        let e: [Plane; 3] = std::array::from_fn(|k| Plane::Uniform(f32::from(j == k)));
        let [a, b, c] = &e;
        let column = call.lanes([a, b, c, &sin, &cos, &axis[0], &axis[1], &axis[2]], rodrigues);
        for (i, x) in column.into_iter().enumerate() {
            cells[i * 4 + j] = x;
        }
    }
    Ok(matrix(4, &cells))
}

/// Matrices.
pub static FUNCTIONS: &[Builtin] = &[
    Builtin {
        name: "transform",
        params: &[Param::new("m"), Param::new("p")],
        brief: "Transforms the point p by the matrix m.",
        doc: "A matrix is a vector of rows, and points are columns: the result is `m p`. A point with one component \
              less than m has rows gets a 1 at its end, and the result is divided by its last component \
              (perspective). So a matrix of 4 rows moves, rotates and projects points in space, and one of 3 rows \
              points in the plane. A vector with as many components as m has rows is only multiplied. In a vector of \
              points, each is transformed. Instead of m you can give the name of a space, or of two: \
              `transform(\"camera\", p)`, `transform(\"object\", \"camera\", p)` (see *Spaces* in docs/language.md).",
        examples: &[
            ex("transform(translation([1 2 3]), [10 20 30])", "[11 22 33]"),
            ex("transform([[0 -1] [1 0]], [1 0])", "[0 1]"),
            ex("transform([[1 0 0 0] [0 1 0 0] [0 0 1 0] [0 0 1 0]], [4 6 2])", "[2 3 1]"),
        ],
        kernel: Kernel::Whole(transform),
    },
    Builtin {
        name: "vtransform",
        params: &[Param::new("m"), Param::new("v")],
        brief: "Transforms the direction v by the matrix m, without its translation.",
        doc: "v has one component less than m has rows, or as many. See [transform](#transform).",
        examples: &[ex("vtransform(translation([1 2 3]), [10 20 30])", "[10 20 30]")],
        kernel: Kernel::Whole(vtransform),
    },
    Builtin {
        name: "ntransform",
        params: &[Param::new("m"), Param::new("n")],
        brief: "Transforms the normal n of a surface by the matrix m.",
        doc: "Uses the inverse transpose of m without its translation, so the normal stays at right angles to the \
              surface where m stretches it. Its length changes: take its [direction](#direction).",
        examples: &[ex("ntransform(scaling([2 1 1]), [1 1 0])", "[0.5 1 0]")],
        kernel: Kernel::Whole(ntransform),
    },
    Builtin {
        name: "multiply",
        params: &[Param::rest("m", 2)],
        brief: "The product of matrices; the last one applies first.",
        doc: "`transform(multiply(a, b), p)` is `transform(a, transform(b, p))`. (`a * b` multiplies component by \
              component.) The last argument can be a vector (a column). The sizes must fit.",
        examples: &[
            ex("multiply([[1 2] [3 4]], [[0 1] [1 0]])", "[[2 1] [4 3]]"),
            ex("multiply([[1 2] [3 4]], [1 1])", "[3 7]"),
        ],
        kernel: Kernel::Whole(multiply),
    },
    Builtin {
        name: "inverse",
        params: &[Param::new("m")],
        brief: "The matrix that undoes m.",
        doc: "Of 2, 3 or 4 rows and columns. A singular matrix (determinant 0) gives infinities and NaNs.",
        examples: &[ex("inverse([[2 0] [0 4]])", "[[0.5 0] [0 0.25]]")],
        kernel: Kernel::Whole(inverse),
    },
    Builtin {
        name: "transpose",
        params: &[Param::new("m")],
        brief: "The matrix with rows and columns exchanged.",
        doc: "",
        examples: &[ex("transpose([[1 2 3] [4 5 6]])", "[[1 4] [2 5] [3 6]]")],
        kernel: Kernel::Whole(transpose),
    },
    Builtin {
        name: "determinant",
        params: &[Param::new("m")],
        brief: "The factor by which the matrix m scales areas (2 rows) or volumes (3 rows).",
        doc: "Of 2, 3 or 4 rows and columns. Negative if m mirrors, 0 if m flattens.",
        examples: &[ex("determinant([[1 2] [3 4]])", "-2"), ex("determinant(scaling(2))", "8")],
        kernel: Kernel::Whole(determinant),
    },
    Builtin {
        name: "identity",
        params: &[Param::or("n", "4")],
        brief: "The identity matrix of n rows.",
        doc: "",
        examples: &[ex("identity(2)", "[[1 0] [0 1]]")],
        kernel: Kernel::Whole(identity),
    },
    Builtin {
        name: "translation",
        params: &[Param::new("t")],
        brief: "The matrix that moves points by t.",
        doc: "Of 4 rows for a t of 3 components; of 3 rows, for points in the plane, for a t of 2.",
        examples: &[ex("translation([5 6])", "[[1 0 5] [0 1 6] [0 0 1]]")],
        kernel: Kernel::Whole(translation),
    },
    Builtin {
        name: "scaling",
        params: &[Param::new("s")],
        brief: "The matrix that scales by s.",
        doc: "Of 4 rows for a scalar or an s of 3 components, one for each axis; of 3 rows, for points in the plane, \
              for an s of 2.",
        examples: &[ex("scaling([2 3])", "[[2 0 0] [0 3 0] [0 0 1]]")],
        kernel: Kernel::Whole(scaling),
    },
    Builtin {
        name: "rotation",
        params: &[Param::new("angle"), Param::or("axis", "[0 0 1]")],
        brief: "The matrix of 4 rows that rotates points about an axis, by an angle in radians.",
        doc: "Like [rotate](#rotate): counterclockwise, looking against the axis.",
        examples: &[ex("transform(rotation(pi/2), [1 0 0])", "[0 1 0]")],
        kernel: Kernel::Whole(rotation),
    },
];
