//! What the samples of a TIFF mean: grey, RGB, palettes, inks, YCbCr and CIE L*a*b*, as grey or sRGB.

use super::super::color::linear_to_srgb;
use super::super::error::ImageError;
use super::super::layout::Decoded;
use super::directory::{Directory, TiffReader};
use super::samples::{Kind, Storage};
use super::unsupported;

/// How samples become a colour.
#[derive(Debug)]
pub(super) enum Photometric {
    Grey {
        /// 0 is white.
        inverted: bool,
    },
    Rgb,
    /// Codes of the colours, and the greatest code.
    Palette(Vec<[u16; 3]>, u16),
    Cmyk,
    YCbCr(Box<YCbCr>),
    Lab(Lab),
}

/// Weights of the primaries, and the codes of black and white, for each of the three samples.
#[derive(Debug)]
pub(super) struct YCbCr {
    weights: [f64; 3],
    reference: [[f64; 2]; 3],
    max: f64,
}

/// How L*, a* and b* are coded, and their white as X and Z of Y = 1.
#[derive(Debug)]
pub(super) struct Lab {
    offset: bool,
    storage: Storage,
    to_rgb: [[f64; 3]; 3],
    white: [f64; 3],
}

impl Photometric {
    /// Reads the tags that say what the samples mean, and refuses what is not read.
    pub fn of(
        file: &mut TiffReader,
        directory: &Directory,
        number: Option<u64>,
        count: usize,
        storage: &Storage,
        ink_set: u64,
    ) -> Result<Photometric, ImageError> {
        let name = file.name().to_string();
        let refuse = |feature: &str| Err(unsupported(&name, feature));
        let own = match number {
            Some(0) => Photometric::Grey { inverted: true },
            Some(1 | 4 | 51177) => Photometric::Grey { inverted: false },
            Some(2 | 34892) if count >= 3 => Photometric::Rgb,
            None if count >= 3 => Photometric::Rgb,
            None | Some(2 | 34892) => Photometric::Grey { inverted: false },
            Some(3) => palette(file, directory, storage)?,
            Some(5) if count >= 4 && ink_set != 2 => Photometric::Cmyk,
            Some(5) => return refuse("inks other than CMYK"),
            Some(6) => Photometric::YCbCr(Box::new(YCbCr::of(file, directory, storage)?)),
            Some(8 | 9) if count < 3 => Photometric::Grey { inverted: false },
            Some(kind @ (8 | 9)) => {
                let xy = directory.fractions(file, 318)?;
                let white = match xy[..] {
                    [x, y, ..] if x > 0.0 && y > 0.0 => [x / y, 1.0, (1.0 - x - y) / y],
                    _ => D50,
                };
                Photometric::Lab(Lab { offset: kind == 9, storage: *storage, to_rgb: to_rgb(white), white })
            }
            Some(10) => return refuse("colours in ITU L*a*b*"),
            Some(32803) => return refuse("the raw samples of a camera's sensor (CFA)"),
            Some(32844 | 32845) => return refuse("colours in LogL or LogLuv"),
            Some(other) => return refuse(&format!("photometric interpretation {other}")),
        };
        if own.samples() > count {
            return refuse(&format!(
                "{count} samples for each pixel, of which its colours need {}",
                own.samples()
            ));
        }
        Ok(own)
    }

    /// How many samples of a pixel make its colour.
    pub fn samples(&self) -> usize {
        match self {
            Photometric::Grey { .. } | Photometric::Palette(..) => 1,
            Photometric::Rgb | Photometric::YCbCr(_) | Photometric::Lab(_) => 3,
            Photometric::Cmyk => 4,
        }
    }

