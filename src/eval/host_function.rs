//! Functions that the embedding program adds to the language.

use crate::shape::Shape;
use crate::value::{Lanes, PixelValue, Plane, Value};
use std::fmt;

type ForPixel = dyn Fn(&[PixelValue]) -> Result<PixelValue, String> + Send + Sync;
type ForBatch = dyn Fn(&BatchArguments<'_>) -> Result<BatchResult, String> + Send + Sync;

enum Body {
    Pixel(Box<ForPixel>),
    Batch(Box<ForBatch>),
}

/// A function written in Rust, called from programs like any other. It must answer the same to the same
/// arguments: it is called in any order, from any thread, and for whole batches.
pub struct HostFunction {
    name: String,
    params: Vec<String>,
    body: Body,
}

/// The arguments of a call for a batch of lanes.
pub struct BatchArguments<'a> {
    n: usize,
    shapes: Vec<&'a Shape>,
    lanes: Vec<Vec<Lanes>>,
}

/// What a function gives for a batch: a shape, and a plane of one number a lane for each of its cells.
pub struct BatchResult {
    /// The same in every lane.
    pub shape: Shape,
    /// `shape.cells()` planes of as many numbers as there are lanes.
    pub planes: Vec<Vec<f32>>,
}

impl BatchArguments<'_> {
    /// How many lanes there are.
    pub fn lanes(&self) -> usize {
        self.n
    }

    /// How many arguments.
    pub fn count(&self) -> usize {
        self.shapes.len()
    }

    /// The shape of an argument, counted from 0.
    pub fn shape(&self, arg: usize) -> &Shape {
        self.shapes[arg]
    }

    /// One cell of an argument, one number a lane. Lanes that are not active may hold anything.
    pub fn plane(&self, arg: usize, cell: usize) -> &[f32] {
        self.lanes[arg][cell].get(self.n)
    }
}

impl HostFunction {
    /// A function of one pixel's values.
    pub fn for_pixel(
        name: &str,
        params: &[&str],
        f: impl Fn(&[PixelValue]) -> Result<PixelValue, String> + Send + Sync + 'static,
    ) -> HostFunction {
        let params = params.iter().map(|p| p.to_string()).collect();
        HostFunction { name: name.into(), params, body: Body::Pixel(Box::new(f)) }
    }

    /// A function of a batch's planes.
    pub fn for_batch(
        name: &str,
        params: &[&str],
        f: impl Fn(&BatchArguments<'_>) -> Result<BatchResult, String> + Send + Sync + 'static,
    ) -> HostFunction {
        let params = params.iter().map(|p| p.to_string()).collect();
        HostFunction { name: name.into(), params, body: Body::Batch(Box::new(f)) }
    }

    /// Its name in programs.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The names of its parameters.
    pub fn params(&self) -> &[String] {
        &self.params
    }

    /// As a call is written.
    pub fn signature(&self) -> String {
        format!("{}({})", self.name, self.params.join(", "))
    }

    /// One lane's value.
    pub(super) fn call_pixel(&self, args: &[PixelValue]) -> Option<Result<PixelValue, String>> {
        match &self.body {
            Body::Pixel(f) => Some(f(args)),
            Body::Batch(_) => None,
        }
    }

    /// All lanes' values at once; `None` for a function of one pixel.
    pub(super) fn call_batch(&self, args: &[Value], n: usize) -> Option<Result<Value, String>> {
        let Body::Batch(f) = &self.body else { return None };
        let arguments = BatchArguments {
            n,
            shapes: args.iter().map(|a| &a.shape).collect(),
            lanes: args.iter().map(|a| a.planes.iter().map(|p| p.spread(n)).collect()).collect(),
        };
        Some(f(&arguments).and_then(|result| {
            let cells = result.shape.cells();
            if result.planes.len() != cells || result.planes.iter().any(|p| p.len() != n) {
                return Err(format!("it must give {cells} planes of {n} numbers for {}", result.shape));
            }
            let planes = result.planes.iter().map(|p| Plane::filled(n, |out| out.copy_from_slice(p)));
            Ok(Value { shape: result.shape.clone(), planes: planes.collect() })
        }))
    }
}

impl fmt::Debug for HostFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.signature())
    }
}
