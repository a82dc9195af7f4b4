//! `pse join`: the tiles of a picture put together.

use super::failure::{Failure, warn};
use super::frames::{self, Frame, Frames};
use super::interrupt;
use super::output;
use super::region::{Region, bands};
use super::tiles::{self, Tiles};
use clap::Args;
use pse::image::{
    ErrorKind, File, Format, Image, Input, Metadata, ReadOptions, Rows, Variable, WriteOptions, Writer, read,
};
use pse::internal::shape::Shape;
use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

const EXAMPLES: &str = "\
Examples:
  pse join marble.*.exr -o marble.exr -o marble.png
  pse join 'tiles/fire.####.{tile}.exr' --tiles 4x4 --frames 1-100 -o fire.####.png

Tiles are .exr files that pse run wrote with --tile or --region. The joined file has the same bytes as one run of the \
whole picture, provided that you give --half, --bits and --raw to pse join and not to pse run.";

/// Which tiles, and where to.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct JoinArgs {
    /// The tiles; with --tiles, {tile} in a name stands for the number of each
    #[arg(required = true, value_name = "FILE")]
    files: Vec<String>,
    /// Number of columns and rows of tiles to expect
    #[arg(long, value_name = "CxR")]
    tiles: Option<Tiles>,
    /// Accept tiles that do not cover the edges of the picture
    #[arg(long, conflicts_with = "tiles")]
    partial: bool,
    /// Join several frames: 1-24, -3-3, 1,5,9 or 1-20x2. In file names, ####, @@@@, %d or %04d stands for the frame
    /// number
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<Frames>,
    /// A file to write; repeat for several. The extension selects the format
    #[arg(short, long, required = true, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// EXR: write 16-bit floats, except for surface, point and depth
    #[arg(long)]
    half: bool,
    /// PNG and TIFF: bits per component; 32 writes floats, TIFF only
    #[arg(long, value_name = "8|16|32", value_parser = super::run::bits)]
    bits: Option<u8>,
    /// Write pictures (PNG, JPEG, …) without sRGB conversion
    #[arg(long)]
    raw: bool,
    /// Create missing output folders
    #[arg(long)]
    mkdir: bool,
    /// Let an output replace a tile
    #[arg(long)]
    force: bool,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
}

/// Joins each frame's tiles.
pub(super) fn join(args: &JoinArgs) -> Result<(), Failure> {
    interrupt::cancel_command();
    output::force(args.force);
    for path in &args.output {
        Format::of(path)?;
        let frames = args.frames.as_ref().map_or(0, |f| f.0.len());
        let has = frames::has_pattern(&path.to_string_lossy());
        if has != (frames > 0) && (has || frames > 1) {
            let shown = path.display();
            return Err(match has {
                true => Failure::usage(format!("{shown} needs a frame number, and none is given"))
                    .hint("Give the frames: --frames 1-24."),
                false => Failure::usage(format!("{frames} frames would all be written to {shown}"))
                    .hint("Put the frame number into the name: -o out.####.png."),
            });
        }
    }
    if args.frames.is_none() {
        let sequence = args.files.iter().find(|name| frames::is_sequence(name));
        sequence.map_or(Ok(()), |name| frames::check_number(name, Frame::default()))?;
    }
    match &args.frames {
        Some(frames) => frames.0.iter().try_for_each(|&frame| args.frame(Some(frame))),
        None => args.frame(None),
    }
}

impl JoinArgs {
    fn frame(&self, frame: Option<i64>) -> Result<(), Failure> {
        let name = |name: &str| frame.map_or_else(|| name.to_string(), |f| frames::fill(name, f));
        let tile = |name: &str| frames::input(name, frame).to_string_lossy().into_owned();
        let joined = Joined::open(&self.names(tile)?)?;
        let mut writers: Vec<(Writer, Option<_>, PathBuf)> = Vec::new();
        let mut distinct = output::Distinct::default();
        let options =
            WriteOptions { half: self.half, bits: self.bits, raw: self.raw, ..WriteOptions::default() };
        let Region { x0, y0, x1, y1 } = joined.whole;
        let (width, height) = ((x1 - x0) as usize, (y1 - y0) as usize);
        let [w, h] = joined.metadata.resolution.unwrap_or([width, height]);
        let whole = [w, h] == [width, height];
        if !whole && !self.partial && self.tiles.is_none() {
            let message = format!("the tiles hold {} of a picture of {w}x{h}", joined.whole);
            return Err(Failure::plain(message).hint(
                "A tile at the edge may be missing. Give the number of tiles, as in --tiles 4x4; or add --partial if no tile is missing.",
            ));
        }
        for path in &self.output {
            let path = PathBuf::from(name(&path.to_string_lossy()));
            if self.mkdir {
                output::make_folder(&path)?;
            }
            let format = output::check(&path).map_err(|failure| output::or_mkdir(failure, &path))?;
            distinct.add(&path)?;
            let shown = if format == Format::Exr { None } else { Some(joined.shown(&path)?) };
            writers.push((Writer::create(&path, height, &options)?, shown, path));
        }
        let mut reader = Reader::new(&joined);
        for rows in bands(width, 0..height) {
            if interrupt::CANCEL.load(Ordering::Relaxed) {
                return Err(Failure::Interrupted);
            }
            let band = reader.read(rows)?;
            for (writer, shown, _) in &mut writers {
                match shown {
                    Some(shown) => writer.rows(&picture(&band, shown))?,
                    None => writer.rows(&band)?,
                }
            }
        }
        for (writer, _, path) in writers {
            writer.finish()?;
            if !self.quiet {
                let n = joined.tiles.len();
                warn(&format!("wrote {} ({width}x{height}) from {n} tiles", output::shown(&path)));
            }
        }
        if !whole && !self.quiet {
            warn(&format!("the tiles hold {} of a picture of {w}x{h}", joined.whole));
        }
        Ok(())
    }