    /// The names of the channels of the colour.
    pub fn channels(&self) -> &'static [&'static str] {
        match self {
            Photometric::Grey { .. } => &["Y"],
            _ => &["R", "G", "B"],
        }
    }

    /// The type that the pixels are decoded to.
    pub fn decoded(&self, storage: &Storage) -> Decoded {
        let small = storage.kind == Kind::Unsigned && storage.bits <= 16;
        match self {
            Photometric::Palette(_, 255) => Decoded::Byte(255),
            Photometric::Palette(..) => Decoded::Short(u16::MAX),
            Photometric::Lab(_) => Decoded::Float,
            Photometric::Cmyk => Decoded::Float,
            _ if !small => Decoded::Float,
            Photometric::YCbCr(_) if storage.bits > 8 => Decoded::Short(u16::MAX),
            Photometric::YCbCr(_) => Decoded::Byte(255),
            _ if storage.bits <= 8 => Decoded::Byte(storage.max() as u8),
            _ => Decoded::Short(storage.max() as u16),
        }
    }

    /// Whether the numbers are light: floats are, whole numbers are encoded as sRGB.
    pub fn linear(&self, storage: &Storage) -> bool {
        storage.kind == Kind::Float && !matches!(self, Photometric::Lab(_))
    }

    /// Whether decoded samples are those that are stored.
    pub fn stored(&self) -> bool {
        matches!(self, Photometric::Grey { .. } | Photometric::Rgb)
    }

    /// Converts the colour of a pixel; `samples` are 0 to 1, those of a palette are codes.
    pub fn convert(&self, samples: &[f64]) -> [f64; 3] {
        match self {
            Photometric::Grey { .. } => [samples[0]; 3],
            Photometric::Rgb => [samples[0], samples[1], samples[2]],
            Photometric::Palette(colors, max) => {
                let color = colors.get(samples[0] as usize).copied().unwrap_or_default();
                color.map(|code| f64::from(code) / f64::from(*max))
            }
            Photometric::Cmyk => [0, 1, 2].map(|i| (1.0 - samples[i]) * (1.0 - samples[3])),
            Photometric::YCbCr(about) => about.convert(samples),
            Photometric::Lab(about) => about.convert(samples),
        }
    }
}

fn palette(
    file: &mut TiffReader,
    directory: &Directory,
    storage: &Storage,
) -> Result<Photometric, ImageError> {
    if storage.kind != Kind::Unsigned || storage.bits > 16 {
        return Err(unsupported(file.name(), format!("a palette for numbers of {} bits", storage.bits)));
    }
    let map = directory.numbers(file, 320)?;
    let count = 1usize << storage.bits;
    if map.len() < 3 * count {
        return Err(file.damaged("its palette is too short"));
    }
    let map = &map[..3 * count];
    // Many writers put codes of 8 bits into the upper or the lower byte.
    let shift = if map.iter().all(|&v| v < 256) {
        Some(0)
    } else if map.iter().all(|&v| v & 0xff == 0) {
        Some(8)
    } else {
        None
    };
    let code = |v: u64| (v >> shift.unwrap_or(0)) as u16;
    let colors = (0..count).map(|i| [i, count + i, 2 * count + i].map(|at| code(map[at]))).collect();
    Ok(Photometric::Palette(colors, if shift.is_some() { 255 } else { u16::MAX }))
}

impl YCbCr {
    fn of(file: &mut TiffReader, directory: &Directory, storage: &Storage) -> Result<YCbCr, ImageError> {
        let weights = match directory.fractions(file, 529)?[..] {
            [r, g, b, ..] if g > 0.0 && (r + g + b).is_finite() => [r, g, b],
            _ => [0.299, 0.587, 0.114],
        };
        let max = storage.max();
        let middle = (max + 1.0) / 2.0;
        let usual = [[0.0, max], [middle, max], [middle, max]];
        let reference = match directory.fractions(file, 532)?[..] {
            [a, b, c, d, e, f, ..] if a != b && c != d && e != f => [[a, b], [c, d], [e, f]],
            _ => usual,
        };
        Ok(YCbCr { weights, reference, max })
    }

