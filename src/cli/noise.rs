//! `pse noise`: what the kinds of noise are and look like.

mod canvas;
mod panels;
mod row;
mod sheet;

use super::failure::{Failure, print, warn};
use super::output;
use super::progress::{Meter, Style};
use clap::Args;
use pse::image::{self, WriteOptions};
use pse::noise::{KINDS, Kind, reference};
use row::{Common, Row};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  pse noise                                   list the kinds
  pse noise --list wiener                     describe one kind in full
  pse noise -o sheet.png                      draw all kinds with their spectra
  pse noise value gradient value_gradient hermite lattice_convolution sparse_convolution
                                              Peachey's figures 2.35 to 2.37, into noise.png
  pse noise fractalsum:gradient turbulence:gradient    his figures 2.38 and 2.39
  pse noise sparse_convolution sparse_convolution,density=1 sparse_convolution,kernel=gabor
                                              Lewis's figure 5
  pse noise wiener --set covariance=oscillatory --set period=8 --seed 3

Each row of the picture shows one noise: a plane section (grey, from 2.5 standard deviations below the mean to 2.5 \
above); its values along the middle row; the power spectrum of plane sections, with the band from 0.3 to 0.7 cycles per \
unit marked; the amplitude spectrum along straight lines; a histogram.

Besides kinds you can draw sums of octaves: turbulence, fractalsum, fBm, ridged and hybrid. They use the default kind; \
turbulence:KIND uses another. Their spectra have logarithmic axes.";

/// Which noises, and where to.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct NoiseArgs {
    /// The kinds or sums of octaves, with their options (default: all)
    #[arg(value_name = "KIND[,OPTION=VALUE]")]
    kinds: Vec<String>,
    /// Describe the kinds in full
    #[arg(long, conflicts_with_all = ["output", "set", "seed", "dimensions", "size", "force"])]
    list: bool,
    /// The picture to write; - writes EXR to standard output (default: noise.png if kinds are given)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Set an option for all kinds: density=3, kernel=gabor, period=4,4,0
    #[arg(long, value_name = "OPTION=VALUE")]
    set: Vec<String>,
    /// The seed
    #[arg(long, value_name = "N", default_value_t = 0.0, allow_negative_numbers = true)]
    seed: f32,
    /// Dimensions of a point (default: 3, or the nearest that the kind has)
    #[arg(long, value_name = "1-4", value_parser = clap::value_parser!(u8).range(1..=4))]
    dimensions: Option<u8>,
    /// The side of a plane section in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 192, value_parser = clap::value_parser!(u16).range(64..=1024))]
    size: u16,
    /// Let the default output noise.png replace a file that pse did not write
    #[arg(long)]
    force: bool,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
}

/// Draws the sheet, or tells about the kinds.
pub(super) fn noise(args: &NoiseArgs) -> Result<(), Failure> {
    if args.list {
        return list(&args.kinds);
    }
    if args.kinds.is_empty() && args.output.is_none() {
        return print(&reference::list());
    }
    let common = Common { set: &args.set, seed: args.seed, dimensions: args.dimensions.map(usize::from) };
    let rows = match args.kinds.is_empty() {
        true => row::all(&common)?,
        false => args.kinds.iter().map(|text| Row::new(text, &common)).collect::<Result<_, _>>()?,
    };
    let path = args.output.clone().unwrap_or_else(|| "noise.png".into());
    output::check(&path)?;
    if args.output.is_none() {
        output::check_default(&path, args.force)?;
    }
    let meter = Meter::new("noise", Style::Bar, args.quiet, 1);
    let image = sheet::draw(&rows, usize::from(args.size), |progress| meter.update(progress));
    meter.frame();
    image::write(&path, &image?, &WriteOptions::default())?;
    if !args.quiet {
        let n = rows.len();
        let s = if n == 1 { "" } else { "s" };
        warn(&format!("wrote {} ({n} noise{s})", output::shown(&path)));
    }
    Ok(())
}

/// All that is known of some kinds, or of all.
fn list(names: &[String]) -> Result<(), Failure> {
    let kinds: Vec<&'static Kind> = match names {
        [] => KINDS.to_vec(),
        names => names.iter().map(|name| row::kind(name)).collect::<Result<_, _>>()?,
    };
    let texts: Vec<String> = kinds.into_iter().map(reference::describe).collect();
    print(&texts.join("\n"))
}
