//! Symmetric positive definite matrices: Cholesky's factors, in plain f64.

/// A square matrix, row by row.
pub(super) struct Matrix {
    pub size: usize,
    pub at: Vec<f64>,
}

impl Matrix {
    /// From its elements.
    pub(super) fn new(size: usize, mut element: impl FnMut(usize, usize) -> f64) -> Matrix {
        let at = (0..size * size).map(|n| element(n / size, n % size)).collect();
        Matrix { size, at }
    }

    /// Its inverse; `None` if it is not positive definite. As a covariance it must also leave each of its variables so
    /// much variance if all the others are known: that is 1 divided by an element of the inverse's diagonal.
    pub(super) fn inverse(&self, least: f64) -> Option<Matrix> {
        let n = self.size;
        // The lower factor L, with L Lᵗ the matrix.
        let mut low = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| low[i * n + k] * low[j * n + k]).sum();
                let rest = self.at[i * n + j] - known;
                if i > j {
                    low[i * n + j] = rest / low[j * n + j];
                } else if rest > 0.0 {
                    low[i * n + i] = rest.sqrt();
                } else {
                    return None; // for a NaN too
                }
            }
        }
        // Column by column: L y = a unit vector, Lᵗ x = y.
        let mut inverse = vec![0.0; n * n];
        for column in 0..n {
            let mut x = vec![0.0; n];
            for i in column..n {
                let known: f64 = (column..i).map(|k| low[i * n + k] * x[k]).sum();
                x[i] = (f64::from(u8::from(i == column)) - known) / low[i * n + i];
            }
            for i in (0..n).rev() {
                let known: f64 = (i + 1..n).map(|k| low[k * n + i] * x[k]).sum();
                x[i] = (x[i] - known) / low[i * n + i];
            }
            for i in 0..n {
                inverse[i * n + column] = x[i];
            }
        }
        let enough = (0..n).all(|i| inverse[i * n + i] * least <= 1.0);
        enough.then_some(Matrix { size: n, at: inverse })
    }

    /// Its product with a vector.
    pub(super) fn times(&self, v: &[f64]) -> Vec<f64> {
        self.at.chunks(self.size).map(|row| row.iter().zip(v).map(|(a, v)| a * v).sum()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_undoes() {
        let n = 9;
        let matrix = Matrix::new(n, |i, j| 1.0 / (1.0 + (i.abs_diff(j) * i.abs_diff(j)) as f64));
        let inverse = matrix.inverse(0.0).unwrap();
        for i in 0..n {
            let unit: Vec<f64> = (0..n).map(|j| f64::from(u8::from(i == j))).collect();
            for (j, x) in matrix.times(&inverse.times(&unit)).into_iter().enumerate() {
                assert!((x - unit[j]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_none() {
        assert!(Matrix::new(2, |i, j| if i == j { 1.0 } else { 1.5 }).inverse(0.0).is_none());
        assert!(Matrix::new(2, |_, _| 1.0).inverse(1e-9).is_none());
        let near = |least| Matrix::new(2, |i, j| if i == j { 1.0 } else { 0.6 }).inverse(least);
        assert!(near(0.63).is_some() && near(0.65).is_none()); // 1 - 0.6²
        assert!(Matrix::new(2, |_, _| f64::NAN).inverse(0.0).is_none());
    }
}
