//! Where a texture comes from, and which of its channels are wanted; read when a run needs it, and kept.

use super::level::Level;
use super::sphere::Seat;
use super::wanted::{Known, Wanted, known, wanted, wanted_of};
use super::{Layout, Needs, Texture, bytes, sphere};
use crate::image::{
    ErrorKind, File, Image, ImageError, Input, Mapping, ReadOptions, fill, has_pattern, read,
};
use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;
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
    /// What messages call it.
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

    /// Would both be read alike?
    pub fn same(&self, other: &Source) -> bool {
        let origin = match (&self.origin, &other.origin) {
            (Origin::File(Input::Path(a)), Origin::File(Input::Path(b))) => a == b,
            (Origin::File(Input::Bytes { bytes: a, .. }), Origin::File(Input::Bytes { bytes: b, .. })) => {
                Arc::ptr_eq(a, b)
            }
            (Origin::Image(a), Origin::Image(b)) => Arc::ptr_eq(a, b),
            _ => false,
        };
        origin && self.channel == other.channel && self.raw == other.raw && self.layout == other.layout
    }

    /// Its file in a frame, if it is a file on disk.
    ///
    /// # Errors
    /// If the name has a place for the frame's number and that is not whole.
    pub fn path(&self, frame: f32) -> Result<Option<PathBuf>, ImageError> {
        let Origin::File(Input::Path(path)) = &self.origin else { return Ok(None) };
        let name = path.file_name().map_or(Cow::default(), |name| name.to_string_lossy());
        // A file may well be called so.
        if !has_pattern(&name) || path.exists() {
            return Ok(Some(path.clone()));
        }
        if frame.fract() != 0.0 || !frame.is_finite() {
            let message =
                format!("`{}` has no place for frame {frame}, only for whole numbers", path.display());
            return Err(ImageError::new(ErrorKind::Missing, message));
        }
        Ok(Some(path.with_file_name(fill(&name, frame as i64))))
    }

    /// Looks whether it can be read, as far as the header tells. Of a sequence that is frame 0, if there is one.
    ///
    /// # Errors
    /// If the file cannot be read, or does not have what is wanted.
    pub fn check(&self) -> Result<(), ImageError> {
        match self.path(0.0)? {
            Some(path) if !path.exists() => Ok(()),
            path => self.open(path).map(drop),
        }
    }

    /// The texture in a frame: read, or the one that was kept. `left` is how many bytes it may take, and then
    /// how many are left.
    ///
    /// # Errors
    /// If the file cannot be read, does not have what is wanted, or takes more than is left.
    pub fn load(&self, frame: f32, left: &mut u64) -> Result<Arc<Texture>, ImageError> {
        let path = self.path(frame)?;
        // Nothing is left half done in it.
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, texture)) = kept.as_ref().filter(|(of, _)| *of == path) {
            let image = &texture.levels[0];
            let sides = image.texels.len() / (image.width * image.height * image.components);
            self.charge([image.width, image.height * sides], image.components, left)?;
            return Ok(Arc::clone(texture));
        }
        // The last frame's makes room.
        *kept = None;
        let opened = self.open(path.clone())?;
        let [w, h] = opened.resolution();
        let size = match sphere::sides(w, h).filter(|_| self.layout == Layout::Cube) {
            Some((n, _)) => [n, 6 * n],
            None => [w, h],
        };
        self.charge(size, opened.wanted.shape.cells(), left)?;
        let texture = Arc::new(self.texture(&opened)?);
        *kept = Some((path, Arc::clone(&texture)));
        Ok(texture)
    }

    /// Takes the bytes of a texture from those that are left.
    fn charge(&self, size: [usize; 2], components: usize, left: &mut u64) -> Result<(), ImageError> {
        let bytes = bytes(size, components, self.needs);
        if let Some(rest) = left.checked_sub(bytes) {
            *left = rest;
            return Ok(());
        }
        let [w, h] = size;
        let (wanted, room) = (bytes.div_ceil(1 << 20), *left >> 20);
        let message =
            format!("`{}` takes {wanted} MB of memory, and for textures {room} MB are left", self.name);
        let s = if components == 1 { "" } else { "s" };
        let mut error = ImageError::new(ErrorKind::TooLarge, message)
            .hint(format!("It has {w} x {h} texels of {components} float{s} each."));
        if self.needs.sums {
            error =
                error.hint("Two thirds of that are its summed-area table; `filter = \"mip\"` needs none.");
        }
        Err(error.hint("Make the image smaller, or allow more (`--texture-memory`)."))
    }

    fn open(&self, path: Option<PathBuf>) -> Result<Opened<'_>, ImageError> {
        let input = match (&self.origin, path) {
            (Origin::Image(image), _) => {
                let known: Vec<Known<'_>> = image.variables.iter().map(known).collect();
                let wanted = wanted(&self.name, &known, self.channel.as_deref())?;
                return self.checked(Opened { pixels: Pixels::Memory(image), wanted });
            }
            (Origin::File(_), Some(path)) => Input::Path(path),
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
            let message = format!("`{}` is no image of a cube: it has {w} x {h} pixels", self.name);
            return Err(ImageError::new(ErrorKind::Unsupported, message)
                .hint("Square sides stand in a row, 6 x 1 or 1 x 6; in two rows, 3 x 2; or as a cross, 4 x 3 or 3 x 4.")
                .hint("An image by latitude and longitude needs no `layout`."));
        }
        Ok(opened)
    }

    /// Reads the pixels, and arranges them: as the display window has them, the sides of a cube one below the other.
    fn texture(&self, opened: &Opened<'_>) -> Result<Texture, ImageError> {
        let image = match &opened.pixels {
            Pixels::Memory(image) => Cow::Borrowed(&***image),
            Pixels::File(file) => {
                let names: Vec<&str> = opened.wanted.names.iter().map(String::as_str).collect();
                Cow::Owned(file.load(&names)?)
            }
        };
        let all: Vec<&[f32]> = opened
            .wanted
            .names
            .iter()
            .filter_map(|name| image.variable(name))
            .flat_map(|variable| variable.planes.iter().map(|p| &**p))
            .collect();
        let planes: Vec<&[f32]> = opened.wanted.components.iter().map(|&i| all[i]).collect();
        let components = opened.wanted.shape.cells();
        let [w, h] = opened.resolution();
        let [left, top] = image.metadata.origin.map(i64::from);
        // A pixel of the display window; beyond the pixels that the image holds there is nothing.
        let put = |column: usize, row: usize, out: &mut Vec<f32>| {
            let (x, y) = (column as i64 - left, row as i64 - top);
            let held = (0..image.width as i64).contains(&x) && (0..image.height as i64).contains(&y);
            let at = held.then_some((y * image.width as i64 + x) as usize);
            out.extend(planes.iter().map(|plane| at.map_or(0.0, |at| sound(plane[at]))));
            if opened.wanted.opaque {
                out.push(if held { 1.0 } else { 0.0 });
            }
        };
        let mut texels = Vec::new();
        if texels.try_reserve_exact(w * h * components).is_err() {
            let message = format!("`{}` does not fit in memory", self.name);
            return Err(ImageError::new(ErrorKind::TooLarge, message));
        }
        let level = match sphere::sides(w, h).filter(|_| self.layout == Layout::Cube) {
            Some((n, sides)) => {
                for Seat { column, row, turned } in sides {
                    for (y, x) in (0..n).flat_map(|y| (0..n).map(move |x| (y, x))) {
                        let (x, y) = if turned { (n - 1 - x, n - 1 - y) } else { (x, y) };
                        put(column * n + x, row * n + y, &mut texels);
                    }
                }
                Level { width: n, height: n, components, texels }
            }
            None => {
                (0..h).for_each(|y| (0..w).for_each(|x| put(x, y, &mut texels)));
                Level { width: w, height: h, components, texels }
            }
        };
        Ok(Texture::new(opened.wanted.shape.clone(), self.layout, level, self.needs))
    }
}

