//! Files that lie, or are cut short: an error each, and never a panic.

use super::*;

/// Small files of every kind.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    use exr::prelude::Compression as Packed;
    let mut list = Vec::new();
    let packings = [
        Packed::Uncompressed,
        Packed::RLE,
        Packed::ZIP16,
        Packed::PIZ,
        Packed::PXR24,
        Packed::B44,
        Packed::DWAA(None),
        Packed::DWAB(None),
    ];
    for compression in packings {
        let mut one = part(None, (13, 9), &["point.x", "point.y", "point.z", "surface"]);
        one.compression = compression;
        one.channels[0].1 = FlatSamples::F16(vec![half::f16::from_f32(0.3); 13 * 9]);
        list.push(("a.exr", exr_bytes(vec![one], (13, 9))));
    }
    let mut tiled = part(Some("N"), (13, 9), &["X", "Y", "Z"]);
    tiled.blocks = Blocks::Tiles(Vec2(4, 4));
    list.push(("a.exr", exr_bytes(vec![part(Some("rgb"), (13, 9), &["R", "G", "B"]), tiled], (13, 9))));
    // Subsampled channels, and luminance and chroma.
    for name in ["luminance_chroma_420_zip", "rgb_with_half_mask"] {
        let path = format!("{}/tests/exr/{name}.exr", env!("CARGO_MANIFEST_DIR"));
        list.push(("a.exr", std::fs::read(path).unwrap()));
    }
    let planes =
        (0..4).map(|c| Cow::Owned((0..117).map(|i| (i * (c + 1) % 100) as f32 / 100.0).collect())).collect();
    let variables = vec![Variable { name: "color".into(), shape: Shape::Vector(4), planes }];
    let image = Image { width: 13, height: 9, variables, metadata: Metadata::default() };
    for (name, format) in [
        ("a.png", Format::Png),
        ("a.jpg", Format::Jpeg),
        ("a.tif", Format::Tiff),
        ("a.hdr", Format::Hdr),
        ("a.bmp", Format::Bmp),
        ("a.tga", Format::Tga),
        ("a.webp", Format::Webp),
    ] {
        list.push((name, encode(name, format, &image, &WriteOptions::default()).unwrap()));
    }
    list
}

/// Reads all there is; damage may also go unnoticed, but must not panic.
fn try_all(name: &str, bytes: Vec<u8>) -> Result<(), ImageError> {
    let file = read(Input::from_bytes(name, bytes), &ReadOptions::default())?;
    file.load_all()?;
    info(&file).map(|about| drop(about.to_string()))
}

/// A small generator of its own, so that a failure comes again.
fn next(state: &mut u64) -> usize {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*state >> 33) as usize
}

#[test]
fn flipped_bits_never_panic() {
    let mut state = 1;
    for (name, bytes) in samples() {
        assert!(try_all(name, bytes.clone()).is_ok(), "{name} is whole");
        for round in 0..300 {
            let mut bad = bytes.clone();
            for _ in 0..=round % 4 {
                // Every other flip goes to the header, where the sizes are.
                let range = if round % 2 == 0 { bad.len() } else { bad.len().min(500) };
                let at = next(&mut state) % range;
                bad[at] ^= 1 << (next(&mut state) % 8);
            }
            let _ = try_all(name, bad);
        }
    }
}

#[test]
fn truncated_files_never_panic() {
    for (name, bytes) in samples() {
        let step = (bytes.len() / 150).max(1);
        for length in (0..bytes.len()).step_by(step) {
            let result = try_all(name, bytes[..length].to_vec());
            // Of an EXR every byte counts; the others may end in bytes that nobody needs.
            assert!(name != "a.exr" || result.is_err(), "{name} cut to {length} of {} bytes", bytes.len());
        }
    }
}

#[test]
fn absurd_sizes_are_refused() {
    // A data window of 2^29 square in a small file.
    let bytes = exr_bytes(vec![part(None, (2, 2), &["surface"])], (2, 2));
    let at = bytes.windows(10).position(|w| w == b"dataWindow").unwrap() + 10 + 1 + 6 + 4;
    let mut bad = bytes.clone();
    bad[at + 8..at + 12].copy_from_slice(&(1i32 << 29).to_le_bytes());
    bad[at + 12..at + 16].copy_from_slice(&(1i32 << 29).to_le_bytes());
    let error = try_all("a.exr", bad).unwrap_err();
    assert_eq!(error.kind, ErrorKind::TooLarge, "{error}");
    let mut png = samples().into_iter().find(|s| s.0 == "a.png").unwrap().1;
    png[16..20].copy_from_slice(&0x4000_0000u32.to_be_bytes());
    png[20..24].copy_from_slice(&0x4000_0000u32.to_be_bytes());
    assert!(try_all("a.png", png).is_err());
}

#[test]
fn deep_and_foreign_files_say_so() {
    let bytes = exr_bytes(vec![part(Some("a"), (2, 2), &["Z"]), part(Some("b"), (2, 2), &["A"])], (2, 2));
    let text = b"scanlineimage";
    let mut deep = bytes.clone();
    let size = text.len() as i32;
    for i in 0..bytes.len() - text.len() {
        if bytes[i..].starts_with(text) {
            assert_eq!(deep[i - 4..i], size.to_le_bytes());
            deep[i..i + 13].copy_from_slice(b"deepscanline\0");
            deep[i - 4..i].copy_from_slice(&12i32.to_le_bytes());
        }
    }
    // The padding byte would end the header; take it out.
    let mut packed = Vec::new();
    let mut i = 0;
    while i < deep.len() {
        if deep[i..].starts_with(b"deepscanline\0") {
            packed.extend(b"deepscanline");
            i += 13;
        } else {
            packed.push(deep[i]);
            i += 1;
        }
    }
    let error = try_all("deep.exr", packed).unwrap_err();
    assert!(error.message.contains("deep data"), "{error}");
    assert_eq!(try_all("a.txt", b"hello, world".to_vec()).unwrap_err().kind, ErrorKind::UnknownFormat);
    assert_eq!(try_all("a.exr", Vec::new()).unwrap_err().kind, ErrorKind::Damaged);
    let missing = read(Input::Path("no/such/file.exr".into()), &ReadOptions::default()).err().unwrap();
    assert_eq!(missing.message, "cannot read `no/such/file.exr`: there is no such file");
}
