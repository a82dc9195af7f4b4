//! What the command says where an artist's habit, another program's name or a slip led to a mistake: the whole message
//! of each command is in `tests/errors/commands`.

use super::{Folder, ended};
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use exr::prelude::{ImageAttributes, IntegerBounds, LayerAttributes, WritableImage};
use std::time::{Duration, Instant};

/// Compares what a command says with the message of that name.
#[track_caller]
pub(super) fn says(f: &Folder, name: &str, arguments: &[&str]) {
    let ended = f.pse_with(arguments, b"");
    assert_ne!(ended.code, 0, "pse {arguments:?} is a mistake");
    let shown: Vec<String> = arguments.iter().map(|a| format!("{a:?}")).collect();
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../errors/commands");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, format!("$ pse {}\n{}", shown.join(" "), ended.err)));
}

/// Writes an EXR file of 4 x 4 pixels with these channels.
pub(super) fn exr(f: &Folder, name: &str, channels: &[&str]) {
    let values = |i: usize| FlatSamples::F32((0..16).map(|p| (i + 1) as f32 + p as f32 / 16.0).collect());
    let list = channels.iter().enumerate().map(|(i, c)| AnyChannel::new(*c, values(i))).collect();
    let layer =
        Layer::new((4, 4), LayerAttributes::default(), Encoding::UNCOMPRESSED, AnyChannels::sort(list));
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((4, 4)));
    exr::image::Image::from_layers(attributes, vec![layer]).write().to_file(f.path(name)).expect(name);
}

/// A file of two view layers, as Blender writes it.
fn two_layers(f: &Folder) {
    let passes =
        ["Combined.R", "Combined.G", "Combined.B", "Position.X", "Position.Y", "Position.Z", "IndexOB.X"];
    let names: Vec<String> =
        ["ViewLayer", "Props"].iter().flat_map(|l| passes.iter().map(move |p| format!("{l}.{p}"))).collect();
    exr(f, "layers.exr", &names.iter().map(String::as_str).collect::<Vec<_>>());
}

