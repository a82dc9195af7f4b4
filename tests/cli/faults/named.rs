//! Files that programs and other files name, which lead somewhere else or have no end.

use super::Shell;

/// A line that ends soon, within 1.5 GB of address space: if it waits it is stopped, and that is a failure.
fn soon(arguments: &str) -> String {
    format!("ulimit -v 1500000; timeout 60 \"$PSE\" {arguments}")
}

#[test]
fn what_is_no_file_is_not_waited_for() {
    let f = Shell::new();
    f.good("mkfifo fifo.pse fifo.png fifo.exr; mkdir sub; mkfifo sub/t.0001.png; ln -s fifo.png link.png");
    let _socket = std::os::unix::net::UnixListener::bind(f.path("socket.png")).expect("a socket");
    let pipe = "it is a pipe, not a regular file";
    for (text, why) in [
        ("import \"fifo.pse\"\ncolor = white", pipe),
        ("color = texture(\"fifo.png\", uv)", pipe),
        ("color = texture(\"link.png\", uv)", pipe),
        ("color = texture(\"fifo.exr\", uv, channel = \"alpha\")", pipe),
        ("color = environment(\"fifo.png\", normal)", pipe),
        ("color = texture(\"sub/t.####.png\", uv)", pipe),
        ("color = texture(\"socket.png\", uv)", "it is a socket, not a regular file"),
        ("color = texture(\"sub\", uv)", "it is a directory"),
    ] {
        f.write("p.pse", format!("{text}\n"));
        f.bad(&soon("run -q p.pse --size 4x4 --frame 1 -o o.png"), &[why]);
        if !text.contains("####") {
            f.bad(&soon("check p.pse"), &[why]);
        }
    }
}

#[test]
fn links_do_not_lead_out_of_the_folders() {
    let f = Shell::new();
    f.good("mkdir -p a/sub out/deep; pse run -q -e red --size 4x4 -o out/t.png; cp out/t.png out/t.0002.png");
    f.write("out/secret.pse", "the secret words\n");
    f.write("out/lib.pse", "function lib(p)\n    return p\n");
    f.write("out/deep/x.pse", "color = 1\n");
    f.good("cd a; ln -s ../out/deep sub/link; ln -s ../out out; ln -s ../out/secret.pse secret.pse; ln -s secret.pse again.pse");
    f.good("cd a; ln -s ../out/lib.pse lib.pse; ln -s ../out/t.png t.png; cp ../out/t.png t.0001.png; ln -s ../out/t.0002.png .");
    f.good("cd a; ln -s /etc/passwd passwd.pse; ln -s nowhere.pse none.pse; ln -s loop.pse loop.pse");
    let run = "run -q a/p.pse --size 4x4 -o o.png";
    let outside = ["links lead to", "--path"];
    for (text, words) in [
        ("import \"secret.pse\"", &outside[..]),
        ("import \"again.pse\"", &outside),
        ("import \"passwd.pse\"", &outside),
        ("import \"out/secret.pse\"", &outside),
        ("import \"sub/link/x.pse\"", &outside),
        // `..` undoes the folder before it, not the link.
        ("import \"sub/link/../secret.pse\"", &["there is no a/sub/secret.pse"]),
        ("import \"none.pse\"", &["there is no a/none.pse"]),
        ("import \"loop.pse\"", &["loop.pse: "]),
        ("c = texture(\"t.png\", uv)", &outside),
        ("c = texture(\"out/t.png\", uv)", &outside),
        ("c = texture(\"sub/link/../../t.png\", uv)", &outside),
        ("c = environment(\"t.png\", normal)", &outside),
        ("c = texture(\"t.####.png\", uv)", &outside),
    ] {
        f.write("a/p.pse", format!("{text}\ncolor = white\n"));
        let ended = f.run(&soon(&format!("{run} --frame 2")));
        assert_eq!(ended.code, 1, "{text}: {}", ended.err);
        for word in words {
            assert!(ended.err.contains(word), "{text}\nno `{word}` in {}", ended.err);
        }
        assert!(!ended.err.contains("secret words") && !ended.err.contains("root:"), "{text}: {}", ended.err);
    }
    // What is there is not told either.
    f.write("a/p.pse", "color = texture(\"out/tt.png\", uv)\n");
    let ended = f.run(&format!("pse {run}"));
    assert!(ended.code == 1 && !ended.err.contains("out/t.png"), "{}", ended.err);
    // Links within the folders, and folders that are given, are followed.
    for text in [
        "import \"lib.pse\"\ncolor = lib(white)",
        "color = texture(\"t.png\", uv)",
        "color = texture(\"out/t.png\", uv)",
        "color = texture(\"t.####.png\", uv)",
    ] {
        f.write("a/p.pse", format!("{text}\n"));
        f.bad(&format!("pse {run} --frame 2"), &["links lead to"]);
        f.good(&format!("pse {run} --frame 2 --path out"));
    }
    f.good("rm o.png; cd a; cp ../out/lib.pse sub/lib.pse; ln -sf sub/lib.pse lib.pse; ln -s sub/.. here");
    f.write("a/p.pse", "import \"here/lib.pse\"\ncolor = lib(white)\n");
    f.good(&format!("pse {run}; rm o.png"));
    // The folder of the program may be a link itself.
    f.good(&format!("ln -s a b; pse {}; rm o.png", run.replace("a/p.pse", "b/p.pse")));
}

