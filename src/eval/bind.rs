//! Binds a program to an image: where the value of each outer variable comes from, and the frame's own run.

use super::absent::{absent, of_image};
use super::frame;
use super::input::Inputs;
use super::machine::Slot;
use super::pixels::Pixels;
use super::pixelsize;
use super::print::Prints;
use super::run::{Failure, Options, TEXTURE_MEMORY};
use super::samples::is_id;
use super::shadow::Neighbours;
use super::spaces;
use super::steps::Steps;
use super::tracer::Tracer;
use crate::diagnostic::Diagnostic;
use crate::image::Image;
use crate::resolve::tree::*;
use crate::resolve::{names, space_of, unreadable};
use crate::shape::Shape;
use crate::syntax::MAX_ERRORS;
use crate::texture::Texture;
use crate::value::{PixelValue, Plane, Value};
use std::collections::HashMap;
use std::sync::Arc;

/// Says what is known of a variable that an image does not have, as hints to the user.
pub type Missing<'o> = dyn Fn(&str) -> Vec<String> + Sync + 'o;

/// Where a variable's first value comes from.
pub(super) enum Source {
    /// Nowhere: the program assigns it.
    Nowhere,
    /// One value for the frame.
    Uniform(PixelValue),
    /// A variable of the input, by its number in [`Inputs::variables`].
    Input(usize),
    /// The same, moved from the pixel's middle to the position of a sample: see [`super::shadow`].
    Moved(usize),
    /// `I`, the direction to a point from the eye.
    Incident(Box<Source>, [f32; 3]),
    /// `pixel`.
    Position,
    /// `pixelsize`: [`Bound::size`].
    PixelSize,
    /// `pixel_freq`, from `pixelsize`.
    PixelFreq,
}

/// A program's variables on one image.
pub(super) struct Bound<'r> {
    /// One a global.
    pub sources: Vec<Source>,
    pub inputs: Inputs<'r>,
    /// Who has which neighbours, for programs with derivatives and for samples beside the middle.
    pub neighbours: Option<Neighbours>,
    /// Memory of the steps between pixels, for the next binding.
    pub steps: [Vec<f32>; 2],
    /// Memory for planes whose pixels do not follow one another in the host's buffer.
    pub staged: Vec<f32>,
    /// `pixelsize` of each pixel; empty where the program does not read it.
    pub size: Vec<f32>,
    pub missing: Option<&'r Missing<'r>>,
    /// As [`Options::camera_hint`].
    pub camera_hint: Option<&'r str>,
    /// As [`Resolved::textures`].
    pub textures: Vec<Arc<Texture>>,
    /// What runs once a frame printed.
    pub prints: Prints,
}

impl Source {
    /// May it differ from pixel to pixel?
    pub fn varies(&self) -> bool {
        !matches!(self, Source::Uniform(_) | Source::Nowhere)
    }

    /// The variable at the beginning of a batch. `places`: how far from the middle each pixel is sampled; none if it is
    /// the middle.
    pub fn slot(&self, pixels: Pixels<'_>, bound: &Bound<'_>, places: &[[f32; 2]]) -> Slot {
        let value = match self {
            Source::Nowhere => return Slot::EMPTY,
            Source::Uniform(value) => Value::from(value),
            Source::Input(variable) => {
                let variable = bound.inputs.get(*variable);
                let planes = variable.planes().map(|p| p.gather(pixels)).collect();
                Value { shape: variable.shape.clone(), planes }
            }
            Source::Moved(variable) => {
                let variable = bound.inputs.get(*variable);
                let planes = variable.planes().map(|p| bound.moved(&p, pixels, places)).collect();
                Value { shape: variable.shape.clone(), planes }
            }
            Source::Incident(point, eye) => {
                let point = point.slot(pixels, bound, places).value.unwrap_or(Value::uniform(0.0));
                incident(&point, *eye, pixels.len())
            }
            Source::Position => {
                let (width, [x, y]) = (bound.inputs.width.max(1), bound.inputs.metadata.origin);
                let column = move |i: usize| (i % width) as f32 + x as f32 + 0.5;
                let row = move |i: usize| (i / width) as f32 + y as f32 + 0.5;
                let mut planes = [pixels.map(column), pixels.map(row)];
                for (axis, plane) in planes.iter_mut().enumerate() {
                    if let Plane::Varying(lanes) = plane {
                        let lanes = lanes.get_mut(pixels.len()).iter_mut();
                        lanes.zip(places).for_each(|(x, place)| *x += place[axis]);
                    }
                }
                Value::vector(planes.into_iter().collect())
            }
            Source::PixelSize => Value::scalar(pixels.gather(&bound.size)),
            Source::PixelFreq => Value::scalar(pixels.map(|i| 0.5 / bound.size[i])),
        };
        Slot::full(value)
    }
}

