//! The images that a program runs on: opened, and those variables read that it uses.

use super::failure::Failure;
use super::frames;
use super::region::Region;
use crate::image::{ErrorKind, File, Image, ImageError, Input, Mapping, ReadOptions, read};
use std::path::PathBuf;
use std::str::FromStr;

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

/// An image whose header has been read.
pub(super) struct Opened {
    /// Its name in the program.
    pub name: Option<String>,
    /// The file.
    pub file: File,
}

/// The images of a run.
pub(super) struct Inputs {
    /// In the order of the arguments.
    pub list: Vec<Opened>,
}

impl Inputs {
    /// Opens the files, with the frame's number in their names if there is one.
    pub fn open(
        args: &[InputArg],
        maps: &[MapArg],
        raw: bool,
        frame: Option<i64>,
    ) -> Result<Inputs, Failure> {
        for map in maps {
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
            let path: PathBuf = frame.map_or_else(|| arg.path.clone(), |f| frames::fill(&arg.path, f)).into();
            let own = |m: &&MapArg| m.image == arg.name;
            let maps = maps.iter().filter(own).map(|m| m.mapping.clone()).collect();
            let file = read(Input::from_argument(&path)?, &ReadOptions { maps, raw })?;
            list.push(Opened { name: arg.name.clone(), file });
        }
        Ok(Inputs { list })
    }

    /// Reads what `wanted` names and the files have, into one image; `base`, a scene, comes first.
    pub fn load(&self, base: Option<Image<'static>>, wanted: &[String]) -> Result<Image<'static>, Failure> {
        let mut taken: Vec<&str> = Vec::new();
        let (mut merged, mut first) = (base, "the scene".to_string());
        for (i, Opened { name, file }) in self.list.iter().enumerate() {
            let mut names = Vec::new();
            for full in wanted {
                let own = match name {
                    Some(name) => full.strip_prefix(name.as_str()).and_then(|rest| rest.strip_prefix('.')),
                    // Of two unnamed images that have a variable, the first gives it.
                    None => Some(full.as_str()).filter(|n| !n.contains('.') && !taken.contains(n)),
                };
                let Some(own) = own else { continue };
                match file.find(own) {
                    Ok(_) => names.push((own, full.as_str())),
                    Err(e) if e.kind == ErrorKind::Missing => {}
                    Err(e) => return Err(e.into()),
                }
            }
            let own: Vec<&str> = names.iter().map(|(own, _)| *own).collect();
            let mut image = file.load(&own)?;
            for (variable, (_, full)) in image.variables.iter_mut().zip(&names) {
                variable.name = full.to_string();
            }
            if name.is_none() {
                taken.extend(own);
            }
            let Some(all) = &mut merged else {
                merged = Some(image);
                first = self.list[i].file.name();
                continue;
            };
            let (one, other) = (Region::held(all), Region::held(&image));
            if one != other || all.resolution() != image.resolution() {
                let tell = |name: &str, image: &Image<'_>| {
                    let [w, h] = image.resolution();
                    let window = match [image.width, image.height] == [w, h] {
                        true => String::new(),
                        false => format!(" (holding {})", Region::held(image)),
                    };
                    format!("{name} is {w}x{h}{window}")
                };
                let message = "the inputs are of different sizes";
                let facts = format!("{}, {}.", tell(&first, all), tell(&file.name(), &image));
                return Err(Failure::plain(message)
                    .hint(facts)
                    .hint("A program sees one pixel of each at a time, so their windows must agree."));
            }
            all.variables.extend(image.variables);
        }
        Ok(merged.unwrap_or_default())
    }

    /// Does some input have the variable? An error if several of its channels could be it.
    pub fn find(&self, full: &str) -> Option<Result<(), ImageError>> {
        self.list.iter().find_map(|opened| {
            let own = match &opened.name {
                Some(name) => full.strip_prefix(name.as_str())?.strip_prefix('.')?,
                None => Some(full).filter(|n| !n.contains('.'))?,
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
            Some((image, own)) => (Some(image), own),
            None => (None, full),
        };
        let Some(opened) = self.list.iter().find(|o| o.name.as_deref() == image) else {
            return vec![match image {
                Some(image) => {
                    format!("There is no input called {image}: name one with -i {image}=FILE.")
                }
                None => "All inputs have names: an -i FILE without one gives plain variables.".into(),
            }];
        };
        let hints = opened.file.missing(own).hints;
        let argument = image.map_or("--map ".to_string(), |i| format!("--map {i}."));
        hints.into_iter().map(|h| h.replace("--map ", &argument)).collect()
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