    fn convert(&self, samples: &[f64]) -> [f64; 3] {
        let part = |i: usize, range: f64| {
            let [low, high] = self.reference[i];
            (samples[i] * self.max - low) * range / (high - low)
        };
        // The chroma reaches as far as codes go above the middle.
        let half = (self.max - 1.0) / 2.0;
        let (luma, blue, red) = (part(0, self.max), part(1, half), part(2, half));
        let [wr, wg, wb] = self.weights;
        let r = luma + red * (2.0 - 2.0 * wr);
        let b = luma + blue * (2.0 - 2.0 * wb);
        let g = (luma - wr * r - wb * b) / wg;
        [r, g, b].map(|v| (v / self.max).clamp(0.0, 1.0))
    }
}

const D50: [f64; 3] = [0.9642, 1.0, 0.8249];
const D65: [f64; 3] = [0.95047, 1.0, 1.08883];

type Matrix = [[f64; 3]; 3];

fn apply(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| std::array::from_fn(|j| (0..3).map(|k| row[k] * b[k][j]).sum()))
}

/// From XYZ of a white to linear sRGB, adapted by Bradford's matrix.
fn to_rgb(white: [f64; 3]) -> Matrix {
    const BRADFORD: Matrix =
        [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
    const BACK: Matrix = [
        [0.986_992_9, -0.147_054_3, 0.159_962_7],
        [0.432_305_3, 0.518_360_3, 0.049_291_2],
        [-0.008_528_7, 0.040_042_8, 0.968_486_7],
    ];
    const SRGB: Matrix = [
        [3.240_454_2, -1.537_138_5, -0.498_531_4],
        [-0.969_266, 1.876_010_8, 0.041_556],
        [0.055_643_4, -0.204_025_9, 1.057_225_2],
    ];
    let (from, to) = (apply(&BRADFORD, white), apply(&BRADFORD, D65));
    let scaled: Matrix = std::array::from_fn(|i| BRADFORD[i].map(|v| v * to[i] / from[i]));
    product(&SRGB, &product(&BACK, &scaled))
}

impl Lab {
    fn convert(&self, samples: &[f64]) -> [f64; 3] {
        let (bits, max) = (self.storage.bits as i32, self.storage.max());
        // Codes of a* and b* have eight bits in front of the point.
        let unit = libm::ldexp(1.0, bits - 8);
        let part = |v: f64| match (self.storage.kind, self.offset) {
            (Kind::Float, _) => v,
            (Kind::Signed, _) => v * max / (unit / 2.0).max(1.0),
            (_, true) => v * max / unit - 128.0,
            (_, false) if v * max >= 128.0 * unit => v * max / unit - 256.0,
            (_, false) => v * max / unit,
        };
        let lightness = match (self.storage.kind, self.offset, bits) {
            (Kind::Float, ..) => samples[0],
            (Kind::Unsigned, true, 9..) => samples[0] * max / unit / 255.0 * 100.0,
            _ => samples[0] * 100.0,
        };
        let y = (lightness + 16.0) / 116.0;
        let position = [y + part(samples[1]) / 500.0, y, y - part(samples[2]) / 200.0];
        let cube = |f: f64| {
            if f > 6.0 / 29.0 { f * f * f } else { 108.0 / 841.0 * (f - 4.0 / 29.0) }
        };
        let xyz: [f64; 3] = std::array::from_fn(|i| cube(position[i]) * self.white[i]);
        apply(&self.to_rgb, xyz).map(linear_to_srgb)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::color::srgb_to_linear;
    use super::*;

    #[test]
    fn lab_of_known_colours() {
        let storage = Storage { kind: Kind::Float, bits: 32, big_endian: false, predictor: 1 };
        let lab = Lab { offset: false, storage, to_rgb: to_rgb(D50), white: D50 };
        // White, middle grey, and sRGB's red under D50.
        for (lab_value, expected) in [
            ([100.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
            ([53.585, 0.0, 0.0], [0.5, 0.5, 0.5]),
            ([54.29, 80.81, 69.89], [1.0, 0.0, 0.0]),
        ] {
            let rgb = lab.convert(&lab_value);
            for (a, b) in rgb.iter().zip(expected) {
                assert!((srgb_to_linear(*a) - srgb_to_linear(b)).abs() < 2e-3, "{rgb:?} {expected:?}");
            }
        }
    }
}
