//! What can be wrong with the wish for a scene, and what to do about it.

use crate::diagnostic::Diagnostic;
use std::fmt;

/// An error of a scene or view. The text gives the fact and the remedy.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneError {
    /// No scene has this name.
    UnknownScene {
        /// As asked for.
        name: String,
        /// The most similar name there is, if any is similar.
        nearest: Option<&'static str>,
        /// All names.
        names: Vec<&'static str>,
    },
    /// No columns, no rows, or too many pixels.
    BadSize {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// The planes of a picture of this size do not fit into memory.
    OutOfMemory {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// A point of the camera is not finite or too far away.
    BadPoint {
        /// `eye` or `look_at`.
        what: &'static str,
        /// As given.
        point: [f64; 3],
        /// The largest coordinate allowed.
        limit: f64,
    },
    /// The eye and the point that it looks at are the same.
    NoDirection {
        /// That point.
        point: [f64; 3],
    },
    /// The angle is not between 0 and 180 degrees.
    BadFov(f64),
    /// The scale is out of range.
    BadScale(f64),
    /// The eye is inside a solid, in the plane of a sheet, or under water.
    EyeInside {
        /// What it is in, as a noun.
        what: &'static str,
        /// The scene's default eye, at the scale asked for.
        instead: [f64; 3],
    },
    /// The mesh has no faces.
    NoFaces,
    /// The mesh has more triangles than 32 bits can number.
    TooManyTriangles,
    /// A face of very many corners whose outline crosses itself.
    CrossingFace {
        /// Which, counted from 1.
        face: usize,
        /// How many corners it has.
        corners: u32,
    },
    /// The origin must be in front of the eye for this scene.
    OriginBehind,
    /// A text is not a size or a point.
    BadText {
        /// The text.
        text: String,
        /// What it should be, with an example.
        expected: &'static str,
    },
}

impl SceneError {
    /// The fact, one sentence without a full stop.
    pub fn message(&self) -> String {
        use SceneError::*;
        match self {
            UnknownScene { name, .. } => format!("there is no scene `{name}`"),
            BadSize { width, height } if *width == 0 || *height == 0 => {
                format!("a picture of {width}x{height} has no pixels")
            }
            BadSize { width, height } => format!("a picture of {width}x{height} is too large"),
            OutOfMemory { width, height } => {
                format!("not enough memory for a picture of {width}x{height}")
            }
            BadPoint { what, point, .. } if point.iter().any(|c| !c.is_finite()) => {
                format!("{what} {} is not a finite point", Point(*point))
            }
            BadPoint { what, point, .. } => format!("{what} {} is too far away", Point(*point)),
            NoDirection { point } => {
                format!("the eye and the point that it looks at are the same, {}", Point(*point))
            }
            BadFov(fov) => format!("a field of view of {fov} degrees shows nothing"),
            BadScale(scale) => format!("a scene cannot be scaled by {scale}"),
            EyeInside { what, .. } => format!("the eye is in the {what}"),
            NoFaces => "the mesh has no faces with an area, so nothing is visible".into(),
            TooManyTriangles => "the mesh has more than 4 billion triangles".into(),
            CrossingFace { face, corners } => {
                format!("the outline of face {face}, of {corners} corners, crosses itself")
            }
            OriginBehind => {
                "the scene's card goes through the origin, which is not in front of the eye".into()
            }
            BadText { text, .. } if text.trim().is_empty() => "the text is empty".into(),
            BadText { text, .. } => format!("`{text}` cannot be read"),
        }
    }

    /// The remedy, without a full stop.
    pub fn hint(&self) -> String {
        use SceneError::*;
        match self {
            UnknownScene { nearest: Some(nearest), .. } => format!("did you mean `{nearest}`?"),
            UnknownScene { names, .. } => format!("the scenes are {}", names.join(", ")),
            BadSize { width, height } if *width == 0 || *height == 0 => {
                "give at least one column and one row".into()
            }
            BadSize { .. } => format!("give at most {} pixels", super::gather::MAX_PIXELS),
            OutOfMemory { .. } => "give a smaller size".into(),
            BadPoint { limit, .. } => format!("give three numbers between -{limit} and {limit}"),
            NoDirection { .. } => "move the eye away from the point it looks at".into(),
            BadFov(_) => "give an angle between 0 and 180 degrees, for example 40".into(),
            BadScale(_) => "give a number from 0.001 to 1000".into(),
            EyeInside { instead, .. } => format!("move it out, for example to {}", Point(*instead)),
            NoFaces => "give a mesh with polygons; points and lines are not shown".into(),
            TooManyTriangles => "give a coarser mesh".into(),
            CrossingFace { .. } => format!(
                "split the face; a face that crosses itself can have at most {} corners",
                crate::mesh::MAX_EARS
            ),
            OriginBehind => "look towards 0,0,0, or step back from it".into(),
            BadText { expected, .. } => format!("give {expected}"),
        }
    }

    /// The same with its points in a space that is so much larger, as the user gave them.
    pub(super) fn scaled(mut self, scale: f64) -> SceneError {
        match &mut self {
            SceneError::BadPoint { point, limit, .. } => {
                *point = point.map(|c| c * scale);
                *limit *= scale;
            }
            SceneError::NoDirection { point } => *point = point.map(|c| c * scale),
            _ => {}
        }
        self
    }

    /// The same with its points moved from a local origin to the world.
    pub(super) fn moved(mut self, origin: glam::DVec3) -> SceneError {
        match &mut self {
            SceneError::BadPoint { point, limit, .. } => {
                *point = (glam::DVec3::from(*point) + origin).to_array();
                *limit += origin.abs().max_element();
            }
            SceneError::NoDirection { point } => *point = (glam::DVec3::from(*point) + origin).to_array(),
            _ => {}
        }
        self
    }

    /// Converts the error to a diagnostic.
    pub fn diagnostic(&self) -> Diagnostic {
        Diagnostic::bare("scene", self.message()).hint(self.hint())
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.message(), self.hint())
    }
}

impl std::error::Error for SceneError {}

/// A point as the command line takes it: `1,-2.5,0`.
struct Point([f64; 3]);

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "{x},{y},{z}")
    }
}
