//! PNG files, row by row.

use super::error::ImageError;
use super::stamp::{NAME, SOFTWARE, SOFTWARE_KEYWORD};
use super::write::unwritable;
use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// A PNG that is written from the top down.
pub(super) struct PngWriter {
    name: String,
    rows: png::StreamWriter<'static, Packed>,
    packed: Packed,
    /// Bytes of a component.
    wide: bool,
}

/// What the encoder has made and nobody has taken yet.
#[derive(Clone, Default)]
struct Packed(Arc<Mutex<Vec<u8>>>);

impl Packed {
    fn take(&self) -> Vec<u8> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Write for Packed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl PngWriter {
    /// Begins a picture of RGB, or with alpha, of 8 or 16 bits; `stamp` goes behind the header.
    pub fn new(
        name: &str,
        size: [usize; 2],
        alpha: bool,
        bits: u8,
        stamp: Option<&str>,
    ) -> Result<PngWriter, ImageError> {
        let packed = Packed::default();
        let mut encoder = png::Encoder::new(packed.clone(), size[0] as u32, size[1] as u32);
        encoder.set_color(if alpha { png::ColorType::Rgba } else { png::ColorType::Rgb });
        encoder.set_depth(if bits == 16 { png::BitDepth::Sixteen } else { png::BitDepth::Eight });
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::Filter::Adaptive);
        if let Some(stamp) = stamp {
            encoder.add_text_chunk(NAME.into(), stamp.into()).map_err(|e| unwritable(name, e))?;
        }
        // Behind the stamp: both are looked for among the first chunks.
        encoder.add_text_chunk(SOFTWARE_KEYWORD.into(), SOFTWARE.into()).map_err(|e| unwritable(name, e))?;
        let rows = encoder.write_header().and_then(|writer| writer.into_stream_writer_with_size(CHUNK));
        let rows = rows.map_err(|e| unwritable(name, e))?;
        Ok(PngWriter { name: name.into(), rows, packed, wide: bits == 16 })
    }

    /// Adds rows: codes in the machine's byte order.
    pub fn rows(&mut self, codes: &[u8], out: &mut impl Write) -> Result<(), ImageError> {
        let written = match self.wide {
            false => self.rows.write_all(codes),
            true => {
                let (pairs, _) = codes.as_chunks::<2>();
                let big = pairs.iter().flat_map(|&pair| u16::from_ne_bytes(pair).to_be_bytes());
                self.rows.write_all(&big.collect::<Vec<u8>>())
            }
        };
        written.map_err(|e| unwritable(&self.name, e))?;
        out.write_all(&self.packed.take()).map_err(|e| ImageError::io("write", &self.name, &e))
    }

    /// Ends the file.
    pub fn finish(self, out: &mut impl Write) -> Result<(), ImageError> {
        self.rows.finish().map_err(|e| unwritable(&self.name, e))?;
        out.write_all(&self.packed.take()).map_err(|e| ImageError::io("write", &self.name, &e))
    }
}

/// Bytes of a chunk of the file.
const CHUNK: usize = 1 << 16;
