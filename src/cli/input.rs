//! The images that a program runs on: opened, and those variables read that it uses.

use super::camera::FoundCamera;
use super::failure::Failure;
use super::frames::{self, FrameSource};
use super::region::Region;
use super::scene::ViewArgs;
use clap::Args;
use pse::image::{ErrorKind, File, Image, ImageError, Input, Mapping, ReadOptions, Rows, read};
use pse::internal::eval::NO_IMAGE;
use pse::internal::program::Program;
use pse::internal::resolve::names::{self, component};
use pse::internal::resolve::unknown::component_meant;
use pse::internal::vocabulary;
use pse::scene::Renderer;
use pse::solid::Isosurface;
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;
use std::sync::OnceLock;

/// `FILE`, or `NAME=FILE` for an image whose variables are called `NAME.…`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct InputArg {
    /// The image's name in the program.
    pub name: Option<String>,
    /// The file, which may have a place for the frame's number.
    pub path: String,
}

impl FromStr for InputArg {
    type Err = String;

    fn from_str(text: &str) -> Result<InputArg, String> {
        let (name, path) = match text.split_once('=') {
            Some((name, path)) if is_name(name) => (Some(name.to_string()), path),
            _ => (None, text),
        };
        match path.is_empty() {
            true => Err("no file is named".into()),
            false => Ok(InputArg { name, path: path.into() }),
        }
    }
}

fn is_name(text: &str) -> bool {
    text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && text.starts_with(|c: char| !c.is_ascii_digit())
}

/// `NAME=CHANNELS`, or `IMAGE.NAME=CHANNELS` for a named image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MapArg {
    /// The image's name in the program.
    pub image: Option<String>,
    /// What it says of that image.
    pub mapping: Mapping,
}

impl FromStr for MapArg {
    type Err = String;

    fn from_str(text: &str) -> Result<MapArg, String> {
        let named = text.split_once('=').and_then(|(left, _)| left.split_once('.')).map(|(image, _)| image);
        let (image, rest) = match named.filter(|i| is_name(i)) {
            Some(image) => (Some(image.to_string()), &text[image.len() + 1..]),
            None => (None, text),
        };
        match rest.parse::<Mapping>() {
            Ok(mapping) => Ok(MapArg { image, mapping }),
            Err(ImageError { message, hints, .. }) => Err(format!("{message}. {}", hints.join(" "))),
        }
    }
}

/// The images that a program runs on.
#[derive(Clone, Debug, Args)]
pub(super) struct ImageArgs {
    /// An input image; - reads standard input. With NAME=, its variables are NAME.point, NAME.color, …
    #[arg(short, long, value_name = "FILE|NAME=FILE", help_heading = "Input")]
    pub input: Vec<InputArg>,
    /// Use a built-in scene as input (default without -i: donut); `pse scene --list` lists them
    #[arg(long, value_name = "NAME", help_heading = "Input")]
    pub scene: Option<String>,
    /// Read a variable from the channels named here: point=ViewLayer.Position
    #[arg(long, value_name = "NAME=CHANNELS", help_heading = "Input")]
    pub map: Vec<MapArg>,
    /// Distance between neighbouring pixels in the space of point (default: measured from point)
    #[arg(long, value_name = "SIZE", help_heading = "Input")]
    pub pixelsize: Option<f32>,
    /// Define a coordinate space by its matrix from world space: object='inverse(translation([0 0 1]))'
    #[arg(long, value_name = "NAME=MATRIX", help_heading = "Input")]
    pub space: Vec<String>,
    #[command(flatten)]
    pub view: ViewArgs,
}

impl ImageArgs {
    /// The files that are named, each of which may have a place for the frame's number.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.input.iter().map(|i| i.path.as_str()).chain(self.view.mesh.as_deref())
    }

    /// The view, if it is an image that is looked at, not a scene or mesh.
    pub fn view_of_image(&self) -> Option<&ViewArgs> {
        let scene = self.scene.is_some() || self.view.mesh.is_some() || self.input.is_empty();
        (!scene).then_some(&self.view)
    }

    /// The same files, to find the frame that they are of.
    pub fn frame_sources(&self) -> Vec<FrameSource<'_>> {
        let images = self.input.iter().map(|i| FrameSource { path: &i.path, named: i.name.is_some() });
        images.chain(self.view.mesh.as_deref().map(|path| FrameSource { path, named: false })).collect()
    }

    /// Is nothing named to run on?
    pub fn is_empty(&self) -> bool {
        self.scene.is_none() && self.paths().next().is_none()
    }
}

