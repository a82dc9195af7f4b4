//! A small image of every format, and a way to read whatever becomes of one.

use pse::image::{Compression, Format, ImageError, Input, ReadOptions, WriteOptions, encode, read};
use pse::{Image, Shape, Variable};

/// A small file of every kind that is written here, and some of other programs.
pub fn samples() -> Vec<(String, Vec<u8>)> {
    let plane = |c: usize| (0..13 * 9).map(|i| (i * (c + 1) % 100) as f32 / 100.0).collect::<Vec<f32>>();
    let color = Variable::new("color", Shape::Vector(4), (0..4).map(plane)).expect("four planes");
    let point = Variable::new("point", Shape::Vector(3), (0..3).map(plane)).expect("three planes");
    let image = Image::new(13, 9, [color, point]).expect("an image");
    let mut list = Vec::new();
    let mut add = |name: &str, format, options: WriteOptions| {
        list.push((name.to_string(), encode(name, format, &image, &options).expect(name)));
    };
    let plain = WriteOptions::default;
    for compression in
        [Compression::None, Compression::Rle, Compression::Zips, Compression::Zip, Compression::Piz]
    {
        add(&format!("{compression:?}.exr"), Format::Exr, WriteOptions { compression, ..plain() });
    }
    add("half.exr", Format::Exr, WriteOptions { half: true, ..plain() });
    for (name, format, bits) in [
        ("8.png", Format::Png, 8),
        ("16.png", Format::Png, 16),
        ("a.jpg", Format::Jpeg, 8),
        ("8.tif", Format::Tiff, 8),
        ("16.tif", Format::Tiff, 16),
        ("32.tif", Format::Tiff, 32),
        ("a.hdr", Format::Hdr, 32),
        ("a.bmp", Format::Bmp, 8),
        ("a.tga", Format::Tga, 8),
        ("a.webp", Format::Webp, 8),
    ] {
        add(name, format, WriteOptions { bits: Some(bits), ..plain() });
    }
    list
}

/// Reads all of it, a few rows at a time.
pub fn read_all(name: &str, bytes: &[u8]) -> Result<(), ImageError> {
    let file = read(Input::from_bytes(name, bytes), &ReadOptions::default())?;
    let plain = file.variables().iter().filter(|v| !v.alias && v.candidates.len() == 1);
    let names: Vec<&str> = plain.map(|v| v.name.as_str()).collect();
    let mut rows = file.rows(&names)?;
    let [width, height] = file.size();
    // What is believed to be large is read in part.
    for top in (0..height.min(1 << 12)).step_by(5) {
        let image = rows.read(top..height.min(top + 5))?;
        assert_eq!(image.width, width);
    }
    Ok(())
}
