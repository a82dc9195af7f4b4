//! What views are called, and what `--map` makes of names that several channels have.

use super::*;

/// Channels of a part, `name|view: R G B`, a line each.
fn stereo(parts: &[(&'static str, &'static str, &[&str])]) -> Vec<u8> {
    let parts = parts.iter().map(|(name, view, channels)| Part {
        view: Some(*view).filter(|view| !view.is_empty()),
        ..part(Some(name), (2, 2), channels)
    });
    exr_bytes(parts.collect(), (2, 2))
}

fn mapped(bytes: &[u8], map: &str) -> Result<File, ImageError> {
    let options = ReadOptions { maps: vec![map.parse()?], raw: false };
    read(Input::from_bytes("test.exr", bytes.to_vec()), &options)
}

fn whole(error: &ImageError) -> String {
    format!("{}\n{}", error.message, error.hints.join("\n"))
}

const RGB: &[&str] = &["R", "G", "B"];

#[test]
fn channels_without_a_view_are_the_picture() {
    for parts in [
        [("rgba", "", RGB), ("rgba.right", "right", RGB)],
        [("right", "right", RGB), ("main", "", RGB)],
        [("beauty", "", RGB), ("right_rgba", "right", RGB)],
    ] {
        let bytes = stereo(&parts);
        let file = open(bytes.clone());
        let of = |name: &str| channels_of(&file, name);
        let hero = parts.iter().position(|(_, view, _)| view.is_empty()).unwrap();
        let own = |part: usize| format!("{}.R", parts[part].0);
        assert_eq!(of("color")[0], own(hero), "{parts:?}");
        assert_eq!(of("right.color")[0], own(1 - hero), "{parts:?}");
    }
    // What no view has belongs to all: the first view is the picture.
    let file =
        open(stereo(&[("rgba.left", "left", RGB), ("rgba.right", "right", RGB), ("depth", "", &["Z"])]));
    assert_eq!(channels_of(&file, "color")[0], "rgba.left.R");
    assert_eq!(channels_of(&file, "right.color")[0], "rgba.right.R");
    assert_eq!(channels_of(&file, "depth"), ["depth.Z"]);
    // Beside a picture of no view both views have names of their own.
    let file = open(stereo(&[("rgba.left", "left", RGB), ("rgba.right", "right", RGB), ("rgba", "", RGB)]));
    assert_eq!(channels_of(&file, "color")[0], "rgba.R");
    assert_eq!(channels_of(&file, "left.color")[0], "rgba.left.R");
    assert_eq!(channels_of(&file, "right.color")[0], "rgba.right.R");
}

/// Every candidate's name chooses that candidate and no other.
fn choices_work(bytes: &[u8], name: &str) {
    let file = open(bytes.to_vec());
    let error = file.find(name).expect_err("several");
    let maps: Vec<&str> = error.hints.iter().filter_map(|hint| hint.split("--map ").nth(1)).collect();
    assert!(maps.len() > 1, "{name}: {}", whole(&error));
    let mut chosen: Vec<Vec<String>> = Vec::new();
    for map in maps {
        let map = map.trim_matches('\'');
        let file = mapped(bytes, map).unwrap_or_else(|e| panic!("{map}: {}", whole(&e)));
        let channels = channels_of(&file, name);
        assert!(!chosen.contains(&channels), "{map}");
        chosen.push(channels);
    }
}

#[test]
fn what_is_offered_chooses_one() {
    // A layer with two kinds of components; parts whose names differ in case alone; a part that is called as a channel.
    let names =
        ["a.Position.X", "a.Position.Y", "a.Position.Z", "a.Position.R", "a.Position.G", "a.Position.B"];
    choices_work(&exr_bytes(vec![part(None, (2, 2), &names)], (2, 2)), "point");
    choices_work(&stereo(&[("N", "", &["X", "Y", "Z"]), ("n", "", &["X", "Y", "Z"])]), "normal");
    choices_work(&stereo(&[("a.rgba", "", RGB), ("b.rgba", "", RGB), ("b", "", &["rgba.R"])]), "color");
    // Views of the names of components.
    let bytes = stereo(&[("rgba.L", "L", RGB), ("rgba.R", "R", RGB)]);
    for (map, first) in [
        ("color=rgba", "rgba.L.R"),
        ("color=rgba.L", "rgba.L.R"),
        ("color=R.rgba", "rgba.R.R"),
        ("color=rgba.R.R,rgba.R.G,rgba.R.B", "rgba.R.R"),
    ] {
        let file = mapped(&bytes, map).unwrap_or_else(|e| panic!("{map}: {}", whole(&e)));
        assert_eq!(channels_of(&file, "color")[0], first, "{map}");
    }
    let file = open(bytes);
    assert_eq!(channels_of(&file, "color")[0], "rgba.L.R");
    assert_eq!(channels_of(&file, "R.color")[0], "rgba.R.R");
}

#[test]
fn channels_have_names_of_their_own() {
    let file = open(stereo(&[("R", "", &["R"]), ("r", "", &["R"])]));
    let mut names: Vec<&str> = file.channels().iter().map(|c| c.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), 2, "{names:?}");
}

#[test]
fn a_variable_of_a_view_is_mapped_by_its_name() {
    let bytes = stereo(&[("left", "left", &["center.R", "center.G", "center.B"]), ("right", "right", RGB)]);
    let file = mapped(&bytes, "right.color=center").unwrap();
    assert_eq!(channels_of(&file, "right.color")[0], "left.center.R");
    let error = mapped(&bytes, "middle.color=center").err().unwrap();
    assert_eq!(
        whole(&error),
        "--map middle.color=center: `test.exr` has no view `middle`\n\
         To name an image, write -i middle=FILE."
    );
}

#[test]
fn too_few_channels_are_no_vector() {
    let names = ["a.Position.X", "a.Position.Y", "a.Position.Z", "a.Depth.Z", "uv.U"];
    let bytes = exr_bytes(vec![part(None, (2, 2), &names)], (2, 2));
    let error = mapped(&bytes, "point=Position.X").err().unwrap();
    assert_eq!(
        whole(&error),
        "--map point=Position.X: `point` has 3 components, found 1 channel\n\
         Give the whole group: --map point=a.Position."
    );
    let error = mapped(&bytes, "color=Position.X,Position.Y").err().unwrap();
    assert!(error.message.ends_with("`color` has 3 components, found 2 channels"), "{error:?}");
    assert!(mapped(&bytes, "normal=Depth").is_err() && mapped(&bytes, "uv=Position.X").is_err());
    // One channel is a grey colour.
    let file = mapped(&bytes, "color=Depth").unwrap();
    assert_eq!(channels_of(&file, "color"), ["a.Depth.Z"; 3]);
    assert_eq!(file.notes(), ["--map color=Depth: using one channel for red, green and blue"]);
    assert!(mapped(&bytes, "point=a.Position").unwrap().notes().is_empty());
    assert!(mapped(&bytes, "height=Position.X").is_ok());
}