/// The failure to read an image, with a hint if its name is that of something else.
fn of_another_kind(failure: Failure, path: &Path) -> Failure {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let shown = path.display();
    match extension.as_str() {
        "obj" | "ply" | "gltf" | "glb" => failure.hint(format!("It is a mesh: give it with --mesh {shown}.")),
        "pse" => failure.hint(format!("It is a program: give it without -i, as in pse run {shown}.")),
        _ => failure,
    }
}

fn is_component(member: &str) -> bool {
    component(member).is_some()
}

/// An image whose header has been read.
pub(super) struct Opened {
    /// Its name in the program.
    pub name: Option<String>,
    /// The file.
    pub file: File,
    /// Is it one of a sequence?
    of_sequence: bool,
}

impl Opened {
    /// A name of a variable of the file, as programs call it.
    fn full(&self, own: &str) -> String {
        self.name.as_ref().map_or_else(|| own.to_string(), |name| format!("{name}.{own}"))
    }
}

/// What finds the visible surface where there is no file.
#[derive(Clone, Copy)]
pub(super) enum Finder<'i> {
    /// A scene.
    Scene(&'i Renderer),
    /// A solid.
    Solid(&'i Isosurface<'static>),
}

impl<'i> From<&'i Renderer> for Finder<'i> {
    fn from(scene: &'i Renderer) -> Finder<'i> {
        Finder::Scene(scene)
    }
}

impl Finder<'_> {
    /// Columns and rows of the whole picture.
    pub fn size(self) -> [usize; 2] {
        match self {
            Finder::Scene(scene) => scene.size(),
            Finder::Solid(solid) => solid.size(),
        }
    }

    /// Some rows.
    pub fn rows(self, rows: Range<usize>) -> Result<Image<'static>, Failure> {
        match self {
            Finder::Scene(scene) => Ok(scene.rows(rows)?),
            Finder::Solid(solid) => Ok(solid.rows(rows)?),
        }
    }

    fn names(self) -> Vec<&'static str> {
        match self {
            Finder::Scene(scene) => scene.names().collect(),
            Finder::Solid(solid) => solid.names().collect(),
        }
    }
}

/// The images of a run, read from the top down as if they were one.
pub(super) struct Reader<'i> {
    scene: Option<Finder<'i>>,
    /// Each file, with the names that its variables have in the program.
    files: Vec<(Rows<'i>, Vec<String>)>,
    /// Size and windows of the whole, without any variable.
    about: Image<'static>,
}

impl Reader<'_> {
    /// Size and windows of the whole, without any variable.
    pub fn about(&self) -> &Image<'static> {
        &self.about
    }

    /// The names of all variables that it reads.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let scene = self.scene.into_iter().flat_map(|s| s.names()).map(|name| -> &str { name });
        scene.chain(self.files.iter().flat_map(|(_, names)| names).map(String::as_str))
    }

    /// The next rows, which may begin again with the last ones that were read.
    pub fn read(&mut self, rows: Range<usize>) -> Result<Image<'static>, Failure> {
        let mut whole = self.scene.map(|scene| scene.rows(rows.clone())).transpose()?;
        for (file, names) in &mut self.files {
            let mut image = file.read(rows.clone())?;
            for (variable, name) in image.variables.iter_mut().zip(names) {
                variable.name.clone_from(name);
            }
            match &mut whole {
                Some(whole) => whole.variables.extend(image.variables),
                None => whole = Some(image),
            }
        }
        Ok(whole.unwrap_or_default())
    }
}

/// A program sees one pixel of each image at a time.
fn same_window(first: &str, one: &Image<'_>, name: &str, other: &Image<'_>) -> Result<(), Failure> {
    if Region::held(one) == Region::held(other) && one.resolution() == other.resolution() {
        return Ok(());
    }
    let tell = |name: &str, image: &Image<'_>| {
        let [w, h] = image.resolution();
        let window = match [image.width, image.height] == [w, h] {
            true => String::new(),
            false => format!(" (holding {})", Region::held(image)),
        };
        format!("{name} is {w}x{h}{window}")
    };
    Err(Failure::plain("the inputs are of different sizes")
        .hint(format!("{}, {}.", tell(first, one), tell(name, other)))
        .hint("A program reads the same pixel of each, so their windows must agree."))
}

/// The variables to read from images.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Wanted {
    /// Those that the program may see.
    pub names: Vec<String>,
    /// Those that only help, as `surface` tells which neighbours count: they are read where it is clear which channels
    /// they are.
    pub aids: Vec<String>,
}

