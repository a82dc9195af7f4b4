//! One pixel alone: what it gives, what it prints, and what happens on the way.

use super::bind::{Buffers, bind, bind_inputs};
use super::input::Inputs;
use super::machine::Machine;
use super::output;
use super::pixels::Pixels;
use super::print::Prints;
use super::run::{Failure, Options};
use super::trace::{Trace, TraceOptions};
use super::tracer::Tracer;
use super::worker::{Parts, Worker};
use crate::image::Image;
use crate::resolve::Resolved;
use crate::shape::Shape;
use crate::value::PixelValue;

/// Every variable that a program assigns, with its value.
type Values = Vec<(String, PixelValue)>;

/// Runs a program at one pixel: what it assigns there, and what it prints.
pub fn eval_pixel(
    program: &Resolved,
    image: &Image<'_>,
    pixel: usize,
    options: &Options<'_>,
) -> Result<(Values, Prints), Failure> {
    let bound = bind(program, image, None, options)?;
    let mut worker = Worker::new(program, &bound, options, program.by_normal.is_some(), Parts::default());
    let mut prints = bound.prints.clone();
    let list = [pixel];
    let ran = worker.run(Pixels::List(&list), &mut |machine, _| {
        machine.printer.give(&mut prints);
        Ok(())
    });
    match ran {
        Ok(()) => {
            bound.sound(program)?;
            Ok((values(&worker.machine), prints))
        }
        Err(stop) => Err(stop.failure(&bound)),
    }
}

/// Runs a program at one pixel and tells all that happens. It is the middle of the pixel that is run.
pub fn trace(
    program: &Resolved,
    image: &Image<'_>,
    pixel: usize,
    options: &Options<'_>,
    wanted: &TraceOptions,
) -> Result<Trace, Failure> {
    // A plan passes statements by.
    let options = Options { no_optimize: true, samples: None, ..options.clone() };
    let mut tracer = Some(Box::new(Tracer::new(wanted)));
    let inputs = Inputs::of(image);
    let bound = bind_inputs(program, inputs, None, &options, Buffers::default(), &mut tracer)?;
    let mut worker = Worker::new(program, &bound, &options, program.by_normal.is_some(), Parts::default());
    worker.machine.trace(tracer);
    let list = [pixel];
    let ran = worker.run(Pixels::List(&list), &mut |_, _| Ok(()));
    let error = match ran.map_err(|stop| stop.failure(&bound)) {
        Ok(()) => None,
        Err(Failure::Program(errors)) => errors.into_iter().next(),
        Err(Failure::Cancelled) => return Err(Failure::Cancelled),
    };
    bound.sound(program)?;
    let tracer = worker.machine.tracer.take();
    let (events, births) = tracer.map_or_else(Default::default, |tracer| tracer.finish());
    let mut values = if error.is_none() { values(&worker.machine) } else { Vec::new() };
    let colored = values.iter().any(|(name, value)| name == "color" && *value.shape() != Shape::Vector(4));
    if let Some(alpha) = output::kept_alpha(program, &bound.inputs, &options).filter(|_| colored) {
        values.push(("alpha".to_string(), bound.inputs.get(alpha).plane(0).at(pixel).into()));
    }
    Ok(Trace { pixel: bound.position(pixel), events, births, values, error })
}

/// What the program has assigned at the first pixel of the batch.
fn values(machine: &Machine<'_>) -> Values {
    let values = machine.program.globals.iter().zip(&machine.globals);
    values
        .filter(|(global, _)| (global.assigned.is_some() || global.name == "color") && !global.library)
        .filter_map(|(global, slot)| Some((global.name.clone(), slot.value.as_ref()?.pixel(0))))
        .collect()
}
