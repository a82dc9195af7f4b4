//! Variables whose names mean two things, views of images with names, and what a session reads.

use super::{Folder, ended};
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use exr::prelude::{ImageAttributes, IntegerBounds, LayerAttributes, WritableImage};

/// Writes an EXR file of parts with a view each, whose channels hold their number from 1.
fn exr(f: &Folder, name: &str, side: usize, parts: &[(&str, &str, &[&str])]) {
    let layers: Vec<Layer<AnyChannels<FlatSamples>>> = parts
        .iter()
        .map(|(part, view, channels)| {
            let values = |i: usize| FlatSamples::F32(vec![(i + 1) as f32; side * side]);
            let list = channels.iter().enumerate().map(|(i, c)| AnyChannel::new(*c, values(i))).collect();
            let text = |text: &str| Some(text).filter(|t| !t.is_empty()).map(|t| t.into());
            let attributes = LayerAttributes {
                layer_name: text(part),
                view_name: text(view),
                ..LayerAttributes::default()
            };
            Layer::new((side, side), attributes, Encoding::UNCOMPRESSED, AnyChannels::sort(list))
        })
        .collect();
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((side, side)));
    exr::image::Image::from_layers(attributes, layers).write().to_file(f.path(name)).expect(name);
}

const RGB: &[&str] = &["R", "G", "B"];

#[test]
fn the_systems_names_are_the_systems() {
    let f = Folder::new();
    exr(&f, "g.exr", 2, &[("", "", &["frame", "pixel", "pi", "resolution", "R", "G", "B"])]);
    let said =
        f.good("run -e color=[frame,pixel.x,resolution.y] -i g.exr --frame 7 --region 0,0,1,1 -o a.exr").err;
    assert_eq!(f.planes("a.exr", "color").concat(), [7.0, 0.5, 2.0]);
    for name in ["frame", "pixel", "resolution"] {
        let note = format!("`{name}` is the value of the system, not the channel of g.exr");
        assert!(said.contains(&note) && said.contains(&format!("--map NAME={name}")), "{said}");
    }
    f.good("run -e color=white*pass -i g.exr --map pass=frame --frame 7 -o b.exr");
    assert_eq!(f.planes("b.exr", "color")[0][0], 1.0);
    // A constant is hidden, as the reference says, and a note says so.
    let said = f.good("run -e color=white*pi -i g.exr -o c.exr").err;
    assert_eq!(f.planes("c.exr", "color")[0][0], 3.0);
    assert!(said.contains("`pi` is the variable of g.exr, not the ratio"), "{said}");
    assert!(!f.good("run -e color=color -i g.exr -o d.exr").err.contains("system"));
}

#[test]
fn a_list_has_what_programs_can_read() {
    let f = Folder::new();
    let channels = ["if.x", "if.y", "if.z", "return", "frame", "Combined.R", "Combined.G", "Combined.B"];
    exr(&f, "g.exr", 2, &[("", "", &channels)]);
    let said = f.good("info g.exr").text;
    assert!(!said.contains("(if") && said.contains("(Combined.x)"), "{said}");
    for note in [
        "note: `if` cannot be read in programs: rename the channels with --map NAME=CHANNELS.",
        "note: `return` cannot be read in programs",
        "note: `frame` is a name of the system in programs",
    ] {
        assert!(said.contains(note), "{said}");
    }
    f.good("run -e a -i g.exr --map a=if -o a.exr");
    // A view whose name is a variable's.
    exr(&f, "v.exr", 2, &[("rgba.main", "main", RGB), ("rgba.color", "color", RGB)]);
    let said = f.good("info v.exr").text;
    assert!(said.contains("note: `color.color` cannot be read in programs"), "{said}");
    f.good("run -e color=other -i v.exr --map other=rgba.color -o b.exr");
}