impl Wanted {
    /// All names, and whether the program needs them.
    pub fn all(&self) -> impl Iterator<Item = (&String, bool)> {
        self.names.iter().map(|name| (name, true)).chain(self.aids.iter().map(|name| (name, false)))
    }
}

impl From<Vec<String>> for Wanted {
    fn from(names: Vec<String>) -> Wanted {
        Wanted { names, aids: Vec::new() }
    }
}

/// The images of a run.
pub(super) struct Inputs {
    /// In the order of the arguments.
    pub list: Vec<Opened>,
    /// The camera that their points tell, from the first time on that it is asked for.
    pub resection: OnceLock<FoundCamera>,
}

impl Inputs {
    /// Opens the files, with the frame's number in their names if there is one.
    pub fn open(
        args: &[InputArg],
        maps: &[MapArg],
        raw: bool,
        frame: Option<i64>,
    ) -> Result<Inputs, Failure> {
        Inputs::open_by(args, maps, raw, frame, Input::from_argument)
    }

    /// The same, where `source` says how to read the file of a path.
    pub fn open_by(
        args: &[InputArg],
        maps: &[MapArg],
        raw: bool,
        frame: Option<i64>,
        source: impl Fn(&Path) -> Result<Input, ImageError>,
    ) -> Result<Inputs, Failure> {
        // What stands before a variable may be a view of the images without a name.
        let is_view = |map: &MapArg| {
            map.image.is_some()
                && !args.iter().any(|a| a.name == map.image)
                && args.iter().any(|a| a.name.is_none())
        };
        for map in maps.iter().filter(|map| !is_view(map)) {
            if !args.iter().any(|a| a.name == map.image) {
                let image = map.image.as_ref().map_or("no unnamed input".into(), |i| format!("no input {i}"));
                let name = &map.mapping.name;
                return Err(Failure::usage(format!("--map sets {name}, but there is {image}"))
                    .hint("Give the image with -i FILE, or -i NAME=FILE."));
            }
        }
        let mut list: Vec<Opened> = Vec::new();
        for arg in args {
            if arg.name.is_some() && list.iter().any(|o| o.name == arg.name) {
                let name = arg.name.as_deref().unwrap_or_default();
                return Err(Failure::usage(format!("two inputs are called {name}")));
            }
            let path = frames::input(&arg.path, frame);
            let own = |map: &MapArg| match &map.image {
                Some(view) if is_view(map) && arg.name.is_none() => {
                    let Mapping { name, channels } = map.mapping.clone();
                    Some(Mapping { name: format!("{view}.{name}"), channels })
                }
                image if *image == arg.name => Some(map.mapping.clone()),
                _ => None,
            };
            let maps = maps.iter().filter_map(own).collect();
            let file = read(source(&path)?, &ReadOptions { maps, raw })
                .map_err(|error| of_another_kind(error.into(), &path))?;
            let of_sequence = frames::has_pattern(&arg.path);
            list.push(Opened { name: arg.name.clone(), file, of_sequence });
        }
        Ok(Inputs { list, resection: OnceLock::new() })
    }

    /// No images.
    pub fn none() -> Inputs {
        Inputs { list: Vec::new(), resection: OnceLock::new() }
    }

    /// The names of all variables that can be read, as programs call them.
    pub fn variables(&self) -> Vec<String> {
        let of = |opened: &Opened| {
            let plain = opened.file.variables().iter().filter(|b| !b.alias && b.candidates.len() == 1);
            let names = plain.map(|b| opened.full(&b.name));
            names.filter(|name| names::is_readable(name)).collect::<Vec<_>>()
        };
        self.list.iter().flat_map(of).collect()
    }