/// A variable of the image, `moved` to the places of a sample or not.
fn given(variable: usize, moved: bool) -> Source {
    if moved { Source::Moved(variable) } else { Source::Input(variable) }
}

/// The directions from the eye to points, of length 1.
pub(super) fn incident(point: &Value, eye: [f32; 3], n: usize) -> Value {
    let mut planes = [0, 1, 2].map(|i| point.planes.get(i).unwrap_or(&Plane::Uniform(0.0)).spread(n));
    let [x, y, z] = planes.each_mut().map(|plane| plane.get_mut(n));
    for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
        let d = [*x - eye[0], *y - eye[1], *z - eye[2]];
        let inverse = crate::builtin::inverse((d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt());
        (*x, *y, *z) = (d[0] * inverse, d[1] * inverse, d[2] * inverse);
    }
    Value::vector(planes.into_iter().map(Plane::Varying).collect())
}

impl Bound<'_> {
    /// Column and row of a pixel in the display window.
    pub fn position(&self, pixel: usize) -> [i32; 2] {
        let (width, [x, y]) = (self.inputs.width.max(1), self.inputs.metadata.origin);
        [(pixel % width) as i32 + x, (pixel / width) as i32 + y]
    }

    /// Does the image have that variable?
    pub fn has(&self, name: &str) -> bool {
        self.inputs.find(name).is_some()
    }

    /// What to tell who reads a variable that the image does not have.
    pub fn missing_hints(&self, name: &str) -> Vec<String> {
        match self.has(name) || !names::USUAL_INPUTS.contains(&name) {
            true => Vec::new(),
            false => of_image(name, &self.inputs.names(), self.missing),
        }
    }
}

/// Binds a program to an image and runs what runs once a frame. `sampled` has the variables that were made anew for a
/// sample, instead of those of the image.
pub(super) fn bind<'r>(
    program: &'r Resolved,
    image: &'r Image<'r>,
    sampled: Option<&'r Image<'r>>,
    options: &'r Options<'r>,
) -> Result<Bound<'r>, Failure> {
    bind_inputs(program, Inputs::of(image), sampled, options, Buffers::default(), &mut None)
}

/// Memory of an earlier binding, to be used again.
#[derive(Default)]
pub(super) struct Buffers {
    pub sources: Vec<Source>,
    pub size: Vec<f32>,
    pub steps: [Vec<f32>; 2],
    pub staged: Vec<f32>,
    pub neighbours: Vec<u8>,
}

