//! Tests of the whole: reading, binding, writing.

mod damage;
mod gbuffers;
mod kinds;
mod many;
mod maps;
mod parts;
mod renderers;
mod round_trip;
mod rows;

use super::*;
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Layer};
use exr::prelude::{ImageAttributes, IntegerBounds, LayerAttributes, LineOrder, Vec2, WritableImage};
use std::io::Cursor;

/// A part for [`exr_bytes`].
struct Part {
    name: Option<&'static str>,
    view: Option<&'static str>,
    origin: (i32, i32),
    size: (usize, usize),
    compression: exr::prelude::Compression,
    blocks: Blocks,
    order: LineOrder,
    channels: Vec<(String, FlatSamples)>,
}

/// A one-channel-a-name part, each channel filled with its number (from 1) plus the pixel's number / 1000.
fn part(name: Option<&'static str>, size: (usize, usize), channels: &[&str]) -> Part {
    let fill = |i: usize| {
        let values = (0..size.0 * size.1).map(|p| (i + 1) as f32 + p as f32 / 1000.0);
        FlatSamples::F32(values.collect())
    };
    Part {
        name,
        view: None,
        origin: (0, 0),
        size,
        compression: exr::prelude::Compression::ZIP16,
        blocks: Blocks::ScanLines,
        order: LineOrder::Increasing,
        channels: channels.iter().enumerate().map(|(i, c)| (c.to_string(), fill(i))).collect(),
    }
}

/// An EXR file as other programs write them, by the `exr` crate's own writer.
fn exr_bytes(parts: Vec<Part>, display: (usize, usize)) -> Vec<u8> {
    let layers: Vec<Layer<AnyChannels<FlatSamples>>> = parts
        .into_iter()
        .map(|p| {
            let list = p.channels.into_iter().map(|(n, s)| AnyChannel::new(n.as_str(), s)).collect();
            let attributes = LayerAttributes {
                layer_name: p.name.map(|n| n.into()),
                view_name: p.view.map(|n| n.into()),
                layer_position: Vec2(p.origin.0, p.origin.1),
                ..LayerAttributes::default()
            };
            let encoding = Encoding { compression: p.compression, blocks: p.blocks, line_order: p.order };
            Layer::new(p.size, attributes, encoding, AnyChannels::sort(list))
        })
        .collect();
    let display = IntegerBounds::from_dimensions(display);
    let mut out = Cursor::new(Vec::new());
    exr::image::Image::from_layers(ImageAttributes::new(display), layers)
        .write()
        .to_buffered(&mut out)
        .unwrap();
    out.into_inner()
}

fn open(bytes: Vec<u8>) -> File {
    read(Input::from_bytes("test.exr", bytes), &ReadOptions::default()).unwrap()
}

/// A file with these channels in one part.
fn file_of(channels: &[&str]) -> File {
    open(exr_bytes(vec![part(None, (2, 2), channels)], (2, 2)))
}

/// The names of the channels that the variable is read from.
fn channels_of(file: &File, name: &str) -> Vec<String> {
    file.find(name).unwrap().channels.iter().map(|&c| file.channels()[c].name.clone()).collect()
}
