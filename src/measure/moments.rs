//! Mean, deviation and the like of samples.

/// What samples are like, whatever their order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// How many there are.
    pub count: usize,
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation (the root of the mean square from the mean).
    pub deviation: f64,
    /// By how much their fourth moment over the square of their variance exceeds 3, that of a normal distribution.
    pub kurtosis: f64,
    /// The least of them.
    pub least: f32,
    /// The most of them.
    pub most: f32,
}

impl Moments {
    /// Those of samples. All but the count is NaN if there are none, or if one is NaN.
    pub fn of(samples: &[f32]) -> Moments {
        let count = samples.len();
        let wide = || samples.iter().map(|&x| f64::from(x));
        let mean = wide().sum::<f64>() / count as f64;
        let (mut second, mut fourth) = (0.0, 0.0);
        for x in wide() {
            let square = (x - mean) * (x - mean);
            second += square;
            fourth += square * square;
        }
        let variance = second / count as f64;
        let kurtosis = fourth / count as f64 / (variance * variance) - 3.0;
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        for &x in samples {
            (least, most) = (least.min(x), most.max(x));
        }
        if mean.is_nan() {
            (least, most) = (f32::NAN, f32::NAN);
        }
        Moments { count, mean, deviation: variance.sqrt(), kurtosis, least, most }
    }

    /// The root of their mean square.
    pub fn rms(&self) -> f64 {
        (self.mean * self.mean + self.deviation * self.deviation).sqrt()
    }

    /// The largest of their absolute values.
    pub fn size(&self) -> f64 {
        f64::from(self.most.max(-self.least))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::Random;

    #[test]
    fn of_even_numbers() {
        let mut random = Random::new(3);
        let samples: Vec<f32> = (0..200_000).map(|_| random.within(1.0) as f32 + 5.0).collect();
        let m = Moments::of(&samples);
        assert!((m.mean - 5.0).abs() < 0.005 && (m.deviation - 1.0 / 3.0_f64.sqrt()).abs() < 0.003);
        // An even distribution has 9/5 - 3.
        assert!((m.kurtosis + 1.2).abs() < 0.01);
        assert!((4.0..4.001).contains(&m.least) && (5.999..6.0001).contains(&m.most));
        assert!((m.rms() - (25.0_f64 + 1.0 / 3.0).sqrt()).abs() < 0.01 && m.size() == f64::from(m.most));
    }

    #[test]
    fn of_few_and_of_none() {
        let m = Moments::of(&[1.0, 3.0]);
        assert_eq!((m.mean, m.deviation, m.kurtosis, m.least, m.most), (2.0, 1.0, -2.0, 1.0, 3.0));
        assert!(Moments::of(&[]).mean.is_nan() && Moments::of(&[1.0, f32::NAN]).most.is_nan());
    }
}
