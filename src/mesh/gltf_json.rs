//! The JSON of a glTF file: only what a mesh is made of is looked at.
//!
//! The crate `gltf` checks a whole document and refuses it for a texture without an image, an `extras` that is no object, or an
//! integer that is written `1.0`, all of which the specification allows; and it takes a node's numbers as `f32`. So the few
//! properties that are needed are read here from the generic JSON, each when it is needed.

use super::read::Wrong;
use serde_json::Value;

/// Extensions that a file may require: without them the shape is the same, or they are known here. Those that end in `_` stand
/// for all that begin so.
const KNOWN: [&str; 12] = [
    "KHR_mesh_quantization",
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_xmp",
    "KHR_animation_pointer",
    "EXT_texture_",
    "EXT_lights_",
    "EXT_materials_",
    "MSFT_texture_",
    "MSFT_packing_",
    "ADOBE_materials_",
];

/// A document.
pub(super) struct Document {
    root: Value,
}

impl Document {
    /// Parses a document, if it is of version 2 and requires nothing that is not known.
    pub fn parse(text: &[u8]) -> Result<Document, Wrong> {
        // A text in a binary file is filled up with blanks, or with zeros by some programs.
        let end = text.iter().rposition(|&b| b != 0 && !b.is_ascii_whitespace()).map_or(0, |last| last + 1);
        let root: Value =
            serde_json::from_slice(&text[..end]).map_err(|e| format!("its JSON cannot be read: {e}"))?;
        if !root.is_object() {
            return Err("its JSON is not glTF: it is not an object".into());
        }
        let document = Document { root };
        document.check()?;
        Ok(document)
    }

    fn check(&self) -> Result<(), Wrong> {
        let asset = self.root.get("asset").ok_or("its JSON is not glTF: `asset` is missing")?;
        for name in ["version", "minVersion"] {
            // A string, but a number in old files.
            let version =
                asset.get(name).map(|value| value.as_str().map_or(value.to_string(), str::to_string));
            if let Some(version) = version.filter(|v| v.split('.').next() != Some("2")) {
                return Err(format!("it uses glTF version {version}; pse reads version 2"));
            }
        }
        let known = |name: &str| KNOWN.iter().any(|k| name == *k || k.ends_with('_') && name.starts_with(k));
        let required = list(&self.root, "extensionsRequired").iter().filter_map(Value::as_str);
        match required.into_iter().find(|name| !known(name)) {
            Some(name) => Err(format!("it requires the extension {name}, which pse does not read")),
            None => Ok(()),
        }
    }

    /// All objects of a kind: `nodes`, `meshes`. There may be none.
    pub fn all(&self, kind: &str) -> &[Value] {
        list(&self.root, kind)
    }

    /// The object of a kind with that index.
    pub fn one(&self, kind: &str, index: usize) -> Result<&Value, Wrong> {
        self.all(kind).get(index).ok_or_else(|| {
            let count = self.all(kind).len();
            format!("it refers to {kind}[{index}], but there are only {count}")
        })
    }

    /// The scene that is to be shown first, or else the first one.
    pub fn scene(&self) -> Result<Option<&Value>, Wrong> {
        match index(&self.root, "scene")? {
            Some(index) => self.one("scenes", index).map(Some),
            None => Ok(self.all("scenes").first()),
        }
    }
}

/// A list that an object has by that name; empty if there is none.
pub(super) fn list<'a>(of: &'a Value, name: &str) -> &'a [Value] {
    of.get(name).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// A text that an object has by that name.
pub(super) fn text<'a>(of: &'a Value, name: &str) -> Option<&'a str> {
    of.get(name).and_then(Value::as_str)
}

/// A value as an integer from 0. JSON does not tell 1 from 1.0.
pub(super) fn integer(value: &Value) -> Option<usize> {
    let whole = |x: f64| (x >= 0.0 && x.fract() == 0.0 && x < 9e15).then_some(x as u64);
    value.as_u64().or_else(|| value.as_f64().and_then(whole)).and_then(|x| usize::try_from(x).ok())
}

/// An integer that an object may have by that name: an index, a length.
pub(super) fn index(of: &Value, name: &str) -> Result<Option<usize>, Wrong> {
    match of.get(name) {
        None | Some(Value::Null) => Ok(None),
        Some(value) => integer(value)
            .map(Some)
            .ok_or_else(|| format!("`{name}` is {}, which is not a whole number", short(value))),
    }
}

/// An integer that an object must have.
pub(super) fn required(of: &Value, name: &str) -> Result<usize, Wrong> {
    index(of, name)?.ok_or_else(|| format!("`{name}` is missing"))
}

/// Indices that an object may have as a list.
pub(super) fn indices(of: &Value, name: &str) -> Result<Vec<usize>, Wrong> {
    let wrong = |value: &Value| format!("`{name}` has {}, which is not a whole number", short(value));
    list(of, name).iter().map(|value| integer(value).ok_or_else(|| wrong(value))).collect()
}

/// So many numbers that an object may have as a list.
pub(super) fn numbers<const N: usize>(of: &Value, name: &str) -> Result<Option<[f64; N]>, Wrong> {
    let Some(value) = of.get(name).filter(|value| !value.is_null()) else { return Ok(None) };
    let numbers: Option<Vec<f64>> =
        value.as_array().and_then(|list| list.iter().map(Value::as_f64).collect());
    let numbers = numbers.and_then(|list| list.try_into().ok());
    numbers.map(Some).ok_or_else(|| format!("`{name}` is {}, not a list of {N} numbers", short(value)))
}

/// An extension that an object has.
pub(super) fn extension<'a>(of: &'a Value, name: &str) -> Option<&'a Value> {
    of.get("extensions")?.get(name)
}

/// A value as text, not more than a line's worth of it.
fn short(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}
