//! A function of a program, asked at points of space.

use crate::host::Host;
use crate::image::Variable;
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
        self.program.ask(&self.name, arguments, options)
    }

    /// The error of a value that cannot be used, told at the function.
    pub fn refuse(&self, message: String, hint: &str) -> Error {
        self.program.refuse(&self.name, message, hint)
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