    /// The names of the files.
    fn names(&self, fill: impl Fn(&str) -> String) -> Result<Vec<String>, Failure> {
        let mut names = Vec::new();
        for name in &self.files {
            let name = fill(name);
            match self.tiles {
                Some(tiles) if tiles::has_place(&name) => {
                    names.extend((1..=tiles.count()).map(|n| tiles::fill(&name, n)));
                }
                None if tiles::has_place(&name) => {
                    return Err(Failure::usage(format!(
                        "{name} matches several tiles, and their number is not given"
                    ))
                    .hint("Give their number: --tiles 4x4."));
                }
                _ => names.push(name),
            }
        }
        match self.tiles.filter(|tiles| tiles.count() != names.len()) {
            Some(tiles) => Err(Failure::usage(format!(
                "{tiles} are {} tiles, and {} are given",
                tiles.count(),
                names.len()
            ))),
            None => Ok(names),
        }
    }
}

/// A tile with its header read.
struct Tile {
    file: File,
    region: Region,
}

/// Tiles that make up a rectangle.
struct Joined {
    tiles: Vec<Tile>,
    whole: Region,
    /// As all tiles have it, but for the place.
    metadata: Metadata,
}

impl Joined {
    /// Reads all headers, and sees whether they go together.
    fn open(names: &[String]) -> Result<Joined, Failure> {
        let mut tiles: Vec<Tile> = Vec::new();
        for name in names {
            let file = read(Input::Path(name.into()), &ReadOptions::default()).map_err(|error| {
                let missing = matches!(error.kind, ErrorKind::Io(std::io::ErrorKind::NotFound));
                let failure = Failure::from(error);
                if missing { failure.hint("Render the missing tile first.") } else { failure }
            })?;
            if !file.seeks() {
                return Err(Failure::plain(format!("`{name}` is not a tile: it is not an EXR file"))
                    .hint("Write tiles as .exr files: other formats do not hold the exact numbers and their position."));
            }
            let [width, height] = file.size();
            let region =
                Region::held(&Image { width, height, metadata: file.metadata().clone(), ..Image::default() });
            tiles.push(Tile { region, file });
        }
        let Some(first) = tiles.first() else { return Err(Failure::usage("no tiles are given")) };
        let mut whole = first.region;
        for tile in &tiles {
            same_kind(first, tile)?;
            let Region { x0, y0, x1, y1 } = tile.region;
            whole = Region {
                x0: whole.x0.min(x0),
                y0: whole.y0.min(y0),
                x1: whole.x1.max(x1),
                y1: whole.y1.max(y1),
            };
        }
        cover(&tiles, whole)?;
        let mut metadata = first.file.metadata().clone();
        metadata.origin = [whole.x0 as i32, whole.y0 as i32];
        let size = [(whole.x1 - whole.x0) as usize, (whole.y1 - whole.y0) as usize];
        metadata.resolution = Some(metadata.resolution.unwrap_or(size));
        Ok(Joined { tiles, whole, metadata })
    }

    /// The channels that a picture shows as its colour, and as alpha: those of `color`, or the only variable's.
    fn shown(&self, picture: &Path) -> Result<(Vec<usize>, Option<usize>), Failure> {
        let names: Vec<&str> = self.tiles[0].file.channels().iter().map(|c| c.name.as_str()).collect();
        let place = |name: &str| names.iter().position(|n| *n == name);
        let places = |list: &[String]| list.iter().map(|n| place(n)).collect::<Option<Vec<usize>>>();
        if let Some(color) = places(&["R", "G", "B"].map(String::from)) {
            return Ok((color, place("A")));
        }
        if names.len() == 1 {
            return Ok((vec![0], None));
        }
        let owner = names[0].rsplit_once('.').map_or("", |(owner, _)| owner);
        match places(&["x", "y", "z"].map(|letter| format!("{owner}.{letter}"))) {
            Some(vector) if names.len() == 3 => Ok((vector, None)),
            Some(vector) if names.len() == 4 && place(&format!("{owner}.w")).is_some() => {
                Ok((vector, place(&format!("{owner}.w"))))
            }
            _ => {
                Err(Failure::plain(format!("cannot write `{}`: the tiles hold no color", picture.display()))
                    .hint(format!("They hold {}; an .exr file holds any variable.", names.join(", "))))
            }
        }
    }
}

