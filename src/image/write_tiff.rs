//! TIFF files: RGB of 8 or 16 bits or 32-bit floats, and alpha, which a tag describes.

use std::borrow::Cow;
use std::io::{Seek, Write};
use tiff::TiffResult;
use tiff::encoder::colortype::{ColorType, RGB8, RGB16, RGB32Float, RGBA8, RGBA16, RGBA32Float};
use tiff::encoder::{TiffEncoder, TiffKind, TiffValue};
use tiff::tags::{ExtraSamples, Tag};

/// Beyond this many bytes of pixels a file is written as a BigTIFF, with a margin for the directory.
const MAX_CLASSIC: usize = (u32::MAX as usize) - (1 << 20);

/// Writes a picture of 3 components, or of 4 where `alpha` says what the fourth is.
pub(super) fn write(
    out: impl Write + Seek,
    size: [usize; 2],
    bits: u8,
    alpha: Option<ExtraSamples>,
    samples: &[u8],
) -> TiffResult<()> {
    match samples.len() > MAX_CLASSIC {
        true => encode(TiffEncoder::new_big(out)?, size, bits, alpha, samples),
        false => encode(TiffEncoder::new(out)?, size, bits, alpha, samples),
    }
}

fn encode<K: TiffKind>(
    mut encoder: TiffEncoder<impl Write + Seek, K>,
    size: [usize; 2],
    bits: u8,
    alpha: Option<ExtraSamples>,
    samples: &[u8],
) -> TiffResult<()> {
    match (bits, alpha) {
        (8, None) => image::<RGB8, _>(&mut encoder, size, alpha, samples),
        (8, Some(_)) => image::<RGBA8, _>(&mut encoder, size, alpha, samples),
        (16, None) => image::<RGB16, _>(&mut encoder, size, alpha, &numbers(samples)),
        (16, Some(_)) => image::<RGBA16, _>(&mut encoder, size, alpha, &numbers(samples)),
        (_, None) => image::<RGB32Float, _>(&mut encoder, size, alpha, &numbers(samples)),
        (_, Some(_)) => image::<RGBA32Float, _>(&mut encoder, size, alpha, &numbers(samples)),
    }
}

/// The bytes as numbers, where they lie if they lie well.
fn numbers<T: bytemuck::Pod>(bytes: &[u8]) -> Cow<'_, [T]> {
    bytemuck::try_cast_slice(bytes)
        .map_or_else(|_| Cow::Owned(bytemuck::pod_collect_to_vec(bytes)), Cow::Borrowed)
}

fn image<C: ColorType, K: TiffKind>(
    encoder: &mut TiffEncoder<impl Write + Seek, K>,
    [width, height]: [usize; 2],
    alpha: Option<ExtraSamples>,
    samples: &[C::Inner],
) -> TiffResult<()>
where
    [C::Inner]: TiffValue,
{
    let mut image = encoder.new_image::<C>(width as u32, height as u32)?;
    if let Some(alpha) = alpha {
        image.encoder().write_tag(Tag::ExtraSamples, &[alpha.to_u16()][..])?;
    }
    image.write_data(samples)
}
