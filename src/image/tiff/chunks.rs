//! The strips and tiles of a TIFF: where they lie, and how they are put together.

use super::super::error::ImageError;
use super::super::guard;
use super::super::layout::{Codes, Decoded};
use super::super::source::Input;
use super::Tiff;
use super::codec::{self, Compression, Packing};
use super::color::Photometric;
use super::directory::{Directory, TiffReader};
use super::jpeg::{self, OldFrame};
use super::samples::Kind;
use ::image::ImageDecoder;
use ::image::codecs::webp::WebPDecoder;
use std::io::Cursor;

/// The place of a strip or tile in the image.
struct Place {
    /// Its first column and row.
    at: [usize; 2],
    /// Columns and rows that it stores.
    size: [usize; 2],
    /// The sample that it has, if each has strips of its own.
    plane: Option<usize>,
    /// Where its bytes are in the file, and how many.
    bytes: (u64, u64),
}

impl Tiff {
    /// Decodes the image, as it is stored: not turned.
    pub fn decode(&self, input: &Input) -> Result<Codes, ImageError> {
        let name = input.name();
        let (mut file, directory) = TiffReader::open(input)?;
        guard::contain(|| {
            let stored = self.stored_samples(&mut file, &directory)?;
            Ok(self.converted(stored))
        })
        .ok_or_else(|| ImageError::damaged(&name, "its pixel data is invalid"))?
    }

    /// Samples of a pixel in a strip or tile.
    fn chunk_samples(&self) -> usize {
        if self.planar { 1 } else { self.count }
    }

    /// All samples as numbers of the smallest type that holds them.
    fn stored_samples(&self, file: &mut TiffReader, directory: &Directory) -> Result<Codes, ImageError> {
        let [width, height] = self.size;
        let total = width * height * self.count;
        let short = || ImageError::damaged(file.name(), "not enough memory for its pixels");
        let mut out = match (self.storage.kind, self.storage.bits) {
            (Kind::Unsigned, ..=8) => Codes::Byte(zeros(total).ok_or_else(short)?),
            (Kind::Unsigned, ..=16) => Codes::Short(zeros(total).ok_or_else(short)?),
            _ => Codes::Float(zeros(total).ok_or_else(short)?),
        };
        let chunks = self.chunks(file, directory)?;
        if self.compression == Compression::OldJpeg {
            let frame = OldFrame {
                size: self.size,
                components: self.count,
                subsampling: match directory.numbers(file, 530)?[..] {
                    [across @ 1..=4, down @ 1..=4, ..] => [across as usize, down as usize],
                    _ => [2, 2],
                },
                rows: self.chunk[1],
            };
            let ranges: Vec<(u64, u64)> = chunks.iter().map(|place| place.bytes).collect();
            let stream = jpeg::old_stream(file, directory, &frame, &ranges)?;
            let place = Place { at: [0, 0], size: self.size, plane: None, bytes: (0, 0) };
            let bytes = self.jpeg(&[], &stream, &place).map_err(|why| file.damaged(why))?;
            self.place(&mut out, &place, &bytes);
            return Ok(out);
        }
        let tables = directory.raw(file, 347)?;
        let kind = if self.tiled { "tile" } else { "strip" };
        for (i, place) in chunks.iter().enumerate() {
            let (at, length) = place.bytes;
            let wrong = |why: String| format!("{kind} {} of {}: {why}", i + 1, chunks.len());
            if length == 0 {
                return Err(file.damaged(wrong("it is empty".into())));
            }
            let mut bytes = file.bytes(at, length)?;
            if self.reversed {
                bytes.iter_mut().for_each(|b| *b = b.reverse_bits());
            }
            let bytes = match self.compression {
                Compression::Jpeg => self.jpeg(&tables, &bytes, place),
                Compression::Webp => self.webp(&bytes, place),
                compression => {
                    let packing = Packing {
                        compression,
                        two_dimensional: self.two_dimensional,
                        size: place.size,
                        length: self.packed_length(place),
                    };
                    codec::decode(&packing, &bytes)
                }
            };
            self.place(&mut out, place, &bytes.map_err(|why| file.damaged(wrong(why)))?);
        }
        Ok(out)
    }

