//! Parts, windows, sample types and compressions.

use super::*;
use exr::prelude::Compression as Packed;

#[test]
fn the_parts_name_carries_the_layer() {
    let parts = vec![
        part(Some("rgba"), (2, 2), &["R", "G", "B", "A"]),
        part(Some("surface"), (2, 2), &["surface"]),
        part(Some("point"), (2, 2), &["x", "y", "z"]),
        part(
            Some("ViewLayer.Normal"),
            (2, 2),
            &["ViewLayer.Normal.X", "ViewLayer.Normal.Y", "ViewLayer.Normal.Z"],
        ),
        part(Some("ViewLayer"), (2, 2), &["UV.U", "UV.V"]),
        part(Some("depth"), (2, 2), &["Z"]),
    ];
    let file = open(exr_bytes(parts, (2, 2)));
    assert_eq!(channels_of(&file, "color"), ["rgba.R", "rgba.G", "rgba.B"]);
    assert_eq!(channels_of(&file, "alpha"), ["rgba.A"]);
    assert_eq!(channels_of(&file, "surface"), ["surface"]);
    assert_eq!(channels_of(&file, "point"), ["point.x", "point.y", "point.z"]);
    assert_eq!(channels_of(&file, "normal")[2], "ViewLayer.Normal.Z");
    assert_eq!(channels_of(&file, "uv"), ["ViewLayer.UV.U", "ViewLayer.UV.V"]);
    assert_eq!(channels_of(&file, "depth"), ["depth.Z"]);
}

#[test]
fn parts_with_different_windows_share_the_rectangle_around_them() {
    let mut small = part(Some("N"), (2, 1), &["X", "Y", "Z"]);
    small.origin = (-1, 1);
    let file = open(exr_bytes(vec![part(Some("main"), (3, 2), &["R", "G", "B"]), small], (3, 2)));
    assert_eq!(file.size(), [4, 2]);
    assert_eq!(file.metadata().origin, [-1, 0]);
    assert_eq!(file.metadata().resolution, Some([3, 2]));
    let file = mapped_color(file);
    let image = file.load(&["color", "normal"]).unwrap();
    // The numbers in the file are 1 2 3 for B G R, the order in which they lie.
    assert_eq!(image.variables[0].planes[2][..], [0.0, 3.0, 3.001, 3.002, 0.0, 3.003, 3.004, 3.005]);
    assert_eq!(image.variables[1].planes[0][..], [0.0, 0.0, 0.0, 0.0, 1.0, 1.001, 0.0, 0.0]);
}

/// The same file with `color` mapped to its group of an unknown name.
fn mapped_color(file: File) -> File {
    let options = ReadOptions { maps: vec!["color=main".parse().unwrap()], raw: false };
    read(file.input, &options).unwrap()
}

#[test]
fn every_compression_and_tiling() {
    let lossless = [Packed::Uncompressed, Packed::RLE, Packed::ZIP1, Packed::ZIP16, Packed::PIZ];
    let lossy = [Packed::PXR24, Packed::B44, Packed::B44A, Packed::DWAA(None), Packed::DWAB(None)];
    for (exact, compression) in lossless.map(|c| (true, c)).into_iter().chain(lossy.map(|c| (false, c))) {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 8))] {
            let mut one = part(None, (37, 41), &["point.x", "point.y", "point.z", "id"]);
            one.compression = compression;
            one.blocks = blocks;
            one.channels[3].1 = FlatSamples::U32((0..37 * 41).collect());
            one.channels[1].1 =
                FlatSamples::F16((0..37 * 41).map(|i| half::f16::from_f32(i as f32 / 64.0)).collect());
            let image = open(exr_bytes(vec![one], (37, 41))).load(&["surface", "point"]).unwrap();
            let close = |got: f32, want: f32| {
                if exact { got == want } else { (got - want).abs() < 0.05 * want + 0.1 }
            };
            for i in 0..37 * 41 {
                assert_eq!(image.variables[0].planes[0][i], i as f32, "{compression:?} {blocks:?}");
                let (x, y) = (image.variables[1].planes[0][i], image.variables[1].planes[1][i]);
                assert!(close(x, 1.0 + i as f32 / 1000.0), "{compression:?} {blocks:?}: {x}");
                let want = half::f16::from_f32(i as f32 / 64.0).to_f32();
                assert!(close(y, want), "{compression:?} {blocks:?}: {y} is not {want}");
            }
        }
    }
}

