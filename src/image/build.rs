//! Images made by a host, from planes of its own.

use super::{Image, Metadata, Variable};
use crate::shape::Shape;
use std::borrow::Cow;
use std::fmt;

/// The planes do not form an image.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// The number of planes of a variable differs from the number of cells of its shape.
    Planes {
        /// Which variable.
        name: String,
        /// How many its shape wants.
        wanted: usize,
        /// How many there are.
        found: usize,
    },
    /// The number of pixels of a plane differs from that of the image.
    Pixels {
        /// Which variable.
        name: String,
        /// Columns times rows.
        wanted: usize,
        /// How many the plane has.
        found: usize,
    },
    /// Two variables have the same name.
    Twice(String),
    /// No memory holds so many pixels.
    TooLarge {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BuildError::Planes { name, wanted, found } => {
                write!(f, "the variable {name} needs {wanted} planes, one a component; it has {found}")
            }
            BuildError::Pixels { name, wanted, found } => {
                write!(f, "a plane of {name} holds {found} numbers for {wanted} pixels")
            }
            BuildError::TooLarge { width, height } => {
                write!(f, "an image of {width} x {height} pixels is too large")
            }
            BuildError::Twice(name) => write!(f, "two variables are called {name}"),
        }
    }
}

impl std::error::Error for BuildError {}

impl<'a> Variable<'a> {
    /// Creates a variable of this shape, with a plane for each of its cells, borrowed (`&[f32]`) or owned
    /// (`Vec<f32>`).
    ///
    /// # Errors
    /// If their number is another.
    pub fn new(
        name: &str,
        shape: Shape,
        planes: impl IntoIterator<Item = impl Into<Cow<'a, [f32]>>>,
    ) -> Result<Variable<'a>, BuildError> {
        let planes: Vec<Cow<'a, [f32]>> = planes.into_iter().map(Into::into).collect();
        let (wanted, found) = (shape.cells(), planes.len());
        if wanted != found {
            return Err(BuildError::Planes { name: name.into(), wanted, found });
        }
        Ok(Variable { name: name.into(), shape, planes })
    }
}

impl<'a> Image<'a> {
    /// Creates an image of `width` columns and `height` rows; each plane holds its pixels row by row, from the top.
    ///
    /// # Errors
    /// If a plane has another number of pixels, or two variables the same name.
    pub fn new(
        width: usize,
        height: usize,
        variables: impl IntoIterator<Item = Variable<'a>>,
    ) -> Result<Image<'a>, BuildError> {
        let variables: Vec<Variable<'a>> = variables.into_iter().collect();
        let wanted = width.checked_mul(height).ok_or(BuildError::TooLarge { width, height })?;
        for (i, variable) in variables.iter().enumerate() {
            if let Some(plane) = variable.planes.iter().find(|p| p.len() != wanted) {
                return Err(BuildError::Pixels { name: variable.name.clone(), wanted, found: plane.len() });
            }
            if variables[..i].iter().any(|v| v.name == variable.name) {
                return Err(BuildError::Twice(variable.name.clone()));
            }
        }
        Ok(Image { width, height, variables, metadata: Metadata::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_must_fit() {
        let plane = [0.0; 6];
        let good = Variable::new("depth", Shape::Scalar, [&plane[..]]);
        assert!(Image::new(3, 2, good.clone()).is_ok());
        assert!(matches!(
            Image::new(2, 2, good.clone()),
            Err(BuildError::Pixels { wanted: 4, found: 6, .. })
        ));
        assert!(matches!(Variable::new("p", Shape::Vector(3), [&plane[..]]), Err(BuildError::Planes { .. })));
        let twice = [good.clone().unwrap(), good.unwrap()];
        assert_eq!(Image::new(3, 2, twice).unwrap_err(), BuildError::Twice("depth".into()));
    }
}