/// A band as a picture shows it.
fn picture<'a>(band: &'a Image<'a>, (color, alpha): &(Vec<usize>, Option<usize>)) -> Image<'a> {
    let plane = |&i: &usize| Cow::Borrowed(&*band.variables[i].planes[0]);
    let shape = if color.len() == 1 { Shape::Scalar } else { Shape::Vector(color.len() as u32) };
    let variable = |name: &str, shape, channels: &[usize]| Variable {
        name: name.into(),
        shape,
        planes: channels.iter().map(plane).collect(),
    };
    let mut variables = vec![variable("color", shape, color)];
    variables.extend(alpha.map(|i| variable("alpha", Shape::Scalar, &[i])));
    Image { width: band.width, height: band.height, variables, metadata: band.metadata.clone() }
}

/// Do two tiles belong to one picture?
fn same_kind(first: &Tile, tile: &Tile) -> Result<(), Failure> {
    let (a, b) = (first.file.name(), tile.file.name());
    let refuse = |what: &str| {
        Err(Failure::plain(format!("`{a}` and `{b}` are tiles of different pictures")).hint(what.to_string()))
    };
    let display = |tile: &Tile| {
        let about = tile.file.metadata();
        (about.resolution.unwrap_or(tile.file.size()), about.display_origin, about.pixel_aspect.to_bits())
    };
    if display(first) != display(tile) {
        return refuse("Their display windows differ.");
    }
    let channels = |tile: &Tile| -> Vec<_> {
        tile.file.channels().iter().map(|c| (c.name.clone(), c.samples)).collect()
    };
    if channels(first) != channels(tile) {
        return refuse("They hold different variables.");
    }
    Ok(())
}

/// Is each pixel of the whole in one tile?
fn cover(tiles: &[Tile], whole: Region) -> Result<(), Failure> {
    let mut pixels = 0;
    for (i, tile) in tiles.iter().enumerate() {
        if let Some((other, both)) =
            tiles[..i].iter().find_map(|other| Some((other, other.region.and(tile.region)?)))
        {
            let (a, b) = (other.file.name(), tile.file.name());
            return Err(Failure::plain(format!("`{a}` and `{b}` both hold the pixels {both}"))
                .hint("Some files may be of another run. Join the tiles of one run."));
        }
        pixels += tile.region.area();
    }
    match pixels == whole.area() {
        true => Ok(()),
        false => {
            Err(Failure::plain(format!("{} of the pixels {whole} are in no tile", whole.area() - pixels))
                .hint("A tile is missing."))
        }
    }
}

/// Reads all tiles at once from the top down.
struct Reader<'a> {
    joined: &'a Joined,
    /// For each tile its rows, while some of them are wanted.
    open: Vec<Option<Rows<'a>>>,
}

impl<'a> Reader<'a> {
    fn new(joined: &'a Joined) -> Reader<'a> {
        Reader { joined, open: joined.tiles.iter().map(|_| None).collect() }
    }

    /// The next rows of the whole.
    fn read(&mut self, rows: Range<usize>) -> Result<Image<'static>, Failure> {
        let Region { x0, y0, x1, .. } = self.joined.whole;
        let width = (x1 - x0) as usize;
        let mut metadata = self.joined.metadata.clone();
        metadata.origin[1] += rows.start as i32;
        let mut band = Image { width, height: rows.len(), variables: Vec::new(), metadata };
        for (tile, open) in self.joined.tiles.iter().zip(&mut self.open) {
            let top = (tile.region.y0 - y0) as usize;
            let part = rows.start.max(top)..rows.end.min(top + tile.file.size()[1]);
            if part.is_empty() {
                // It is done with, or its turn comes.
                *open = None;
                continue;
            }
            let reader = match open {
                Some(reader) => reader,
                None => open.insert(tile.file.channel_rows()?),
            };
            let image = reader.read(part.start - top..part.end - top)?;
            if band.variables.is_empty() {
                let blank = |v: &Variable<'_>| Variable {
                    name: v.name.clone(),
                    shape: Shape::Scalar,
                    planes: vec![vec![0.0; width * rows.len()].into()],
                };
                band.variables = image.variables.iter().map(blank).collect();
            }
            let left = (tile.region.x0 - x0) as usize;
            let from = image.variables.iter().flat_map(|v| &v.planes);
            for (to, from) in band.variables.iter_mut().flat_map(|v| &mut v.planes).zip(from) {
                for (y, line) in (part.start - rows.start..).zip(from.chunks_exact(image.width)) {
                    to.to_mut()[y * width + left..][..line.len()].copy_from_slice(line);
                }
            }
        }
        Ok(band)
    }
}
