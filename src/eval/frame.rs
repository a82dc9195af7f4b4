//! What runs once a frame: the values of params, and the blocks of `if begin_frame`.

use super::bind::{Bound, Source, bind, constant_value};
use super::fault::Fault;
use super::machine::{Machine, Memory};
use super::pixels::Pixels;
use super::print::Prints;
use super::run::{Failure, Options};
use super::spaces;
use super::tracer::Tracer;
use crate::diagnostic::Diagnostic;
use crate::image::Image;
use crate::resolve::tree::*;
use crate::resolve::{names, space_of};
use crate::shape::Shape;
use crate::value::{Mask, PixelValue, Value};

/// What came of a frame's run.
#[derive(Default)]
pub(super) struct Frame {
    /// For each global the value that the frame gives it.
    pub values: Vec<Option<PixelValue>>,
    /// What was printed.
    pub prints: Prints,
    /// The ranges that params state, in their order.
    pub ranges: Vec<Option<[f32; 2]>>,
}

/// A param as its program has it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ParamInfo {
    /// Its name.
    pub name: String,
    /// Its value in this frame, if it is not set from outside.
    pub default: PixelValue,
    /// The range that it states, the lower end first.
    pub range: Option<[f32; 2]>,
}

/// The params of a program on an image.
pub fn params(
    program: &Resolved,
    image: &Image<'_>,
    options: &Options<'_>,
) -> Result<Vec<ParamInfo>, Failure> {
    let options = Options { set: Vec::new(), ..options.clone() };
    let bound = bind(program, image, None, &options)?;
    let Frame { values, ranges, .. } = run(program, &options, &bound, &mut None)?;
    let params = program.params.iter().zip(ranges);
    Ok(params
        .filter_map(|(param, range)| {
            let default = values.get(param.slot as usize)?.clone()?;
            Some(ParamInfo { name: param.name.clone(), default, range })
        })
        .collect())
}

/// Runs params and `if begin_frame`: the values of the frame's variables.
pub(super) fn run(
    program: &Resolved,
    options: &Options<'_>,
    bound: &Bound<'_>,
    tracer: &mut Option<Box<Tracer>>,
) -> Result<Frame, Failure> {
    if program.params.is_empty() && program.frame.is_empty() {
        return Ok(Frame { values: vec![None; program.globals.len()], ..Frame::default() });
    }
    let [columns, rows] = bound.inputs.resolution();
    let metadata = bound.inputs.metadata;
    let set = options.set_values();
    let sources = program.globals.iter().map(|global| {
        if let Some(&value) = set.get(global.name.as_str()).filter(|_| !global.library) {
            return Source::Uniform(value.clone());
        }
        if let Some(space) = space_of(&global.name) {
            return spaces::space(space, metadata, options).map_or(Source::Nowhere, Source::Uniform);
        }
        match (global.name.as_str(), names::constant(&global.name)) {
            (_, Some(constant)) => Source::Uniform(constant_value(constant)),
            ("frame", _) => Source::Uniform(options.frame.into()),
            ("begin_frame", _) => Source::Uniform(1.0.into()),
            ("resolution", _) => Source::Uniform([columns as f32, rows as f32].into()),
            ("eye", _) => {
                spaces::eye(metadata, options).map_or(Source::Nowhere, |e| Source::Uniform(e.into()))
            }
            _ => Source::Nowhere,
        }
    });
    let frame = Bound {
        sources: sources.collect(),
        neighbours: None,
        size: Vec::new(),
        steps: Default::default(),
        staged: Vec::new(),
        inputs: bound.inputs,
        missing: bound.missing,
        camera_hint: bound.camera_hint,
        textures: bound.textures.clone(),
        prints: Prints::default(),
    };
    let mut machine =
        Machine::new(program, &frame, options.isa(), options.limits, options.cancel, Memory::default());
    machine.printer.limit = options.prints;
    machine.printer.frame = true;
    if let Some(tracer) = tracer {
        tracer.frame = true;
    }
    machine.trace(tracer.take());
    let mut ranges = Vec::new();
    let mut run = || -> Result<(), Fault> {
        machine.reset(1, true);
        machine.load(Pixels::Run(0, 1));
        for param in &program.params {
            machine.at = param.span;
            let mut stated = None;
            if let Some(range) = &param.range {
                let value = machine.eval(range, &Mask::All)?;
                let ends: Vec<f32> = value.lane(0).collect();
                stated = match ends[..] {
                    [low, high] if value.shape == Shape::Vector(2) && low < high => Some([low, high]),
                    _ => None,
                };
                if stated.is_none() {
                    let message = format!("the range of `{}` is {}", param.name, value.show(0));
                    let error = Diagnostic::error("param", message, range.span).hint(format!(
                        "A range is two numbers, the lower one first: `param {} = 1 in [0 10]`.",
                        param.name
                    ));
                    return Err(machine.fault(error, 0));
                }
            }
            ranges.push(stated);
            let set = set.get(param.name.as_str());
            let value = match set {
                Some(&value) => Value::from(value),
                None => machine.eval(&param.value, &Mask::All)?,
            };
            machine.store(Place::Global(param.slot), value, &Mask::All)?;
            if machine.tracer.is_some() {
                machine.trace_param(param, set.is_some());
            }
        }
        machine.block(&program.frame, &Mask::All)?;
        Ok(())
    };
    match run() {
        Ok(()) => {}
        Err(Fault::Error(error, _)) => return Err(Failure::Program(vec![*error])),
        Err(Fault::Cancelled) => return Err(Failure::Cancelled),
        // One lane is never cut and counts exactly.
        Err(Fault::Split(_) | Fault::Count(_)) => {
            return Err(Failure::Program(vec![Diagnostic::bare("internal", "a frame's run was cut")]));
        }
    }
    *tracer = machine.tracer.take();
    if let Some(tracer) = tracer {
        tracer.frame = false;
    }
    let mut prints = Prints::default();
    machine.printer.give(&mut prints);
    let values = program
        .globals
        .iter()
        .zip(&machine.globals)
        .map(|(global, slot)| {
            global.framed?;
            slot.value.as_ref().map(|value| value.pixel(0))
        })
        .collect();
    Ok(Frame { values, prints, ranges })
}
