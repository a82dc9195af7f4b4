//! A few rows at a time come to the same as all at once.

use super::*;

/// Names and bits of an image.
fn content(image: &Image<'_>) -> Vec<(String, Vec<Vec<u32>>)> {
    let bits = |p: &Cow<'_, [f32]>| p.iter().map(|v| v.to_bits()).collect();
    image.variables.iter().map(|v| (v.name.clone(), v.planes.iter().map(bits).collect())).collect()
}

/// Reads a file in bands of these heights, one after the other until its end, each with a row more about it.
fn in_bands(file: &File, heights: &[usize]) {
    let names: Vec<&str> = file.variables().iter().filter(|b| !b.alias).map(|b| b.name.as_str()).collect();
    let whole = file.load(&names).unwrap();
    let [width, height] = file.size();
    let mut rows = file.rows(&names).unwrap();
    let mut top = 0;
    for band in heights.iter().cycle() {
        let bottom = height.min(top + band);
        let with = top.saturating_sub(1)..height.min(bottom + 1);
        let part = rows.read(with.clone()).unwrap();
        assert_eq!((part.width, part.height), (width, with.len()));
        assert_eq!(part.resolution(), whole.resolution());
        assert_eq!(part.metadata.origin[1], whole.metadata.origin[1] + with.start as i32);
        let pixels = with.start * width..with.end * width;
        for ((name, planes), (other, expected)) in content(&part).iter().zip(content(&whole)) {
            assert_eq!(*name, other);
            for (plane, expected) in planes.iter().zip(expected) {
                assert_eq!(plane, &expected[pixels.clone()], "{name} in rows {with:?}");
            }
        }
        top = bottom;
        if top == height {
            break;
        }
    }
}

#[test]
fn reading() {
    use exr::prelude::Compression::*;
    let mut files = Vec::new();
    for compression in [Uncompressed, ZIP1, ZIP16, PIZ] {
        for order in [LineOrder::Increasing, LineOrder::Decreasing] {
            for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(8, 5))] {
                let mut one = part(Some("rgb"), (23, 71), &["R", "G", "B"]);
                (one.compression, one.blocks) = (compression, blocks);
                one.order = order;
                // Another part, lower and to the side.
                let mut other = part(Some("N"), (9, 33), &["X", "Y", "Z"]);
                other.origin = (11, 60);
                files.push(open(exr_bytes(vec![one, other], (23, 71))));
            }
        }
    }
    let plain = part(None, (20, 50), &["R", "G", "B"]);
    let image = open(exr_bytes(vec![plain], (20, 50))).load_all().unwrap();
    let png = encode("a.png", Format::Png, &image, &WriteOptions::default()).unwrap();
    files.push(open(png));
    for file in &files {
        for heights in [&[1][..], &[7], &[16], &[32, 3], &[50, 1, 1], &[1000]] {
            in_bands(file, heights);
        }
    }
}

#[test]
fn reading_from_the_middle() {
    let file = open(exr_bytes(vec![part(None, (20, 100), &["R", "G", "B"])], (20, 100)));
    let whole = file.load(&["color"]).unwrap();
    let mut rows = file.rows(&["color"]).unwrap();
    for band in [37..39, 38..55, 90..100] {
        let part = rows.read(band.clone()).unwrap();
        let pixels = band.start * 20..band.end * 20;
        assert_eq!(part.variables[0].planes[1][..], whole.variables[0].planes[1][pixels]);
    }
}

#[test]
fn writing() {
    let file = open(exr_bytes(vec![part(None, (20, 100), &["R", "G", "B", "A", "Z"])], (20, 100)));
    let mut whole = file.load_all().unwrap();
    whole.metadata.origin = [2, 3];
    whole.metadata.resolution = Some([40, 120]);
    let directory = tempfile::tempdir().unwrap();
    for (name, compression) in [
        ("a.exr", Compression::Zip),
        ("b.exr", Compression::None),
        ("c.exr", Compression::Piz),
        ("d.png", Compression::Zip),
    ] {
        let path = directory.path().join(name);
        let options = WriteOptions { compression, ..WriteOptions::default() };
        let expected = encode(name, Format::of(&path).unwrap(), &whole, &options).unwrap();
        for height in [1, 5, 16, 33, 99, 100] {
            let mut rows = file.rows(&["color", "alpha", "depth"]).unwrap();
            let mut writer = Writer::create(&path, 100, &options).unwrap();
            for top in (0..100).step_by(height) {
                assert!(!path.exists(), "a file appears when it is whole");
                let mut band = rows.read(top..100.min(top + height)).unwrap();
                band.metadata = whole.metadata.clone();
                band.metadata.origin[1] += top as i32;
                writer.rows(&band).unwrap();
            }
            writer.finish().unwrap();
            assert!(std::fs::read(&path).unwrap() == expected, "{name} in bands of {height}");
            std::fs::remove_file(&path).unwrap();
        }
    }
    let mut writer = Writer::create(&directory.path().join("e.exr"), 100, &WriteOptions::default()).unwrap();
    writer.rows(&file.rows(&["color"]).unwrap().read(0..40).unwrap()).unwrap();
    assert!(writer.finish().unwrap_err().message.contains("40 rows of 100"));
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0, "nothing is left behind");
}
