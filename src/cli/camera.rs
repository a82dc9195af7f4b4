//! The camera of an image whose header has none: as options give it, or found from the points of the surfaces.

use super::failure::{Failure, warn};
use super::input::Inputs;
use super::interrupt::CANCEL;
use super::region::bands;
use super::scene::ViewArgs;
use pse::gbuffer::{PointSampler, Projection, Resection, ResectionError};
use pse::image::{Image, Matrix4};
use pse::internal::eval::has_space;
use pse::internal::program::{Program, RunOptions};
use pse::internal::resolve::space_of;
use pse::internal::value::PixelValue;
use pse::scene::Renderer;
use pse::scene::camera::Camera as View;
use std::sync::atomic::{AtomicBool, Ordering};

/// The camera that options or points give, for what a program reads of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Camera<'i> {
    /// Matrices from the world to `"camera"` and `"screen"`.
    spaces: Vec<(String, Matrix4)>,
    /// The position of the eye, if nothing else of the camera is given.
    eye: Option<[f32; 3]>,
    /// Why it was not found from the points.
    hint: Option<String>,
    /// What the points tell, if that was asked.
    found: Option<&'i FoundCamera>,
}

/// What a program runs on, as far as its camera goes.
pub(super) struct CameraRequest<'a, 'i> {
    pub program: &'a Program,
    /// The view options, if it is an image that is looked at. A scene has its camera.
    pub view: Option<&'a ViewArgs>,
    pub inputs: &'i Inputs,
    /// Size, windows and header of the input.
    pub about: &'a Image<'a>,
    /// The variables that the input gives.
    pub variables: &'a [String],
    /// What `--set` gives.
    pub set: &'a [(String, PixelValue)],
    /// What `--space` gives.
    pub spaces: &'a [(String, Matrix4)],
}

impl<'i> CameraRequest<'_, 'i> {
    /// The camera, found from all points of the input if the program reads what nothing else tells.
    pub fn find(&self) -> Result<Camera<'i>, Failure> {
        let mut camera = Camera::default();
        let Some(view) = self.view else { return Ok(camera) };
        (camera.eye, camera.spaces) = of_view(view, self.about.resolution())?;
        if self.spaces.iter().any(|(name, _)| name == "camera") {
            camera.eye = None;
        }
        let known = |space: &str| {
            let given = self.spaces.iter().chain(&camera.spaces).any(|(name, _)| name == space);
            given || has_space(space, &self.about.metadata)
        };
        let eye = camera.eye.is_some() || known("camera") || known("screen");
        let missing = |space: &str| self.reads_space(space) && !known(space);
        if !(missing("camera") || missing("screen") || !eye && (self.reads("eye") || self.reads("I"))) {
            return Ok(camera);
        }
        let found = FoundCamera::of(self.inputs)?;
        match &found.outcome {
            Ok(resection) => {
                let spaces = ["camera", "screen"].into_iter().zip(resection.spaces());
                let new = spaces.filter(|(name, _)| !known(name)).map(|(name, m)| (name.to_string(), m));
                let new: Vec<(String, Matrix4)> = new.collect();
                camera.spaces.extend(new);
            }
            Err(reason) => camera.hint = Some(reason.clone()),
        }
        camera.found = Some(found);
        Ok(camera)
    }

    /// Whether the program reads the matrix of that space.
    fn reads_space(&self, space: &str) -> bool {
        let globals = &self.program.resolved().globals;
        globals.iter().any(|g| g.read.is_some() && space_of(&g.name) == Some(space))
    }

    /// Whether the program reads that name before it assigns it, and nothing else gives its value.
    fn reads(&self, name: &str) -> bool {
        let given =
            self.set.iter().any(|(n, _)| n == name) || self.variables.iter().any(|variable| variable == name);
        self.program.resolved().globals.iter().any(|g| {
            let own = !g.library && (given || g.framed.is_some());
            let before = match (g.read, g.assigned) {
                (Some(read), Some(assigned)) => read.start < assigned.start,
                (read, _) => read.is_some(),
            };
            g.name == name && before && !own
        })
    }
}

impl Camera<'_> {
    /// The options of a run with this camera. What they say of spaces comes first.
    pub fn options<'a>(&'a self, mut options: RunOptions<'a>) -> RunOptions<'a> {
        // Of two spaces of one name the last counts.
        options.spaces.splice(0..0, self.spaces.iter().cloned());
        options.eye = self.eye;
        options.camera_hint = self.hint.as_deref();
        options
    }

    /// Reports the camera that was found from points, the first time that these inputs' camera is used.
    pub fn report(&self) {
        if let Some(found) = self.found {
            found.report();
        }
    }

    /// Why it was not found from the points.
    pub fn hint(&self) -> Option<&str> {
        self.hint.as_deref()
    }
}

