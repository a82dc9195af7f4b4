//! A small picture of each kind of file that is read, in `tests/kinds`, against the numbers from which it was made.

use super::*;
use std::fs;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/kinds")
}

#[test]
fn pictures_of_every_kind_have_the_right_numbers() {
    let expected = fs::read_to_string(folder().join("expected.txt")).unwrap();
    let mut faults = Vec::new();
    let mut lines = expected.lines().peekable();
    let mut files = 0;
    while let Some(head) = lines.next() {
        let words: Vec<&str> = head.split(' ').collect();
        let [name, width, height, tolerance, alpha] = words[..] else { panic!("{head}") };
        let pixels: Vec<Vec<f64>> =
            std::iter::from_fn(|| lines.next_if(|l| l.starts_with(|c: char| c.is_ascii_digit())))
                .map(|line| line.split(' ').map(|n| n.parse().unwrap()).collect())
                .collect();
        files += 1;
        let size = [width, height].map(|n| n.parse::<usize>().unwrap());
        let tolerance: f64 = tolerance.parse().unwrap();
        if let Some(fault) = compare(name, size, tolerance, alpha == "alpha", &pixels) {
            faults.push(format!("{name}: {fault}"));
        }
    }
    assert!(files > 90, "{files}");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

fn compare(name: &str, size: [usize; 2], tolerance: f64, alpha: bool, pixels: &[Vec<f64>]) -> Option<String> {
    let file = match read(Input::Path(folder().join(name)), &ReadOptions::default()) {
        Ok(file) => file,
        Err(error) => return Some(error.message),
    };
    if file.size() != size || file.find("alpha").is_ok() != alpha {
        return Some(format!("{:?}, alpha {}", file.size(), file.find("alpha").is_ok()));
    }
    let names: &[&str] = if alpha { &["color", "alpha"] } else { &["color"] };
    let image = match file.load(names) {
        Ok(image) => image,
        Err(error) => return Some(error.message),
    };
    if let Err(error) = info(&file) {
        return Some(error.message);
    }
    let planes: Vec<&[f32]> = image.variables.iter().flat_map(|v| &v.planes).map(|p| &**p).collect();
    for pixel in pixels {
        let at = pixel[1] as usize * size[0] + pixel[0] as usize;
        for (plane, expected) in planes.iter().zip(&pixel[2..]) {
            let found = f64::from(plane[at]);
            if (found - expected).abs() > tolerance * expected.abs().max(1.0) {
                let all: Vec<f32> = planes.iter().map(|p| p[at]).collect();
                return Some(format!("{all:?} is not {pixel:?}"));
            }
        }
    }
    None
}

#[test]
fn rows_and_the_whole_agree() {
    for name in ["turned_6.tif", "turned_3.png", "alpha_multiplied_8.tif", "grey12.tif", "packed_tiled.tif"] {
        let file = read(Input::Path(folder().join(name)), &ReadOptions::default()).unwrap();
        let whole = file.load(&["color"]).unwrap();
        let mut rows = file.rows(&["color"]).unwrap();
        let [width, height] = file.size();
        for y in 0..height {
            let row = rows.read(y..y + 1).unwrap();
            for (a, b) in row.variables[0].planes.iter().zip(&whole.variables[0].planes) {
                assert_eq!(a[..], b[y * width..(y + 1) * width], "{name}, row {y}");
            }
        }
    }
}

#[test]
fn raw_pictures_stay_as_they_are_stored() {
    let options = ReadOptions { raw: true, ..Default::default() };
    for (name, size, note) in [
        ("turned_6.tif", [7, 5], "is not applied, because of --raw"),
        ("turned_6.jpg", [20, 24], "is not applied, because of --raw"),
        ("alpha_multiplied_8.tif", [7, 5], "already multiplied"),
    ] {
        let file = read(Input::Path(folder().join(name)), &options).unwrap();
        assert_eq!(file.size(), size, "{name}");
        assert!(info(&file).unwrap().to_string().contains(note), "{name}");
    }
    let plain = read(Input::Path(folder().join("turned_6.jpg")), &ReadOptions::default()).unwrap();
    assert_eq!(plain.size(), [24, 20]);
    let text = info(&plain).unwrap().to_string();
    assert!(
        text.contains("Orientation 6 of the file is applied: its 20 x 24 pixels are rotated by 90 degrees"),
        "{text}"
    );
    let file = read(Input::Path(folder().join("alpha_multiplied_16.tif")), &options).unwrap();
    let image = file.load(&["color"]).unwrap();
    let bytes = fs::read(folder().join("alpha_multiplied_16.tif")).unwrap();
    let first = image.variables[0].planes[0][4] * 65535.0;
    let stored = first.round() as u16;
    assert!(
        bytes.windows(2).any(|pair| pair == stored.to_le_bytes()) && (first - first.round()).abs() < 0.01
    );
}

#[test]
fn further_samples_are_variables() {
    let file = read(Input::Path(folder().join("float32_ten_samples.tif")), &ReadOptions::default()).unwrap();
    let image = file.load(&["color", "sample2", "sample10"]).unwrap();
    assert_eq!(image.variables.len(), 3);
    assert!(image.variables[1].planes[0] != image.variables[2].planes[0]);
}

#[test]
fn every_cut_is_noticed() {
    // So many bytes at the end are of no pixel: checksums, marks, filling.
    for (name, spare) in [
        ("turned_3.jpg", 2),
        ("turned_3.png", 4),
        ("turned_5_text.png", 4),
        ("turned_3.webp", 0),
        ("tga_packed.tga", 0),
        ("tga_16_20.tga", 0),
        ("os2_2.bmp", 0),
        ("rgbe.hdr", 0),
        ("rgbe_upwards.hdr", 0),
        ("float32_rgb.tif", 0),
        ("fax_g4.tif", 4),
        ("packed_lzw.tif", 1),
        ("packed_zstd.tif", 0),
        ("packed_webp.tif", 0),
        ("packed_deflate.tif", 5),
        ("jpeg_tables.tif", 0),
        ("old_jpeg_stream.tif", 0),
    ] {
        let bytes = fs::read(folder().join(name)).unwrap();
        for length in 0..bytes.len() - spare {
            let read = read(Input::from_bytes(name, &bytes[..length]), &ReadOptions::default());
            let loaded = read.and_then(|file| file.load(&["color"]).map(drop));
            assert!(loaded.is_err(), "{name} cut to {length} of {} bytes", bytes.len());
        }
    }
}

#[test]
fn what_is_not_read_is_named() {
    let bytes = fs::read(folder().join("packed_packbits.tif")).unwrap();
    // The value of a tag of one short number.
    let with = |tag: u16, value: u16| {
        let mut bytes = bytes.clone();
        let at =
            bytes.windows(8).rposition(|w| w[..2] == tag.to_le_bytes() && w[4..] == [1, 0, 0, 0]).unwrap();
        bytes[at + 8..at + 10].copy_from_slice(&value.to_le_bytes());
        read(Input::from_bytes("a.tif", bytes), &ReadOptions::default()).err().map(|e| e.message)
    };
    for (tag, value, words) in [
        (259, 34712, "JPEG 2000 compression"),
        (259, 34887, "LERC compression"),
        (259, 1234, "number 1234 compression"),
        (262, 32803, "raw samples of a camera's sensor"),
        (262, 99, "photometric interpretation 99"),
    ] {
        let message = with(tag, value).unwrap_or_default();
        assert!(
            message.contains(words) && message.starts_with("`a.tif` cannot be read: TIFF with"),
            "{message}"
        );
    }
}

#[test]
fn damage_never_panics() {
    let mut state = 7u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % below
    };
    let mut paths: Vec<PathBuf> = fs::read_dir(folder()).unwrap().map(|e| e.unwrap().path()).collect();
    paths.retain(|path| !path.extension().is_some_and(|e| e == "txt" || e == "py"));
    paths.sort();
    for path in paths {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let bytes = fs::read(&path).unwrap();
        for round in 0..60 {
            let mut bad = bytes.clone();
            for _ in 0..=round % 4 {
                let at = next(bad.len());
                bad[at] ^= 1 << next(8);
            }
            if round % 5 == 0 {
                bad.truncate(next(bytes.len()));
            }
            let read = read(Input::from_bytes(&name, bad), &ReadOptions::default());
            let _ = read.and_then(|file| file.load_all().map(drop));
        }
    }
}

#[test]
fn a_short_strip_is_noticed() {
    for name in ["jpeg_tables.tif", "packed_lzw.tif", "fax_g3.tif"] {
        let mut bytes = fs::read(folder().join(name)).unwrap();
        let tag = |w: &[u8]| w[..2] == 279u16.to_le_bytes() && w[4..] == [1, 0, 0, 0];
        let at = bytes.windows(8).position(tag).unwrap() + 8;
        let half = u16::from_le_bytes([bytes[at], bytes[at + 1]]) / 2;
        bytes[at..at + 2].copy_from_slice(&half.to_le_bytes());
        let error = read(Input::from_bytes(name, bytes), &ReadOptions::default())
            .and_then(|file| file.load(&["color"]).map(drop))
            .expect_err(name);
        assert!(error.message.contains("strip 1 of 1: "), "{error}");
    }
}