/// The same for inputs of any kind, and a tracer looks on.
pub(super) fn bind_inputs<'r>(
    program: &'r Resolved,
    inputs: Inputs<'r>,
    sampled: Option<&'r Image<'r>>,
    options: &'r Options<'r>,
    buffers: Buffers,
    tracer: &mut Option<Box<Tracer>>,
) -> Result<Bound<'r>, Failure> {
    check_inputs(&inputs)?;
    let inputs = inputs.with_sampled(sampled);
    let mut bound = Bound {
        sources: buffers.sources,
        neighbours: None,
        size: buffers.size,
        steps: Default::default(),
        staged: Vec::new(),
        missing: options.missing,
        camera_hint: options.camera_hint,
        textures: Vec::new(),
        prints: Prints::default(),
        inputs,
    };
    bound.sources.clear();
    let reads = |name: &str| program.globals.iter().any(|g| g.name == name && g.read.is_some());
    let moved = options.sampling().is_some();
    let memory = (buffers.steps, buffers.staged, buffers.neighbours);
    bound.measure(program, sampled.map_or(inputs, Inputs::of), options, memory);
    // Mistakes of all kinds are reported together; what needs the values of the frame is looked at if it has any.
    let mut errors = check_set(program, options);
    match textures(program, options) {
        Ok(textures) => bound.textures = textures,
        Err(unreadable) => errors.extend(unreadable),
    }
    let mut values = vec![None; program.globals.len()];
    if errors.is_empty() {
        match frame::run(program, options, &bound, tracer) {
            Ok(frame) => (values, bound.prints) = (frame.values, frame.prints),
            Err(Failure::Program(wrong)) => errors.extend(wrong),
            Err(Failure::Cancelled) => return Err(Failure::Cancelled),
        }
    }
    let eye = if reads("eye") || reads("I") { spaces::eye(inputs.metadata, options) } else { None };
    let [columns, rows] = inputs.resolution();
    let set = options.set_values();
    for (global, value) in program.globals.iter().zip(values) {
        let name = global.name.as_str();
        let own = inputs.find_sampled(name);
        let input =
            own.or_else(|| inputs.find(name)).filter(|_| !global.library && !names::RESERVED.contains(&name));
        let source = if let Some(value) = value {
            Source::Uniform(value)
        } else if let Some(value) = set.get(name).copied().filter(|_| !global.library) {
            Source::Uniform(value.clone())
        } else if let Some(variable) = input {
            given(variable, moved && own.is_none() && !is_id(name))
        } else if let Some(constant) = names::constant(name) {
            Source::Uniform(constant_value(constant))
        } else if let Some(space) = space_of(name) {
            spaces::space(space, inputs.metadata, options).map_or(Source::Nowhere, Source::Uniform)
        } else {
            match (name, options.pixelsize) {
                ("frame", ..) => Source::Uniform(options.frame.into()),
                ("begin_frame", ..) => Source::Uniform(0.0.into()),
                ("resolution", ..) => Source::Uniform([columns as f32, rows as f32].into()),
                ("pixel", ..) => Source::Position,
                ("eye", ..) => eye.map_or(Source::Nowhere, |eye| Source::Uniform(eye.into())),
                ("I", ..) => {
                    let own = inputs.find_sampled("point");
                    match (eye, own.or_else(|| inputs.find("point"))) {
                        (Some(eye), Some(point)) if *inputs.get(point).shape == Shape::Vector(3) => {
                            Source::Incident(Box::new(given(point, moved && own.is_none())), eye)
                        }
                        _ => Source::Nowhere,
                    }
                }
                ("pixelsize", Some(size)) => Source::Uniform(size.into()),
                ("pixel_freq", Some(size)) => Source::Uniform((0.5 / size).into()),
                ("pixelsize", None) => Source::PixelSize,
                ("pixel_freq", None) => Source::PixelFreq,
                _ => Source::Nowhere,
            }
        };
        bound.sources.push(source);
    }
    errors.extend(missing_inputs(program, &bound));
    for (global, source) in program.globals.iter().zip(&bound.sources) {
        if let (Some(space), Some(span), Source::Nowhere) = (space_of(&global.name), global.read, source) {
            errors.push(spaces::unknown(space, span, inputs.metadata, options));
        }
    }
    if errors.is_empty() { Ok(bound) } else { Err(Failure::Program(errors)) }
}

/// Whether a run compares pixels with their neighbours, and whether it measures the size of each.
pub(super) fn compares(program: &Resolved, options: &Options<'_>) -> [bool; 2] {
    let reads = |name: &str| program.globals.iter().any(|g| g.name == name && g.read.is_some());
    let sized = options.pixelsize.is_none() && (reads("pixelsize") || reads("pixel_freq"));
    [program.derivatives || options.sampling().is_some(), sized]
}

/// Refuses an image whose planes are not those of its size.
fn check_inputs(inputs: &Inputs<'_>) -> Result<(), Failure> {
    match inputs.fault() {
        None => Ok(()),
        Some(message) => Err(Failure::Program(vec![Diagnostic::bare("input", message)])),
    }
}