    /// The strips or tiles, from the top left.
    fn chunks(&self, file: &mut TiffReader, directory: &Directory) -> Result<Vec<Place>, ImageError> {
        let (own, other) = if self.tiled { ((324, 325), (273, 279)) } else { ((273, 279), (324, 325)) };
        let (offsets, counts) = if directory.has(own.0) { own } else { other };
        let offsets = directory.numbers(file, offsets)?;
        let counts = directory.numbers(file, counts)?;
        let [width, height] = self.size;
        let [columns, rows] = self.chunk;
        let planes = if self.planar { self.count } else { 1 };
        let total = width.div_ceil(columns) * height.div_ceil(rows) * planes;
        // The old JPEG has a stream of its own.
        if offsets.len() < total && self.compression != Compression::OldJpeg {
            let kind = if self.tiled { "tiles" } else { "strips" };
            return Err(file.damaged(format!("it has {} of its {total} {kind}", offsets.len())));
        }
        let mut sorted = offsets.clone();
        sorted.sort_unstable();
        let mut chunks = Vec::new();
        let across = width.div_ceil(columns);
        for (i, &at) in offsets.iter().enumerate().take(total) {
            let (plane, i_plane) = (i / (total / planes), i % (total / planes));
            let (x, y) = (i_plane % across * columns, i_plane / across * rows);
            let rows = if self.tiled { rows } else { rows.min(height - y) };
            let plane = self.planar.then_some(plane);
            let mut place = Place { at: [x, y], size: [columns, rows], plane, bytes: (at, 0) };
            let packed = self.packed_length(&place) as u64;
            let rest = file.length().saturating_sub(at);
            let length = match counts.get(i) {
                // What is not compressed has a known length.
                _ if self.compression == Compression::None => packed,
                Some(&count) if count > 0 => count,
                // Up to the next one.
                None => sorted.get(sorted.partition_point(|&o| o <= at)).map_or(rest, |next| next - at),
                Some(_) if offsets.len() == 1 => rest,
                Some(_) => 0,
            };
            // No compression makes a strip larger than this.
            let most = packed.saturating_mul(8) + (1 << 16);
            let most = if self.compression == Compression::OldJpeg { rest } else { most };
            place.bytes.1 = length.min(rest).min(most);
            chunks.push(place);
        }
        Ok(chunks)
    }

    /// Bytes of a row of a strip or tile.
    fn stride(&self, place: &Place) -> usize {
        (place.size[0] * self.chunk_samples() * self.storage.bits).div_ceil(8)
    }

    /// Bytes of a strip or tile after decompression.
    fn packed_length(&self, place: &Place) -> usize {
        let [across, down] = self.subsampling;
        match self.subsampling {
            [1, 1] => self.stride(place) * place.size[1],
            _ => place.size[0].div_ceil(across) * place.size[1].div_ceil(down) * (across * down + 2),
        }
    }

    fn jpeg(&self, tables: &[u8], bytes: &[u8], place: &Place) -> Result<Vec<u8>, String> {
        let count = self.chunk_samples();
        let [columns, rows] = [place.size[0], self.chunk[1].max(place.size[1])];
        let most = (columns + 64).saturating_mul(rows + 64).saturating_mul(count);
        let picture = jpeg::decode(tables, bytes, most)?;
        if picture.components != count {
            return Err(format!("the JPEG inside has {} samples for each pixel", picture.components));
        }
        cut(&picture.samples, picture.size, count, place.size)
    }

    fn webp(&self, bytes: &[u8], place: &Place) -> Result<Vec<u8>, String> {
        let decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
        let (width, height) = decoder.dimensions();
        let size = [width as usize, height as usize];
        let count = usize::from(decoder.color_type().channel_count());
        if size[0] > place.size[0] + 64 || size[1] > self.chunk[1].max(place.size[1]) + 64 {
            return Err("the WebP inside is larger than its tile".into());
        }
        let mut samples = vec![0; size[0] * size[1] * count];
        decoder.read_image(&mut samples).map_err(|e| e.to_string())?;
        match (count, self.chunk_samples()) {
            (a, b) if a == b => {}
            (3, 4) => {
                samples = samples.as_chunks::<3>().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect()
            }
            (4, 3) => {
                samples = samples.as_chunks::<4>().0.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect()
            }
            _ => return Err(format!("the WebP inside has {count} samples for each pixel")),
        }
        cut(&samples, size, self.chunk_samples(), place.size)
    }

    /// Puts the samples of a strip or tile into the image.
    fn place(&self, out: &mut Codes, place: &Place, bytes: &[u8]) {
        let count = self.chunk_samples();
        let expanded = (self.subsampling != [1, 1]).then(|| self.expanded(place, bytes));
        let stride = self.stride(place);
        let columns = place.size[0].min(self.size[0] - place.at[0]);
        let rows = place.size[1].min(self.size[1] - place.at[1]);
        let mut line = Vec::new();
        let lines = expanded.as_deref().unwrap_or(bytes).chunks_exact(stride);
        let (mut codes, mut numbers) = (Vec::new(), Vec::new());
        for (y, row) in lines.enumerate().take(rows) {
            line.clear();
            line.extend_from_slice(row);
            self.storage.restore(&mut line, count);
            let at = ((place.at[1] + y) * self.size[0] + place.at[0]) * self.count;
            match out {
                Codes::Byte(out) => {
                    codes.clear();
                    self.storage.codes(&line, count, |code| codes.push(code));
                    self.put(&mut out[at..], &codes[..columns * count], place, |c| c as u8);
                }
                Codes::Short(out) => {
                    codes.clear();
                    self.storage.codes(&line, count, |code| codes.push(code));
                    self.put(&mut out[at..], &codes[..columns * count], place, |c| c);
                }
                Codes::Float(out) => {
                    numbers.clear();
                    self.storage.numbers(&line, count, |v| numbers.push(v));
                    self.put(&mut out[at..], &numbers[..columns * count], place, |v| v);
                }
            }
        }
    }

