//! Where a texture comes from, and which of its channels are wanted; read when a run needs it, and kept.

use super::pyramid::Growing;
use super::sphere::Seat;
use super::store::{Store, Tiles};
use super::texels::Texels;
use super::wanted::{Known, Wanted, known, wanted, wanted_of};
use super::{Layout, Needs, Texture, bytes, sphere};
use crate::image::{
    ErrorKind, File, Frame, Image, ImageError, Input, Mapping, ReadOptions, fill, guard, has_pattern, read,
};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// An image that a program may look things up in.
#[derive(Clone, Debug)]
pub enum Origin {
    /// A file. A path with a place for the frame's number (`sky.####.exr`) is another file in each frame.
    File(Input),
    /// An image in memory.
    Image(Arc<Image<'static>>),
}

/// A texture that a program names.
pub struct Source {
    /// The name in messages.
    pub name: String,
    /// Where it comes from.
    pub origin: Origin,
    /// The variable or the channels that are wanted; `None`: the colour, or the only variable that there is.
    pub channel: Option<String>,
    /// Take PNG and the like as they are stored?
    pub raw: bool,
    /// What the image shows.
    pub layout: Layout,
    /// What is kept ready.
    pub needs: Needs,
    /// The last that was read, and the path of its file.
    kept: Mutex<Option<(Option<PathBuf>, Arc<Texture>)>>,
}

impl Source {
    /// A texture that has not been read yet.
    pub fn new(name: &str, origin: Origin, channel: Option<&str>, raw: bool, layout: Layout) -> Source {
        Source {
            name: name.into(),
            origin,
            channel: channel.map(String::from),
            raw,
            layout,
            needs: Needs::default(),
            kept: Mutex::default(),
        }
    }

    /// The same look-ups in another image, in memory.
    pub fn replaced(&self, image: &Arc<Image<'static>>) -> Source {
        let origin = Origin::Image(Arc::clone(image));
        let mut source = Source::new(&self.name, origin, self.channel.as_deref(), self.raw, self.layout);
        source.needs = self.needs;
        source
    }

    /// Would both be read alike?
    pub fn same(&self, other: &Source) -> bool {
        let origin = match (&self.origin, &other.origin) {
            (Origin::File(a), Origin::File(b)) => {
                a.same_bytes(b) || a.path().is_some() && a.path() == b.path()
            }
            (Origin::Image(a), Origin::Image(b)) => Arc::ptr_eq(a, b),
            _ => false,
        };
        origin && self.channel == other.channel && self.raw == other.raw && self.layout == other.layout
    }

    /// Takes over what another one of the same image has read.
    pub fn share(&self, other: &Source) {
        let kept = other.kept.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let texture = kept.filter(|(_, texture)| texture.serves(self.needs));
        if let Some(texture) = texture {
            *self.kept.lock().unwrap_or_else(PoisonError::into_inner) = Some(texture);
        }
    }

    /// Its file in a frame, if it is a file on disk.
    ///
    /// # Errors
    /// If the name has a place for the frame's number and that is not whole.
    pub fn path(&self, frame: Frame) -> Result<Option<PathBuf>, ImageError> {
        let Some(path) = self.file() else { return Ok(None) };
        if !self.is_sequence() {
            return Ok(Some(path.to_path_buf()));
        }
        let Some(number) = frame.number else {
            let (shown, value) = (path.display(), frame.value);
            let message = format!("`{shown}` takes a whole frame number, and the frame is {value}");
            return Err(ImageError::new(ErrorKind::Missing, message));
        };
        Ok(Some(fill(&path.to_string_lossy(), number).into()))
    }

    /// Its path as the program names it, if it is a file on disk.
    fn file(&self) -> Option<&Path> {
        match &self.origin {
            Origin::File(input) => input.path(),
            Origin::Image(_) => None,
        }
    }

    /// Whether it is another file in each frame: its name has a place for the number, and no file is called so.
    pub fn is_sequence(&self) -> bool {
        let path = self.file();
        path.is_some_and(|path| has_pattern(&path.to_string_lossy()) && !path.exists())
    }

    /// Its path with a place for the frame's number, if it is another file in each frame.
    pub fn pattern(&self) -> Option<String> {
        self.file().filter(|_| self.is_sequence()).map(|path| path.to_string_lossy().into_owned())
    }

    /// Looks whether it can be read, as far as the header tells. Of a sequence that is frame 0, if there is one.
    ///
    /// # Errors
    /// If the file cannot be read, or does not have what is wanted.
    pub fn check(&self) -> Result<(), ImageError> {
        match self.path(Frame::from(0_i64))? {
            Some(path) if !path.exists() => Ok(()),
            path => self.open(path).map(drop),
        }
    }

    /// The texture in a frame: read, or the one that was kept. `left` is how many bytes of memory textures may still
    /// take: one that would leave less than a quarter of them is put into a temporary file, tile by tile.
    ///
    /// # Errors
    /// If the file cannot be read, does not have what is wanted, or the temporary file cannot be written.
    pub fn load(&self, frame: Frame, left: &mut u64, tiles: &Arc<Tiles>) -> Result<Arc<Texture>, ImageError> {
        let path = self.path(frame)?;
        // Nothing is left half done in it.
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let most = *left - *left / 4;
        if let Some((_, texture)) = kept.as_ref().filter(|(of, t)| *of == path && t.memory() <= most) {
            *left -= texture.memory();
            return Ok(Arc::clone(texture));
        }
        // The last frame's makes room.
        *kept = None;
        let opened = self.open(path.clone())?;
        let texture = Arc::new(self.texture(&opened, most, tiles)?);
        *left -= texture.memory();
        *kept = Some((path, Arc::clone(&texture)));
        Ok(texture)
    }