/// The textures of this frame, read or kept.
fn textures(program: &Resolved, options: &Options<'_>) -> Result<Vec<Arc<Texture>>, Vec<Diagnostic>> {
    let mut left = options.texture_memory.unwrap_or(TEXTURE_MEMORY) as u64;
    let (mut textures, mut errors) = (Vec::new(), Vec::new());
    for (name, _) in &options.textures {
        if !program.textures.iter().any(|(source, _)| source.name == *name) {
            let known: Vec<&str> = program.textures.iter().map(|(source, _)| source.name.as_str()).collect();
            let error =
                Diagnostic::bare("texture", format!("the program looks nothing up in an image `{name}`"));
            errors.push(match known[..] {
                [] => error,
                _ => error.hint(format!("Its images are {}.", known.join(", "))),
            });
        }
    }
    for (source, span) in &program.textures {
        let replaced = options.textures.iter().rev().find(|(name, _)| source.name == *name);
        let replaced = replaced.map(|(_, image)| source.replaced(image));
        match replaced.as_ref().unwrap_or(source).load(options.file_frame(), &mut left, &program.tiles) {
            Ok(texture) => textures.push(texture),
            Err(error) => errors.push(unreadable(error, *span)),
        }
    }
    program.tiles.allow(left);
    if errors.is_empty() { Ok(textures) } else { Err(errors) }
}

impl<'r> Bound<'r> {
    /// Binds the pixels anew of a program that was bound to inputs like these before.
    pub fn again(
        program: &'r Resolved,
        inputs: Inputs<'r>,
        options: &'r Options<'r>,
        buffers: Buffers,
        textures: Vec<Arc<Texture>>,
        prints: Prints,
    ) -> Result<Bound<'r>, Failure> {
        check_inputs(&inputs)?;
        let Buffers { sources, size, steps, staged, neighbours } = buffers;
        let (missing, camera_hint) = (options.missing, options.camera_hint);
        let mut bound = Bound {
            sources,
            inputs,
            neighbours: None,
            steps: Default::default(),
            staged: Vec::new(),
            size,
            missing,
            camera_hint,
            textures,
            prints,
        };
        bound.measure(program, inputs, options, (steps, staged, neighbours));
        Ok(bound)
    }
}

impl Bound<'_> {
    /// Measures what pixels have to do with their neighbours, where the program asks for it: `pixelsize`, and to which
    /// neighbours the surface goes on.
    fn measure(
        &mut self,
        program: &Resolved,
        inputs: Inputs<'_>,
        options: &Options<'_>,
        (lengths, mut staged, neighbours): ([Vec<f32>; 2], Vec<f32>, Vec<u8>),
    ) {
        let [compares, sized] = compares(program, options);
        self.size.clear();
        if !compares && !sized {
            return;
        }
        let threads = !options.on_one_thread();
        let steps = Steps::of(&inputs, lengths, &mut staged, threads);
        if compares {
            self.neighbours = Some(Neighbours::of(&inputs, &steps, neighbours, threads));
        }
        if sized {
            pixelsize::measure(&inputs, &steps, threads, &mut self.size);
        }
        self.steps = steps.into_buffers();
        self.staged = staged;
    }

    /// Tells whether all that was looked up in textures could be read.
    pub fn sound(&self, program: &Resolved) -> Result<(), Failure> {
        for ((_, span), texture) in program.textures.iter().zip(&self.textures) {
            texture.sound().map_err(|error| Failure::Program(vec![unreadable(error, *span)]))?;
        }
        Ok(())
    }
}

pub(super) fn constant_value(constant: &names::Constant) -> PixelValue {
    match constant.value {
        [x] => (*x).into(),
        vector => vector.into(),
    }
}

