//! Functions that the embedding program adds to the language.

use crate::host::HostError;
use crate::shape::Shape;
use crate::value::{Lanes, PixelValue, Plane, Value};
use smallvec::SmallVec;
use std::fmt;

type ForPixel = dyn Fn(&[PixelValue]) -> Result<PixelValue, HostError> + Send + Sync;
type ForBatch = dyn Fn(&BatchArguments<'_>) -> Result<BatchResult, HostError> + Send + Sync;

type ForLanes = dyn Fn(&[&[f32]], &mut [&mut [f32]]) -> Result<(), HostError> + Send + Sync;

enum Body {
    Pixel(Box<ForPixel>),
    Batch(Box<ForBatch>),
    /// With the components of each argument and of the result.
    Lanes(Vec<usize>, usize, Box<ForLanes>),
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
        f: impl Fn(&[PixelValue]) -> Result<PixelValue, HostError> + Send + Sync + 'static,
    ) -> HostFunction {
        let params = params.iter().map(|p| p.to_string()).collect();
        HostFunction { name: name.into(), params, body: Body::Pixel(Box::new(f)) }
    }

    /// A function of a batch's planes.
    pub fn for_batch(
        name: &str,
        params: &[&str],
        f: impl Fn(&BatchArguments<'_>) -> Result<BatchResult, HostError> + Send + Sync + 'static,
    ) -> HostFunction {
        let params = params.iter().map(|p| p.to_string()).collect();
        HostFunction { name: name.into(), params, body: Body::Batch(Box::new(f)) }
    }

    /// A function of planes with stated numbers of components: `params` has the name and the components of each
    /// parameter, `result` is the number of components that it gives. It gets a plane of each argument's components, one
    /// after the other, and fills a plane for each component of the result; all have one number a lane, and in lanes that
    /// are not active the arguments may hold anything. A scalar argument is repeated for a vector. No call allocates
    /// memory.
    ///
    /// ```
    /// use pse::{Compiler, HostFunction, RunOptions};
    ///
    /// let lift = HostFunction::for_lanes("lift", &[("c", 3), ("by", 1)], 3, |inputs, outputs| {
    ///     for (component, out) in outputs.iter_mut().enumerate() {
    ///         let lanes = out.iter_mut().zip(inputs[component]).zip(inputs[3]);
    ///         lanes.for_each(|((out, c), by)| *out = c + by);
    ///     }
    ///     Ok(())
    /// });
    /// let program = Compiler::new().function(lift).compile("p", "a = lift([1 2 3], 0.5)")?;
    /// let values = program.eval_pixel(&[], &RunOptions::default())?;
    /// assert_eq!(values, [("a".to_string(), [1.5, 2.5, 3.5].into())]);
    /// # Ok::<(), pse::Error>(())
    /// ```
    pub fn for_lanes(
        name: &str,
        params: &[(&str, usize)],
        result: usize,
        f: impl Fn(&[&[f32]], &mut [&mut [f32]]) -> Result<(), HostError> + Send + Sync + 'static,
    ) -> HostFunction {
        let body = Body::Lanes(params.iter().map(|p| p.1).collect(), result, Box::new(f));
        HostFunction { name: name.into(), params: params.iter().map(|p| p.0.to_string()).collect(), body }
    }

    /// Why it cannot be a function of the language: its name, or one of a parameter.
    pub(crate) fn fault(&self) -> Option<String> {
        let names = std::iter::once(&self.name).chain(&self.params);
        if let Some(why) = names.into_iter().find_map(|name| crate::syntax::check_name(name).err()) {
            return Some(format!("the host's function `{}`: {why}", self.signature()));
        }
        let twice = self.params.iter().enumerate().find(|(i, p)| self.params[..*i].contains(p));
        twice.map(|(_, p)| format!("the host's function `{}` has two parameters `{p}`", self.signature()))
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
    pub(super) fn call_pixel(&self, args: &[PixelValue]) -> Option<Result<PixelValue, HostError>> {
        match &self.body {
            Body::Pixel(f) => Some(f(args)),
            Body::Batch(_) | Body::Lanes(..) => None,
        }
    }

    /// All lanes' values at once; `None` for a function of one pixel.
    pub(super) fn call_batch(&self, args: &[Value], n: usize) -> Option<Result<Value, HostError>> {
        let f = match &self.body {
            Body::Pixel(_) => return None,
            Body::Lanes(params, result, f) => return Some(self.call_lanes(args, n, params, *result, &**f)),
            Body::Batch(f) => f,
        };
        let arguments = BatchArguments {
            n,
            shapes: args.iter().map(|a| &a.shape).collect(),
            lanes: args.iter().map(|a| a.planes.iter().map(|p| p.spread(n)).collect()).collect(),
        };
        Some(f(&arguments).and_then(|result| {
            let cells = result.shape.cells();
            if result.planes.len() != cells || result.planes.iter().any(|p| p.len() != n) {
                return Err(format!("it must give {cells} planes of {n} numbers for {}", result.shape).into());
            }
            let planes = result.planes.iter().map(|p| Plane::filled(n, |out| out.copy_from_slice(p)));
            Ok(Value { shape: result.shape.clone(), planes: planes.collect() })
        }))
    }
}

impl HostFunction {
    fn call_lanes(
        &self,
        args: &[Value],
        n: usize,
        params: &[usize],
        result: usize,
        f: &ForLanes,
    ) -> Result<Value, HostError> {
        let mut lanes: SmallVec<[Lanes; 8]> = SmallVec::new();
        for ((value, &components), name) in args.iter().zip(params).zip(&self.params) {
            let fits =
                value.shape.is_scalar() || value.shape == Shape::Vector(components as u32) && components > 1;
            if !fits {
                return Err(format!("`{name}` has {components} components, found {}", value.shape).into());
            }
            let planes = value.planes.iter().cycle().take(components.max(1));
            lanes.extend(planes.map(|plane| plane.spread(n)));
        }
        let inputs: SmallVec<[&[f32]; 8]> = lanes.iter().map(|lanes| lanes.get(n)).collect();
        let mut results: SmallVec<[Lanes; 4]> =
            (0..result).map(|_| Lanes::filled(n, |out| out.fill(0.0))).collect();
        let mut outputs: SmallVec<[&mut [f32]; 4]> =
            results.iter_mut().map(|lanes| lanes.get_mut(n)).collect();
        f(&inputs, &mut outputs)?;
        drop(outputs);
        let shape = if result == 1 { Shape::Scalar } else { Shape::Vector(result as u32) };
        Ok(Value { shape, planes: results.into_iter().map(Plane::Varying).collect() })
    }
}

impl fmt::Debug for HostFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.signature())
    }
}
