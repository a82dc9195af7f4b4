//! EXR files as other programs write them: parts, views, subsampled channels, luminance and chroma, and what is not
//! read beside what is.

use super::{Ended, Folder};
use std::fs;

/// One of the tests' own files.
fn sample(name: &str) -> String {
    format!("{}/tests/exr/{name}.exr", env!("CARGO_MANIFEST_DIR"))
}

impl Folder {
    /// The first pixel of an expression.
    fn first(&self, file: &str, expression: &str, options: &[&str]) -> Vec<f32> {
        let e = format!("v = {expression}");
        let arguments = ["run", "-q", "-e", &e, "-i", file, "-o", "o.exr", "--vars", "v"];
        let ended = self.pse_with(&[&arguments[..], options].concat(), b"");
        assert_eq!(ended.code, 0, "{file} {expression}\n{}", ended.err);
        self.planes("o.exr", "v").iter().map(|plane| plane[0]).collect()
    }

    /// The message where it is an error.
    fn refused(&self, file: &str, expression: &str) -> String {
        let Ended { code, err, .. } =
            self.pse_with(&["run", "-q", "-e", expression, "-i", file, "-o", "o.exr"], b"");
        assert_eq!(code, 1, "{file} {expression}\n{err}");
        err.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// What `pse info` prints.
    fn info(&self, file: &str) -> String {
        let Ended { code, text, err, .. } = self.pse_with(&["info", file], b"");
        assert_eq!(code, 0, "{file}\n{err}");
        text
    }
}

fn near(got: &[f32], want: &[f32]) {
    assert!(
        got.len() == want.len() && got.iter().zip(want).all(|(g, w)| (g - w).abs() < 1e-3),
        "{got:?} {want:?}"
    );
}

#[test]
fn nukes_parts_carry_layer_and_view() {
    let f = Folder::new();
    let file = sample("nuke_parts_dot_view");
    near(&f.first(&file, "color", &[]), &[0.8050, 0.8233, 0.2743]);
    near(&f.first(&file, "depth", &[]), &[0.1306]);
    near(&f.first(&file, "point", &[]), &[0.2114, 0.5383, 0.8484]);
    near(&f.first(&file, "matte", &[]), &[0.2114]);
    // `--map` takes the names that other programs show.
    near(&f.first(&file, "normal", &["--map", "normal=P.main"]), &[0.2114, 0.5383, 0.8484]);
    let file = sample("nuke_parts_underscore");
    near(&f.first(&file, "color", &[]), &[0.8050, 0.8233, 0.2743]);
    near(&f.first(&file, "depth", &[]), &[0.1306]);
}

#[test]
fn the_first_view_has_plain_names_and_the_others_their_own_before() {
    let f = Folder::new();
    let file = sample("stereo_parts");
    near(&f.first(&file, "color", &[]), &[0.8050, 0.8233, 0.2743]);
    near(&f.first(&file, "right.color", &[]), &[0.2114, 0.5383, 0.8484]);
    let file = sample("multiview_single_part");
    near(&f.first(&file, "color", &[]), &[0.5118, 0.3627, 0.1974]);
    near(&f.first(&file, "depth", &[]), &[4.1052]);
    near(&f.first(&file, "right.color", &[]), &[0.7255, 0.1469, 0.7521]);
    near(&f.first(&file, "right.depth", &[]), &[105.5137]);
    near(&f.first(&file, "color", &["--map", "color=right"]), &[0.7255, 0.1469, 0.7521]);
    let info = f.info(&file);
    assert!(info.contains("right.color.x") && info.contains("right.depth"), "{info}");
    assert!(
        f.refused(&file, "color = right.normal")
            .contains("It has `color`, `depth`, `right.color`, `right.depth`")
    );
    // An image of that name is meant before a view.
    let other = sample("nuke_parts_dot_view");
    let ended =
        f.pse_with(&["run", "-q", "-e", "right.matte", "-i", &file, "-i", &format!("right={other}")], b"");
    assert!(ended.err.contains("different sizes"), "{}", ended.err);
}

#[test]
fn luminance_and_chroma_become_a_color() {
    let f = Folder::new();
    for name in ["luminance_chroma_420", "luminance_chroma_420_zip"] {
        let file = sample(name);
        let info = f.info(&file);
        assert!(info.contains("color") && !info.contains("not read"), "{info}");
        let color = f.first(&file, "color", &[]);
        let [y, r, g, b] = [f.first(&file, "Y", &[])[0], color[0], color[1], color[2]];
        near(&[0.2126 * r + 0.7152 * g + 0.0722 * b], &[y]);
        assert!(f.refused(&file, "RY").contains("`RY` is not read: it is subsampled (2 x 2)"));
    }
    near(&f.first(&sample("luminance_chroma_420"), "color", &[]), &[0.0856, 0.5547, 0.8765]);
    // Interpolation reaches over bands and tiles.
    let file = sample("luminance_chroma_420_zip");
    f.good(&format!("run -q -e color -i {file} -o whole.exr"));
    f.good(&format!("run -q -e color -i {file} -o small.exr --batch 7 --threads 1"));
    assert!(f.read("whole.exr") == f.read("small.exr"));
    f.good(&format!("run -q -e color -i {file} -o part.exr --region 7,20,31,33"));
    let (whole, part) = (f.planes("whole.exr", "color"), f.planes("part.exr", "color"));
    for (whole, part) in whole.iter().zip(&part) {
        // The picture has 52 columns.
        let cut = (20..33).flat_map(|row| whole[row * 52 + 7..row * 52 + 31].iter());
        assert!(cut.eq(part.iter()));
    }
}

#[test]
fn what_is_not_read_is_named_beside_what_is() {
    let f = Folder::new();
    let file = sample("rgb_with_half_mask");
    near(&f.first(&file, "color", &[]), &[0.0856, 0.5547, 0.8765]);
    assert!(f.info(&file).contains("note: `mask` is not read: it is subsampled (2 x 2)."));
    assert!(f.refused(&file, "mask").contains("`mask` is not read: it is subsampled (2 x 2)"));
    let map = ["run", "-q", "-e", "d = depth", "-i", &file, "--map", "depth=mask", "-o", "o.exr"];
    let map = f.pse_with(&map, b"");
    let running = map.err.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(running.contains("`mask` of") && running.contains("It is subsampled"), "{}", map.err);
    let file = sample("part_subsampled_beside_rgba");
    near(&f.first(&file, "color", &[]), &[0.6023, 0.7940, 0.4930]);
    assert!(f.info(&file).contains("note: `half.mask` is not read: it is subsampled (2 x 2)."));
}

/// The tests' file of two parts with the compression of the one at `place` replaced.
fn with_compression(f: &Folder, name: &str, place: usize, number: u8) -> String {
    let mut bytes = fs::read(sample("stereo_parts")).unwrap();
    let mark = b"compression\0compression\0\x01\0\0\0";
    let found = bytes.windows(mark.len()).enumerate().filter(|(_, w)| w == mark).nth(place).unwrap().0;
    bytes[found + mark.len()] = number;
    fs::write(f.path(name), bytes).unwrap();
    name.into()
}

#[test]
fn an_unknown_compression_keeps_nobody_from_the_other_parts() {
    let f = Folder::new();
    for (number, words) in [
        (10, "it has HTJ2K256 compression"),
        (11, "it has HTJ2K32 compression"),
        (13, "it has ZSTD compression"),
        (77, "it has compression number 77, which is unknown"),
    ] {
        let file = with_compression(&f, "second.exr", 1, number);
        near(&f.first(&file, "color", &[]), &[0.8050, 0.8233, 0.2743]);
        let info = f.info(&file);
        assert!(info.contains(&format!("note: The part `rgb.right` is not read: {words}.")), "{info}");
        let message = f.refused(&file, "right.color");
        assert!(message.contains(&format!("`rgb.right.R` is not read: {words}")), "{message}");
        let file = with_compression(&f, "first.exr", 0, number);
        near(&f.first(&file, "right.color", &[]), &[0.2114, 0.5383, 0.8484]);
        // Another picture does not take the place of the one that is not read.
        let message = f.refused(&file, "color");
        assert!(message.contains(&format!("`rgb.left.R` is not read: {words}")), "{message}");
    }
}

#[test]
fn components_are_nothing_by_themselves() {
    let f = Folder::new();
    let file = sample("px_py_pz");
    near(&f.first(&file, "point", &[]), &[1.0, 2.0, 3.0]);
    near(&f.first(&file, "normal", &[]), &[4.0, 5.0, 6.0]);
    near(&f.first(&file, "Pz", &[]), &[3.0]);
    assert!(f.refused(&file, "depth").contains("has no variable `depth`"));
    let file = sample("mist_only");
    near(&f.first(&file, "Mist", &[]), &[0.25]);
    near(&f.first(&file, "depth", &["--map", "depth=ViewLayer.Mist"]), &[0.25]);
    assert!(f.refused(&file, "depth").contains("If `Mist` is it: --map depth=ViewLayer.Mist"));
    let note = f.pse_with(&["info", &file, "--map", "depth=Mist"], b"");
    assert!(note.text.contains("`depth` is between 0 and 1"), "{}{}", note.text, note.err);
}

#[test]
fn names_are_utf_8() {
    let f = Folder::new();
    let file = sample("utf8_layer_names");
    assert!(f.info(&file).contains("视图层.Größe.V"));
    near(&f.first(&file, "point", &["--map", "point=视图层.Position"]), &[5.0, 6.0, 7.0]);
    near(&f.first(&file, "size", &["--map", "size=GRÖßE"]), &[4.0]);
}
