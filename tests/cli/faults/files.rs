//! Images that are damaged, lie about their size, or have an odd one.

use super::{Random, Shell};
use crate::formats::{read_all, samples};
use pse::image::{ErrorKind, Input, ReadOptions, read};

/// How often each file is damaged.
const ROUNDS: usize = 500;

#[test]
fn flipped_bits() {
    let mut random = Random(3);
    let (mut refused, mut read) = (0, 0);
    for (name, bytes) in samples() {
        read_all(&name, &bytes).expect("it is whole");
        for round in 0..ROUNDS {
            let mut bad = bytes.clone();
            for _ in 0..=round % 4 {
                // Every other flip is near the beginning, where the sizes are.
                let at = random.below(if round % 2 == 0 { bad.len() } else { bad.len().min(400) });
                bad[at] ^= 1 << random.below(8);
            }
            match read_all(&name, &bad) {
                Ok(()) => read += 1,
                Err(error) => {
                    refused += 1;
                    // The end of a name may be damaged too, but not that of the file.
                    assert!(error.message.contains(&name), "{error}");
                    assert!(!matches!(error.kind, ErrorKind::Io(_)), "{error}");
                }
            }
        }
    }
    // Both happen: not every number that changes can be seen.
    assert!(refused > 2000 && read > 500, "{refused} refused, {read} read");
}

#[test]
fn every_length() {
    for (name, bytes) in samples() {
        for length in 0..bytes.len().min(700) {
            let result = read_all(&name, &bytes[..length]);
            assert!(result.is_err() || !name.ends_with(".exr") && length > 30, "{name} of {length} bytes");
        }
    }
}

/// An EXR file that claims another data window than it has: xMin, yMin, xMax, yMax.
fn lying(bytes: &[u8], window: [i32; 4]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let mark = b"dataWindow\0box2i\0";
    let at = bytes.windows(mark.len()).position(|w| w == mark).expect("a data window") + mark.len() + 4;
    let claimed = window.iter().flat_map(|v| v.to_le_bytes());
    bytes[at..at + 16].iter_mut().zip(claimed).for_each(|(to, byte)| *to = byte);
    bytes
}

#[test]
fn sizes_that_no_file_has() {
    let f = Shell::new();
    f.good("pse scene donut -q --size 20x10 -o g.exr");
    let bytes = f.read("g.exr");
    for (window, words) in [
        ([0, 0, (1 << 16) - 1, (1 << 15) - 1], "claims 65536 x 32768 pixels"),
        ([0, 0, i32::MAX - 1, 0], "lie.exr"),
        ([0, 0, 1 << 29, 1 << 29], "lie.exr"),
        ([i32::MIN, i32::MIN, i32::MAX, i32::MAX], "lie.exr"),
        ([0, 0, -1, -1], "lie.exr"),
        ([5, 5, 4, 9], "lie.exr"),
    ] {
        f.write("lie.exr", lying(&bytes, window));
        for command in ["run -e point -o a.exr -i", "info"] {
            // All memory together, as the system counts it.
            f.bad(&format!("ulimit -v 2000000; pse {command} lie.exr"), &[words]);
        }
    }
    f.write("lie.exr", "");
    f.bad("pse run -e point -i lie.exr -o a.exr", &["it is empty"]);
}

#[test]
fn odd_sizes() {
    let f = Shell::new();
    for (size, [width, height]) in
        [("1x1", [1, 1]), ("1000000x1", [1_000_000, 1]), ("1x1000000", [1, 1_000_000])]
    {
        f.good(&format!("pse run -q -e 'white * pixel.x / 1e6 + pixel.y / 1e6' --size {size} -o a.exr"));
        f.good("pse run -q -e 'color / 2' -i a.exr -o b.png");
        f.good("pse run -q -e '2 * color' -i b.png -o c.exr");
        for name in ["a.exr", "b.png", "c.exr"] {
            let file = read(Input::Path(f.path(name)), &ReadOptions::default()).expect(name);
            assert_eq!(file.size(), [width, height], "{name}");
        }
        let last = |name: &str| {
            let file = read(Input::Path(f.path(name)), &ReadOptions::default()).expect(name);
            *file.load(&["color"]).expect(name).variables[0].planes[0].last().expect("a pixel")
        };
        assert!((last("a.exr") - last("c.exr")).abs() < 0.02, "{size}: {} {}", last("a.exr"), last("c.exr"));
    }
    f.bad("pse run -e white --size 0x5 -o d.exr", &["no pixels"]);
    f.bad("pse run -e white --size 100000x100000 -o d.exr", &["too large"]);
}