    fn put<A: Copy, B>(&self, out: &mut [B], samples: &[A], place: &Place, convert: impl Fn(A) -> B) {
        match place.plane {
            None => out.iter_mut().zip(samples).for_each(|(to, &from)| *to = convert(from)),
            Some(plane) => {
                let pixels = out.iter_mut().skip(plane).step_by(self.count);
                pixels.zip(samples).for_each(|(to, &from)| *to = convert(from));
            }
        }
    }

    /// Subsampled YCbCr with a chroma for each pixel.
    fn expanded(&self, place: &Place, bytes: &[u8]) -> Vec<u8> {
        let [across, down] = self.subsampling;
        let [columns, rows] = place.size;
        let block = across * down + 2;
        let blocks = columns.div_ceil(across);
        let mut out = vec![0; columns * rows * 3];
        for (i, pixel) in out.chunks_exact_mut(3).enumerate() {
            let (x, y) = (i % columns, i / columns);
            let at = (y / down * blocks + x / across) * block;
            let luma = at + y % down * across + x % across;
            pixel.copy_from_slice(&[bytes[luma], bytes[at + block - 2], bytes[at + block - 1]]);
        }
        out
    }

    /// The samples as the layout says.
    fn converted(&self, stored: Codes) -> Codes {
        if let Photometric::Grey { inverted: true } = self.photometric {
            return self.inverted(stored);
        }
        if self.photometric.stored() {
            return stored;
        }
        let max = match self.photometric {
            Photometric::Palette(..) => 1.0,
            _ => self.storage.max(),
        };
        let (own, channels) = (self.photometric.samples(), self.layout.channels.len());
        let mut pixel = vec![0.0; self.count];
        let mut convert = |stored: &dyn Fn(usize) -> f64, at: usize, put: &mut dyn FnMut(f64)| {
            (0..self.count).for_each(|i| pixel[i] = stored(at * self.count + i));
            self.photometric.convert(&pixel[..own]).into_iter().for_each(&mut *put);
            // Extra samples are 0 to 1 as well; beside a palette they are codes.
            let most =
                if max == 1.0 && self.storage.kind == Kind::Unsigned { self.storage.max() } else { 1.0 };
            pixel[own..].iter().for_each(|v| put(v / most));
        };
        let sample: Box<dyn Fn(usize) -> f64> = match stored {
            Codes::Byte(codes) => Box::new(move |i| f64::from(codes[i]) / max),
            Codes::Short(codes) => Box::new(move |i| f64::from(codes[i]) / max),
            Codes::Float(numbers) => Box::new(move |i| f64::from(numbers[i])),
        };
        let pixels = self.size[0] * self.size[1];
        match self.layout.decoded {
            Decoded::Byte(most) => {
                let mut out = Vec::with_capacity(pixels * channels);
                let mut put = |v: f64| out.push((v * f64::from(most) + 0.5) as u8);
                (0..pixels).for_each(|i| convert(&*sample, i, &mut put));
                Codes::Byte(out)
            }
            Decoded::Short(most) => {
                let mut out = Vec::with_capacity(pixels * channels);
                let mut put = |v: f64| out.push((v * f64::from(most) + 0.5) as u16);
                (0..pixels).for_each(|i| convert(&*sample, i, &mut put));
                Codes::Short(out)
            }
            Decoded::Float => {
                let mut out = Vec::with_capacity(pixels * channels);
                let mut put = |v: f64| out.push(v as f32);
                (0..pixels).for_each(|i| convert(&*sample, i, &mut put));
                Codes::Float(out)
            }
        }
    }

    /// Grey of which 0 is white, the other way round; other samples stay.
    fn inverted(&self, stored: Codes) -> Codes {
        let step = self.count;
        let max = self.storage.max();
        match stored {
            Codes::Byte(mut codes) => {
                codes.iter_mut().step_by(step).for_each(|c| *c = max as u8 - *c);
                Codes::Byte(codes)
            }
            Codes::Short(mut codes) => {
                codes.iter_mut().step_by(step).for_each(|c| *c = max as u16 - *c);
                Codes::Short(codes)
            }
            Codes::Float(mut numbers) => {
                numbers.iter_mut().step_by(step).for_each(|v| *v = 1.0 - *v);
                Codes::Float(numbers)
            }
        }
    }
}

fn zeros<T: Clone + Default>(count: usize) -> Option<Vec<T>> {
    let mut list = Vec::new();
    list.try_reserve_exact(count).ok()?;
    list.resize(count, T::default());
    Some(list)
}

/// The upper left part of a picture of bytes, of this size.
fn cut(samples: &[u8], from: [usize; 2], count: usize, to: [usize; 2]) -> Result<Vec<u8>, String> {
    if from == to {
        return Ok(samples.to_vec());
    }
    if from[0] < to[0] || from[1] < to[1] {
        return Err(format!(
            "the picture inside has {} x {} pixels, less than {} x {}",
            from[0], from[1], to[0], to[1]
        ));
    }
    let rows = samples.chunks_exact(from[0] * count).take(to[1]);
    Ok(rows.flat_map(|row| &row[..to[0] * count]).copied().collect())
}
