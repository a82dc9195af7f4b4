//! What `pse info FILE` tells: sizes and windows, parts, attributes, each channel's range and variable,
//! and notes on what may surprise.

use super::RasterScan;
use super::error::ImageError;
use super::file::{Channel, File, Samples, Source};
use super::names::last_field;
use super::read_exr::ExrPart;
use super::scan_exr::Scan;
use crate::visible::visible_name;
use exr::meta::BlockDescription;
use std::fmt;

/// Everything about a file; its text form is a readable table.
#[derive(Clone, Debug, PartialEq)]
pub struct Info {
    /// The file, as messages call it.
    pub name: String,
    /// The format's name.
    pub format: String,
    /// Columns and rows of the stored pixels.
    pub size: [usize; 2],
    /// The first held pixel, from the top left of the display window.
    pub origin: [i32; 2],
    /// Columns and rows of the display window.
    pub resolution: [usize; 2],
    /// The width of a pixel over its height.
    pub pixel_aspect: f32,
    /// The parts, one in most files.
    pub parts: Vec<PartInfo>,
    /// Header attributes: name and value.
    pub attributes: Vec<(String, String)>,
    /// The channels.
    pub channels: Vec<ChannelInfo>,
    /// Likely problems; each is a sentence.
    pub notes: Vec<String>,
}

/// One part of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct PartInfo {
    /// Its name; empty if it has none.
    pub name: String,
    /// The compression's name; empty for formats with only one.
    pub compression: String,
    /// "scan lines", or "tiles of 64 x 64".
    pub layout: String,
    /// Columns and rows of its own data window.
    pub size: [usize; 2],
    /// Its data window's top left, in the file's coordinates.
    pub origin: [i32; 2],
    /// Deep data, which is not read.
    pub deep: bool,
    /// The reason if it cannot be read: a clause that follows "… is not read: ".
    pub unread: Option<String>,
}

/// One channel, with the range of its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelInfo {
    /// The full name.
    pub name: String,
    /// The storage type.
    pub samples: Samples,
    /// The variables that contain the channel: `point.y`, `depth`; a second name is in brackets, an ambiguous one has
    /// a question mark.
    pub variables: Vec<String>,
    /// The smallest finite number; infinity if there is none.
    pub min: f32,
    /// The largest finite number; minus infinity if there is none.
    pub max: f32,
    /// The mean of the finite numbers; NaN if there are none.
    pub mean: f64,
    /// The number of NaNs.
    pub nan: u64,
    /// The number of infinities.
    pub infinite: u64,
    /// The number of zeros.
    pub zero: u64,
    /// The number of finite values that are not whole.
    pub fractional: u64,
    /// The number of pixels of the channel.
    pub count: u64,
}

impl ChannelInfo {
    fn new(name: &str, samples: Samples) -> ChannelInfo {
        ChannelInfo {
            name: name.to_string(),
            samples,
            variables: Vec::new(),
            min: f32::INFINITY,
            max: f32::NEG_INFINITY,
            mean: f64::NAN,
            nan: 0,
            infinite: 0,
            zero: 0,
            fractional: 0,
            count: 0,
        }
    }

    /// Counts in some numbers; `sum` is that of the finite ones so far.
    fn add(&mut self, values: &[f32], sum: &mut f64) {
        for &v in values {
            if v.is_finite() {
                self.min = self.min.min(v);
                self.max = self.max.max(v);
                *sum += f64::from(v);
                self.zero += u64::from(v == 0.0);
                self.fractional += u64::from(v.fract() != 0.0);
            } else if v.is_nan() {
                self.nan += 1;
            } else {
                self.infinite += 1;
            }
        }
        self.count += values.len() as u64;
    }
}

