//! What the samples of a decoded picture are, and how they become the numbers that programs see.

use super::color;
use super::file::{Channel, Samples};
use crate::parallel::*;
use std::ops::Range;

/// The channels of a picture.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// Their names: `R G B`, or `Y` for grey, `A`, and names of further samples.
    pub channels: Vec<String>,
    /// How they are stored in the file.
    pub samples: Samples,
    /// Which of them is alpha.
    pub alpha: Option<Alpha>,
    /// The type of the decoded samples.
    pub decoded: Decoded,
    /// Whether the numbers are light. Otherwise they are encoded as sRGB.
    pub linear: bool,
}

/// The type of decoded samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Decoded {
    /// Codes from 0 to this greatest one, in bytes.
    Byte(u8),
    /// Codes from 0 to this greatest one.
    Short(u16),
    /// Numbers.
    Float,
}

/// The alpha of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Alpha {
    /// Its place among the channels.
    pub channel: usize,
    /// Whether the stored colours are multiplied by it.
    pub associated: bool,
}

/// Decoded samples, those of a pixel one after another.
pub(super) enum Codes {
    Byte(Vec<u8>),
    Short(Vec<u16>),
    Float(Vec<f32>),
}

impl Layout {
    /// The layout of a picture of 1 to 4 channels of 8 or 16 bits, or of floats: grey, grey and alpha, RGB, RGBA.
    pub fn simple(count: usize, samples: Samples) -> Layout {
        let names: &[&str] = match count {
            1 => &["Y"],
            2 => &["Y", "A"],
            3 => &["R", "G", "B"],
            _ => &["R", "G", "B", "A"],
        };
        let decoded = match samples {
            Samples::Byte => Decoded::Byte(255),
            Samples::Short => Decoded::Short(u16::MAX),
            _ => Decoded::Float,
        };
        Layout {
            channels: names.iter().map(|n| n.to_string()).collect(),
            samples,
            alpha: count.is_multiple_of(2).then_some(Alpha { channel: count - 1, associated: false }),
            decoded,
            linear: decoded == Decoded::Float,
        }
    }

    /// The channels as those of a file.
    pub fn list(&self) -> Vec<Channel> {
        let channel = |(index, name): (usize, &String)| Channel {
            name: name.clone(),
            part: 0,
            index,
            samples: self.samples,
            unread: None,
            sampling: [1, 1],
        };
        self.channels.iter().enumerate().map(channel).collect()
    }

    /// Bytes of a decoded sample.
    pub fn sample_bytes(&self) -> u64 {
        match self.decoded {
            Decoded::Byte(_) => 1,
            Decoded::Short(_) => 2,
            Decoded::Float => 4,
        }
    }

    /// Bytes of a decoded pixel.
    pub fn pixel_bytes(&self) -> u64 {
        self.channels.len() as u64 * self.sample_bytes()
    }

