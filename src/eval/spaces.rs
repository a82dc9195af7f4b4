//! Named spaces, and where the eye is: what a frame knows of its camera.

use super::run::Options;
use crate::diagnostic::{Diagnostic, Span};
use crate::image::{Attributes, Matrix4, Metadata};
use crate::resolve::names;
use crate::value::PixelValue;

/// The names under which renderers write the matrix from the world to a space; the first is OpenEXR's own.
const ATTRIBUTES: [(&str, &[&str]); 2] =
    [("camera", &["worldToCamera", "Nl"]), ("screen", &["worldToNDC", "worldToScreen", "NP"])];

const WORLD: Matrix4 =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// The matrix from the world, the space of `point`, to that space: as it was set, or as the image's header has it.
pub fn space(name: &str, metadata: &Metadata, options: &Options<'_>) -> Option<PixelValue> {
    let set = options.spaces.iter().rev().find(|(n, _)| n == name);
    let found = || match name {
        "world" => Some(WORLD),
        _ => of_header(name, &metadata.attributes),
    };
    set.map(|(_, matrix)| *matrix).or_else(found).map(|m| PixelValue::vector(m.map(PixelValue::from)))
}

fn of_header(name: &str, attributes: &Attributes) -> Option<Matrix4> {
    let (_, written) = ATTRIBUTES.iter().find(|(space, _)| *space == name)?;
    written.iter().find_map(|attribute| attributes.matrix(attribute))
}

/// The position of the eye in the world, if the camera is known: the origin of the camera's space, or else the point that the
/// matrix to the screen sees nowhere.
pub fn eye(metadata: &Metadata, options: &Options<'_>) -> Option<[f32; 3]> {
    let of = |name: &str| {
        let set = options.spaces.iter().rev().find(|(n, _)| n == name).map(|(_, matrix)| *matrix);
        set.or_else(|| of_header(name, &metadata.attributes))
    };
    let camera = || of("camera").and_then(origin);
    options.eye.or_else(camera).or_else(|| of("screen").and_then(center_of_projection))
}

/// The point that a matrix takes to the origin.
fn origin(matrix: Matrix4) -> Option<[f32; 3]> {
    let rows = matrix.map(|row| glam::DVec4::from_array(row.map(f64::from)));
    let inverse = glam::DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose().inverse();
    let eye = inverse.w_axis / inverse.w_axis.w;
    eye.is_finite().then(|| eye.truncate().to_array().map(|x| x as f32))
}

/// The point that a projection sees nowhere; `None` if its rays are parallel.
fn center_of_projection(screen: Matrix4) -> Option<[f32; 3]> {
    let [x, y, _, w] = screen.map(|row| glam::DVec4::from_array(row.map(f64::from)));
    let lens = glam::DMat3::from_cols(x.truncate(), y.truncate(), w.truncate()).transpose();
    let eye = lens.inverse() * -glam::DVec3::new(x.w, y.w, w.w);
    eye.is_finite().then(|| eye.to_array().map(|x| x as f32))
}

/// How a user says where the eye is, without a change of the program.
pub const CAMERA: &str = "Or leave the program as it is, and run it with `--eye 0,-5,5`.";

/// The error of a program that reads `eye` where the camera is not known; `hint` says why it was not found from the points.
pub fn no_eye(span: Span, hint: Option<&str>) -> Diagnostic {
    let error = Diagnostic::error("input", "the position of the eye is unknown", span)
        .hint("EXR files store it in the attribute worldToCamera; this input has none.");
    hint.into_iter()
        .fold(error, |error, hint| error.hint(hint))
        .hint("Declare it in the program: `param eye = [0 -5 5]`.")
        .hint(CAMERA)
}

/// Whether an image's header tells the matrix to that space.
pub fn has_space(name: &str, about: &Metadata) -> bool {
    of_header(name, &about.attributes).is_some()
}

/// The error of a space that is not known.
pub fn unknown(name: &str, span: Span, metadata: &Metadata, options: &Options<'_>) -> Diagnostic {
    let error = Diagnostic::error("space", format!("the space \"{name}\" is not defined"), span);
    let mut known: Vec<&str> = vec!["world"];
    known.extend(options.spaces.iter().map(|(name, _)| name.as_str()));
    let headers = ATTRIBUTES.iter().map(|(space, _)| *space);
    known.extend(headers.filter(|space| of_header(space, &metadata.attributes).is_some()));
    known.sort_unstable();
    known.dedup();
    let near = names::nearest(name, known.iter().copied()).map(|near| format!("Did you mean \"{near}\"?"));
    let error = near.into_iter().fold(error, Diagnostic::hint);
    let error = match ATTRIBUTES.iter().find(|(space, _)| *space == name) {
        Some((_, written)) => {
            error.hint(format!("EXR files store it in the attribute {}; this input has none.", written[0]))
        }
        None => error,
    };
    let hint = options.camera_hint.filter(|_| ATTRIBUTES.iter().any(|(space, _)| *space == name));
    let error = hint.into_iter().fold(error, |error, hint| error.hint(hint));
    let quoted: Vec<String> = known.iter().map(|name| format!("\"{name}\"")).collect();
    error
        .hint(format!("Give its matrix from world space: `--space {name}='translation([0 0 1])'`."))
        .hint(format!("Known: {}.", quoted.join(", ")))
}