/// Reads the whole file, a block at a time, and computes its statistics.
///
/// # Errors
/// If the file turns out damaged.
pub fn info(file: &File) -> Result<Info, ImageError> {
    let mut channels: Vec<ChannelInfo> =
        file.channels.iter().map(|c| ChannelInfo::new(&c.name, c.samples)).collect();
    let mut sums = vec![0f64; channels.len()];
    let mut notes = Vec::new();
    let (format, parts) = match &file.source {
        Source::Exr(exr) => {
            let mut row = vec![0f32; file.size()[0]];
            let readable = |c: &Channel| exr.parts[c.part].readable().is_some();
            let count = exr.headers().count();
            let mut faults = Vec::new();
            // One part that is damaged does not keep the others from being described.
            for (index, part) in exr.parts.iter().enumerate() {
                let wanted: Vec<bool> =
                    file.channels.iter().map(|c| c.part == index && readable(c)).collect();
                let mut scan = Scan::new(exr, &file.input, &file.channels, &wanted)?;
                let scanned = scan.decode(0..file.size()[1], |line| {
                    let row = &mut row[..line.len()];
                    line.floats(row, 1);
                    channels[line.channel].add(row, &mut sums[line.channel]);
                });
                if let Err(fault) = scanned {
                    notes.push(format!("The part `{}` cannot be read: {fault}.", part.name));
                    faults.push(fault);
                }
            }
            if faults.len() == count
                && let Some(fault) = faults.pop()
            {
                return Err(fault);
            }
            ("OpenEXR".to_string(), exr.parts.iter().map(part).collect())
        }
        Source::Raster(raster) => {
            let mut scan = RasterScan::new(raster, &file.input)?;
            let height = file.size()[1];
            for top in (0..height).step_by(64) {
                for (index, plane) in scan.rows(top..height.min(top + 64))?.iter().enumerate() {
                    channels[index].add(plane, &mut sums[index]);
                }
            }
            notes.extend(raster.notes());
            (raster.format.to_string(), Vec::new())
        }
    };
    for (channel, sum) in channels.iter_mut().zip(&sums) {
        let finite = channel.count - channel.nan - channel.infinite;
        if finite > 0 {
            channel.mean = sum / finite as f64;
        }
    }
    name_variables(file, &mut channels);
    take_notes(file, &channels, &parts, &mut notes);
    let metadata = file.metadata();
    Ok(Info {
        name: file.name(),
        format,
        size: file.size(),
        origin: metadata.origin,
        resolution: metadata.resolution.unwrap_or(file.size()),
        pixel_aspect: metadata.pixel_aspect,
        parts,
        attributes: metadata.attributes.iter().map(|(n, v)| (n.to_string(), v)).collect(),
        channels,
        notes,
    })
}

fn part(part: &ExrPart) -> PartInfo {
    let header = part.header.as_ref();
    let position = header.map_or([0, 0], |h| {
        let position = h.own_attributes.layer_position;
        [position.x(), position.y()]
    });
    PartInfo {
        name: part.name.clone(),
        compression: part
            .unread_compression
            .clone()
            .or(header.map(|h| h.compression.to_string()))
            .unwrap_or_default(),
        layout: match header.map(|h| h.blocks) {
            Some(BlockDescription::ScanLines) => "scan lines".into(),
            Some(BlockDescription::Tiles(t)) => format!("tiles of {} x {}", t.tile_size.0, t.tile_size.1),
            None => String::new(),
        },
        size: header.map_or([0, 0], |h| [h.layer_size.0, h.layer_size.1]),
        origin: position,
        deep: header.is_some_and(|h| h.deep),
        unread: part.refusal.as_ref().map(|refusal| refusal.why.clone()),
    }
}

/// Tells each channel the variables it is part of.
fn name_variables(file: &File, channels: &mut [ChannelInfo]) {
    for binding in file.variables() {
        for candidate in &binding.candidates {
            let names = component_names(&candidate.shape, candidate.channels.len());
            for (component, &channel) in names.iter().zip(&candidate.channels) {
                let mark = if binding.candidates.len() > 1 { "?" } else { "" };
                // Each of three channels of luminance and chroma has a part in all of the colour.
                let component = if candidate.luminance_chroma { "" } else { component.as_str() };
                let name = format!("{}{component}{mark}", binding.name);
                let name = if binding.alias { format!("({name})") } else { name };
                // A grey image's one channel is all three of its colour.
                let list = &mut channels[channel].variables;
                let same = |v: &String| {
                    let rest = v.trim_start_matches('(').strip_prefix(binding.name.as_str());
                    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[', '?', ')']))
                };
                if !list.iter().any(same) {
                    list.push(name);
                }
            }
        }
    }
}

