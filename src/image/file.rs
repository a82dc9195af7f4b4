//! A file that can be read: its header first, then the variables that are asked for.

use super::Raster;
use super::bind::{self, Binding, Bound, Candidate, ChannelName};
use super::error::{ErrorKind, ImageError};
use super::mapping::Mapping;
use super::read_exr::{self, Exr};
use super::source::{Input, Stamp};
use super::{Image, Metadata};
use std::borrow::Cow;
use std::io::Read;

/// Options for reading.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// The user's mappings (`--map`).
    pub maps: Vec<Mapping>,
    /// Read the stored numbers of pictures such as PNG and JPEG, 0..1, without sRGB decoding and premultiplication:
    /// for normals, masks and other data. It does not affect EXR files.
    pub raw: bool,
}

/// The storage type of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// 16-bit floats.
    Half,
    /// 32-bit floats.
    Float,
    /// 32-bit unsigned integers.
    Uint,
    /// 8-bit codes.
    Byte,
    /// 16-bit codes.
    Short,
    /// 64-bit floats.
    Double,
    /// Whole numbers of this many bits.
    Bits(u8),
    /// An unknown type, which is not read.
    Unknown,
}

/// A channel of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The full name: layer (including the part's name, if it is the layer) and component.
    pub name: String,
    /// The index of its part in the file.
    pub part: usize,
    /// The index in that part.
    pub index: usize,
    /// The storage type.
    pub samples: Samples,
    /// The reason if it cannot be read by itself: a clause that follows "… is not read: ".
    pub unread: Option<String>,
    /// The number of columns and rows of each sample.
    pub sampling: [usize; 2],
}

/// A file whose header has been read. [`File::load`] decodes the pixels.
pub struct File {
    pub(crate) input: Input,
    pub(crate) source: Source,
    pub(crate) channels: Vec<Channel>,
    bindings: Vec<Binding>,
    /// Variables whose channels are not read.
    unread: Vec<Binding>,
    /// What the user should know of the mappings.
    notes: Vec<String>,
    metadata: Metadata,
    size: [usize; 2],
    /// The file as it was when its header was read.
    stamp: Option<Stamp>,
}

pub(crate) enum Source {
    Exr(Box<Exr>),
    Raster(Raster),
}

/// Reads the header of an image, of any format that is read, recognised by content.
///
/// # Errors
/// If the file cannot be read, is damaged, is of an unknown format, or a mapping does not fit it.
pub fn read(input: Input, options: &ReadOptions) -> Result<File, ImageError> {
    let input = input.seekable()?;
    let name = input.name();
    let stamp = input.stamp();
    let mut magic = Vec::new();
    let (reader, _) = input.open()?;
    reader.take(16).read_to_end(&mut magic).map_err(|e| ImageError::io("read", &name, &e))?;
    if magic.is_empty() {
        return Err(ImageError::damaged(&name, "it is empty"));
    }
    let (channels, metadata, size, source) = if magic.starts_with(&read_exr::MAGIC) {
        let exr = Exr::open(&input)?;
        let size = [exr.window.2, exr.window.3];
        (exr.channels(), exr.metadata(), size, Source::Exr(Box::new(exr)))
    } else {
        let raster = Raster::open(&input, options.raw)?;
        (raster.channels(), Metadata::default(), raster.size, Source::Raster(raster))
    };
    if channels.is_empty() {
        return Err(ImageError::damaged(&name, "it has no channels"));
    }
    let names: Cow<'_, [ChannelName]> = match &source {
        Source::Exr(exr) => exr.names().into(),
        Source::Raster(_) => channels.iter().map(|c| ChannelName::plain(&c.name)).collect(),
    };
    let Bound { bindings, unread, notes } = bind::bind(&name, &names, &options.maps)?;
    Ok(File { input, source, channels, bindings, unread, notes, metadata, size, stamp })
}

impl File {
    /// The name in messages.
    pub fn name(&self) -> String {
        self.input.name()
    }

    /// How many bytes the file has.
    pub(crate) fn length(&self) -> Result<u64, ImageError> {
        Ok(self.input.open()?.1)
    }

    /// Columns and rows of the pixels held: the data window (of several parts, the rectangle around
    /// all of theirs; outside its own window a part's channels read 0).
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Is the file on disk still the one whose header was read?
    pub(super) fn unchanged(&self) -> Result<(), ImageError> {
        if self.stamp == self.input.stamp() {
            return Ok(());
        }
        let message = format!("`{}` changed while it was read", self.name());
        Err(ImageError::new(ErrorKind::Changed, message)
            .hint("Run again when no other program writes to it."))
    }

    /// The windows and the other header attributes.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// All channels, in the file's order.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// What a user should know of the mappings, each without a full stop.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// All variables, including second names (marked as alias).
    pub fn variables(&self) -> &[Binding] {
        &self.bindings
    }

    /// The channels of the variable `name`.
    ///
    /// # Errors
    /// If there is none, with what there is and the `--map` that may help; if it is ambiguous, with
    /// the `--map`s that choose.
    pub fn find(&self, name: &str) -> Result<&Candidate, ImageError> {
        match self.bindings.iter().find(|b| b.name == name) {
            Some(binding) => bind::only(&self.name(), binding),
            None => Err(self.missing(name)),
        }
    }

    /// Whether the file has variables of a view with this name, other than the first, even if they cannot be read.
    pub fn has_view(&self, view: &str) -> bool {
        let of_view = |b: &Binding| b.name.split_once('.').is_some_and(|(own, _)| own == view);
        self.bindings.iter().chain(&self.unread).any(of_view)
    }

    /// Creates the error for a program that reads `name`, which this file does not have.
    pub fn missing(&self, name: &str) -> ImageError {
        let error = bind::missing(&self.name(), &self.bindings, name);
        let Some(binding) = self.unread.iter().find(|b| b.name == name) else { return error };
        // The reason comes before anything else that might be tried.
        let list = binding.candidates.iter().flat_map(|c| &c.channels).map(|&c| &self.channels[c]);
        let first = list.clone().find(|c| c.unread.is_some());
        let why = first.and_then(|c| Some(format!("`{}` is not read: {}.", c.name, c.unread.as_ref()?)));
        // That it should be rendered is no advice for what is there.
        let others = error.hints.into_iter().filter(|hint| !hint.starts_with("None of its channels"));
        ImageError { hints: why.into_iter().chain(others).collect(), ..error }
    }

    /// Decodes these variables, in this order, and nothing else.
    ///
    /// # Errors
    /// If one is missing or ambiguous, or the file turns out damaged.
    pub fn load(&self, names: &[&str]) -> Result<Image<'static>, ImageError> {
        self.rows(names)?.read(0..self.size[1])
    }

    /// Decodes every variable that is not ambiguous and no alias.
    ///
    /// # Errors
    /// If the file turns out damaged.
    pub fn load_all(&self) -> Result<Image<'static>, ImageError> {
        let plain = self.bindings.iter().filter(|b| !b.alias && b.candidates.len() == 1);
        let names: Vec<&str> = plain.map(|b| b.name.as_str()).collect();
        self.load(&names)
    }
}
