//! A function of a program, asked at points of space.

use crate::diagnostic::Diagnostic;
use crate::host::Host;
use crate::image::{Image, Variable};
use crate::program::{Compiler, Error, Program, RunOptions};
use crate::shape::Shape;
use std::borrow::Cow;

/// The function, compiled by itself.
pub(super) struct Field {
    program: Program,
    name: String,
}

/// As many points are asked at once: enough for all threads, few enough that progress is seen.
pub(super) const CHUNK: usize = 1 << 18;

impl Field {
    pub fn compile(
        host: &dyn Host,
        file: &str,
        text: &str,
        function: &str,
        arguments: &[&str],
    ) -> Result<Field, Error> {
        let compiler = Compiler::new().host(host).entrance(function, arguments);
        Ok(Field { program: compiler.compile(file, text)?, name: function.into() })
    }

    pub fn program(&self) -> &Program {
        &self.program
    }

    /// Its values: a plane for each component, all of as many numbers as the planes of the arguments have.
    pub fn ask(
        &self,
        arguments: Vec<Variable<'_>>,
        options: &RunOptions<'_>,
    ) -> Result<Vec<Vec<f32>>, Error> {
        let count = arguments.first().and_then(|v| v.planes.first()).map_or(0, |p| p.len());
        let image = Image { width: count, height: 1, variables: arguments, ..Image::default() };
        let options = RunOptions {
            outputs: Some(vec![self.name.clone()]),
            samples: None,
            progress: None,
            ..options.clone()
        };
        let mut report = self.program.run(&image, &options)?;
        let Some(value) = report.image.variables.pop() else { return Ok(Vec::new()) };
        Ok(value.planes.into_iter().map(Cow::into_owned).collect())
    }

    /// The error of a value that cannot be used, told at the function.
    pub fn refuse(&self, message: String, hint: &str) -> Error {
        let function = self.program.resolved().functions.iter().find(|f| f.name == self.name);
        let diagnostic = match function {
            Some(function) => Diagnostic::error("value", message, function.span),
            None => Diagnostic::bare("value", message),
        };
        let diagnostics = vec![diagnostic.hint(hint)];
        Error { diagnostics, sources: self.program.sources().clone(), cancelled: false }
    }

    /// What is wrong if its value is no vector of 3.
    pub fn no_vector(&self, found: usize) -> Error {
        let message = match found {
            1 => format!("`{}()` gives a scalar, not a vector of 3", self.name),
            _ => format!("`{}()` gives {found} numbers, not a vector of 3", self.name),
        };
        self.refuse(message, "Return a vector such as [x y z].")
    }
}

/// A variable that is a vector of 3.
pub(super) fn vector(name: &str, vectors: impl Iterator<Item = [f32; 3]> + Clone) -> Variable<'static> {
    let plane = |i: usize| Cow::Owned(vectors.clone().map(|v| v[i]).collect());
    Variable { name: name.into(), shape: Shape::Vector(3), planes: (0..3).map(plane).collect() }
}

/// A variable that is a scalar.
pub(super) fn scalar(name: &str, numbers: Vec<f32>) -> Variable<'static> {
    Variable { name: name.into(), shape: Shape::Scalar, planes: vec![Cow::Owned(numbers)] }
}