    /// Prepares to read what `wanted` names and the files have; a scene comes first. `alpha`: and the alpha of the files,
    /// if there is one.
    pub fn reader<'i>(
        &'i self,
        scene: Option<impl Into<Finder<'i>>>,
        wanted: &Wanted,
        alpha: bool,
    ) -> Result<Reader<'i>, Failure> {
        let scene: Option<Finder<'i>> = scene.map(Into::into);
        let mut taken: Vec<&str> = Vec::new();
        let mut reader = Reader { scene, files: Vec::new(), about: Image::default() };
        let mut first: Option<String> = None;
        if let Some(scene) = scene {
            [reader.about.width, reader.about.height] = scene.size();
            let what = if matches!(scene, Finder::Solid(_)) { "the solid" } else { "the scene or mesh" };
            first = Some(what.to_string());
        }
        for Opened { name, file, .. } in &self.list {
            let mut names = Vec::new();
            for (full, needed) in wanted.all() {
                let own = match name {
                    Some(name) => full.strip_prefix(name.as_str()).and_then(|rest| rest.strip_prefix('.')),
                    // Of two unnamed images that have a variable, the first gives it. One with a point in its name is of
                    // another view, unless an image is called so.
                    None => Some(full.as_str()).filter(|n| !self.is_of_named(n) && !taken.contains(n)),
                };
                let Some(own) = own.filter(|_| !names::RESERVED.contains(&full.as_str())) else { continue };
                match file.find(own) {
                    Ok(_) => names.push((own, full.as_str())),
                    Err(e) if e.kind == ErrorKind::Missing => {}
                    // Nobody is blamed for what the program does not read.
                    Err(e) if e.kind == ErrorKind::Ambiguous && !needed => {}
                    Err(e) => return Err(e.into()),
                }
            }
            // What only goes with the colour is not worth an error.
            let alpha = alpha && name.is_none() && scene.is_none() && !taken.contains(&"alpha");
            if alpha && !wanted.all().any(|(n, _)| n == "alpha") && file.find("alpha").is_ok() {
                names.push(("alpha", "alpha"));
            }
            let own: Vec<&str> = names.iter().map(|(own, _)| *own).collect();
            reader.files.push((file.rows(&own)?, names.iter().map(|(_, full)| full.to_string()).collect()));
            if name.is_none() {
                taken.extend(own);
            }
            let [width, height] = file.size();
            let about = Image { width, height, metadata: file.metadata().clone(), ..Image::default() };
            match &first {
                Some(first) => same_window(first, &reader.about, &file.name(), &about)?,
                None => (first, reader.about) = (Some(file.name()), about),
            }
        }
        Ok(reader)
    }

    /// The name of the file that gives the variable, as messages call it.
    pub fn name_of(&self, full: &str) -> Option<String> {
        let own = |opened: &&Opened| opened.name.is_none() && opened.file.find(full).is_ok();
        self.list.iter().find(own).map(|opened| opened.file.name())
    }

    /// Has an image without a name, and no other, a view of that name?
    fn has_view(&self, view: &str) -> bool {
        !self.list.iter().any(|o| o.name.as_deref() == Some(view))
            && self.list.iter().any(|o| o.name.is_none() && o.file.has_view(view))
    }

    /// Is it a variable of an image with a name?
    fn is_of_named(&self, full: &str) -> bool {
        let image = full.split_once('.').map(|(image, _)| image);
        image.is_some() && self.list.iter().any(|opened| opened.name.as_deref() == image)
    }

    /// Does some input have the variable? An error if several of its channels could be it.
    pub fn find(&self, full: &str) -> Option<Result<(), ImageError>> {
        self.list.iter().find_map(|opened| {
            let own = match &opened.name {
                Some(name) => full.strip_prefix(name.as_str())?.strip_prefix('.')?,
                None => Some(full).filter(|n| !self.is_of_named(n) && !names::RESERVED.contains(n))?,
            };
            match opened.file.find(own) {
                Ok(_) => Some(Ok(())),
                Err(e) if e.kind == ErrorKind::Missing => None,
                Err(e) => Some(Err(e)),
            }
        })
    }

    /// What to tell a program that reads a variable which no input has.
    pub fn missing(&self, full: &str) -> Vec<String> {
        let (image, own) = match full.split_once('.') {
            Some((view, _)) if self.has_view(view) => (None, full),
            Some((image, own)) => (Some(image), own),
            None => (None, full),
        };
        let of_view =
            |o: &Opened| own == full && full.split_once('.').is_some_and(|(v, _)| o.file.has_view(v));
        let named = |o: &&Opened| o.name.as_deref() == image;
        // Of several images without a name the one that has the view knows more of it.
        let found = self.list.iter().find(|o| named(o) && of_view(o));
        let Some(opened) = found.or_else(|| self.list.iter().find(named)) else {
            return match image {
                Some(image) => {
                    let of_layer = self.layer(image, own);
                    let known = || vocabulary::channel(image, own).map(|instead| vec![instead.to_string()]);
                    let none = || vec![format!("{NO_IMAGE} {image}: name one with -i {image}=FILE.")];
                    of_layer.or_else(known).unwrap_or_else(none)
                }
                None => {
                    vec!["All inputs have names. An -i FILE without a name gives plain variables.".into()]
                }
            };
        };
        // Behind the variable there may be a component.
        let own = match own.rsplit_once('.') {
            Some((variable, member)) if is_component(member) => variable,
            _ => own,
        };
        let hints = opened.file.missing(own).hints;
        let argument = image.map_or("--map ".to_string(), |i| format!("--map {i}."));
        // Of a sequence it matters which file it is.
        let owner = match opened.of_sequence {
            true => format!("`{}` has ", opened.file.name()),
            false => "It has ".into(),
        };
        let named = |hint: String| match hint.strip_prefix("It has ") {
            Some(rest) => format!("{owner}{rest}"),
            None => hint,
        };
        hints.into_iter().map(|h| named(h.replace("--map ", &argument))).collect()
    }
}