#[test]
fn pipes_that_are_given_are_read_and_devices_are_not() {
    let f = Shell::new();
    f.good("pse scene card -q --size 8x8 -o g.exr; mkfifo p");
    f.good("pse run -q -e 'color = point' -i g.exr -o a.exr");
    for line in [
        "cat g.exr | pse run -q -e 'color = point' -o o.exr -i -",
        "cat g.exr > p & pse run -q -e 'color = point' -o o.exr -i p",
        "pse run -q -e 'color = point' -o o.exr -i /dev/stdin < g.exr",
        "cat g.exr | pse run -q -e 'color = point' -o o.exr -i /dev/stdin",
    ] {
        f.good(line);
        assert!(f.read("o.exr") == f.read("a.exr"), "{line}");
    }
    f.good("printf 'v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nf 1 2 3\\n' > m.obj; mkfifo m; ln -s /dev/zero z.obj; ln -s /dev/zero z.png");
    f.good("cat m.obj > f.obj; pse scene --mesh m.obj -q --size 8x8 -o one.exr; mkfifo q.obj");
    f.good("cat m.obj > q.obj & pse scene --mesh q.obj -q --size 8x8 -o two.exr");
    assert!(f.read("one.exr") == f.read("two.exr"));
    f.bad(&soon("scene --mesh z.obj -q --size 8x8 -o x.exr"), &["it is a device"]);
    f.bad(&soon("run -q -e color -i z.png -o x.exr"), &["it is a device"]);
    f.bad(&soon("info /dev/zero"), &["it is a device"]);
    // Nothing is kept of what is no image, however long it is.
    f.bad(&format!("{} < /dev/zero", soon("run -q -e color -i - -o x.exr")), &["is not an image"]);
}

#[test]
fn buffers_of_meshes() {
    let f = Shell::new();
    let gltf = |uri: &str, length: usize| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "buffers":[{{"uri":"{uri}","byteLength":{length}}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}]}}"#
        )
    };
    let points: Vec<u8> =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    f.good("mkdir a out; mkfifo a/fifo.bin; ln -s /dev/zero a/zero.bin; ln -s ../out/o.bin a/out.bin; ln -s good.bin a/link.bin");
    f.write("a/good.bin", &points);
    f.write("out/o.bin", &points);
    for (uri, length, why) in [
        ("good.bin", 36, ""),
        ("link.bin", 36, ""),
        ("fifo.bin", 36, "it is a pipe"),
        ("zero.bin", 36, "links lead to"),
        ("out.bin", 36, "links lead to"),
        ("good.bin", 1 << 40, "buffer 0 has 36 bytes"),
    ] {
        f.write("a/m.gltf", gltf(uri, length));
        let line = soon("scene --mesh a/m.gltf -q --size 8x8 -o o.exr");
        match why {
            "" => drop(f.good(&format!("{line}; rm o.exr"))),
            _ => f.bad(&line, &[why]),
        }
    }
}

/// The checksum of a chunk of a PNG file.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |mut crc: u32, byte| {
        crc ^= u32::from(*byte);
        (0..8).for_each(|_| crc = (crc >> 1) ^ (0xedb8_8320 * (crc & 1)));
        crc
    })
}

/// A PNG file's size, bits and interlacing, set to others.
fn claims(mut png: Vec<u8>, [width, height]: [u32; 2], bits: u8, color: u8) -> Vec<u8> {
    png[16..20].copy_from_slice(&width.to_be_bytes());
    png[20..24].copy_from_slice(&height.to_be_bytes());
    (png[24], png[25], png[28]) = (bits, color, 1);
    let sum = crc(&png[12..29]);
    png[29..33].copy_from_slice(&sum.to_be_bytes());
    png
}

#[test]
fn pictures_that_would_become_large() {
    let f = Shell::new();
    f.good("pse run -q -e black --size 1x1 -o one.png; pse run -q -e black --size 6000x6000 -o big.png");
    // Few bytes that claim many pixels, and honest ones of a single colour.
    f.write("short.png", claims(f.read("one.png"), [16384, 16384], 1, 0));
    f.write("flat.png", claims(f.read("big.png"), [24000, 24000], 1, 0));
    let small = f.read("big.png").len();
    assert!(small < 1_000_000, "{small}");
    f.write("i.pse", "color = 2 * color\n");
    for (name, words) in [
        ("short.png", &["short.png", "damaged or incomplete: it ends too early"][..]),
        ("flat.png", &["would become 24000 x 24000 pixels in memory at once", "row by row"]),
    ] {
        f.write("t.pse", format!("color = texture(\"{name}\", uv)\n"));
        f.write("e.pse", format!("color = environment(\"{name}\", normal)\n"));
        for line in [format!("i.pse -i {name}"), "t.pse --size 4x4".into(), "e.pse --size 4x4".into()] {
            f.bad(&format!("ulimit -v 700000; pse run -q {line} --threads 1 -o o.exr"), words);
        }
        f.bad(&format!("ulimit -v 700000; pse check t.pse -i {name}"), words);
    }
}