    /// The numbers that programs see of these pixels, a plane for each channel: linear light, multiplied by alpha; with
    /// `raw` as they are stored.
    pub fn planes(&self, codes: &Codes, pixels: Range<usize>, raw: bool) -> Vec<Vec<f32>> {
        let count = self.channels.len();
        let range = pixels.start * count..pixels.end * count;
        let alpha = self.alpha.filter(|_| !raw);
        let number = |c: usize, plain: bool| match (codes, self.decoded) {
            (Codes::Byte(codes), Decoded::Byte(max)) => {
                let table: Vec<f32> = (0..=max).map(|v| value(v.into(), max.into(), plain)).collect();
                gather(&codes[range.clone()], count, c, |v| table[usize::from(v.min(max))])
            }
            (Codes::Short(codes), Decoded::Short(u16::MAX)) if !plain => {
                gather(&codes[range.clone()], count, c, color::decode16)
            }
            (Codes::Short(codes), Decoded::Short(max)) if max < 1 << 14 => {
                let table: Vec<f32> = (0..=max).map(|v| value(v, max, plain)).collect();
                gather(&codes[range.clone()], count, c, |v| table[usize::from(v.min(max))])
            }
            (Codes::Short(codes), Decoded::Short(max)) => {
                gather(&codes[range.clone()], count, c, |v| value(v, max, plain))
            }
            (Codes::Float(numbers), _) => {
                gather(&numbers[range.clone()], count, c, |v| if plain { v } else { color::decode(v) })
            }
            _ => vec![0.0; pixels.len()],
        };
        let colors = |c: usize| self.alpha.is_none_or(|a| a.channel != c) && self.is_color(c);
        // Colours that are encoded and multiplied are divided before they are decoded.
        let divided = alpha.is_some_and(|a| a.associated) && !self.linear;
        let plain = |c: usize| raw || self.linear || divided || !colors(c);
        let mut planes: Vec<Vec<f32>> = (0..count).map(|c| number(c, plain(c))).collect();
        let Some(alpha) = alpha else { return planes };
        let cover = planes[alpha.channel].clone();
        for (_, plane) in planes.iter_mut().enumerate().filter(|(c, _)| colors(*c)) {
            let both = plane.par_iter_mut().zip(&cover).with_min_len(4096);
            match (alpha.associated, self.linear) {
                (true, true) => {}
                (true, false) => both.for_each(|(v, &a)| {
                    *v = if a > 0.0 { color::decode(*v / a) * a } else { color::decode(*v) };
                }),
                (false, _) => both.for_each(|(v, a)| *v *= a),
            }
        }
        planes
    }

    fn is_color(&self, c: usize) -> bool {
        matches!(self.channels[c].as_str(), "R" | "G" | "B" | "Y")
    }
}

fn value(code: u16, max: u16, plain: bool) -> f32 {
    match (plain, max) {
        (true, _) => (f64::from(code) / f64::from(max)) as f32,
        (false, 255) => color::decode8(code as u8),
        (false, u16::MAX) => color::decode16(code),
        (false, _) => color::srgb_to_linear(f64::from(code) / f64::from(max)) as f32,
    }
}

/// Component `c` of interleaved samples.
fn gather<T: Copy + Sync>(
    samples: &[T],
    count: usize,
    c: usize,
    convert: impl Fn(T) -> f32 + Sync + Send,
) -> Vec<f32> {
    samples.par_chunks_exact(count).with_min_len(4096).map(|pixel| convert(pixel[c])).collect()
}

impl Codes {
    /// How many samples there are.
    pub fn len(&self) -> usize {
        match self {
            Codes::Byte(codes) => codes.len(),
            Codes::Short(codes) => codes.len(),
            Codes::Float(numbers) => numbers.len(),
        }
    }

    /// The picture turned and mirrored as an EXIF orientation says; `size` is that before.
    pub fn oriented(self, size: [usize; 2], count: usize, orientation: u8) -> Codes {
        match (self, orientation) {
            (codes, ..=1 | 9..) => codes,
            (Codes::Byte(codes), _) => Codes::Byte(orient(&codes, size, count, orientation)),
            (Codes::Short(codes), _) => Codes::Short(orient(&codes, size, count, orientation)),
            (Codes::Float(numbers), _) => Codes::Float(orient(&numbers, size, count, orientation)),
        }
    }
}

/// Columns and rows after turning.
pub(super) fn oriented_size([width, height]: [usize; 2], orientation: u8) -> [usize; 2] {
    if matches!(orientation, 5..=8) { [height, width] } else { [width, height] }
}

fn orient<T: Copy>(samples: &[T], size: [usize; 2], count: usize, orientation: u8) -> Vec<T> {
    let [width, height] = size;
    let [columns, rows] = oriented_size(size, orientation);
    let mut out = Vec::with_capacity(samples.len());
    for y in 0..rows {
        for x in 0..columns {
            // Where the pixel is stored.
            let (sx, sy) = match orientation {
                2 => (width - 1 - x, y),
                3 => (width - 1 - x, height - 1 - y),
                4 => (x, height - 1 - y),
                5 => (y, x),
                6 => (y, height - 1 - x),
                7 => (width - 1 - y, height - 1 - x),
                8 => (width - 1 - y, x),
                _ => (x, y),
            };
            let at = (sy * width + sx) * count;
            out.extend_from_slice(&samples[at..at + count]);
        }
    }
    out
}
