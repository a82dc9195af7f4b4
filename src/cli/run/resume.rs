//! Which frames are there already: a hash of all that a frame's pixels depend on, kept in the header of its files.

use super::RunArgs;
use super::plan::{Output, Plan, textures, values};
use crate::cli::failure::Failure;
use crate::cli::frames::{self, Frame};
use crate::cli::model;
use pse::image::{Content, is_whole, recorded};
use pse::internal::files;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The hashes of files that were looked at: a picture that serves all frames is read once.
#[derive(Default)]
pub(super) struct Hashes(HashMap<PathBuf, blake3::Hash>);

impl Hashes {
    /// Of all that is in the file: time and place say nothing on another machine.
    fn of(&mut self, path: &Path) -> Option<blake3::Hash> {
        if let Some(hash) = self.0.get(path) {
            return Some(*hash);
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(recorded(path, Content::Data, files::regular(path)).ok()?).ok()?;
        let hash = hasher.finalize();
        self.0.insert(path.to_path_buf(), hash);
        Some(hash)
    }

    /// The hash of a frame's run: equal for the same program, version, inputs and options on every machine. `None` if
    /// an input cannot be read, which the run itself will tell.
    pub fn of_frame(&mut self, args: &RunArgs, plan: &Plan, frame: Frame) -> Result<Option<String>, Failure> {
        let mut hasher = blake3::Hasher::new();
        // Each part goes in with its length, so that no two lists of parts look alike.
        let mut add = |part: &[u8]| {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part);
        };
        add(env!("CARGO_PKG_VERSION").as_bytes());
        for source in plan.program.sources().iter() {
            add(source.text.as_bytes());
        }
        let (set, spaces) = values(args, frame.value)?;
        let options = format!(
            "{:?}",
            (
                (frame.value, set, spaces, args.images.pixelsize),
                (&plan.scene, &args.images.view, &args.images.map, args.raw),
                (&plan.vars, &plan.shown, args.region, args.tile, args.half, args.bits),
                (args.samples, args.filter, args.seed),
                &args.solid,
            )
        );
        add(options.as_bytes());
        if let Some(solid) = plan.solid(args, frame)? {
            for source in solid.program().sources().iter() {
                add(source.text.as_bytes());
            }
        }
        let named = |path: &str| frames::input(path, frame.number);
        let inputs = args.images.input.iter().map(|i| (i.name.as_deref(), named(&i.path)));
        let textures = textures(&plan.program, frame);
        let mesh = args.images.view.mesh.iter().flat_map(|mesh| model::files(&named(mesh)));
        for (name, path) in inputs.chain(textures.chain(mesh).map(|path| (None, path))) {
            let Some(hash) = self.of(&path) else { return Ok(None) };
            add(name.unwrap_or_default().as_bytes());
            add(hash.as_bytes());
        }
        Ok(Some(hasher.finalize().to_hex().to_string()))
    }
}

/// Are all files of the frame there, from the run of that hash and undamaged?
pub(super) fn is_done(outputs: &[Output], hash: &str) -> bool {
    outputs.iter().all(|output| output.format.holds_stamp() && is_whole(&output.path, hash))
}

/// What cannot be resumed is told before the work.
pub(super) fn check(args: &RunArgs) -> Result<(), Failure> {
    if args.resume && args.output.is_empty() && (args.hash || args.repeat.is_some()) {
        let failure = Failure::usage("--resume needs an output file");
        return Err(failure.hint("Give one with -o, or remove --resume."));
    }
    let pipe =
        args.images.input.iter().any(|i| i.path == "-") || args.output.iter().any(|o| o.as_os_str() == "-");
    match args.resume && pipe {
        true => Err(Failure::usage("--resume cannot use standard input or output (-)")
            .hint("Give files with -i and -o, or remove --resume.")),
        false => Ok(()),
    }
}
