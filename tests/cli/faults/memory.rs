//! Memory stays within what is allowed, and the same comes out.

use super::Shell;
use pse::image::{Input, ReadOptions, read};

/// Megabytes that the command says it took at most, and the rows that it had at a time.
fn told(err: &str) -> (f64, usize) {
    let after = |mark: &str| err.split(mark).nth(1).and_then(|rest| rest.split_whitespace().next());
    let peak = after("peak memory").and_then(|n| n.parse().ok()).expect("the peak");
    (peak, after("rows per band").and_then(|n| n.parse().ok()).expect("the rows"))
}

#[cfg(target_os = "linux")]
#[test]
fn memory_is_bounded() {
    let f = Shell::new();
    f.write("p.pse", "color = white * Noise(8 * point) + filterwidth(point)\nn = 2 * normal\n");
    f.good("pse scene donut -q -o g.exr --size 2500x1200");
    f.good("pse run -q -e 'color = white * Noise(9 * point)' -i g.exr -o g.png");
    for (input, vars) in [("-i g.exr", "--vars color,n,point"), ("-e color -i g.png", "")] {
        let program = if vars.is_empty() { "" } else { "p.pse" };
        let line = format!("pse run {program} {input} {vars} --stats --threads 2");
        let usual = told(&f.good(&format!("{line} -o a.exr")).err);
        let picture = if vars.is_empty() { "-o p.png" } else { "" };
        let mut before = 0;
        for most in [120, 160, 250] {
            let ended = f.good(&format!("{line} -o b.exr {picture} --memory {most}"));
            let (peak, rows) = told(&ended.err);
            assert!(peak < f64::from(most) * 1.048_576, "{input}: {peak} MB of {most}, {rows} rows");
            assert!(rows > before || rows == usual.1, "{rows} rows with {most} MB, {before} before");
            assert!(f.read("a.exr") == f.read("b.exr"), "{input}: other bytes with {most} MB");
            before = rows;
        }
    }
    let run = "pse run p.pse -i g.exr -o c.exr";
    f.bad(&format!("{run} --memory 20"), &["the run needs about", "--memory allows 20", "Allow more"]);
    f.bad(&format!("{run} --memory 120 --repeat 1"), &["the run needs about"]);
    f.bad(
        "pse run p.pse -i g.exr -o c.tif --memory 60",
        &["the run needs about", "Only EXR and PNG are read and written row by row"],
    );
}

/// The same picture as an interlaced PNG: of one pixel both are alike but for the mark in the header.
fn interlaced(mut png: Vec<u8>) -> Vec<u8> {
    png[28] = 1;
    let mut crc = u32::MAX;
    for byte in &png[12..29] {
        crc ^= u32::from(*byte);
        (0..8).for_each(|_| crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 });
    }
    png[29..33].copy_from_slice(&(!crc).to_be_bytes());
    png
}

/// The picture with a colour profile of so many zeros, which take little room as a packed block.
#[cfg(target_os = "linux")]
fn with_profile(png: &[u8], length: usize) -> Vec<u8> {
    use std::io::Write;
    let mut packed = flate2::write::ZlibEncoder::new(b"icc\0\0".to_vec(), flate2::Compression::best());
    let zeros = vec![0; 1 << 20];
    (0..length >> 20).for_each(|_| packed.write_all(&zeros).expect("memory"));
    let profile = packed.finish().expect("memory");
    let block = [b"iCCP", &profile[..]].concat();
    let mut sum = flate2::Crc::new();
    sum.update(&block);
    let size = (profile.len() as u32).to_be_bytes();
    // The header's block ends after its checksum.
    [&png[..33], &size, &block, &sum.sum().to_be_bytes(), &png[33..]].concat()
}

#[cfg(target_os = "linux")]
#[test]
fn a_packed_profile_takes_no_memory() {
    let f = Shell::new();
    f.good("pse run -q -e '[0.2 0.4 0.6]' --scene card --size 2x2 -o one.png");
    let bomb = with_profile(&f.read("one.png"), 600 << 20);
    assert!(bomb.len() < 1 << 20);
    f.write("small.png", with_profile(&f.read("one.png"), 1 << 20));
    f.write("bomb.png", &bomb);
    f.write("two.png", interlaced(bomb));
    for name in ["one.png", "small.png", "bomb.png", "two.png"] {
        // Run on, and looked up: both read the header before the pixels.
        let texture = format!("-e 'color = texture(\"{name}\", 0.5, 0.5)' --scene card --size 2x2");
        for run in [format!("-e color -i {name}"), texture] {
            let ended = f.run(&format!("pse run {run} -o a.exr --stats"));
            // A profile beyond the limit may be refused, or left out.
            if ended.code == 0 {
                let (peak, _) = told(&ended.err);
                assert!(peak < 250.0, "{run}: {peak} MB");
            }
            assert!(ended.code == 0 || name != "small.png", "{}", ended.err);
        }
    }
    // Of the process that is limited to less than the profile nothing is left undone, either.
    for name in ["bomb.png", "two.png"] {
        let ended = f.run(&format!("ulimit -v 4000000; pse info {name}"));
        assert!(ended.code == 0 || ended.code == 1, "{}: {}", ended.code, ended.err);
    }
}

#[test]
fn what_cannot_stream_says_so() {
    let f = Shell::new();
    f.good("pse run -q -e '[0.2 0.4 0.6]' --scene card --size 1x1 -o one.png -o one.jpg");
    f.write("two.png", interlaced(f.read("one.png")));
    let colors = ["one.png", "two.png"].map(|name| {
        let file = read(Input::Path(f.path(name)), &ReadOptions::default()).expect(name);
        file.load(&["color"]).expect(name).variables[0].planes.clone()
    });
    assert_eq!(colors[0], colors[1]);
    for (files, expected) in [
        ("-i one.png -o a.exr", None),
        ("-i one.png -o a.png", None),
        ("-i two.png -o a.png", Some("two.png: the rows of an interlaced PNG")),
        ("-i one.jpg -o a.png", Some("one.jpg: only EXR and PNG are decoded row by row")),
        ("-i one.png -o a.tif", Some("a.tif: only EXR and PNG are written row by row")),
    ] {
        let err = f.good(&format!("pse run -e color {files} --stats")).err;
        match expected {
            Some(words) => assert!(err.contains(&format!("held in memory {words}")), "{files}\n{err}"),
            None => assert!(!err.contains("held in memory"), "{files}\n{err}"),
        }
    }
}
