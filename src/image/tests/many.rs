//! Files with very many names of one kind: what takes time for each pair of them would not come to an end here.

use super::super::bind::{ChannelName, bind};
use super::super::part_names::{self, PartNames};
use super::*;
use exr::meta::attribute::AttributeValue;

const MANY: usize = 100_000;

#[test]
fn attributes() {
    let variable = Variable::new("color", Shape::Scalar, [vec![0.5; 4]]).unwrap();
    let mut image = Image::new(2, 2, [variable]).unwrap();
    let text = |i: usize| AttributeValue::Text(exr::prelude::Text::from(format!("{i}").as_str()));
    let plain = (0..MANY).map(|i| (format!("a{i}"), text(i)));
    // Each of these describes a cryptomatte.
    let mattes = (0..MANY).map(|i| (format!("cryptomatte/{i}/name"), text(i)));
    image.metadata.attributes.list = plain.chain(mattes).collect();
    let bytes = encode("a.exr", Format::Exr, &image, &WriteOptions::default()).unwrap();
    let file = open(bytes);
    // Those of mattes whose channels are not written are left out.
    assert!(file.metadata().attributes.iter().count() >= MANY);
    assert!(file.metadata().attributes.iter().any(|(name, value)| name == "a99999" && value == "99999"));
}

#[test]
fn layers_and_channels() {
    let layers =
        (0..MANY / 3).flat_map(|i| ["R", "G", "B"].map(|c| ChannelName::plain(&format!("l{i}.{c}"))));
    let names: Vec<ChannelName> = layers.collect();
    let bound = bind("a.exr", &names, &[]).unwrap();
    assert_eq!(bound.bindings.len(), MANY / 3);
    let stems: Vec<ChannelName> =
        (0..MANY).map(|i| ChannelName::plain(&format!("p{}{}", i / 2, ["x", "y"][i % 2]))).collect();
    assert_eq!(bind("a.exr", &stems, &[]).unwrap().bindings.len(), MANY);
    // All in one group that is ambiguous.
    let same: Vec<ChannelName> =
        (0..MANY / 10).map(|i| ChannelName::plain(&format!("l{i}.depth.Z"))).collect();
    let depth = bind("a.exr", &same, &[]).unwrap().bindings.remove(0);
    assert_eq!((depth.name.as_str(), depth.candidates.len()), ("depth", MANY / 10));
}

#[test]
fn parts_and_views() {
    let of = |name: String, view: Option<String>| PartNames {
        name,
        view,
        views: Vec::new(),
        channels: vec!["R".into()],
    };
    let numbered: Vec<PartNames> = (0..MANY / 4).map(|i| of(format!("part{i}"), None)).collect();
    assert_eq!(part_names::name(&numbered).len(), MANY / 4);
    let viewed = (0..MANY / 4).map(|i| of(format!("rgba.v{i}"), Some(format!("v{i}"))));
    let bare = (0..MANY / 4).map(|i| of(format!("depth_v{i}"), None));
    let names = part_names::name(&viewed.chain(bare).collect::<Vec<_>>());
    assert_eq!(names.iter().filter(|name| name.view.as_deref() == Some("v77")).count(), 2);
}
