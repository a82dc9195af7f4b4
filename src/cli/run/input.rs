//! What a frame runs on: rows of files or of a scene, as they are wanted, or all of them in memory.

use super::plan::values;
use super::{Plan, RunArgs};
use crate::cli::camera::{Camera, CameraRequest};
use crate::cli::failure::Failure;
use crate::cli::frames::Frame;
use crate::cli::input::{Inputs, Reader};
use crate::cli::region::{Region, bands};
use crate::cli::solid::Found;
use pse::image::{Image, Metadata, Variable};
use pse::internal::eval::Places;
use pse::solid::{Isosurface, SolidStats};
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

/// A frame's input.
pub(super) struct FrameInput {
    pub inputs: Arc<Inputs>,
    scene: Option<Found>,
    /// All of it in memory, if it is to be run several times.
    whole: Option<Image<'static>>,
    /// Size and windows.
    about: Image<'static>,
    /// The variables that are read, but for those of named images.
    pub names: String,
    /// All variables that are read.
    variables: Vec<String>,
    /// The rows to run.
    rows: Range<usize>,
    pub region: Option<Region>,
    /// How many pixels about the region, and about a band, the program needs to know.
    around: usize,
    /// Run as one band?
    one: bool,
}

/// Some rows to run, in an image that has also those about them.
pub(super) struct Band<'a> {
    pub image: Image<'a>,
    pub rows: Range<usize>,
}

impl FrameInput {
    /// Opens the files. They are read at once if they are `kept` for several runs, else band by band.
    pub fn open(args: &RunArgs, plan: &Plan, frame: Frame, kept: bool) -> Result<FrameInput, Failure> {
        let inputs = Inputs::open(&args.images.input, &args.images.map, args.raw, frame.number)?;
        let view = &args.images.view;
        let solid = plan.solid(args, frame)?.map(|solid| Found::Solid(solid.into()));
        let scene = match &plan.scene {
            Some(seen) => Some(Found::Scene(view.renderer(seen, frame.number, args.quiet)?.into())),
            None => solid,
        };
        let mut reader = inputs.reader(scene.as_ref().map(Found::finder), &plan.wanted, plan.keep_alpha)?;
        let about = reader.about().clone();
        let own: Vec<&str> = reader.names().filter(|n| !n.contains('.')).collect();
        let names = own.join(", ");
        let region = args.part(&about)?;
        let rows = match region {
            Some(region) => region.rows(&about)?,
            None => 0..about.height,
        };
        let variables: Vec<String> = reader.names().map(String::from).collect();
        let whole = if kept { Some(reader.read(0..about.height)?) } else { None };
        drop(reader);
        let (around, one) = (plan.around, args.repeat.is_some());
        let inputs = Arc::new(inputs);
        Ok(FrameInput { inputs, scene, whole, about, names, variables, rows, region, around, one })
    }