#[test]
fn info_tells_ranges_and_names() {
    let mut one = part(None, (2, 2), &["L.Position.X", "L.Position.Y", "L.Position.Z", "L.IndexOB.X"]);
    one.compression = Packed::DWAA(None);
    one.channels[0].1 = FlatSamples::F32(vec![f32::NAN, f32::INFINITY, -1.0, 3.0]);
    one.channels[3].1 = FlatSamples::F32(vec![0.0, 1.0, 1.5, 2.0]);
    let about = info(&open(exr_bytes(vec![one], (2, 2)))).unwrap();
    let x = about.channels.iter().find(|c| c.name == "L.Position.X").unwrap();
    assert_eq!((x.min, x.max, x.mean, x.nan, x.infinite), (-1.0, 3.0, 1.0, 1, 1));
    assert_eq!(x.variables, ["point.x", "(Position.x)"]);
    let text = about.to_string();
    assert!(text.contains("note: `surface` is not a whole number at 1 pixel"), "{text}");
    assert!(text.contains("L.Position.Y is not exact"), "{text}");
    assert!(text.contains("`surface` is 0 at 1 pixel"), "{text}");
}

/// The table of so many blocks, behind which the first of them begins.
fn table(bytes: &[u8], blocks: usize) -> std::ops::Range<usize> {
    let at = |place: usize| u64::from_le_bytes(bytes[place..place + 8].try_into().unwrap()) as usize;
    let start = (8..).find(|&place| at(place) == place + 8 * blocks).unwrap();
    start..start + 8 * blocks
}

#[test]
fn blocks_are_found_without_their_table() {
    for (blocks, count) in [(Blocks::ScanLines, 3), (Blocks::Tiles(Vec2(8, 8)), 25)] {
        let mut one = part(None, (37, 33), &["R", "G", "B"]);
        one.blocks = blocks;
        let good = exr_bytes(vec![one], (37, 33));
        let whole = open(good.clone()).load(&["color"]).unwrap();
        let mut bytes = good;
        let range = table(&bytes, count);
        bytes[range].fill(0);
        let found = open(bytes.clone()).load(&["color"]).unwrap();
        assert_eq!(found.variables[0].planes, whole.variables[0].planes);
        // A block that is not there is missed.
        let cut = bytes.len() - 20;
        let error = open(bytes[..cut].to_vec()).load(&["color"]).unwrap_err();
        assert!(error.message.contains("missing"), "{error}");
    }
}

#[test]
fn of_one_part_the_flags_say_how_it_is_stored() {
    let bytes = exr_bytes(vec![part(None, (2, 2), &["surface"])], (2, 2));
    let replaced = |bytes: &[u8], from: &[u8], to: &[u8]| {
        let at = bytes.windows(from.len()).position(|w| w == from).unwrap();
        [&bytes[..at], to, &bytes[at + from.len()..]].concat()
    };
    let odd = replaced(&bytes, b"scanlineimage", b"deepscanlines");
    assert_eq!(open(odd).load(&["surface"]).unwrap().variables[0].planes[0][..], [1.0, 1.001, 1.002, 1.003]);
    let parts = vec![part(Some("a"), (2, 2), &["surface"]), part(Some("b"), (2, 2), &["Z"])];
    let odd = replaced(&exr_bytes(parts, (2, 2)), b"scanlineimage", b"deepscanlines");
    let file = open(odd);
    assert!(file.load(&["depth"]).is_ok());
    let error = file.find("surface").err().unwrap();
    assert!(error.hints[0].contains("it is of an unknown type, `deepscanlines`"), "{:?}", error.hints);
    let text = info(&file).unwrap().to_string();
    assert!(text.contains("note: The part `a` is not read: it is of an unknown type"), "{text}");
}

#[test]
fn a_damaged_part_does_not_hide_the_others() {
    let parts =
        vec![part(Some("rgb"), (5, 40), &["R", "G", "B"]), part(Some("N"), (5, 40), &["X", "Y", "Z"])];
    let bytes = exr_bytes(parts, (5, 40));
    let file = open(bytes[..bytes.len() - 30].to_vec());
    assert!(file.load(&["color"]).is_ok());
    assert_eq!(file.load(&["normal"]).unwrap_err().kind, ErrorKind::Damaged);
    let text = info(&file).unwrap().to_string();
    assert!(text.contains("note: The part `N` cannot be read: ") && text.contains("rgb.R"), "{text}");
}
