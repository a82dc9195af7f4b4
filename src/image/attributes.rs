//! What a header says beside channels and windows, and passes through from inputs to outputs.

use super::Matrix4;
#[cfg(feature = "exr")]
use super::header_exr::text as header_text;
#[cfg(feature = "exr")]
use exr::meta::attribute::AttributeValue;

/// A value of a header attribute, of which only matrices come without OpenEXR files.
#[cfg(not(feature = "exr"))]
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum AttributeValue {
    /// Four rows, for points that are rows.
    Matrix4x4([f32; 16]),
}

/// EXR header attributes that pass through from an input to an output, sorted by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attributes {
    pub(crate) list: Vec<(String, AttributeValue)>,
}

impl Attributes {
    /// Names and values as readable text.
    pub fn iter(&self) -> impl Iterator<Item = (&str, String)> {
        self.list.iter().map(|(name, value)| (name.as_str(), text_of(value)))
    }

    /// The matrix with this name, for points that are columns (in OpenEXR they are rows).
    pub fn matrix(&self, name: &str) -> Option<Matrix4> {
        let (_, value) = self.list.iter().find(|(n, _)| n == name)?;
        match value {
            AttributeValue::Matrix4x4(m) => {
                Some(std::array::from_fn(|row| std::array::from_fn(|column| m[column * 4 + row])))
            }
            #[cfg(feature = "exr")]
            _ => None,
        }
    }

    /// Sets the matrix with this name, for points that are columns.
    pub fn set_matrix(&mut self, name: &str, matrix: &Matrix4) {
        let rows = std::array::from_fn(|i| matrix[i % 4][i / 4]);
        self.list.retain(|(n, _)| n != name);
        self.list.push((name.to_string(), AttributeValue::Matrix4x4(rows)));
        self.list.sort_by(|a, b| a.0.cmp(&b.0));
    }
}

#[cfg(feature = "exr")]
/// An attribute's value for people, cut if it is long.
fn text_of(value: &AttributeValue) -> String {
    let row = |v: &[f32]| v.iter().map(|x| x.to_string()).collect::<Vec<_>>().join(" ");
    let shown = match value {
        AttributeValue::Text(value) => header_text(value.as_slice()),
        AttributeValue::TextVector(list) => {
            list.iter().map(|value| header_text(value.as_slice())).collect::<Vec<String>>().join(" ")
        }
        AttributeValue::F32(v) => v.to_string(),
        AttributeValue::F64(v) => v.to_string(),
        AttributeValue::I32(v) => v.to_string(),
        AttributeValue::Rational((a, b)) => format!("{a}/{b}"),
        AttributeValue::FloatVec2(v) => row(&[v.0, v.1]),
        AttributeValue::FloatVec3(v) => row(&[v.0, v.1, v.2]),
        AttributeValue::IntVec2(v) => format!("{} {}", v.0, v.1),
        AttributeValue::IntVec3(v) => format!("{} {} {}", v.0, v.1, v.2),
        AttributeValue::Matrix3x3(m) => row(m),
        AttributeValue::Matrix4x4(m) => row(m),
        AttributeValue::Bytes { bytes, .. } => format!("{} bytes", bytes.len()),
        AttributeValue::Custom { kind, bytes } => format!("{} bytes of {kind}", bytes.len()),
        other => format!("{other:?}"),
    };
    let mut text: String = shown.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if let Some((cut, _)) = text.char_indices().nth(100) {
        text.truncate(cut);
        text.push('…');
    }
    text
}

/// A matrix for people.
#[cfg(not(feature = "exr"))]
fn text_of(AttributeValue::Matrix4x4(rows): &AttributeValue) -> String {
    rows.map(|x| x.to_string()).join(" ")
}
