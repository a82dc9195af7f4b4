//! The arguments of `pse run`.

use crate::cli::failure::Failure;
use crate::cli::frames::{FrameArg, Frames};
use crate::cli::input::ImageArgs;
use crate::cli::progress::Style;
use crate::cli::region::Region;
use crate::cli::solid::SolidArgs;
use crate::cli::source::ProgramArgs;
use crate::cli::tiles::Tile;
use clap::{Args, ValueEnum};
use pse::image::{Image, WriteOptions};
use pse::internal::eval::TEXTURE_MEMORY;
use pse::internal::program::{Filter, Limits, Sampling};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  pse run marble.pse                                        the built-in donut, into marble.png
  pse run marble.pse -i gbuffer.exr -o marble.exr -o marble.png
  pse run -e 'n = Noise(8 * point)' -e 'white * n' --scene vase --size 480x640
  pse run marble.pse --set veins=6 --set tint='[1 0.8 0.6]'
  pse run fire.pse -i fg.####.exr -i bg=sky.png -o fire.####.png --frames 1-24
  pse run fire.pse -o fire.####.png --frames 1-1000 --resume --keep-going
  pse run coral.pse --iso coral.pse -o coral.png            a solid that a program tells of
  pse run marble.pse --tile 3/4x4 -o 'marble.{tile}.exr'    one of 16 tiles, for pse join
  pse run marble.pse --hash                                 a digest of the pixels, and no file
  pse run a.pse -i g.exr -o - | pse run b.pse -i - -o b.png

Pictures (.png .jpg .tif .hdr .bmp .tga .webp) show color. Of a program that assigns none, they show the one \
variable that --vars names: a scalar as grey, a vector of 3 as a colour. An .exr file holds any variable.

Without -i and --scene, the built-in donut is used. PSE_SIMD=baseline, avx2 or avx512 in the environment \
chooses the instruction set; the result is the same.";

/// What to run, on what, and where to.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(in crate::cli) struct RunArgs {
    #[command(flatten)]
    pub program: ProgramArgs,
    /// Set a param (or an input variable) to an expression: veins=6, tint='[1 0 0]'
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,

    #[command(flatten)]
    pub images: ImageArgs,
    #[command(flatten)]
    pub solid: SolidArgs,
    /// Take PNG, JPEG and the like as plain numbers, and write them so: no sRGB curve either way
    #[arg(long, help_heading = "Input")]
    pub raw: bool,
    /// The number of the frame; that in the name or the header of the input if not given
    #[arg(
        long,
        value_name = "N",
        help_heading = "Frames",
        conflicts_with = "frames",
        allow_negative_numbers = true
    )]
    pub frame: Option<FrameArg>,
    /// Several frames: 1-24, -3-3, 1,5,9 or 1-20x2 (1-20:2 is the same). Names of files may hold the number as ####, @@@@,
    /// %d or %04d
    #[arg(long, value_name = "LIST", help_heading = "Frames", allow_hyphen_values = true)]
    pub frames: Option<Frames>,
    /// Leave out frames whose files are there, whole, and of the same run: a hash of program, inputs and options stands
    /// in the header of .exr and .png files that were written with --resume
    #[arg(long, help_heading = "Frames")]
    pub resume: bool,
    /// Go on with the next frame after one that fails, and name those that failed at the end
    #[arg(long, help_heading = "Frames")]
    pub keep_going: bool,
    /// How progress is told
    #[arg(long, value_enum, default_value_t, value_name = "STYLE", help_heading = "Frames")]
    pub progress: Style,

    /// A file to write, several if repeated; the extension tells the format. PROGRAM.png if not given; - is standard
    /// output, as EXR
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    pub output: Vec<PathBuf>,
    /// The variables to write, with commas between; color if not given, or all if the program assigns none
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = "Output")]
    pub vars: Option<Vec<String>>,
    /// Compute only these pixels: x0,y0,x1,y1 (x1 and y1 are one past the last) or WxH+X+Y
    #[arg(long, value_name = "REGION", help_heading = "Output", allow_hyphen_values = true)]
    pub region: Option<Region>,
    /// Compute only one tile, as in 3/4x4: the third of four columns and four rows. Names hold its number as {tile}
    #[arg(long, value_name = "N/CxR", help_heading = "Output", conflicts_with = "region")]
    pub tile: Option<Tile>,
    /// Print a digest of the computed numbers, the same on every machine. Writes only to -o
    #[arg(long, help_heading = "Output")]
    pub hash: bool,
    /// Make the folders of the outputs
    #[arg(long, help_heading = "Output")]
    pub mkdir: bool,
    /// EXR: 16-bit floats, but for surface, point and depth
    #[arg(long, help_heading = "Output")]
    pub half: bool,
    /// PNG and TIFF: bits a component; 32 is for TIFF, as floats
    #[arg(long, value_name = "8|16|32", value_parser = bits, help_heading = "Output")]
    pub bits: Option<u8>,
    /// Run the program so many times in each pixel, at places here and there, and write the mean
    #[arg(long, value_name = "N", value_parser = positive, help_heading = "Antialiasing", allow_negative_numbers = true)]
    pub samples: Option<usize>,
    /// What a pixel sees of its surroundings: itself (box), or up to one (triangle) or two pixels beside it
    #[arg(long, value_enum, default_value_t, requires = "samples", help_heading = "Antialiasing")]
    pub filter: FilterArg,
    /// Other places for another number
    #[arg(long, value_name = "S", default_value_t = 0, requires = "samples", help_heading = "Antialiasing")]
    pub seed: u32,
    /// Show so many lines of what the program prints, those of the first pixels; 0 shows none
    #[arg(long, value_name = "N", default_value_t = 10, help_heading = "Output")]
    pub print: usize,
    /// Let an output replace an input, and one without -o a file that pse did not write
    #[arg(long, help_heading = "Output")]
    pub force: bool,
    /// Say nothing but errors
    #[arg(short, long, help_heading = "Output")]
    pub quiet: bool,

    /// Threads; as many as the machine has if not given
    #[arg(long, value_name = "N", value_parser = positive, help_heading = "Speed")]
    pub threads: Option<usize>,
    /// Say how long reading, running and writing took, and what ran
    #[arg(long, help_heading = "Speed")]
    pub stats: bool,
    /// Run so many times in memory, and tell the median time of a pixel. Writes only to -o
    #[arg(long, value_name = "N", value_parser = positive, help_heading = "Speed")]
    pub repeat: Option<usize>,
    /// Tell where the time goes: for each line what it took by itself, and which share of the pixels was active
    #[arg(long, help_heading = "Speed")]
    pub profile: bool,
    /// Walk the program's tree alone, without plans for straight stretches of it: slower, and the same result
    #[arg(long, help_heading = "Speed")]
    pub no_optimize: bool,
    /// Lanes of a batch
    #[arg(long, value_name = "N", value_parser = positive, hide = true)]
    pub batch: Option<usize>,

    /// Megabytes that the run may take, all in all. So many rows are read, run and written at a time as fit, judged
    /// beforehand by the numbers of a pixel; textures may have a quarter of it, and the values of all threads an eighth. What cannot
    /// fit is refused
    #[arg(long, value_name = "MB", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Limits")]
    pub memory: Option<u32>,
    #[command(flatten)]
    pub limits: LimitArgs,
}

