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
  pse run coral.pse --iso coral.pse -o coral.png            a solid from its density
  pse run marble.pse --tile 3/4x4 -o 'marble.{tile}.exr'    one of 16 tiles, for pse join
  pse run marble.pse --hash                                 a digest of the result, and no file
  pse run a.pse -i g.exr -o - | pse run b.pse -i - -o b.png

A picture (.png .jpg .tif .hdr .bmp .tga .webp) shows color. For a program without color, name one variable with \
--vars: a scalar is shown as grey, a vector of 3 as a colour. An .exr file holds any number of variables.

Without -i and --scene, the input is the built-in donut. The environment variable PSE_SIMD (baseline, avx2 or avx512) \
selects the instruction set; the result is the same.";

/// What to run, on what, and where to.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(in crate::cli) struct RunArgs {
    #[command(flatten)]
    pub program: ProgramArgs,
    /// Set a param or an input variable to an expression: veins=6, tint='[1 0 0]'
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,

    #[command(flatten)]
    pub images: ImageArgs,
    #[command(flatten)]
    pub solid: SolidArgs,
    /// Read and write pictures (PNG, JPEG, …) without sRGB conversion
    #[arg(long, help_heading = "Input")]
    pub raw: bool,
    /// The frame number (default: the one in the input's name or header)
    #[arg(
        long,
        value_name = "N",
        help_heading = "Frames",
        conflicts_with = "frames",
        allow_negative_numbers = true
    )]
    pub frame: Option<FrameArg>,
    /// Run several frames: 1-24, -3-3, 1,5,9 or 1-20x2 (or 1-20:2). In file names, ####, @@@@, %d or %04d stands for
    /// the frame number
    #[arg(long, value_name = "LIST", help_heading = "Frames", allow_hyphen_values = true)]
    pub frames: Option<Frames>,
    /// Skip frames whose output files are complete and come from the same run. Files written with --resume (.exr and
    /// .png) carry a hash of program, inputs and options in their header
    #[arg(long, help_heading = "Frames")]
    pub resume: bool,
    /// After a frame fails, continue with the next; list the failed frames at the end
    #[arg(long, help_heading = "Frames")]
    pub keep_going: bool,
    /// How to report progress
    #[arg(long, value_enum, default_value_t, value_name = "STYLE", help_heading = "Frames")]
    pub progress: Style,

    /// A file to write; repeat for several. The extension selects the format; - writes EXR to standard output
    /// (default: PROGRAM.png)
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    pub output: Vec<PathBuf>,
    /// The variables to write, separated by commas (default: color, or all variables if the program assigns no color)
    #[arg(long, value_name = "NAMES", value_delimiter = ',', help_heading = "Output")]
    pub vars: Option<Vec<String>>,
    /// Compute only these pixels: x0,y0,x1,y1 (x1 and y1 exclusive) or WxH+X+Y
    #[arg(long, value_name = "REGION", help_heading = "Output", allow_hyphen_values = true)]
    pub region: Option<Region>,
    /// Compute only tile N of a grid: 3/4x4 is the third of four columns by four rows. In file names, {tile} stands
    /// for its number
    #[arg(long, value_name = "N/CxR", help_heading = "Output", conflicts_with = "region")]
    pub tile: Option<Tile>,
    /// Print a digest of the result, which is the same on every machine. Writes a file only with -o
    #[arg(long, help_heading = "Output")]
    pub hash: bool,
    /// Create missing output folders
    #[arg(long, help_heading = "Output")]
    pub mkdir: bool,
    /// EXR: write 16-bit floats, except for surface, point and depth
    #[arg(long, help_heading = "Output")]
    pub half: bool,
    /// PNG and TIFF: bits per component; 32 writes floats, TIFF only
    #[arg(long, value_name = "8|16|32", value_parser = bits, help_heading = "Output")]
    pub bits: Option<u8>,
    /// Average N jittered samples per pixel
    #[arg(long, value_name = "N", value_parser = positive, help_heading = "Antialiasing", allow_negative_numbers = true)]
    pub samples: Option<usize>,
    /// The reconstruction filter: box (radius half a pixel), triangle (1 pixel), catmull-rom or mitchell (2 pixels)
    #[arg(long, value_enum, default_value_t, requires = "samples", help_heading = "Antialiasing")]
    pub filter: FilterArg,
    /// The seed of the sample positions
    #[arg(long, value_name = "S", default_value_t = 0, requires = "samples", help_heading = "Antialiasing")]
    pub seed: u32,
    /// Show at most N lines of the program's print output, from the first pixels; 0 shows none
    #[arg(long, value_name = "N", default_value_t = 10, help_heading = "Output")]
    pub print: usize,
    /// Let an output replace an input, and a default output replace a file that pse did not write
    #[arg(long, help_heading = "Output")]
    pub force: bool,
    /// Print errors only
    #[arg(short, long, help_heading = "Output")]
    pub quiet: bool,

    /// Number of threads (default: one per core)
    #[arg(long, value_name = "N", value_parser = positive, help_heading = "Speed")]
    pub threads: Option<usize>,
    /// Print how long reading, running and writing took, and what ran
    #[arg(long, help_heading = "Speed")]
    pub stats: bool,
    /// Run N times in memory and print the median time per pixel. Writes a file only with -o
    #[arg(long, value_name = "N", value_parser = positive, help_heading = "Speed")]
    pub repeat: Option<usize>,
    /// Print where the time goes: for each line, its own time and the share of pixels that were active
    #[arg(long, help_heading = "Speed")]
    pub profile: bool,
    /// Run without the optimizer: slower, with the same result
    #[arg(long, help_heading = "Speed")]
    pub no_optimize: bool,
    /// Lanes of a batch
    #[arg(long, value_name = "N", value_parser = positive, hide = true)]
    pub batch: Option<usize>,

    /// Limit the memory of the whole run. Rows are processed in bands that fit, estimated beforehand from the
    /// components of a pixel; textures get a quarter of the limit, the values of all threads an eighth. A run that
    /// cannot fit is refused
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
    /// Maximum loop iterations and function calls per pixel
    #[arg(long, value_name = "N", default_value_t = Limits::default().steps)]
    max_steps: u32,
    /// Maximum nesting depth of function calls
    #[arg(long, value_name = "N", default_value_t = Limits::default().depth)]
    max_depth: u32,
    /// Maximum number of scalars in a vector
    #[arg(long, value_name = "N", default_value_t = Limits::default().cells)]
    max_vector: usize,
    /// Maximum memory for values, per thread
    #[arg(long, value_name = "MB", default_value_t = Limits::default().memory >> 20)]
    max_memory: usize,
    /// Memory for all textures; larger textures go through a temporary file
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
