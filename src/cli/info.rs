//! `pse info`: what is in an image file.

use super::failure::{Failure, print};
use super::input::MapArg;
use crate::image::{Input, ReadOptions, info as image_info, read};
use clap::Args;
use std::path::PathBuf;

/// Which files.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  pse info gbuffer.exr\n  pse info gbuffer.exr --map point=ViewLayer.Position"
)]
pub(super) struct InfoArgs {
    /// The images; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Read a variable from other channels than the names suggest
    #[arg(long, value_name = "NAME=CHANNELS")]
    map: Vec<MapArg>,
    /// Take PNG, JPEG and the like as plain numbers: no sRGB decoding
    #[arg(long)]
    raw: bool,
}

/// Prints a table for each file.
pub(super) fn info(args: &InfoArgs) -> Result<(), Failure> {
    let maps = args.map.iter().map(|m| m.mapping.clone()).collect();
    let options = ReadOptions { maps, raw: args.raw };
    for (i, path) in args.files.iter().enumerate() {
        let file = read(Input::from_argument(path)?, &options)?;
        let table = image_info(&file)?.to_string();
        print(if i > 0 { "\n" } else { "" })?;
        print(&table)?;
    }
    Ok(())
}