impl Inputs {
    /// What a user should know of what a program reads: the mappings, and names that mean two things.
    pub fn notes(&self, program: &Program) -> Vec<String> {
        let mut notes: Vec<String> =
            self.list.iter().flat_map(|opened| opened.file.notes()).cloned().collect();
        let globals = &program.resolved().globals;
        let reads = |name: &str| globals.iter().any(|g| !g.library && g.name == name && g.read.is_some());
        for Opened { file, .. } in self.list.iter().filter(|opened| opened.name.is_none()) {
            let has = |name: &str| file.variables().iter().any(|binding| binding.name == name);
            let shown = file.name();
            for name in names::RESERVED.iter().filter(|name| reads(name) && has(name)) {
                notes.push(format!(
                    "`{name}` is the value of the system, not the channel of {shown}. Rename the channel with --map \
                     NAME={name}"
                ));
            }
            for constant in names::CONSTANTS.iter().filter(|c| reads(c.name) && has(c.name)) {
                let name = constant.name;
                notes.push(format!("`{name}` is the variable of {shown}, not {}", constant.brief));
            }
        }
        notes
    }

    /// What to tell a program that names a layer of an input before a variable: layers are no part of names.
    fn layer(&self, layer: &str, own: &str) -> Option<Vec<String>> {
        let (variable, member) = match own.rsplit_once('.') {
            Some((variable, member)) => {
                (variable, component_meant(member).or(Some(member)).filter(|m| is_component(m)))
            }
            None => (own, None),
        };
        let unnamed = || self.list.iter().filter(|opened| opened.name.is_none());
        let of_layer = |group: &str| {
            let mut fields = group.split('.');
            fields.any(|field| field.eq_ignore_ascii_case(layer)) && fields.next().is_some()
        };
        let bindings = || unnamed().flat_map(|opened| opened.file.variables());
        for binding in bindings().filter(|b| b.name == variable || b.name == own) {
            let Some(candidate) = binding.candidates.iter().find(|c| of_layer(&c.group)) else { continue };
            let short = match member.filter(|_| binding.name == variable && !candidate.shape.is_scalar()) {
                Some(member) => format!("{variable}.{member}"),
                None => binding.name.clone(),
            };
            return Some(vec![match binding.candidates.len() {
                1 if own != variable && short == variable => {
                    format!("Write it without the layer and the component: `{short}`.")
                }
                1 => format!("Write it without the layer: `{short}`."),
                _ => format!(
                    "Write `{short}`, and choose the layer: --map {}={}.",
                    binding.name, candidate.group
                ),
            }]);
        }
        // The layer is there, and has no such variable.
        let found = |opened: &&Opened| {
            let groups = opened.file.variables().iter().flat_map(|b| &b.candidates).map(|c| c.group.as_str());
            let mut layers = groups.filter_map(|group| group.rsplit_once('.').map(|(layers, _)| layers));
            layers.any(|layers| layers.split('.').any(|field| field.eq_ignore_ascii_case(layer)))
        };
        let file = &unnamed().find(found)?.file;
        let first = format!("`{layer}` is a layer of {}. Names do not contain layers.", file.name());
        Some(std::iter::once(first).chain(file.missing(variable).hints).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_and_maps_may_name_an_image() {
        let input = |t: &str| t.parse::<InputArg>().unwrap();
        assert_eq!(input("bg=a.exr").name.as_deref(), Some("bg"));
        assert_eq!(input("./bg=a.exr").name, None);
        assert_eq!(input("a.exr").path, "a.exr");
        assert!("bg=".parse::<InputArg>().is_err());
        let map: MapArg = "bg.color=A.B".parse().unwrap();
        assert_eq!((map.image.as_deref(), map.mapping.name.as_str()), (Some("bg"), "color"));
        let map: MapArg = "point=ViewLayer.Position".parse().unwrap();
        assert_eq!((map.image, map.mapping.name.as_str()), (None, "point"));
        assert!("point".parse::<MapArg>().unwrap_err().contains("ViewLayer.Position"));
    }
}