/// A filter by its name.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(in crate::cli) enum FilterArg {
    #[default]
    Box,
    Triangle,
    CatmullRom,
    Mitchell,
}

/// What a pixel may use up.
#[derive(Debug, Args)]
#[command(next_help_heading = "Limits")]
pub(in crate::cli) struct LimitArgs {
    /// Rounds of loops and calls of functions at a pixel
    #[arg(long, value_name = "N", default_value_t = Limits::default().steps)]
    max_steps: u32,
    /// Calls inside of calls
    #[arg(long, value_name = "N", default_value_t = Limits::default().depth)]
    max_depth: u32,
    /// Scalars in a vector
    #[arg(long, value_name = "N", default_value_t = Limits::default().cells)]
    max_vector: usize,
    /// Megabytes of values that a thread holds
    #[arg(long, value_name = "MB", default_value_t = Limits::default().memory >> 20)]
    max_memory: usize,
    /// Megabytes of textures in memory, all together; larger ones go through a temporary file
    #[arg(long, value_name = "MB", default_value_t = TEXTURE_MEMORY >> 20)]
    texture_memory: usize,
}

impl LimitArgs {
    /// As the evaluator takes them.
    pub fn limits(&self) -> Limits {
        Limits {
            steps: self.max_steps,
            depth: self.max_depth,
            cells: self.max_vector,
            memory: self.max_memory.saturating_mul(1 << 20),
        }
    }

    /// Bytes that textures may take.
    pub fn textures(&self) -> usize {
        self.texture_memory.saturating_mul(1 << 20)
    }
}

impl RunArgs {
    /// How each pixel is sampled, if not in its middle alone.
    pub fn sampling(&self) -> Option<Sampling> {
        let filter = match self.filter {
            FilterArg::Box => Filter::Box,
            FilterArg::Triangle => Filter::Triangle,
            FilterArg::CatmullRom => Filter::CatmullRom,
            FilterArg::Mitchell => Filter::Mitchell,
        };
        let count = self.samples.filter(|n| *n > 1)? as u32;
        Some(Sampling { count, filter, seed: self.seed })
    }

    /// How files are written.
    pub fn write_options(&self) -> WriteOptions {
        WriteOptions { half: self.half, bits: self.bits, raw: self.raw, ..WriteOptions::default() }
    }

    /// The pixels to compute of an image, if not all.
    pub fn part(&self, image: &Image<'_>) -> Result<Option<Region>, Failure> {
        match self.tile {
            Some(tile) => tile.region(image).map(Some),
            None => Ok(self.region),
        }
    }
}

/// Bits of a component.
pub(in crate::cli) fn bits(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        "32" => Ok(32),
        _ => Err("a component has 8, 16 or 32 bits".into()),
    }
}

/// A whole number from 1 on.
pub(in crate::cli) fn positive(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|n| (1..=1 << 16).contains(n))
        .ok_or("give a whole number from 1 to 65536".into())
}