/// A file of one view layer with a cryptomatte.
fn crypto(f: &Folder) {
    let passes =
        ["Combined.R", "Combined.G", "Combined.B", "Position.X", "Position.Y", "Position.Z", "UV.U", "UV.V"];
    let mattes = ["r", "g", "b", "a"].map(|c| format!("ViewLayer.CryptoObject00.{c}"));
    let names: Vec<String> = passes.iter().map(|p| format!("ViewLayer.{p}")).chain(mattes).collect();
    exr(f, "crypto.exr", &names.iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn what_is_not_read_is_not_blamed() {
    let f = Folder::new();
    two_layers(&f);
    let map = "--map point=ViewLayer.Position";
    f.good(&format!("run -e color=point -i layers.exr {map} -o a.exr"));
    f.good(&format!("run -e point -i layers.exr {map} -o b.exr"));
    assert_eq!(f.planes("a.exr", "color"), f.planes("b.exr", "color"));
    // The colour is given on every way, and then changed.
    f.good(&format!("run -e color=point -e color*=2 -i layers.exr {map} -o c.exr"));
    f.good(&format!("run -e color=point*0.5 -e color=color+1 --vars color -i layers.exr {map} -o c.exr"));
    f.good(&format!("check a.pse -i layers.exr {map}").replace("a.pse", {
        f.write("a.pse", "color = point\n");
        "a.pse"
    }));
    // Which neighbours count is told by `surface` too, but the program does not ask for it.
    f.good(&format!("run -e turbulence(point) -i layers.exr {map} -o d.exr"));
    f.good(&format!("trace -e color=point --pixel 1,1 -i layers.exr {map}"));
    // At a pixel, too, each channel that may be meant has a line of its own.
    f.write("n.pse", "if point.x > 100\n    albedo = point\ncolor = albedo\n");
    exr(
        &f,
        "names.exr",
        &[
            "Position.X",
            "Position.Y",
            "Position.Z",
            "Here.X",
            "Here.Y",
            "Here.Z",
            "There.X",
            "There.Y",
            "There.Z",
        ],
    );
    says(&f, "maps_at_a_pixel", &["run", "n.pse", "-i", "names.exr", "-o", "e.exr"]);
    // What keeps the image's value somewhere, or is read, has to be chosen.
    says(
        &f,
        "ambiguous_kept",
        &[
            "run",
            "-e",
            "if point.x > 2",
            "-e",
            "    color = point",
            "-i",
            "layers.exr",
            "--map",
            "point=ViewLayer.Position",
            "-o",
            "e.exr",
        ],
    );
    says(
        &f,
        "ambiguous_read",
        &[
            "run",
            "-e",
            "color * point.x",
            "-i",
            "layers.exr",
            "--map",
            "point=ViewLayer.Position",
            "-o",
            "e.exr",
        ],
    );
    f.write("r.pse", "color = color * point.x\n");
    says(&f, "ambiguous_checked", &["check", "r.pse", "-i", "layers.exr"]);
}

#[test]
fn mistakes_of_all_kinds_are_reported_together() {
    let f = Folder::new();
    crypto(&f);
    f.write(
        "all.pse",
        "a = tint * 2\nb = foo(point, bar)\nc = max(1, 2\nd = Noise(point, knd = 2)\ne = point.q\nf = uv.u\n\
         g = P + albedo\ncolor = a + b + c + d + e + f + g\n",
    );
    says(&f, "all_kinds_run", &["run", "all.pse", "-i", "crypto.exr", "-o", "a.exr"]);
    says(&f, "all_kinds_scene", &["run", "all.pse", "-o", "a.exr"]);
    says(&f, "all_kinds_check", &["check", "all.pse"]);
    says(&f, "all_kinds_check_of_file", &["check", "all.pse", "-i", "crypto.exr"]);
    says(&f, "all_kinds_trace", &["trace", "all.pse", "--scene", "card"]);
    // In a session each line is one program.
    let said = ended(f.command().args(["repl", "--scene", "card"]).write_stdin("foo(1) * bar\n")).err;
    assert!(said.contains("no function `foo()`") && said.contains("no variable `bar`"), "{said}");
    // What is wrong with values from outside does not hide what the program misses.
    f.write("set.pse", "param size = 1\ncolor = white * size * colr\n");
    says(&f, "all_kinds_set", &["run", "set.pse", "--set", "siez=2", "-o", "a.exr"]);
}

#[test]
fn names_and_habits_of_other_programs() {
    let f = Folder::new();
    crypto(&f);
    let run = |name: &str, program: &str| {
        says(&f, name, &["run", "-e", program, "-i", "crypto.exr", "-o", "a.exr"]);
    };
    run("layer_in_a_name", "white * ViewLayer.CryptoObject00.g");
    run("component_u", "white * uv.u");
    run("component_u_of_a_point", "white * point.u");
    run("renderman_point", "white * P.x");
    run("renderman_normal", "N.x * white");
    run("renderman_depth", "Z * white");
    run("renderman_color", "Ci * 2");
    run("houdini_point", "@P * 2");
    run("houdini_vector", "v@P * 2");
    run("missing_depth", "depth * white");
    for word in
        ["ramp", "fit", "rand", "hash", "aces", "luma", "premult", "blur", "clamp01", "texture2D", "smooth"]
    {
        run(&format!("function_{word}"), &format!("color = {word}(point.x, 3)"));
    }
    run("web_color", "color = #ff0000");
    run("web_color_in_a_call", "color = mix(#ff8000, white, 0.5)");
    run("call_without_brackets", "color = white * sin point.x");
    run("call_without_brackets_of_a_number", "color = white * sqrt 2");
}

#[test]
fn options() {
    let f = Folder::new();
    f.write("p.pse", "param amount = 1\ncolor = amount * white\n");
    f.write("scene.glb", "glTF");
    says(&f, "set_with_commas", &["run", "p.pse", "--set", "amount=1,0.5", "-o", "a.exr"]);
    says(&f, "set_of_a_pixel", &["run", "p.pse", "--set", "amount=point.x", "-o", "a.exr"]);
    says(&f, "set_of_the_size", &["run", "p.pse", "--set", "amount=resolution.x", "-o", "a.exr"]);
    says(&f, "mesh_as_image", &["run", "p.pse", "-i", "scene.glb", "-o", "a.exr"]);
    says(&f, "missing_mesh_as_image", &["run", "p.pse", "-i", "teapot.obj", "-o", "a.exr"]);
    says(&f, "missing_folder", &["run", "p.pse", "-o", "out/a.exr"]);
    f.good("run p.pse -o made/a.exr --mkdir --size 8x8");
    f.good("run p.pse --set amount=frame/2 --frame 3 -o b.exr --size 8x8");
}

#[test]
fn nothing_from_a_file_reaches_the_terminal_raw() {
    let f = Folder::new();
    let (title, bidi) = ("\u{1b}]0;owned\u{7}", "\u{202e}");
    let raw = |text: &str| text.contains(['\u{1b}', '\u{7}', '\u{9b}', '\u{202e}', '\u{2066}']);
    let safe = |what: &str, arguments: &[&str]| {
        let ended = f.pse_with(arguments, b"");
        assert!(!raw(&ended.err) && !raw(&ended.text), "{what}: {:?} {:?}", ended.text, ended.err);
        assert!(
            ended.err.contains("\\u{") || ended.text.contains("\\u"),
            "{what}: {} {}",
            ended.text,
            ended.err
        );
        ended
    };
    // The names of channels are Latin-1.
    let layer = format!("a{title}\u{9b}31m.Position");
    let names = [format!("{layer}.X"), format!("{layer}.Y"), format!("{layer}.Z"), format!("b{title}.R")];
    exr(&f, "evil.exr", &names.each_ref().map(String::as_str));
    safe("channels", &["info", "evil.exr"]);
    safe(
        "channels offered",
        &["run", "-e", "normal", "-i", "evil.exr", "--map", "normal=nothing", "-o", "a.exr"],
    );
    // A program's own text, in excerpts, strings and names of files.
    f.write("p.pse", format!("# {title}\u{9b}31m\ncolor = nothing + 1 # {title}{bidi}\n"));
    let said = safe("excerpt", &["run", "p.pse", "-o", "a.exr"]).err;
    let (line, mark) = (said.find("nothing + 1").unwrap(), said.find("───").unwrap());
    let column = |at: usize| said[..at].chars().rev().take_while(|c| *c != '\n').count();
    assert_eq!(column(line), column(mark), "{said}");
    f.write("q.pse", format!("print(\"{title}{bidi}\")\ncolor = white\n"));
    safe("printed", &["run", "q.pse", "-o", "a.exr", "--size", "2x2"]);
    safe("tree", &["ast", "q.pse"]);
    safe("trace", &["trace", "q.pse"]);
    let json = safe("JSON", &["trace", "q.pse", "--json"]).text;
    let events: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert!(events.to_string().contains(bidi), "{events}");
    safe("missing file", &["run", "-e", "white", "-i", &format!("no{title}.exr"), "-o", "a.exr"]);
    safe("missing program", &["check", &format!("no{title}{bidi}.pse")]);
    safe("an argument", &["run", "p.pse", &format!("--threads={bidi}{title}")]);
    safe("a name of a scene", &["run", "-e", "white", "--scene", &format!("{bidi}donut")]);
    f.write(&format!("w{title}.pse"), "color = white\n");
    safe("written", &["run", &format!("w{title}.pse"), "--size", "2x2"]);
    // Meshes.
    let obj = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\ng x{title}{bidi}\nf 1 2 3\n");
    f.write("m.obj", &obj);
    safe("groups", &["info", "m.obj"]);
    f.write("n.obj", format!("v 0 0 {title}{bidi}\n"));
    safe("a quoted line", &["info", "n.obj"]);
    f.write("n.ply", format!("ply\nformat ascii 1.0\nelement vertex {title}{bidi}\nend_header\n"));
    safe("a quoted header", &["info", "n.ply"]);
    f.write(
        "n.gltf",
        "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"byteLength\": 36, \"uri\": \"x\\u001b]0;y\\u0007\\u202e.bin\"}], \
          \"bufferViews\": [{\"buffer\": 0, \"byteLength\": 36}], \
          \"accessors\": [{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\"}], \
          \"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 0}}]}], \
          \"nodes\": [{\"mesh\": 0}], \"scenes\": [{\"nodes\": [0]}], \"scene\": 0}",
    );
    safe("a URI", &["info", "n.gltf"]);
    // A text for programs is not changed on its way into one.
    let formatted = f.pse_with(&["fmt", "-"], format!("color = 1 # {bidi}\n").as_bytes());
    assert!(formatted.text.contains(bidi));
}

/// The time for mistakes without end: names are compared only for messages that are shown.
#[test]
fn many_mistakes_take_little_time() {
    let f = Folder::new();
    let many = |line: &dyn Fn(usize) -> String| (0..6000).map(|i| line(i) + "\n").collect::<String>();
    let programs: [(&str, String); 10] = [
        ("unknown variables", many(&|i| format!("a{i} = unknown_name_{i}"))),
        ("unknown functions", many(&|i| format!("a{i} = unknown_function_{i}(1)"))),
        ("both", many(&|i| format!("a{i} = unknown_function_{i}(unknown_name_{i})"))),
        ("unknown parameters", many(&|i| format!("a{i} = Noise(point, kin{i} = 1)"))),
        ("unknown kinds", many(&|i| format!("a{i} = Noise(point, kind = \"gradien{i}\")"))),
        ("components", many(&|i| format!("a{i} = point.foo{i} + uv.u"))),
        ("imports", many(&|i| format!("import \"no{i}.pse\""))),
        ("textures", many(&|i| format!("a{i} = texture(\"no{i}.png\", uv)"))),
        ("functions defined twice", many(&|i| format!("function f{}(x)\n    return x", i / 2))),
        ("frame variables", many(&|i| format!("param q{i} = unknown_name_{i}"))),
    ];
    for (what, text) in programs {
        f.write("many.pse", &text);
        for command in ["check", "run"] {
            let start = Instant::now();
            let ended = f.pse_with(&[command, "many.pse"], b"");
            let took = start.elapsed();
            assert!(!ended.err.is_empty(), "{what}");
            assert!(took < Duration::from_secs(20), "{command}, {what}: {took:?}");
            let messages = ended.err.matches("╭─[").count();
            assert!(messages <= 60, "{command}, {what}: {messages} messages");
        }
    }
}
