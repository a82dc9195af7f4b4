//! The image that the preview works on: files or a scene, read as far as programs ask for it.

use super::PreviewArgs;
use crate::cli::camera::{Camera, CameraRequest};
use crate::cli::failure::Failure;
use crate::cli::frames::{self, Frame};
use crate::cli::input::{InputArg, Inputs, MapArg, Wanted};
use crate::cli::known::Known;
use crate::cli::run::{reading, scene};
use crate::cli::scene::ViewArgs;
use pse::image::{Image, Input, Matrix4};
use pse::internal::program::Program;
use pse::internal::value::PixelValue;
use pse::scene::Renderer;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// The images of the preview.
pub(super) struct Pictures {
    input: Vec<InputArg>,
    map: Vec<MapArg>,
    raw: bool,
    scene: Option<Renderer>,
    /// Standard input and pipes, which can be read once only, by their paths.
    pipes: BTreeMap<PathBuf, Input>,
    /// The view options, if it is an image that is looked at.
    view: Option<Arc<ViewArgs>>,
    /// What was read last.
    kept: Option<Kept>,
}

struct Kept {
    /// Which state of the files, and which frame of them.
    of: (u64, Option<i64>),
    /// The variables that were asked for.
    wanted: Wanted,
    inputs: Arc<Inputs>,
    image: Arc<Image<'static>>,
}

/// What a program runs on.
#[derive(Clone)]
pub(super) struct Picture {
    /// The image, with what the program reads of it.
    pub image: Arc<Image<'static>>,
    /// The files, to tell what they have.
    pub inputs: Arc<Inputs>,
    /// The view options, if it is an image that is looked at.
    view: Option<Arc<ViewArgs>>,
}

impl Picture {
    /// The camera, found from the points of the files if the program reads it and nothing else tells it.
    pub fn camera(
        &self,
        program: &Program,
        set: &[(String, PixelValue)],
        spaces: &[(String, Matrix4)],
    ) -> Result<Camera<'_>, Failure> {
        let variables: Vec<String> = self.image.variables.iter().map(|v| v.name.clone()).collect();
        let request = CameraRequest {
            program,
            view: self.view.as_deref(),
            inputs: &self.inputs,
            about: &self.image,
            variables: &variables,
            set,
            spaces,
        };
        let camera = request.find()?;
        camera.report();
        Ok(camera)
    }
}

impl Pictures {
    /// What the arguments name.
    pub fn new(args: &PreviewArgs) -> Result<Pictures, Failure> {
        let images = &args.images;
        let frame = args.first_frame();
        let scene =
            scene(images)?.map(|seen| images.view.renderer(&seen, frame.number, false)).transpose()?;
        let mut pipes = BTreeMap::new();
        for path in images.input.iter().map(|input| PathBuf::from(&input.path)) {
            let seekable = Input::from_argument(&path)?.seekable()?;
            if seekable.path().is_none() {
                pipes.insert(path, seekable);
            }
        }
        Ok(Pictures {
            pipes,
            input: images.input.clone(),
            map: images.map.clone(),
            raw: args.raw,
            scene,
            view: images.view_of_image().cloned().map(Arc::new),
            kept: None,
        })
    }

    /// The files of a frame.
    pub fn files(&self, frame: Frame) -> Vec<PathBuf> {
        self.input.iter().map(|input| frames::input(&input.path, frame.number)).collect()
    }

    /// Is every frame another image?
    pub fn animated(&self) -> bool {
        self.input.iter().any(|input| frames::is_sequence(&input.path))
    }

    /// All variables that programs can read.
    pub fn names(&self) -> Vec<String> {
        let scene = self.scene.iter().flat_map(|scene| scene.names()).map(|name| name.to_string());
        scene.chain(self.kept.iter().flat_map(|kept| kept.inputs.variables())).collect()
    }

    /// What is known of the images before a program has run on them.
    pub fn known(&self) -> Known {
        let first =
            self.scene.as_ref().map(|scene| ("scene".to_string(), scene.names().map(String::from).collect()));
        match (&self.kept, first) {
            (Some(kept), first) => Known::Images { first, inputs: Arc::clone(&kept.inputs) },
            (None, Some(first)) if self.input.is_empty() => {
                Known::Images { first: Some(first), inputs: Arc::new(Inputs::none()) }
            }
            (None, _) => Known::Usual,
        }
    }

    /// What a program reads in a frame, and what else is to be shown; `files` is the number of the files' state.
    pub fn read(
        &mut self,
        program: &Program,
        also: &[String],
        frame: Frame,
        files: u64,
    ) -> Result<Picture, Failure> {
        let mut sequences = self.input.iter().filter(|input| frames::is_sequence(&input.path));
        sequences.try_for_each(|input| frames::check_number(&input.path, frame))?;
        let of = (files, frame.number.filter(|_| self.animated()));
        let (mut wanted, _) = reading(program, also, false, false);
        if let Some(kept) = self.kept.as_ref().filter(|kept| kept.of == of) {
            let has = |name: &String| kept.wanted.all().any(|(kept, _)| kept == name);
            if wanted.all().all(|(name, _)| has(name)) {
                return Ok(Picture {
                    image: Arc::clone(&kept.image),
                    inputs: Arc::clone(&kept.inputs),
                    view: self.view.clone(),
                });
            }
            // What was wanted will be again.
            let new = |of: &Vec<String>, names: &Vec<String>| -> Vec<String> {
                names.iter().filter(|name| !of.contains(name)).cloned().collect()
            };
            let (names, aids) =
                (new(&wanted.names, &kept.wanted.names), new(&wanted.aids, &kept.wanted.aids));
            wanted.names.extend(names);
            wanted.aids.extend(aids);
        }
        let inputs = Arc::new(Inputs::open_by(&self.input, &self.map, self.raw, frame.number, |path| {
            self.pipes.get(path).map_or_else(|| Input::from_argument(path), |pipe| Ok(pipe.clone()))
        })?);
        let mut reader = inputs.reader(self.scene.as_ref(), &wanted, true)?;
        let height = reader.about().height;
        let mut image = reader.read(0..height)?;
        if image.width == 0 || image.height == 0 {
            // A program may well read no variable at all.
            let about = reader.about();
            image =
                Image { width: about.width, height, metadata: about.metadata.clone(), ..Image::default() };
        }
        drop(reader);
        let image = Arc::new(image);
        let view = self.view.clone();
        let picture = Picture { image: Arc::clone(&image), inputs: Arc::clone(&inputs), view };
        self.kept = Some(Kept { of, wanted, inputs, image });
        Ok(picture)
    }
}