    #[cfg_attr(
        not(feature = "exr"),
        expect(unreachable_code, unused_variables, reason = "there are no files")
    )]
    fn open(&self, path: Option<PathBuf>) -> Result<Opened<'_>, ImageError> {
        let input: Input = match (&self.origin, path) {
            (Origin::Image(image), _) => {
                let known: Vec<Known<'_>> = image.variables.iter().map(known).collect();
                let wanted = wanted(&self.name, &known, self.channel.as_deref())?;
                return self.checked(Opened { pixels: Pixels::Memory(image), wanted });
            }
            (Origin::File(input), Some(path)) => input.with_path(path),
            (Origin::File(input), None) => input.clone(),
        };
        let mut options = ReadOptions { maps: Vec::new(), raw: self.raw };
        let file = read(input.clone(), &options)?;
        let error = match wanted_of(&file, self.channel.as_deref()) {
            Ok(wanted) => return self.checked(Opened { pixels: Pixels::File(Box::new(file)), wanted }),
            Err(error) => error,
        };
        // A channel or a group of them by the name that it has in the file, as `--map` takes it.
        let Some(channels) = &self.channel else { return Err(error) };
        options.maps = vec![Mapping { name: channels.clone(), channels: channels.clone() }];
        let Ok(file) = read(input, &options) else { return Err(error) };
        let wanted = wanted_of(&file, self.channel.as_deref())?;
        self.checked(Opened { pixels: Pixels::File(Box::new(file)), wanted })
    }

    fn checked<'a>(&self, opened: Opened<'a>) -> Result<Opened<'a>, ImageError> {
        let [w, h] = opened.resolution();
        if w == 0 || h == 0 {
            return Err(ImageError::new(ErrorKind::Damaged, format!("`{}` has no pixels", self.name)));
        }
        if self.layout == Layout::Cube && sphere::sides(w, h).is_none() {
            let message = format!("`{}` is not an image of a cube: it has {w} x {h} pixels", self.name);
            return Err(ImageError::new(ErrorKind::Unsupported, message)
                .hint("A cube has square sides in a row (6 x 1 or 1 x 6), in two rows (3 x 2), or in a cross (4 x 3 or 3 x 4).")
                .hint("An image by latitude and longitude needs no `layout`."));
        }
        Ok(opened)
    }

    /// Reads the pixels, and arranges them: as the display window has them, the sides of a cube one below the other.
    fn texture(&self, opened: &Opened<'_>, most: u64, tiles: &Arc<Tiles>) -> Result<Texture, ImageError> {
        let [w, h] = opened.resolution();
        let shape = opened.wanted.shape.clone();
        let cube = sphere::sides(w, h).filter(|_| self.layout == Layout::Cube);
        let (size, sides) = cube.map_or(([w, h], 1), |(n, _)| ([n, n], 6));
        let length = opened.file_bytes()?;
        // What a short file claims to be gets no more memory than it deserves, but tiles.
        let memory = most.min(guard::texture_memory(length));
        let whole = bytes([size[0], sides * size[1]], shape.cells(), self.needs) <= memory;
        let store = match whole {
            true => None,
            false => {
                guard::check_tiles(
                    &self.name,
                    bytes([size[0], sides * size[1]], shape.cells(), self.needs),
                    length,
                )?;
                Some(Arc::new(Store::new(tiles)?))
            }
        };
        let mut growing = Growing::new(size, sides, shape.cells(), self.needs, store.as_ref())?;
        // The sides of a cube may stand beside each other: what is not in memory then is decoded for each of them.
        // Formats that cannot go back would begin again for each.
        let mut texels = Texels::new(opened, cube.is_some() && (whole || !opened.seeks()));
        let mut row = Vec::new();
        match cube {
            Some((n, seats)) => {
                for Seat { column, row: down, turned } in seats {
                    for y in 0..n {
                        let y = if turned { n - 1 - y } else { y };
                        texels.row(down * n + y, column * n..(column + 1) * n, turned, &mut row)?;
                        growing.push(&row)?;
                    }
                }
            }
            None => {
                for y in 0..h {
                    texels.row(y, 0..w, false, &mut row)?;
                    growing.push(&row)?;
                }
            }
        }
        let (levels, sums) = growing.finish()?;
        Ok(Texture { shape, layout: self.layout, levels, sums, store })
    }
}

/// An image with its header read.
pub(super) struct Opened<'a> {
    pub pixels: Pixels<'a>,
    pub wanted: Wanted,
}

pub(super) enum Pixels<'a> {
    File(Box<File>),
    Memory(&'a Arc<Image<'static>>),
}

impl Opened<'_> {
    /// Whether rows can be decoded without those above them.
    fn seeks(&self) -> bool {
        match &self.pixels {
            Pixels::File(file) => file.seeks(),
            Pixels::Memory(_) => true,
        }
    }

    /// The length of its file; of an image in memory, no file lies about it.
    fn file_bytes(&self) -> Result<u64, ImageError> {
        match &self.pixels {
            Pixels::File(file) => file.length(),
            Pixels::Memory(_) => Ok(u64::MAX),
        }
    }

    pub fn resolution(&self) -> [usize; 2] {
        match &self.pixels {
            Pixels::File(file) => file.metadata().resolution.unwrap_or(file.size()),
            Pixels::Memory(image) => image.resolution(),
        }
    }
}

impl fmt::Debug for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "texture {}", self.name)
    }
}

#[cfg(test)]
pub(super) fn from_image(image: Image<'static>, layout: Layout, needs: Needs, most: u64) -> Texture {
    let mut source = Source::new("test", Origin::Image(Arc::new(image)), None, false, layout);
    source.needs = needs;
    let opened = source.open(None).expect("it is there");
    source.texture(&opened, most, &Arc::default()).expect("it can be arranged")
}