/// An image with its header read.
struct Opened<'a> {
    pixels: Pixels<'a>,
    wanted: Wanted,
}

enum Pixels<'a> {
    File(Box<File>),
    Memory(&'a Arc<Image<'static>>),
}

impl Opened<'_> {
    fn resolution(&self) -> [usize; 2] {
        match &self.pixels {
            Pixels::File(file) => file.metadata().resolution.unwrap_or(file.size()),
            Pixels::Memory(image) => image.resolution(),
        }
    }
}

/// A number that averages can bear.
fn sound(x: f32) -> f32 {
    const MOST: f32 = 65504.0;
    if x.is_finite() {
        x
    } else if x.is_nan() {
        0.0
    } else {
        MOST.copysign(x)
    }
}

impl fmt::Debug for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "texture {}", self.name)
    }
}

#[cfg(test)]
pub(super) fn from_image(image: Image<'static>, layout: Layout, needs: Needs) -> Texture {
    let mut source = Source::new("test", Origin::Image(Arc::new(image)), None, false, layout);
    source.needs = needs;
    Arc::into_inner(source.load_once()).expect("nobody else has it")
}

#[cfg(test)]
impl Source {
    fn load_once(&self) -> Arc<Texture> {
        let texture = self.load(0.0, &mut u64::MAX.clone()).expect("it can be read");
        *self.kept.lock().expect("not poisoned") = None;
        texture
    }
}
