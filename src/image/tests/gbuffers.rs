//! The G-buffers of a real renderer, fifteen spellings of one scene: cut-outs that lie in `tests/gbuffers`,
//! and the whole files where they lie beside the repository.

use super::*;
use std::path::{Path, PathBuf};

fn load(path: &Path, names: &[&str]) -> Image<'static> {
    let file = read(Input::Path(path.to_path_buf()), &ReadOptions::default()).unwrap();
    file.load(names).unwrap_or_else(|e| panic!("{e}: {:?}", e.hints))
}

fn directory(relative: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(relative)
}

fn files(directory: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(directory) else { return Vec::new() };
    let mut list: Vec<PathBuf> = entries
        .filter_map(|e| Some(e.ok()?.path()))
        .filter(|p| p.extension().is_some_and(|e| e == "exr"))
        .collect();
    list.sort();
    list
}

/// How many pixels have each id from 0 to 4.
fn ids(image: &Image<'_>) -> [usize; 5] {
    let mut counts = [0; 5];
    for &id in image.variable("surface").unwrap().planes[0].iter() {
        if (0..5).any(|i| i as f32 == id) {
            counts[id as usize] += 1;
        }
    }
    counts
}

/// Points, normals and ids agree with the file of the same size that is exact, within what the
/// storage of each loses. `scale` files are compared where both have pixels.
fn agree(path: &Path, image: &Image<'_>, exact: &Image<'_>) {
    let name = path.file_name().unwrap().to_string_lossy();
    let point = match () {
        // The cut-out was compressed with loss a second time.
        _ if name.contains("dwaa") => 0.04,
        _ if name.contains("allhalf") => 0.0011,
        // Two versions of the renderer, whose arithmetic differs in the last bits.
        _ => 1e-4,
    };
    let filtered = name.contains("filtered") || name.contains("antialiased");
    let overscan = if name.contains("overscan") { [20, 10] } else { [0, 0] };
    let offset = [0, 1].map(|i| image.metadata.origin[i] + overscan[i] - exact.metadata.origin[i]);
    let mut compared = 0;
    for y in 0..image.height as i32 {
        for x in 0..image.width as i32 {
            let (ex, ey) = (x + offset[0], y + offset[1]);
            if ex < 0 || ey < 0 || ex >= exact.width as i32 || ey >= exact.height as i32 {
                continue;
            }
            let (i, j) = ((y as usize) * image.width + x as usize, ey as usize * exact.width + ex as usize);
            let of = |image: &Image<'_>, name: &str, at: usize| -> Vec<f32> {
                image.variable(name).unwrap().planes.iter().map(|p| p[at]).collect()
            };
            if filtered || exact.variable("surface").unwrap().planes[0][j] == 0.0 {
                continue;
            }
            assert_eq!(of(image, "surface", i), of(exact, "surface", j), "{name}: id at {x} {y}");
            for variable in ["point", "normal"] {
                for (a, b) in of(image, variable, i).into_iter().zip(of(exact, variable, j)) {
                    let bad_normal = name.contains("nonfinite") && a.is_nan();
                    assert!(
                        (a - b).abs() <= point || bad_normal,
                        "{name}: {variable} at {x} {y}: {a} is not {b}"
                    );
                }
            }
            compared += 1;
        }
    }
    assert!(filtered || compared > 300, "{name}: only {compared} pixels compared");
}

const ALL: [&str; 3] = ["surface", "point", "normal"];

#[test]
fn cut_outs_agree_with_one_another() {
    let list = files(&directory("tests/gbuffers"));
    assert_eq!(list.len(), 14);
    for size in ["320x180", "480x270"] {
        let exact = load(
            &directory(&format!(
                "tests/gbuffers/{}",
                if size == "320x180" {
                    "donut_320x180_blender50_singlepart_f32_zip.exr"
                } else {
                    "donut_480x270_plain_f32_zip.exr"
                }
            )),
            &ALL,
        );
        for path in list.iter().filter(|p| p.to_string_lossy().contains(size)) {
            agree(path, &load(path, &ALL), &exact);
            let file = read(Input::Path(path.clone()), &ReadOptions::default()).unwrap();
            assert!(!info(&file).unwrap().to_string().is_empty());
        }
    }
}

