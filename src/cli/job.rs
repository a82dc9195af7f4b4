//! `pse job`: a run of many frames or tiles as an Open Job Description bundle, which render farms execute.

mod bundle;
mod files;
mod manifest;
mod template;
mod words;

use super::failure::{Failure, print, warn};
use super::frames::{self, Frame};
use super::run::{Plan, RunArgs};
use super::tiles::Tiles;
use clap::Args;
use pse::internal::quote;
use std::path::{Path, PathBuf};
use words::RunWords;

const EXAMPLES: &str = "\
Examples:
  pse job fire.pse --frames 1-100 -o fire.job
  pse job fire.pse --frames 1-1000 --chunk 20 -i fg.####.exr --picture fire.####.png -o fire.job
  pse job marble.pse --size 8192x8192 --samples 64 --tiles 4x4 --picture marble.png -o marble.job
  openjd run fire.job/template.json                         run it on this machine
  deadline bundle submit fire.job                           submit it to AWS Deadline Cloud

All other options are those of pse run. The bundle contains copies of the program, its imports and its textures. \
The images of -i are not copied; their folder is a parameter of the job.";

/// What to run, in which parts, and where the bundle goes.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct JobArgs {
    /// The folder of the bundle; created if missing
    #[arg(short = 'o', long, value_name = "DIR", help_heading = "Job")]
    bundle: PathBuf,
    /// Frames per task, through the TASK_CHUNKING extension (default: 1)
    #[arg(long, value_name = "N", value_parser = super::run::positive, requires = "frames", help_heading = "Job")]
    chunk: Option<usize>,
    /// Cut each picture into C by R tiles, one task each, and join them in a second step
    #[arg(long, value_name = "CxR", help_heading = "Job")]
    tiles: Option<Tiles>,
    /// The job's name (default: the program's name)
    #[arg(long, value_name = "NAME", value_parser = name, help_heading = "Job")]
    name: Option<String>,
    #[command(flatten)]
    run: RunWords,
}

/// The name of a job, as Open Job Description allows it.
fn name(text: &str) -> Result<String, String> {
    match text.chars().count() {
        1..=128 if !text.chars().any(char::is_control) => Ok(text.into()),
        _ => Err("a job's name has 1 to 128 characters, and no control characters".into()),
    }
}

/// Refuses frames whose files are not there: a task for one could only fail.
fn check_frames(args: &RunArgs, plan: &Plan) -> Result<(), Failure> {
    let images = args.images.paths().filter(|path| !(*path == "head" && args.images.view.mesh.is_some()));
    let files = images.map(|path| (path.to_string(), frames::is_sequence(path)));
    let textures = plan.program.resolved().textures.iter().filter(|(source, _)| source.is_sequence());
    let file = |path: &str, frame: Frame| frames::input(path, frame.number);
    let missing =
        |path: &str| plan.frames.iter().filter(|frame| !file(path, **frame).exists()).collect::<Vec<_>>();
    let textures = textures.filter_map(|(source, _)| source.pattern());
    for (path, several) in files.chain(textures.map(|path| (path, true))) {
        let missing: Vec<i64> = missing(&path).iter().filter_map(|frame| frame.number).collect();
        if !several && !Path::new(&path).exists() {
            return Err(Failure::plain(format!("cannot read `{path}`: there is no such file")));
        }
        if let Some(first) = missing.first().filter(|_| several) {
            let there = plan.frames.iter().filter_map(|frame| frame.number).filter(|n| !missing.contains(n));
            let there: Vec<i64> = there.collect();
            let (s, are) = if missing.len() == 1 { ("", "is") } else { ("s", "are") };
            let list = frames::ranges(&missing, "x");
            let failure = Failure::plain(format!("frame{s} {list} of `{path}` {are} not there"));
            return Err(match there.is_empty() {
                true => {
                    failure.hint(format!("The first would be `{}`.", file(&path, (*first).into()).display()))
                }
                false => {
                    failure.hint(format!("Give those that are: --frames {}", frames::ranges(&there, "x")))
                }
            });
        }
    }
    Ok(())
}

/// Writes the bundle.
pub(super) fn job(args: &JobArgs) -> Result<(), Failure> {
    let RunWords { run, words } = &args.run;
    // What would fail on the farm is told here.
    let plan = Plan::new(run)?;
    if run.program.is_stdin() || run.images.input.iter().any(|i| i.path == "-") {
        return Err(Failure::usage("a job cannot read standard input: it runs elsewhere, and later")
            .hint("Give files."));
    }
    if run.solid.iso.is_some() {
        return Err(Failure::usage("a job cannot contain the program of --iso")
            .hint("Write the solid with pse scene --iso, and give the file with -i."));
    }
    check_frames(run, &plan)?;
    let job_name = match &args.name {
        Some(name) => name.clone(),
        None => name(&run.program.stem()).map_err(|e| {
            Failure::usage(e).hint("The program's name is too long. Give a job name with --name.")
        })?,
    };
    let pictures = pictures(run.output.clone(), &run.program.stem(), run.frames.is_some())?;
    let ranges = run.frames.as_ref().map(|frames| frames::ranges(&frames.0, ":"));
    let files = files::Files::of(run, &plan)?;
    let template = template::Template {
        name: job_name,
        frames: ranges,
        chunk: args.chunk,
        tiles: args.tiles,
        pictures,
        words: words.clone(),
        program: files.program.clone(),
        lines: run.program.lines.clone(),
        paths: files.paths(),
        inputs: template::Inputs::of(&run.images.input, run.images.view.mesh.as_deref())?,
    };
    let texts = bundle::Texts {
        template: template.json(files::FOLDER)?,
        interim: template.json(&bundle::staged_folder())?,
        values: template.inputs.values(),
    };
    bundle::write(&args.bundle, &files, &texts, run.force)?;
    if !run.quiet {
        let path = args.bundle.join("template.json");
        warn(&format!("wrote {}, {}", path.display(), template.tasks(run.frames.as_ref())));
        let value = |(name, folder): (&str, &Path)| {
            format!(" -p {}", quote::word(&format!("{name}={}", folder.to_string_lossy())))
        };
        let values: String = template.inputs.folders().map(value).collect();
        print(&format!("openjd run {}{values}\n", quote::path(&path)))?;
    }
    Ok(())
}

/// The pictures that the job makes, in the folder of its output.
fn pictures(given: Vec<PathBuf>, stem: &str, several: bool) -> Result<Vec<PathBuf>, Failure> {
    if given.is_empty() {
        return Ok(vec![format!("{stem}{}.png", if several { ".####" } else { "" }).into()]);
    }
    let outside = |path: &&PathBuf| {
        path.is_absolute() || path.components().any(|c| !matches!(c, std::path::Component::Normal(_)))
    };
    let counted = |path: &&PathBuf| frames::has_pattern(&path.to_string_lossy());
    if let Some(path) = given.iter().find(counted).filter(|_| !several) {
        let shown = path.display();
        return Err(Failure::usage(format!("--picture {shown} needs a frame number, and none is given"))
            .hint("Give the frames: --frames 1-24, or --frames 1 for one."));
    }
    match given.iter().find(outside) {
        Some(path) => {
            let shown = path.display();
            Err(Failure::usage(format!("--picture {shown} is outside the job's output folder"))
                .hint("Give a name like fire.####.png. The folder is the job's parameter OutputDir."))
        }
        None => Ok(given),
    }
}