#[test]
fn views_of_an_image_with_a_name() {
    let f = Folder::new();
    exr(&f, "s.exr", 2, &[("rgba.left", "left", RGB), ("rgba.R", "R", RGB)]);
    f.good("run -e color=x.color+x.R.color -i x=s.exr -o a.exr");
    assert_eq!(f.planes("a.exr", "color")[2][0], 6.0);
    f.good("run -e color=white*x.R.color.z -i x=s.exr -o b.exr");
    assert_eq!(f.planes("b.exr", "color")[0][0], 3.0);
    // A mapping of a view, of an image with a name and without.
    f.good("run -e color=R.color -i s.exr --map R.color=rgba.left.R,rgba.left.G,rgba.left.B -o c.exr");
    f.good("run -e color=x.R.color -i x=s.exr --map x.R.color=rgba.left.R,rgba.left.G,rgba.left.B -o d.exr");
    let words = ["has no view `middle`", "-i middle=FILE"];
    f.bad(1, "run -e color=color -i s.exr --map middle.color=rgba.left -o e.exr", &words);
    let said = f.pse("run -e color=x.middle.color -i x=s.exr -o e.exr").err;
    assert!(said.contains("no variable `x.middle.color`") && said.matches('×').count() == 1, "{said}");
}

#[test]
fn a_session_reads_by_every_name() {
    let f = Folder::new();
    let channels =
        ["v.Combined.R", "v.Combined.G", "v.Combined.B", "v.Position.X", "v.Position.Y", "v.Position.Z"];
    exr(&f, "g.exr", 2, &[("", "", &channels)]);
    let lines = "Combined\nPosition.x\na = Combined\n:show Position\na + color\n:vars\n";
    let ended = ended(f.command().args(["repl", "-i", "g.exr"]).write_stdin(lines));
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.text.contains("[1 2 3]") && ended.text.contains("[2 4 6]"), "{}", ended.text);
}

#[test]
fn frames_of_another_size_are_noted() {
    let f = Folder::new();
    for (frame, side) in [(1, 4), (2, 4), (3, 5), (4, 5)] {
        exr(&f, &format!("g.{frame}.exr"), side, &[("", "", RGB)]);
    }
    let said = f.good("run -e color -i g.#.exr --frames 1-4 -o a.#.exr").err;
    assert_eq!(said.matches("the first frame is 4x4").count(), 1, "{said}");
    assert!(said.contains("frame 3 is 5x5, but the first frame is 4x4"), "{said}");
    assert!(!f.good("run -e color -i g.#.exr --frames 3-4 -o a.#.exr").err.contains("first frame"));
}

#[test]
fn one_frame_needs_one_number() {
    let f = Folder::new();
    for name in ["g.0003.exr", "h.0004.exr", "f.0001.left.exr"] {
        exr(&f, name, 2, &[("", "", RGB)]);
    }
    let said = f.good("run -e color*frame -i g.0003.exr -i h.0004.exr -o a.exr").err;
    assert!(said.contains("`g.0003.exr` has frame 3 and `h.0004.exr` has frame 4, so frame is 0"), "{said}");
    assert!(
        !f.good("run -e color*frame -i g.0003.exr -i h.0004.exr --frame 5 -o a.exr")
            .err
            .contains("so frame is 0")
    );
    f.good("run -e white*frame -i f.0001.left.exr -o b.exr");
    assert_eq!(f.planes("b.exr", "color")[0][0], 1.0);
}

#[test]
fn what_belongs_to_a_mesh_is_not_replaced() {
    let f = Folder::new();
    f.write("m.obj", "mtllib my m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    f.write("my m.png", "mine");
    f.write("m.obj", "mtllib my.png other.png\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    f.write("other.png", "mine");
    f.bad(1, "run -e white --mesh m.obj --size 4x4 -o other.png", &["the output `other.png` is the input"]);
    f.good("run -e white --mesh m.obj --size 4x4 -o else.png");
    assert_eq!(f.read("other.png"), b"mine");
}
