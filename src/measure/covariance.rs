//! How values at two places go together.

use super::Moments;

/// The covariance of pairs: the mean of the products of what they differ from their means.
///
/// # Panics
/// If there are more of one than of the other.
pub fn covariance(a: &[f32], b: &[f32]) -> f64 {
    assert_eq!(a.len(), b.len(), "pairs");
    let (ma, mb) = (Moments::of(a).mean, Moments::of(b).mean);
    let products = a.iter().zip(b).map(|(&a, &b)| (f64::from(a) - ma) * (f64::from(b) - mb));
    products.sum::<f64>() / a.len() as f64
}

/// The correlation of pairs: their covariance over both deviations, -1 … 1; 0 if one of them never changes.
///
/// # Panics
/// If there are more of one than of the other.
pub fn correlation(a: &[f32], b: &[f32]) -> f64 {
    let both = Moments::of(a).deviation * Moments::of(b).deviation;
    if both == 0.0 { 0.0 } else { covariance(a, b) / both }
}

/// The autocovariance of equally spaced samples along a line: that of samples 0, 1, … `lags` places apart, the mean
/// being that of all. The first is the variance.
///
/// # Panics
/// If there are not more samples than lags.
pub fn autocovariance(samples: &[f32], lags: usize) -> Vec<f64> {
    assert!(samples.len() > lags, "{} samples for {lags} lags", samples.len());
    let mean = Moments::of(samples).mean;
    let centred: Vec<f64> = samples.iter().map(|&x| f64::from(x) - mean).collect();
    let of = |lag: usize| {
        let products = centred.iter().zip(&centred[lag..]).map(|(a, b)| a * b);
        products.sum::<f64>() / (centred.len() - lag) as f64
    };
    (0..=lags).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::Random;

    #[test]
    fn of_a_sine_and_of_white_noise() {
        let sine: Vec<f32> = (0..10_000).map(|i| crate::math::sin(i as f32 * 0.1)).collect();
        for (lag, c) in autocovariance(&sine, 40).iter().enumerate() {
            assert!((c - 0.5 * libm::cos(lag as f64 * 0.1)).abs() < 0.005, "{lag}: {c}");
        }
        let mut random = Random::new(5);
        let white: Vec<f32> = (0..50_000).map(|_| random.within(1.0) as f32).collect();
        let c = autocovariance(&white, 10);
        assert!((c[0] - 1.0 / 3.0).abs() < 0.005 && c[1..].iter().all(|c| c.abs() < 0.006), "{c:?}");
        assert!(correlation(&sine, &sine[..]) > 0.9999 && correlation(&white[..10_000], &sine).abs() < 0.03);
        assert_eq!(correlation(&[1.0, 1.0], &[0.0, 2.0]), 0.0);
        let opposite: Vec<f32> = sine.iter().map(|x| 3.0 - 2.0 * x).collect();
        assert!((correlation(&sine, &opposite) + 1.0).abs() < 1e-6);
    }
}