    /// The camera, if the files do not tell it and the program reads it.
    pub fn camera(&self, args: &RunArgs, plan: &Plan, frame: f32) -> Result<Camera<'_>, Failure> {
        let (set, spaces) = values(args, frame)?;
        let request = CameraRequest {
            program: &plan.program,
            view: args.images.view_of_image().filter(|_| self.scene.is_none()),
            inputs: &self.inputs,
            about: &self.about,
            variables: &self.variables,
            set: &set,
            spaces: &spaces,
        };
        request.find()
    }

    /// Columns and rows of the whole picture.
    pub fn resolution(&self) -> [usize; 2] {
        self.about.resolution()
    }

    /// The pixels that are run, and what lies where.
    pub fn about(&self) -> Result<Image<'static>, Failure> {
        match self.region {
            Some(region) => region.cut(&self.about, 0),
            None => Ok(self.about.clone()),
        }
    }

    /// What of an image comes from the scene, as it is seen at a sample's places.
    pub fn resample(&self, image: &Image<'_>, places: &Places) -> Result<Image<'static>, String> {
        let Some(scene) = &self.scene else { return Err("there is no scene".into()) };
        let top = image.metadata.origin[1] as usize;
        let rows = scene.rows_at(top..top + image.height, |pixel| places.offset(pixel))?;
        match rows.width == image.width {
            true => Ok(rows),
            // The rows hold all columns of it.
            false => Region::held(image).cut(&rows, 0).map_err(|_| "the region lies outside".into()),
        }
    }

    /// Does a sample have to be looked at anew?
    pub fn is_seen(&self) -> bool {
        self.scene.is_some()
    }

    /// The solid.
    pub fn solid(&self) -> Option<&Isosurface<'static>> {
        match &self.scene {
            Some(Found::Solid(solid)) => Some(solid),
            _ => None,
        }
    }

    /// The statistics of a solid.
    pub fn solid_stats(&self) -> Option<SolidStats> {
        self.solid().map(Isosurface::stats)
    }

    /// The rows of each band, no more than so many if there is a limit.
    pub fn bands(&self, most: Option<usize>) -> Vec<Range<usize>> {
        match (self.one, most) {
            (true, _) => vec![self.rows.clone()],
            (false, None) => bands(self.about.width, self.rows.clone()).collect(),
            (false, Some(most)) => {
                let Range { start, end } = self.rows;
                (start..end).step_by(most).map(|top| top..end.min(top + most)).collect()
            }
        }
    }

    /// The first row that is run.
    pub fn first_row(&self) -> Range<usize> {
        self.rows.start..self.rows.start + 1
    }

    /// How many rows above and below a band are read with it.
    pub fn around(&self) -> usize {
        self.around
    }

    /// Bytes that the input takes beside the bands.
    pub fn fixed(&self) -> u64 {
        self.inputs.list.iter().map(|opened| opened.file.working_memory()).sum()
    }

    /// A way through all bands from the first.
    pub fn reader<'a>(&'a self, plan: &Plan) -> Result<BandReader<'a>, Failure> {
        let reader = match &self.whole {
            Some(_) => None,
            None => Some(self.inputs.reader(
                self.scene.as_ref().map(Found::finder),
                &plan.wanted,
                plan.keep_alpha,
            )?),
        };
        Ok(BandReader { input: self, reader })
    }

    /// What was run, without the pixels about the region.
    pub fn cut(&self, image: Image<'static>) -> Result<Image<'static>, Failure> {
        match self.region {
            Some(region) if self.around > 0 => region.cut(&image, 0),
            _ => Ok(image),
        }
    }
}

/// Reads band after band.
pub(super) struct BandReader<'a> {
    input: &'a FrameInput,
    reader: Option<Reader<'a>>,
}

impl<'a> BandReader<'a> {
    /// The band of these rows.
    pub fn read(&mut self, rows: Range<usize>) -> Result<Band<'a>, Failure> {
        let FrameInput { around, about, region, .. } = self.input;
        let with = rows.start.saturating_sub(*around)..about.height.min(rows.end + around);
        let inner = rows.start - with.start..rows.end - with.start;
        let image = match (&mut self.reader, &self.input.whole) {
            (Some(reader), _) => reader.read(with)?,
            (None, Some(whole)) => part(whole, with),
            (None, None) => Image::default(),
        };
        let image = match region {
            Some(region) => region.cut(&image, *around as i64)?,
            None => image,
        };
        Ok(Band { image, rows: inner })
    }
}

/// Some rows of an image, borrowed.
fn part<'a>(whole: &'a Image<'static>, rows: Range<usize>) -> Image<'a> {
    let pixels = rows.start * whole.width..rows.end * whole.width;
    let variables = whole.variables.iter().map(|v| Variable {
        name: v.name.clone(),
        shape: v.shape.clone(),
        planes: v.planes.iter().map(|p| Cow::Borrowed(&p[pixels.clone()])).collect(),
    });
    let [x, y] = whole.metadata.origin;
    let metadata = Metadata {
        origin: [x, y + rows.start as i32],
        resolution: Some(whole.resolution()),
        ..whole.metadata.clone()
    };
    Image { width: whole.width, height: rows.len(), variables: variables.collect(), metadata }
}