/// What is set from outside must be something that the program has.
fn check_set(program: &Resolved, options: &Options<'_>) -> Vec<Diagnostic> {
    let mut errors = Vec::new();
    let own = program.globals.iter().zip(0u32..).filter(|(global, _)| !global.library);
    let slots: HashMap<&str, u32> = own.map(|(global, slot)| (global.name.as_str(), slot)).collect();
    let params: HashMap<u32, &Param> = program.params.iter().map(|param| (param.slot, param)).collect();
    for (name, value) in &options.set {
        // Nobody reads more, and a list of all params is long.
        if errors.len() == MAX_ERRORS {
            break;
        }
        let by_option = match name.as_str() {
            "frame" => Some("the frame's number (`--frame`)"),
            "pixelsize" | "pixel_freq" => Some("the size of a pixel (`--pixelsize`)"),
            _ => None,
        };
        if let Some(option) = by_option {
            let error = Diagnostic::bare("name", format!("`{name}` cannot be set with `--set`"));
            errors.push(error.hint(format!("Use the option for {option}.")));
            continue;
        }
        if let Some(&slot) = slots.get(name.as_str()) {
            let global = &program.globals[slot as usize];
            let param = params.get(&slot);
            errors.extend(param.and_then(|param| unfit(param, value)));
            let param = param.is_some();
            if let Some(span) = global.assigned.or(global.framed).filter(|_| !param) {
                let error = Diagnostic::error(
                    "name",
                    format!("`{name}` is assigned by the program, not a param"),
                    span,
                );
                errors.push(error.hint(format!("To set it from outside, declare it: `param {name} = …`.")));
            }
            continue;
        }
        let known = program.params.iter().map(|p| p.name.as_str());
        let error = Diagnostic::bare("name", format!("the program has no param `{name}` to set"));
        let near = names::nearest(name, known.clone()).map(|n| format!("Did you mean `{n}`?"));
        let list: Vec<&str> = known.collect();
        let hint = near.unwrap_or_else(|| match list[..] {
            [] => format!("It has no params; `param {name} = 1` declares one."),
            _ => format!("Its params are {}.", list.join(", ")),
        });
        errors.push(error.hint(hint));
    }
    errors
}

/// The error of a value that is not a number, or has another shape than the param's own where that is written down.
fn unfit(param: &Param, value: &PixelValue) -> Option<Diagnostic> {
    let name = &param.name;
    if value.cells().iter().any(|x| x.is_nan()) {
        let error =
            Diagnostic::error("param", format!("`{name}` is set to NaN, which is no number"), param.span);
        return Some(error);
    }
    let number = |e: &Expr| match &e.kind {
        ExprKind::Number(_) => true,
        ExprKind::Unary(_, inner) => matches!(inner.kind, ExprKind::Number(_)),
        _ => false,
    };
    let shape = match &param.value.kind {
        ExprKind::Vector(elements) if elements.iter().all(|e| matches!(e, Element::Item(e) if number(e))) => {
            Shape::Vector(elements.len() as u32)
        }
        _ if number(&param.value) => Shape::Scalar,
        _ => return None,
    };
    if shape == *value.shape() {
        return None;
    }
    let message = format!("`{name}` is {shape} in the program, and is set to {}", value.shape());
    let hint = match shape {
        Shape::Scalar => format!("Set it to one number: `{name}=1`."),
        _ => format!("Set all components: `{name}=[{}]`.", vec!["1"; shape.cells()].join(" ")),
    };
    Some(Diagnostic::error("param", message, param.span).hint(hint))
}

/// The errors of names that are read and come from nowhere, the first of them.
fn missing_inputs(program: &Resolved, bound: &Bound<'_>) -> Vec<Diagnostic> {
    let nowhere = |(global, source): &(&Global, &Source)| {
        matches!(source, Source::Nowhere)
            && global.assigned.is_none()
            && global.framed.is_none()
            && !global.library
            && space_of(&global.name).is_none()
    };
    program
        .globals
        .iter()
        .zip(&bound.sources)
        .filter(nowhere)
        .filter_map(|(global, _)| {
            Some(absent(
                program,
                &global.name,
                global.read?,
                &bound.inputs.names(),
                bound.missing,
                bound.camera_hint,
            ))
        })
        .take(MAX_ERRORS)
        .collect()
}
