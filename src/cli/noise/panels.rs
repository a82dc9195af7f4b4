//! What a row of a sheet shows, measured: nothing of how it is drawn.

use super::row::Row;
use pse::measure::{LineSpectrum, Moments, Random, Section, Spectrum};

/// A curve: frequencies and what is there.
pub type Curve = Vec<(f64, f64)>;

/// The numbers of a row.
pub struct Panels {
    /// How many units a plane section is wide.
    pub units: f64,
    /// A plane section: `side` rows of as many values.
    pub section: Vec<f32>,
    /// Values at equal steps along the middle of the section.
    pub graph: Vec<f32>,
    /// Power by frequency, or, of a sum, the power's density.
    pub power: Curve,
    /// Amplitude by frequency along lines.
    pub amplitude: Curve,
    /// Values of scattered points, and what they are like.
    pub values: Vec<f32>,
    pub moments: Moments,
    /// The shares of power below 0.3 cycles a unit, from there to 0.7, and above 1.
    pub shares: [f64; 3],
    /// By which power of frequency the density goes, of a sum.
    pub slope: Option<f64>,
}

/// Where the plane that is shown begins: it cuts through the cells somewhere, and so does the line along its middle.
const ORIGIN: [f64; 4] = [0.0, 0.3, 0.4, 0.7];

impl Panels {
    /// Measures a noise, with `side` rows in the section that is shown.
    pub fn new(row: &Row, side: usize) -> Panels {
        let d = row.dimensions;
        // Sums have fine detail. They end at what the samples of their spectrum can show.
        let (units, spacing) = if row.is_sum { (6.0, 1.0 / 32.0) } else { (12.0, 1.0 / 8.0) };
        let high = 0.5 / (1.0_f32 / 32.0);
        let noise = |p: &[&[f32]], out: &mut [f32]| row.sample(high, p, out);
        let axis = |k: usize| (0..d).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
        let origin = &ORIGIN[..d];
        let step = units / side as f64;
        let plane = Section {
            origin: origin.into(),
            along: axis(0),
            across: axis(1),
            columns: side,
            rows: side,
            spacing: step,
        };
        let mut middle: Vec<f64> = origin.into();
        if let Some(y) = middle.get_mut(1) {
            *y += units / 2.0;
        }
        let graph = Section::line(&middle, &axis(0), 4 * side, step / 4.0).sample(noise);
        let mut random = Random::new(1);
        let mut spectrum = Spectrum::new(256, spacing);
        for _ in 0..16 {
            spectrum.add(&Section::tilted(&mut random, d, 256, spacing, 300.0).sample(noise));
        }
        let mut line = LineSpectrum::new(1 << 14, spacing);
        for _ in 0..8 {
            let origin: Vec<f64> = (0..d).map(|_| random.within(300.0)).collect();
            line.add(&Section::line(&origin, &random.direction(d), 1 << 14, spacing).sample(noise));
        }
        let points = random.points(d, 1 << 17, 500.0, 1.0 / 4096.0);
        let mut values = vec![0.0; points[0].len()];
        noise(&points.iter().map(Vec::as_slice).collect::<Vec<_>>(), &mut values);
        let (power, slope) = match row.is_sum {
            true => (spectrum.density(), Some(spectrum.slope(0.7, 8.0))),
            false => (spectrum.energy(), None),
        };
        Panels {
            units,
            section: plane.sample(noise),
            graph,
            power,
            amplitude: line.amplitude(if row.is_sum { 1.0 / 16.0 } else { 1.0 / 32.0 }),
            moments: Moments::of(&values),
            values,
            shares: [(0.0, 0.3), (0.3, 0.7), (1.0, f64::INFINITY)]
                .map(|(low, high)| spectrum.share(low, high)),
            slope,
        }
    }
}