/// The camera that the points of inputs tell.
#[derive(Debug)]
pub(super) struct FoundCamera {
    /// The camera, or why there is none.
    pub outcome: Result<Resection, String>,
    /// The name of the file that has the points.
    name: String,
    reported: AtomicBool,
}

impl FoundCamera {
    /// Finds it, once for the same inputs. All rows are read, whatever part of the image is run, so that each part has the
    /// same camera.
    pub fn of(inputs: &Inputs) -> Result<&FoundCamera, Failure> {
        if let Some(known) = inputs.resection.get() {
            return Ok(known);
        }
        let name = inputs.name_of("point").unwrap_or_default();
        let outcome = match inputs.find("point") {
            None => Err(reason(&ResectionError::NoPoints)),
            Some(Err(ambiguous)) => {
                let hints = ambiguous.hints.join(" ");
                Err(format!("The camera cannot be found from the points: {}. {hints}", ambiguous.message))
            }
            Some(Ok(())) => resect(inputs)?.map_err(|error| reason(&error)),
        };
        Ok(inputs.resection.get_or_init(|| FoundCamera { outcome, name, reported: AtomicBool::new(false) }))
    }

    /// Reports what was found, once.
    pub fn report(&self) {
        if let Ok(found) = &self.outcome
            && !self.reported.swap(true, Ordering::Relaxed)
        {
            warn(&format!("{}: {}", self.name, description(found)));
        }
    }
}

/// The camera that draws over an image: as options or its header tell it, or found from its points; or why it is not known.
pub(super) fn projection(
    inputs: &Inputs,
    view: &ViewArgs,
    image: &Image<'_>,
    quiet: bool,
) -> Result<Result<Projection, String>, Failure> {
    let size = image.resolution();
    let (eye, given) = of_view(view, size)?;
    let written = image.metadata.attributes.matrix("worldToNDC");
    let screen = given.iter().find(|(name, _)| name == "screen").map(|(_, matrix)| *matrix);
    if screen.is_none() && eye.is_some() {
        return Ok(Err("`--eye` alone does not determine the view.".into()));
    }
    if let Some(projection) = screen.or(written).and_then(|screen| Projection::new(&screen, size)) {
        return Ok(Ok(projection));
    }
    let found = FoundCamera::of(inputs)?;
    if !quiet {
        found.report();
    }
    Ok(found.outcome.clone().map(|found| found.projection))
}

fn resect(inputs: &Inputs) -> Result<Result<Resection, ResectionError>, Failure> {
    let numbered = matches!(inputs.find("surface"), Some(Ok(())));
    let names: Vec<String> =
        ["point", "surface"].map(String::from).into_iter().take(1 + usize::from(numbered)).collect();
    let mut reader = inputs.reader(None::<&Renderer>, &names.into(), false)?;
    let about = reader.about().clone();
    let mut sampler = PointSampler::new(&about);
    for rows in bands(about.width, 0..about.height) {
        sampler.add(&reader.read(rows)?);
        if CANCEL.load(Ordering::Relaxed) {
            return Err(Failure::Interrupted);
        }
    }
    Ok(sampler.resect())
}

/// Why the camera of an input is not known.
fn reason(error: &ResectionError) -> String {
    format!("The camera cannot be found from the points: {error}.")
}

/// Points without noise have smaller residuals, in pixels, even halves.
const NOISE: f64 = 0.1;

/// The camera in a line.
pub(super) fn description(found: &Resection) -> String {
    let eye = found.projection.eye();
    // As many digits as the error leaves.
    let digits = (-libm::log10(3.0 * found.eye_error.max(1e-12))).floor().clamp(0.0, 6.0) as usize;
    let eye = eye.to_array().map(|x| plain(x, digits)).join(" ");
    let residual = plain(found.residual, 4);
    let noise = match found.residual > NOISE {
        true => "; a pixel filter, depth of field or motion blur causes such a residual",
        false => "",
    };
    format!(
        "camera found from the points: eye [{eye}], residual {residual} pixels (median of {} points){noise}",
        found.points
    )
}

/// A number without zeros at its end.
fn plain(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}

/// The camera that `--eye`, `--look-at` and `--fov` give to an image.
type OfView = (Option<[f32; 3]>, Vec<(String, Matrix4)>);

fn of_view(view: &ViewArgs, size: [usize; 2]) -> Result<OfView, Failure> {
    let Some(eye) = view.eye else { return Ok((None, Vec::new())) };
    let position = eye.0.map(|x| x as f32);
    let Some(look_at) = view.look_at else { return Ok((Some(position), Vec::new())) };
    let camera = View::within(
        f64::MAX,
        eye.0.into(),
        look_at.0.into(),
        Some(view.fov.unwrap_or(45.0)),
        [1.0; 2],
        size,
    )?;
    let spaces = ["camera", "screen"].map(String::from).into_iter().zip(camera.spaces(1.0));
    // Without an angle it is not known where things are on the screen.
    Ok((Some(position), spaces.take(1 + usize::from(view.fov.is_some())).collect()))
}