fn component_names(shape: &crate::shape::Shape, cells: usize) -> Vec<String> {
    match shape {
        crate::shape::Shape::Scalar => vec![String::new()],
        crate::shape::Shape::Vector(n @ 2..=4) => {
            "xyzw".chars().take(*n as usize).map(|c| format!(".{c}")).collect()
        }
        _ => (1..=cells).map(|i| format!("[{i}]")).collect(),
    }
}

fn take_notes(file: &File, channels: &[ChannelInfo], parts: &[PartInfo], notes: &mut Vec<String>) {
    let of = |name: &str| file.find(name).ok().map(|c| &channels[c.channels[0]]);
    let read = || parts.iter().filter(|p| p.unread.is_none());
    for (index, part) in parts.iter().enumerate() {
        if let Some(why) = &part.unread {
            let name =
                if part.name.is_empty() { (index + 1).to_string() } else { format!("`{}`", part.name) };
            notes.push(format!("The part {name} is not read: {why}."));
        }
    }
    for channel in file.channels.iter().filter(|c| parts.get(c.part).is_some_and(|p| p.unread.is_none())) {
        let shown = channels.iter().any(|c| c.name == channel.name && !c.variables.is_empty());
        if let Some(why) = channel.unread.as_ref().filter(|_| !shown) {
            notes.push(format!("`{}` is not read: {why}.", channel.name));
        }
    }
    let windows = || read().map(|p| (p.size, p.origin));
    if windows().any(|window| Some(window) != windows().next()) {
        notes.push("The parts' data windows differ; outside its own window, a part's channels are 0.".into());
    }
    let lossy: Vec<&str> = file
        .channels
        .iter()
        .zip(channels)
        .filter(|(c, about)| {
            let dwa = parts.get(c.part).is_some_and(|p| p.compression.to_lowercase().starts_with("dwa"));
            let picture = about.variables.iter().any(|v| v.starts_with("color") || v.starts_with("alpha"));
            let lossy = matches!(last_field(&c.name), "R" | "G" | "B" | "Y" | "RY" | "BY");
            dwa && !picture && lossy && c.unread.is_none()
        })
        .map(|(c, _)| c.name.as_str())
        .collect();
    if !lossy.is_empty() {
        notes.push(format!(
            "DWA compression is lossy for channels named R G B Y, even floats: {} {} not exact. Render data passes with ZIP.",
            lossy.join(", "),
            if lossy.len() == 1 { "is" } else { "are" }
        ));
    }
    let surface = of("surface");
    if let Some(ids) = surface {
        if ids.fractional > 0 {
            let at = pixels(ids.fractional);
            notes.push(format!(
                "`surface` is not a whole number at {at}: a pixel filter has mixed ids there."
            ));
        }
        if ids.samples == Samples::Uint && ids.max >= 16_777_216.0 {
            notes.push(
                "Some ids of `surface` are above 2^24, where a 32-bit float has no odd numbers.".into(),
            );
        }
        if ids.zero > 0 {
            notes.push(format!("`surface` is 0 at {}: probably the background.", pixels(ids.zero)));
        }
    } else if let Some(depth) = of("depth")
        && (depth.infinite > 0 || depth.max >= 1e9)
    {
        let far = if depth.infinite > 0 { "infinite".into() } else { short(f64::from(depth.max)) };
        notes.push(format!("The background is probably where `depth` is {far}."));
    }
    if let Some(depth) = of("depth")
        && depth.fractional > 0
        && depth.min >= 0.0
        && depth.max <= 1.0
    {
        notes.push(
            "`depth` is between 0 and 1: it may be scaled or inverted, and not a distance in scene units."
                .into(),
        );
    }
    for binding in file.variables().iter().filter(|b| b.candidates.len() > 1) {
        let groups: Vec<String> = binding.candidates.iter().map(|c| format!("`{}`", c.group)).collect();
        notes.push(format!(
            "`{}` could be {}: choose one with --map {}=….",
            binding.name,
            groups.join(" or "),
            binding.name
        ));
    }
    let bad: Vec<&str> =
        channels.iter().filter(|c| c.nan > 0 || c.infinite > 0).map(|c| c.name.as_str()).collect();
    if !bad.is_empty() {
        notes.push(format!("NaN or infinity in {}.", bad.join(", ")));
    }
}

