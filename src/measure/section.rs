//! Plane and straight sections through a space of any number of dimensions.

use super::random::Random;

/// Points at equal steps on a plane, or on a line: rows of `columns` points.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Where the first point is.
    pub origin: Vec<f64>,
    /// The direction of a row, of length 1.
    pub along: Vec<f64>,
    /// The direction from row to row, of length 1.
    pub across: Vec<f64>,
    /// Points in a row.
    pub columns: usize,
    /// Rows; 1 for a line.
    pub rows: usize,
    /// From point to point.
    pub spacing: f64,
}

impl Section {
    /// A line of so many points.
    pub fn line(origin: &[f64], along: &[f64], count: usize, spacing: f64) -> Section {
        let across = vec![0.0; origin.len()];
        Section { origin: origin.into(), along: along.into(), across, columns: count, rows: 1, spacing }
    }

    /// A square of `side` × `side` points at a random place, up to `reach` from the origin along each axis, and
    /// in a random orientation.
    pub fn tilted(random: &mut Random, dimensions: usize, side: usize, spacing: f64, reach: f64) -> Section {
        let origin = (0..dimensions).map(|_| random.within(reach)).collect();
        let [along, across] = random.frame(dimensions);
        Section { origin, along, across, columns: side, rows: side, spacing }
    }

    /// The points' coordinates: a list a coordinate, row after row.
    pub fn points(&self) -> Vec<Vec<f32>> {
        let coordinate = |k: usize| {
            let at = move |i: usize, j: usize| {
                let (u, v) = (i as f64 * self.spacing, j as f64 * self.spacing);
                (self.origin[k] + (u * self.along[k] + v * self.across[k])) as f32
            };
            (0..self.rows).flat_map(|j| (0..self.columns).map(move |i| at(i, j))).collect()
        };
        (0..self.origin.len()).map(coordinate).collect()
    }

    /// The values at the points, as `noise` gives them: from a slice a coordinate into the slice of values.
    pub fn sample(&self, noise: impl FnOnce(&[&[f32]], &mut [f32])) -> Vec<f32> {
        let points = self.points();
        let mut values = vec![0.0; self.columns * self.rows];
        noise(&points.iter().map(Vec::as_slice).collect::<Vec<_>>(), &mut values);
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_where_they_should() {
        let section = Section {
            origin: vec![1.0, 2.0, 3.0],
            along: vec![0.0, 1.0, 0.0],
            across: vec![0.0, 0.0, -1.0],
            columns: 3,
            rows: 2,
            spacing: 0.5,
        };
        let expected = [[1.0; 6], [2.0, 2.5, 3.0, 2.0, 2.5, 3.0], [3.0, 3.0, 3.0, 2.5, 2.5, 2.5]];
        assert_eq!(section.points(), expected);
        assert_eq!(section.sample(|p, out| out.copy_from_slice(p[1])), expected[1]);
        assert_eq!(Section::line(&[1.0], &[1.0], 3, 2.0).points(), [[1.0, 3.0, 5.0]]);
    }

    #[test]
    fn tilted_sections_are_square() {
        let mut random = Random::new(4);
        for dimensions in 2..=4 {
            let points = Section::tilted(&mut random, dimensions, 11, 0.25, 50.0).points();
            let distance = |a: usize, b: usize| {
                points.iter().map(|x| f64::from(x[a] - x[b]) * f64::from(x[a] - x[b])).sum::<f64>().sqrt()
            };
            assert!((distance(0, 10) - 2.5).abs() < 1e-4 && (distance(0, 110) - 2.5).abs() < 1e-4);
            assert!((distance(10, 110) - 2.5 * 2.0_f64.sqrt()).abs() < 1e-4);
        }
    }
}
