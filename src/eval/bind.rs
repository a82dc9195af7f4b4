//! Binds a program to an image: where the value of each outer variable comes from, and the frame's own run.

use super::absent::{absent, of_image};
use super::frame;
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
use crate::image::{Image, Variable};
use crate::resolve::tree::*;
use crate::resolve::{names, space_of, unreadable};
use crate::shape::Shape;
use crate::syntax::MAX_ERRORS;
use crate::texture::Texture;
use crate::value::{PixelValue, Plane, Value};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Says what is known of a variable that an image does not have, as hints to the user.
pub type Missing<'o> = dyn Fn(&str) -> Vec<String> + Sync + 'o;

/// Where a variable's first value comes from.
pub(super) enum Source<'r> {
    /// Nowhere: the program assigns it.
    Nowhere,
    /// One value for the frame.
    Uniform(PixelValue),
    /// A variable of the image.
    Input(&'r Variable<'r>),
    /// The like, moved from the pixel's middle to the place of a sample: see [`super::shadow`].
    Moved(&'r Variable<'r>),
    /// `I`, the direction to a point from the eye.
    Incident(Box<Source<'r>>, [f32; 3]),
    /// `pixel`.
    Position,
    /// `pixelsize`, one a pixel.
    PixelSize(Arc<[f32]>),
    /// `pixel_freq`, from `pixelsize`.
    PixelFreq(Arc<[f32]>),
}

/// A program's variables on one image.
pub(super) struct Bound<'r> {
    /// One a global.
    pub sources: Vec<Source<'r>>,
    /// Who has which neighbours, for programs with derivatives and for samples beside the middle.
    pub neighbours: Option<Neighbours>,
    pub width: usize,
    pub origin: [i32; 2],
    pub has: Vec<String>,
    pub missing: Option<&'r Missing<'r>>,
    /// As [`Options::camera_hint`].
    pub camera_hint: Option<&'r str>,
    /// As [`Resolved::textures`].
    pub textures: Vec<Arc<Texture>>,
    /// What runs once a frame printed.
    pub prints: Prints,
}

impl Source<'_> {
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
            Source::Input(variable) => Value {
                shape: variable.shape.clone(),
                planes: variable.planes.iter().map(|p| pixels.gather(p)).collect(),
            },
            Source::Moved(variable) => {
                let planes = variable.planes.iter().map(|p| bound.moved(p, pixels, places)).collect();
                Value { shape: variable.shape.clone(), planes }
            }
            Source::Incident(point, eye) => {
                let point = point.slot(pixels, bound, places).value.unwrap_or(Value::uniform(0.0));
                incident(&point, *eye, pixels.len())
            }
            Source::Position => {
                let (width, [x, y]) = (bound.width.max(1), bound.origin);
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
            Source::PixelSize(plane) => Value::scalar(pixels.gather(plane)),
            Source::PixelFreq(plane) => Value::scalar(pixels.map(|i| 0.5 / plane[i])),
        };
        Slot::full(value)
    }
}