fn pixels(count: u64) -> String {
    format!("{count} {}", if count == 1 { "pixel" } else { "pixels" })
}

/// A number in a few characters.
fn short(v: f64) -> String {
    let size = v.abs();
    if v == 0.0 {
        "0".into()
    } else if !(1e-3..1e6).contains(&size) {
        format!("{v:.3e}")
    } else if v == v.trunc() {
        format!("{v:.0}")
    } else {
        format!("{v:.4}")
    }
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [w, h] = self.size;
        writeln!(f, "{}: {}, {w} x {h}", visible_name(&self.name), self.format)?;
        if self.resolution != self.size || self.origin != [0, 0] {
            let [x, y] = self.origin;
            let [dw, dh] = self.resolution;
            writeln!(f, "display window {dw} x {dh}, data window {w} x {h} from column {x}, row {y}")?;
        }
        if self.pixel_aspect != 1.0 {
            writeln!(f, "pixel aspect ratio {}", self.pixel_aspect)?;
        }
        for part in &self.parts {
            let name =
                if part.name.is_empty() { String::new() } else { format!(" `{}`", visible_name(&part.name)) };
            let mut words: Vec<String> = Vec::new();
            words.extend([&part.compression, &part.layout].into_iter().filter(|w| !w.is_empty()).cloned());
            if self.parts.len() > 1 && part.size != self.size && part.size != [0, 0] {
                let ([w, h], [x, y]) = (part.size, part.origin);
                words.push(format!("{w} x {h} from column {x}, row {y}"));
            }
            words.extend(part.deep.then(|| "deep".into()));
            words.extend(part.unread.as_ref().map(|_| "not read".into()));
            writeln!(f, "part{name}: {}", words.join(", "))?;
        }
        let mut rows =
            vec![["channel", "type", "min", "max", "mean", "NaN", "inf", "variable"].map(String::from)];
        for c in &self.channels {
            let kind = match c.samples {
                Samples::Half => "half".to_string(),
                Samples::Float => "float".into(),
                Samples::Double => "double".into(),
                Samples::Uint => "uint".into(),
                Samples::Byte => "8 bit".into(),
                Samples::Short => "16 bit".into(),
                Samples::Bits(bits) => format!("{bits} bit"),
                Samples::Unknown => "?".into(),
            };
            let finite = c.count > c.nan + c.infinite;
            let number = |v: f64| if finite { short(v) } else { "-".into() };
            rows.push([
                visible_name(&c.name).into_owned(),
                kind,
                number(f64::from(c.min)),
                number(f64::from(c.max)),
                number(c.mean),
                c.nan.to_string(),
                c.infinite.to_string(),
                visible_name(&c.variables.join(" ")).into_owned(),
            ]);
        }
        let widths: Vec<usize> =
            (0..8).map(|i| rows.iter().map(|r| r[i].chars().count()).max().unwrap_or(0)).collect();
        writeln!(f)?;
        for row in &rows {
            let mut line = String::new();
            for (i, (cell, &width)) in row.iter().zip(&widths).enumerate() {
                // Numbers stand to the right, words to the left.
                match (2..7).contains(&i) {
                    true => line += &format!("{cell:>width$}  "),
                    false => line += &format!("{cell:<width$}  "),
                }
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        if !self.attributes.is_empty() {
            let width = self.attributes.iter().map(|(n, _)| n.chars().count()).max().unwrap_or(0).min(40);
            writeln!(f)?;
            for (name, value) in &self.attributes {
                writeln!(f, "{:<width$}  {}", visible_name(name), visible_name(value))?;
            }
        }
        if !self.notes.is_empty() {
            writeln!(f)?;
            for note in &self.notes {
                writeln!(f, "note: {}", visible_name(note))?;
            }
        }
        Ok(())
    }
}
