//! How often which values occur.

/// Counts of samples in intervals of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Where the first interval begins.
    pub least: f64,
    /// Where the last interval ends.
    pub most: f64,
    /// How many samples lie in each; the last has its upper end in it.
    pub counts: Vec<usize>,
    /// How many there are, in the intervals or not.
    pub total: usize,
}

impl Histogram {
    /// That of samples, in so many intervals from `least` to `most`.
    ///
    /// # Panics
    /// If there are no intervals, or if `most` is not above `least`.
    pub fn of(samples: &[f32], least: f64, most: f64, intervals: usize) -> Histogram {
        assert!(intervals > 0 && most > least, "{intervals} intervals from {least} to {most}");
        let mut counts = vec![0; intervals];
        for &x in samples {
            let x = f64::from(x);
            if x >= least && x <= most {
                let place = ((x - least) / (most - least) * intervals as f64) as usize;
                counts[place.min(intervals - 1)] += 1;
            }
        }
        Histogram { least, most, counts, total: samples.len() }
    }

    /// The width of an interval.
    pub fn width(&self) -> f64 {
        (self.most - self.least) / self.counts.len() as f64
    }

    /// The probability density in each interval: over all values it integrates to 1.
    pub fn densities(&self) -> Vec<f64> {
        let whole = self.total.max(1) as f64 * self.width();
        self.counts.iter().map(|&n| n as f64 / whole).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_densities() {
        let h = Histogram::of(&[-1.0, -0.6, 0.0, 0.1, 1.0, 2.0, f32::NAN], -1.0, 1.0, 4);
        assert_eq!((&h.counts[..], h.total), (&[2, 0, 2, 1][..], 7));
        assert_eq!(h.width(), 0.5);
        assert!((h.densities().iter().sum::<f64>() * h.width() - 5.0 / 7.0).abs() < 1e-12);
    }
}