/// A variable of the image, `moved` to the places of a sample or not.
fn given<'r>(variable: &'r Variable<'r>, moved: bool) -> Source<'r> {
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
        let width = self.width.max(1);
        [(pixel % width) as i32 + self.origin[0], (pixel / width) as i32 + self.origin[1]]
    }

    /// Does the image have that variable?
    pub fn has(&self, name: &str) -> bool {
        self.has.iter().any(|v| v == name)
    }

    /// What to tell who reads a variable that the image does not have.
    pub fn missing_hints(&self, name: &str) -> Vec<String> {
        match self.has(name) || !names::USUAL_INPUTS.contains(&name) {
            true => Vec::new(),
            false => of_image(name, &self.has, self.missing),
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
    bind_traced(program, image, sampled, options, &mut None)
}

/// The like, and a tracer looks on.
pub(super) fn bind_traced<'r>(
    program: &'r Resolved,
    image: &'r Image<'r>,
    sampled: Option<&'r Image<'r>>,
    options: &'r Options<'r>,
    tracer: &mut Option<Box<Tracer>>,
) -> Result<Bound<'r>, Failure> {
    let moved = options.sampling().is_some();
    let seen = sampled.unwrap_or(image);
    let reads = |name: &str| program.globals.iter().any(|g| g.name == name && g.read.is_some());
    let compares = program.derivatives || moved;
    let sized = options.pixelsize.is_none() && (reads("pixelsize") || reads("pixel_freq"));
    let steps = (compares || sized).then(|| Steps::of(seen));
    let mut bound = Bound {
        sources: Vec::new(),
        neighbours: steps.as_ref().filter(|_| compares).map(|steps| Neighbours::of(seen, steps)),
        width: image.width,
        origin: image.metadata.origin,
        has: image.variables.iter().map(|v| v.name.clone()).collect(),
        missing: options.missing,
        camera_hint: options.camera_hint,
        textures: Vec::new(),
        prints: Prints::default(),
    };
    // Mistakes of all kinds are reported together; what needs the values of the frame is looked at if it has any.
    let mut errors = check_set(program, options);
    match textures(program, options) {
        Ok(textures) => bound.textures = textures,
        Err(unreadable) => errors.extend(unreadable),
    }
    let mut values = vec![None; program.globals.len()];
    if errors.is_empty() {
        match frame::run(program, image, options, &bound, tracer) {
            Ok(frame) => (values, bound.prints) = (frame.values, frame.prints),
            Err(Failure::Program(wrong)) => errors.extend(wrong),
            Err(Failure::Cancelled) => return Err(Failure::Cancelled),
        }
    }
    let size: Option<Arc<[f32]>> =
        steps.as_ref().filter(|_| sized).map(|steps| pixelsize::plane(seen, steps).into());
    drop(steps);
    let eye = if reads("eye") || reads("I") { spaces::eye(image, options) } else { None };
    let [columns, rows] = image.resolution();
    let set = options.set_values();
    for (global, value) in program.globals.iter().zip(values) {
        let name = global.name.as_str();
        let resampled = sampled.and_then(|s| s.variable(name));
        let input = resampled
            .or(image.variable(name))
            .filter(|_| !global.library && !names::RESERVED.contains(&name));
        let source = if let Some(value) = value {
            Source::Uniform(value)
        } else if let Some(value) = set.get(name).copied().filter(|_| !global.library) {
            Source::Uniform(value.clone())
        } else if let Some(variable) = input {
            given(variable, moved && resampled.is_none() && !is_id(name))
        } else if let Some(constant) = names::constant(name) {
            Source::Uniform(constant_value(constant))
        } else if let Some(space) = space_of(name) {
            spaces::space(space, image, options).map_or(Source::Nowhere, Source::Uniform)
        } else {
            match (name, options.pixelsize, &size) {
                ("frame", ..) => Source::Uniform(options.frame.into()),
                ("begin_frame", ..) => Source::Uniform(0.0.into()),
                ("resolution", ..) => Source::Uniform([columns as f32, rows as f32].into()),
                ("pixel", ..) => Source::Position,
                ("eye", ..) => eye.map_or(Source::Nowhere, |eye| Source::Uniform(eye.into())),
                ("I", ..) => {
                    let resampled = sampled.and_then(|image| image.variable("point"));
                    match (eye, resampled.or_else(|| image.variable("point"))) {
                        (Some(eye), Some(point)) if point.shape == Shape::Vector(3) => {
                            Source::Incident(Box::new(given(point, moved && resampled.is_none())), eye)
                        }
                        _ => Source::Nowhere,
                    }
                }
                ("pixelsize", Some(size), _) => Source::Uniform(size.into()),
                ("pixel_freq", Some(size), _) => Source::Uniform((0.5 / size).into()),
                ("pixelsize", None, Some(plane)) => Source::PixelSize(plane.clone()),
                ("pixel_freq", None, Some(plane)) => Source::PixelFreq(plane.clone()),
                _ => Source::Nowhere,
            }
        };
        bound.sources.push(source);
    }
    errors.extend(missing_inputs(program, &bound));
    for (global, source) in program.globals.iter().zip(&bound.sources) {
        if let (Some(space), Some(span), Source::Nowhere) = (space_of(&global.name), global.read, source) {
            errors.push(spaces::unknown(space, span, image, options));
        }
    }
    if errors.is_empty() { Ok(bound) } else { Err(Failure::Program(errors)) }
}

/// The textures of this frame, read or kept.
fn textures(program: &Resolved, options: &Options<'_>) -> Result<Vec<Arc<Texture>>, Vec<Diagnostic>> {
    let mut left = options.texture_memory.unwrap_or(TEXTURE_MEMORY) as u64;
    let (mut textures, mut errors) = (Vec::new(), Vec::new());
    for (source, span) in &program.textures {
        match source.load(options.file_frame(), &mut left, &program.tiles) {
            Ok(texture) => textures.push(texture),
            Err(error) => errors.push(unreadable(error, *span)),
        }
    }
    program.tiles.allow(left);
    if errors.is_empty() { Ok(textures) } else { Err(errors) }
}

impl Bound<'_> {
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
    let params: HashSet<u32> = program.params.iter().map(|param| param.slot).collect();
    for (name, _) in &options.set {
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
            let param = params.contains(&slot);
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

/// The errors of names that are read and come from nowhere, the first of them.
fn missing_inputs(program: &Resolved, bound: &Bound<'_>) -> Vec<Diagnostic> {
    let nowhere = |(global, source): &(&Global, &Source<'_>)| {
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
            Some(absent(program, &global.name, global.read?, &bound.has, bound.missing, bound.camera_hint))
        })
        .take(MAX_ERRORS)
        .collect()
}
