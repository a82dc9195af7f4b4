//! Runs of one program one after another, which keep memory, tapes and what was bound.

use super::bind::{Bound, Buffers, bind_inputs};
use super::drive::Interruption;
use super::input::{BufferView, BufferViewMut, Inputs};
use super::limits::Limits;
use super::output::{self, Output};
use super::print::Prints;
use super::run::{Attempt, Failure, Job, Options, Report};
use super::stream;
use super::target::{Target, Targets};
use super::worker::Parts;
use crate::diagnostic::Diagnostic;
use crate::image::{Image, Matrix4, Metadata, Variable};
use crate::lanes::Isa;
use crate::resolve::Resolved;
use crate::shape::Shape;
use crate::texture::Texture;
use crate::value::PixelValue;
use smallvec::SmallVec;
use std::sync::{Arc, Mutex};

/// The state between two runs of one program.
#[derive(Default)]
pub struct Session {
    parts: Mutex<Vec<Parts>>,
    buffers: Buffers,
    binding: Option<Binding>,
}

/// What a run bound and learnt, for runs that are alike.
struct Binding {
    key: Key,
    textures: Vec<Arc<Texture>>,
    prints: Prints,
    outputs: Vec<Output>,
    by_normal: bool,
    /// Whether the shapes of the outputs have been learnt.
    shaped: bool,
}

/// All that decides what is bound, but the pixels.
struct Key {
    textures: Vec<(String, Arc<Image<'static>>)>,
    frame: u32,
    frame_number: Option<i64>,
    set: Vec<(String, PixelValue)>,
    pixelsize: Option<f32>,
    spaces: Vec<(String, Matrix4)>,
    eye: Option<[f32; 3]>,
    outputs: Option<Vec<String>>,
    keep_alpha: bool,
    isa: Option<Isa>,
    no_optimize: bool,
    limits: Limits,
    texture_memory: Option<usize>,
    resolution: [usize; 2],
    attributes: Metadata,
    variables: Vec<(String, Shape)>,
    /// The names of the buffers that are written.
    buffers: Vec<(String, usize)>,
}

impl Key {
    fn of(inputs: &Inputs<'_>, options: &Options<'_>, buffers: &[BufferViewMut<'_>]) -> Key {
        Key {
            textures: options.textures.clone(),
            frame: options.frame.to_bits(),
            frame_number: options.frame_number,
            set: options.set.clone(),
            pixelsize: options.pixelsize,
            spaces: options.spaces.clone(),
            eye: options.eye,
            outputs: options.outputs.clone(),
            keep_alpha: options.keep_alpha,
            isa: options.isa,
            no_optimize: options.no_optimize,
            limits: options.limits,
            texture_memory: options.texture_memory,
            resolution: inputs.resolution(),
            attributes: inputs.metadata.clone(),
            variables: inputs.iter().map(|v| (v.name.to_string(), v.shape.clone())).collect(),
            buffers: buffers.iter().map(|b| (b.name.to_string(), b.components)).collect(),
        }
    }

    /// Whether another run would be bound alike. Nothing is allocated for it.
    fn matches(&self, inputs: &Inputs<'_>, options: &Options<'_>, buffers: &[BufferViewMut<'_>]) -> bool {
        let variables = inputs.iter().map(|v| (v.name, v.shape));
        let buffers = buffers.iter().map(|b| (b.name, b.components));
        same_textures(&self.textures, &options.textures)
            && self.frame == options.frame.to_bits()
            && self.frame_number == options.frame_number
            && self.set == options.set
            && self.pixelsize == options.pixelsize
            && self.spaces == options.spaces
            && self.eye == options.eye
            && self.outputs == options.outputs
            && self.keep_alpha == options.keep_alpha
            && self.isa == options.isa
            && self.no_optimize == options.no_optimize
            && self.limits == options.limits
            && self.texture_memory == options.texture_memory
            && self.resolution == inputs.resolution()
            && self.attributes == *inputs.metadata
            && variables.eq(self.variables.iter().map(|(name, shape)| (name.as_str(), shape)))
            && buffers.eq(self.buffers.iter().map(|(name, components)| (name.as_str(), *components)))
    }
}

fn same_textures(a: &[(String, Arc<Image<'static>>)], b: &[(String, Arc<Image<'static>>)]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|((a, x), (b, y))| a == b && Arc::ptr_eq(x, y))
}

impl Session {
    /// Runs the program at every pixel of an image.
    pub fn run(
        &mut self,
        program: &Resolved,
        image: &Image<'_>,
        options: &Options<'_>,
    ) -> Result<Report, Failure> {
        if options.sampling().is_some() {
            return stream::run(program, image, options);
        }
        self.run_with(program, Inputs::of(image), options, &[], |job, parts| {
            loop {
                match job.attempt(parts)? {
                    Attempt::Done(report) => return Ok(*report),
                    Attempt::Again(misfit) => job.widen(misfit)?,
                }
            }
        })
    }