#[test]
fn whole_files_hold_what_their_description_says() {
    let shared = directory("../shared/gbuffers");
    let mut list = files(&shared);
    list.retain(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("donut_")));
    if list.is_empty() {
        return;
    }
    assert_eq!(list.len(), 15);
    let small = load(&shared.join("donut_320x180_blender50_singlepart_f32_zip.exr"), &ALL);
    let middle = load(&shared.join("donut_480x270_plain_f32_zip.exr"), &ALL);
    for path in &list {
        let name = path.file_name().unwrap().to_string_lossy().to_string();
        let image = load(path, &ALL);
        match () {
            _ if name.contains("960x540") => assert_eq!(ids(&image), [338830, 48551, 16978, 24354, 89687]),
            _ if name.contains("480x270") => {
                assert_eq!(ids(&image), [84709, 12137, 4241, 6090, 22423], "{name}");
                agree(path, &image, &middle);
            }
            _ if name.contains("filtered") => {
                let surface = &image.variables[0].planes[0];
                assert_eq!(surface.iter().filter(|v| v.fract() != 0.0).count(), 938);
            }
            _ if name.contains("crop") => {
                assert_eq!((image.width, image.height), (200, 120));
                assert_eq!(image.metadata.origin, [60, 30]);
                assert_eq!(image.resolution(), [320, 180]);
                agree(path, &image, &small);
            }
            _ if name.contains("overscan") => {
                assert_eq!((image.width, image.height), (320, 180));
                assert_eq!(image.metadata.origin, [-20, -10]);
                assert_eq!(image.resolution(), [280, 160]);
                assert_eq!(ids(&image), [37658, 5390, 1884, 2700, 9968]);
            }
            _ => {
                assert_eq!(ids(&image), [37658, 5390, 1884, 2700, 9968], "{name}");
                agree(path, &image, &small);
            }
        }
    }
    extents(&middle);
    let odd = load(&shared.join("donut_320x180_plain_nonfinite.exr"), &ALL);
    let normal = &odd.variables[2].planes;
    for (x, y) in [(209, 69), (231, 87), (192, 93), (226, 133)] {
        assert!(normal.iter().all(|p| p[y * 320 + x].is_nan()));
        assert_eq!(odd.variables[0].planes[0][y * 320 + x], 3.0);
    }
    assert_eq!(odd.variables[1].planes[1][319], f32::NEG_INFINITY);
    assert!(odd.variables[1].planes[0][0].is_nan());
    others(&shared);
}

fn extents(image: &Image<'_>) {
    let expected = [[-3.0354, 3.0961], [-2.8972, 3.1172], [0.0, 2.1117]];
    for (plane, [low, high]) in image.variables[1].planes.iter().zip(expected) {
        let min = plane.iter().copied().fold(f32::INFINITY, f32::min);
        let max = plane.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        assert!((min - low).abs() < 1e-4 && (max - high).abs() < 1e-4, "{min} {max}");
    }
}

/// Beauty, depth, coverage, albedo and cryptomattes.
fn others(shared: &Path) {
    let names = ["color", "alpha", "depth", "uv"];
    for file in ["blender45_f32_zip", "blender50_multipart_f32_zip", "allhalf_piz"] {
        let image = load(&shared.join(format!("donut_480x270_{file}.exr")), &names);
        let depth = &image.variables[2].planes[0];
        let near = depth.iter().copied().fold(f32::INFINITY, f32::min);
        let far = depth.iter().copied().filter(|d| *d < 1e9).fold(0.0, f32::max);
        assert!((near - 10.011).abs() < 0.005 && (far - 15.726).abs() < 0.005, "{file}: {near} {far}");
        assert_eq!(image.variables[3].shape, Shape::Vector(2));
    }
    let path = shared.join("donut_320x180_blender50_antialiased.exr");
    let image = load(&path, &["surface", "alpha", "albedo", "Mist", "CryptoObject00"]);
    let (id, alpha) = (&image.variables[0].planes[0], &image.variables[1].planes[0]);
    let edges = id.iter().zip(alpha.iter()).filter(|(id, a)| **id == 0.0 && **a != 0.0).count();
    assert_eq!(edges, 522);
    let hashes = [0x75f7_4669, 0x04bb_4c09, 0xcb43_2898, 0x2495_0135, 0];
    assert!(image.variables[4].planes[0].iter().all(|v| hashes.contains(&v.to_bits())), "bits are kept");
    let file = read(Input::Path(path), &ReadOptions::default()).unwrap();
    assert!(
        file.metadata().attributes.iter().any(|(n, v)| n.ends_with("/manifest") && v.contains("75f74669"))
    );
    let bytes = encode("x", Format::Exr, &image, &WriteOptions::default()).unwrap();
    let again = open(bytes).load(&["CryptoObject00"]).unwrap();
    let bits = |image: &Image<'_>| -> Vec<u32> {
        image.variable("CryptoObject00").unwrap().planes[0].iter().map(|v| v.to_bits()).collect()
    };
    assert_eq!(bits(&again), bits(&image));
}
