//! Functions that are asked at points of space, not at pixels.

use super::{Error, Program, RunOptions};
#[cfg(feature = "flow")]
use crate::diagnostic::Diagnostic;
use crate::image::{Image, Variable};
use std::borrow::Cow;

impl Program {
    /// What a function gives that the program was compiled for ([`Compiler::entrance`](super::Compiler::entrance)), as a
    /// plane for each component. Each plane of the arguments has a number for each point.
    pub(crate) fn ask(
        &self,
        function: &str,
        arguments: Vec<Variable<'_>>,
        options: &RunOptions<'_>,
    ) -> Result<Vec<Vec<f32>>, Error> {
        let width = arguments.first().and_then(|v| v.planes.first()).map_or(0, |p| p.len());
        let image = Image { width, height: 1, variables: arguments, ..Image::default() };
        let options = RunOptions {
            outputs: Some(vec![function.into()]),
            samples: None,
            progress: None,
            ..options.clone()
        };
        let report = self.run(&image, &options).map_err(|error| self.at_point(error, &image))?;
        let value = report.image.variables.into_iter().find(|v| v.name == function);
        Ok(value.map_or_else(Vec::new, |v| v.planes.into_iter().map(Cow::into_owned).collect()))
    }

    /// Who asked knows of no pixels: it was a point.
    fn at_point(&self, mut error: Error, asked: &Image<'_>) -> Error {
        for diagnostic in &mut error.diagnostics {
            let Some([column, _]) = diagnostic.pixel.take() else { continue };
            let Some(point) = asked.variable("point") else { continue };
            let at: Vec<String> = point.planes.iter().map(|p| p[column as usize].to_string()).collect();
            diagnostic.hints.push(format!("This happens at the point [{}].", at.join(" ")));
        }
        error
    }

    #[cfg(feature = "flow")]
    /// The error of a value of a function that cannot be used, told at the function.
    pub(crate) fn refuse(&self, function: &str, message: String, hint: &str) -> Error {
        let found = self.resolved.functions.iter().find(|f| f.name == function);
        let diagnostic = match found {
            Some(found) => Diagnostic::error("value", message, found.span),
            None => Diagnostic::bare("value", message),
        };
        let diagnostics = vec![diagnostic.hint(hint)];
        Error { diagnostics, sources: self.sources().clone(), cancelled: false }
    }
}