    /// Runs the program at every pixel of a host's buffers, and writes into others.
    pub fn run_into(
        &mut self,
        program: &Resolved,
        size: [usize; 2],
        metadata: &Metadata,
        inputs: &[BufferView<'_>],
        outputs: &mut [BufferViewMut<'_>],
        options: &Options<'_>,
    ) -> Result<Report, Failure> {
        check_views(size, inputs)?;
        let inputs = Inputs::of_buffers(size, metadata, inputs);
        if options.sampling().is_some() {
            return sampled_into(program, &inputs, outputs, options);
        }
        self.run_with_buffers(program, inputs, options, outputs)
    }

    fn run_with_buffers(
        &mut self,
        program: &Resolved,
        inputs: Inputs<'_>,
        options: &Options<'_>,
        views: &mut [BufferViewMut<'_>],
    ) -> Result<Report, Failure> {
        let names: SmallVec<[BufferViewMut<'_>; 4]> = views
            .iter()
            .map(|v| BufferViewMut {
                name: v.name,
                components: v.components,
                data: &mut [],
                strides: v.strides,
            })
            .collect();
        self.run_with(program, inputs, options, &names, |job, parts| {
            loop {
                job.check_outputs()?;
                let size = job.grid().size();
                let mut targets = SmallVec::new();
                for view in &mut *views {
                    add_targets(&job.outputs, view, size, &mut targets)?;
                }
                match job.drive(Targets::new(size, targets), parts) {
                    Ok(outcome) => return Ok(job.report(Image::default(), outcome)),
                    Err(Interruption::Misfit(misfit)) => job.widen(misfit)?,
                    Err(Interruption::Failure(failure)) => return Err(failure),
                }
            }
        })
    }

    /// Binds the program, or takes what the last run bound, and gives the job to `run`.
    fn run_with<T>(
        &mut self,
        program: &Resolved,
        inputs: Inputs<'_>,
        options: &Options<'_>,
        buffers: &[BufferViewMut<'_>],
        run: impl FnOnce(&mut Job<'_>, &Mutex<Vec<Parts>>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let alike = self.binding.take().filter(|b| b.key.matches(&inputs, options, buffers));
        let height = inputs.height;
        let room = std::mem::take(&mut self.buffers);
        let (bound, key, found) = match alike {
            Some(Binding { key, textures, prints, outputs, by_normal, shaped }) => {
                let bound = Bound::again(program, inputs, options, room, textures, prints)?;
                (bound, key, Some((outputs, by_normal, shaped)))
            }
            None => {
                if let Ok(parts) = self.parts.get_mut() {
                    parts.iter_mut().for_each(|parts| parts.memory.forget_plans());
                }
                let key = Key::of(&inputs, options, buffers);
                (bind_inputs(program, inputs, None, options, room, &mut None)?, key, None)
            }
        };
        let (result, binding) = {
            let named;
            let (mut job, shaped) = match found {
                Some((outputs, by_normal, shaped)) => {
                    (Job::of_outputs(program, &bound, 0..height, options, outputs, by_normal)?, shaped)
                }
                None if buffers.is_empty() => (Job::new(program, &bound, 0..height, options)?, false),
                None => {
                    named = options_for(program, options, buffers);
                    let job = Job::new(program, &bound, 0..height, &named)?;
                    (Job { options, ..job }, false)
                }
            };
            if !shaped {
                job.sample();
            }
            let result = run(&mut job, &self.parts);
            let result = result.and_then(|value| bound.sound(program).map(|()| value));
            (result, (job.outputs, job.by_normal))
        };
        let (outputs, by_normal) = binding;
        let shaped = result.is_ok();
        let Bound { sources, size, steps, staged, neighbours, textures, prints, .. } = bound;
        let neighbours = neighbours.map(super::shadow::Neighbours::into_buffer).unwrap_or_default();
        self.buffers = Buffers { sources, size, steps, staged, neighbours };
        self.binding = Some(Binding { key, textures, prints, outputs, by_normal, shaped });
        result
    }
}

/// The options under which the outputs are those of the buffers.
fn options_for<'o>(program: &Resolved, options: &Options<'o>, buffers: &[BufferViewMut<'_>]) -> Options<'o> {
    let mut names: Vec<String> = buffers.iter().map(|b| b.name.to_string()).collect();
    let alpha = buffers.iter().any(|b| b.name == "color" && b.components == 4);
    if alpha && output::default_names(program).iter().any(|name| name == "alpha") {
        names.push("alpha".into());
    }
    Options { outputs: Some(names), keep_alpha: alpha, ..options.clone() }
}

fn refuse<T>(message: String) -> Result<T, Failure> {
    Err(Failure::Program(vec![Diagnostic::bare("buffer", message)]))
}

/// Refuses buffers that do not hold an image of that size.
fn check_views(size: [usize; 2], inputs: &[BufferView<'_>]) -> Result<(), Failure> {
    for (i, view) in inputs.iter().enumerate() {
        if !view.strides.fits(size, view.shape.cells(), view.data.len()) {
            let (name, length, [w, h]) = (view.name, view.data.len(), size);
            return refuse(format!(
                "the buffer of `{name}` has {length} numbers, too few for its strides at {w} x {h} pixels"
            ));
        }
        if inputs[..i].iter().any(|other| other.name == view.name) {
            return refuse(format!("two buffers are called `{}`", view.name));
        }
    }
    Ok(())
}

/// Adds what a buffer takes of the outputs.
fn add_targets<'p>(
    outputs: &[Output],
    view: &'p mut BufferViewMut<'_>,
    size: [usize; 2],
    targets: &mut SmallVec<[Target<'p>; 8]>,
) -> Result<(), Failure> {
    let [width, height] = size;
    let name = view.name;
    if !view.strides.fits(size, view.components, view.data.len()) {
        let length = view.data.len();
        return refuse(format!(
            "the buffer of `{name}` has {length} numbers, too few for its strides at {width} x {height} pixels"
        ));
    }
    if width == 0 || height == 0 {
        return Ok(());
    }
    let plane_of = |name: &str| {
        let at = outputs.iter().position(|o| o.name == name)?;
        Some((outputs[..at].iter().map(|o| o.shape.cells()).sum::<usize>(), &outputs[at].shape))
    };
    let Some((first, shape)) = plane_of(name) else {
        return refuse(format!("there is no output `{name}`"));
    };
    let cells = shape.cells();
    let ones: usize = outputs.iter().map(|o| o.shape.cells()).sum();
    let mut planes: SmallVec<[(usize, usize); 4]> = SmallVec::new();
    for component in 0..view.components {
        let plane = if shape.is_scalar() {
            first
        } else if component < cells {
            first + component
        } else if name == "color" && component == 3 {
            plane_of("alpha").map_or(ones, |(plane, _)| plane)
        } else {
            return refuse(format!(
                "`{name}` is {shape}, and its buffer has {} components for each pixel",
                view.components
            ));
        };
        planes.push((plane, component));
    }
    // A colour may leave its alpha behind; of other vectors no component is lost.
    if view.components < cells && !(name == "color" && (view.components, cells) == (3, 4)) {
        return refuse(format!(
            "`{name}` is {shape}, and its buffer has {} components for each pixel",
            view.components
        ));
    }
    let strides = view.strides;
    let whole = strides.pixel == 1 && strides.row == width as isize && strides.component >= width * height;
    if whole && view.components > 1 {
        // A plane for each component can be written in place.
        let mut rest = &mut view.data[strides.start..];
        for (plane, _) in planes {
            let (own, others) = rest.split_at_mut(strides.component.min(rest.len()));
            targets.push(Target::plane(plane, own));
            rest = others;
        }
        return Ok(());
    }
    match Target::buffer(planes, view.data, &strides, size) {
        Some(target) => targets.push(target),
        None => return refuse(format!("the rows of the buffer of `{name}` overlap")),
    }
    Ok(())
}

/// A run with several samples of each pixel: the mean is copied into the buffers at the end.
fn sampled_into(
    program: &Resolved,
    inputs: &Inputs<'_>,
    views: &mut [BufferViewMut<'_>],
    options: &Options<'_>,
) -> Result<Report, Failure> {
    let (width, height) = (inputs.width, inputs.height);
    let variable = |v: super::input::InputVariable<'_>| {
        let plane = |p: super::input::Samples<'_>| {
            let mut plane = vec![0.0; width * height];
            p.copy(0, &mut plane);
            plane.into()
        };
        Variable { name: v.name.to_string(), shape: v.shape.clone(), planes: v.planes().map(plane).collect() }
    };
    let variables = inputs.iter().map(variable).collect();
    let image = Image { width, height, variables, metadata: inputs.metadata.clone() };
    let options = options_for(program, options, views);
    let mut report = stream::run(program, &image, &options)?;
    let image = std::mem::take(&mut report.image);
    let outputs: Vec<Output> = image.variables.iter().map(Output::of_variable).collect();
    let mut planes: Vec<Vec<f32>> =
        image.variables.into_iter().flat_map(|v| v.planes).map(|p| p.into_owned()).collect();
    let (size, count) = ([image.width, image.height], image.width * image.height);
    planes.push(vec![1.0; count]);
    let planes: Vec<&mut [f32]> = planes.iter_mut().map(|p| &mut p[..]).collect();
    for view in views {
        let mut targets = SmallVec::new();
        add_targets(&outputs, view, size, &mut targets)?;
        if let Some(mut stretch) = Targets::new(size, targets).next(count) {
            stretch.pieces.iter_mut().for_each(|piece| piece.write(&planes));
        }
    }
    Ok(report)
}
