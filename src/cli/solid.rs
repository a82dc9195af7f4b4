//! Solids on the command line: which, how it is looked at, and what is told of it.

use super::failure::{Failure, warn};
use super::frames::{self, Frame};
use super::input::Finder;
use super::interrupt::CANCEL;
use super::scene::ViewArgs;
use super::source;
use clap::Args;
use pse::Disk;
use pse::image::Image;
use pse::internal::program::{Compiler, Limits, RunOptions};
use pse::internal::value::PixelValue;
use pse::scene::Renderer;
use pse::solid::{Isosurface, SolidError, SolidOptions, SolidStats};
use std::ops::Range;
use std::path::PathBuf;

/// A solid from a density function.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Solid")]
pub(super) struct SolidArgs {
    /// Use a solid as input: a program with a function density(p). Its surface is where the density equals the level
    #[arg(long, value_name = "FILE")]
    pub iso: Option<PathBuf>,
    /// The density at the surface; inside it is higher (default: 0)
    #[arg(long, value_name = "DENSITY", requires = "iso", allow_hyphen_values = true)]
    pub level: Option<f64>,
    /// Two corners of the box around the solid; parts outside are cut off (default: -1.5,-1.5,-1.5,1.5,1.5,1.5)
    #[arg(long = "box", value_name = "X,Y,Z,X,Y,Z", requires = "iso", value_parser = bounds, allow_hyphen_values = true)]
    pub bounds: Option<Bounds>,
    /// The density's maximum change per unit of distance (default: estimated)
    #[arg(long, value_name = "SLOPE", requires = "iso")]
    pub lipschitz: Option<f64>,
    /// Render as a volume: absorb where the density exceeds the level, and emit emission(p)
    #[arg(long, requires = "iso")]
    pub soft: bool,
    /// The longest step through a volume (default: 1/256 of the box)
    #[arg(long, value_name = "LENGTH", requires = "soft")]
    pub step: Option<f64>,
}

/// The least and the greatest coordinates of a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds(pub [[f64; 3]; 2]);

pub(super) fn bounds(text: &str) -> Result<Bounds, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match numbers.as_deref() {
        Some(&[a, b, c, d, e, f]) => Ok(Bounds([[a, b, c], [d, e, f]])),
        _ => Err("give six numbers with commas between, for example -1,-1,-1,1,1,1".into()),
    }
}

impl From<SolidError> for Failure {
    fn from(error: SolidError) -> Failure {
        match error {
            SolidError::Program(error) => (*error).into(),
            SolidError::View(error) => (*error).into(),
            SolidError::Solid(diagnostic) => Failure::Plain(diagnostic),
        }
    }
}

impl SolidArgs {
    /// The solid in this view, in a frame. Of what is set, only what the program has is taken if others may have it.
    pub fn open(
        &self,
        view: &ViewArgs,
        path: &[PathBuf],
        limits: Limits,
        set: Vec<(String, PixelValue)>,
        frame: Frame,
    ) -> Result<Option<Isosurface<'static>>, Failure> {
        let Some(file) = &self.iso else { return Ok(None) };
        let (name, text) = source::read(file)?;
        let host = Disk { path: path.to_vec() };
        let compiler = Compiler::new().host(&host);
        // What else is wrong with the program, it says below.
        if let Ok(program) = compiler.compile(&name, &text) {
            frames::check_textures(&program, frame)?;
        }
        let default = SolidOptions::default();
        let options = SolidOptions {
            view: view.options(),
            bounds: self.bounds.map_or(default.bounds, |b| b.0),
            level: self.level.unwrap_or(default.level),
            lipschitz: self.lipschitz,
            soft: self.soft,
            step: self.step,
        };
        let run = RunOptions {
            frame: frame.value,
            frame_number: frame.number,
            set,
            limits,
            cancel: Some(&CANCEL),
            ..RunOptions::default()
        };
        Ok(Some(Isosurface::new(&compiler, &name, &text, &options, &run)?))
    }
}

/// What rows are rendered from.
pub(super) enum Found {
    Scene(Box<Renderer>),
    Solid(Box<Isosurface<'static>>),
}

impl Found {
    /// Borrowed.
    pub fn finder(&self) -> Finder<'_> {
        match self {
            Found::Scene(scene) => Finder::Scene(scene),
            Found::Solid(solid) => Finder::Solid(solid),
        }
    }

    /// Some rows, seen beside the middle of each pixel.
    pub fn rows_at(
        &self,
        rows: Range<usize>,
        offset: impl Fn([i32; 2]) -> [f32; 2] + Sync,
    ) -> Result<Image<'static>, String> {
        match self {
            Found::Scene(scene) => scene.rows_at(rows, offset).map_err(|e| e.to_string()),
            Found::Solid(solid) => solid.rows_at(rows, offset).map_err(|e| e.to_string()),
        }
    }
}

/// Prints statistics of the search for the surface.
pub(super) fn print_stats(stats: &SolidStats) {
    warn(&format!("density evaluated at {} points", stats.evaluations));
    if let Some([low, high]) = stats.slope_bounds {
        warn(&format!("largest slope        {low:.4} to {high:.4}"));
        warn(&format!("steps per ray        {} at most", stats.max_steps));
        warn(&format!("slope exceeded       {} times", stats.contradictions));
    }
    if stats.visible_pixels > 0 {
        warn(&format!("visible at           {} pixels", stats.visible_pixels));
    }
}

/// Warns if the picture is empty, or parts of the solid may be missing.
pub(super) fn warn_unseen(stats: &SolidStats, solid: &SolidArgs) {
    if let (Some(slope), 1..) = (solid.lipschitz, stats.contradictions) {
        let n = stats.contradictions;
        warn(&format!(
            "the density is steeper than --lipschitz {slope} at {n} steps: parts of the solid may be missing. Give a larger bound, or none"
        ));
    }
    if stats.visible_pixels == 0 {
        warn(
            "no pixel shows the solid. Move the eye, or check that the density crosses the --level inside the --box",
        );
    }
}
