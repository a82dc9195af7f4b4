//! The options of `pse run` that a job was given, to be given again on the farm.

use super::super::run::RunArgs;
use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, CommandFactory, FromArgMatches, Parser};

/// The arguments of `pse run`, understood, and word by word.
#[derive(Debug)]
pub(super) struct RunWords {
    pub run: RunArgs,
    /// Each option with its value, as it was written.
    pub words: Vec<Word>,
}

/// An option.
#[derive(Clone, Debug)]
pub(super) struct Word {
    /// Its long name with the dashes.
    pub option: String,
    /// What stands behind it, if it takes a value.
    pub value: Option<String>,
}

/// Options that say how a single run on this machine is looked at, and have no meaning for a job.
const NOT_OF_JOBS: [&str; 8] = ["region", "tile", "hash", "stats", "repeat", "profile", "progress", "mkdir"];

/// Arguments that the job's template has a place of its own for, or that are for the bundle.
const TOLD_OTHERWISE: [&str; 8] = ["program", "lines", "path", "input", "mesh", "output", "frames", "force"];

/// `pse run` as a command of its own, to look at its arguments.
#[derive(Parser)]
struct Run {
    #[command(flatten)]
    run: RunArgs,
}

impl Args for RunWords {
    fn augment_args(command: Command) -> Command {
        let mut command = RunArgs::augment_args(command);
        for id in NOT_OF_JOBS {
            command = command.mut_arg(id, |arg| arg.hide(true));
        }
        command = command.mut_arg("force", |arg| {
            arg.help("Also replace files of the bundle that were changed after pse wrote them")
                .help_heading("Job")
        });
        command.mut_arg("output", |arg| {
            arg.long("picture")
                .short(None)
                .help("A picture to write in the job's output folder; repeat for several (default: PROGRAM.png)")
                .help_heading("Job")
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for RunWords {
    fn from_arg_matches(matches: &ArgMatches) -> Result<RunWords, clap::Error> {
        let run = RunArgs::from_arg_matches(matches)?;
        let mut words = Vec::new();
        for arg in Run::command().get_arguments() {
            let id = arg.get_id().as_str();
            let given = matches.value_source(id) == Some(ValueSource::CommandLine);
            let Some(long) = arg.get_long().filter(|_| given && !TOLD_OTHERWISE.contains(&id)) else {
                continue;
            };
            let option = format!("--{long}");
            if NOT_OF_JOBS.contains(&id) {
                let message = format!("{option} has no effect in a job; it is for pse run\n");
                return Err(clap::Error::raw(clap::error::ErrorKind::ArgumentConflict, message));
            }
            let delimiter = arg.get_value_delimiter().map(String::from);
            let values: Vec<String> =
                matches.get_raw(id).into_iter().flatten().map(|v| v.to_string_lossy().into_owned()).collect();
            match (arg.get_action().takes_values(), delimiter) {
                (false, _) => words.push(Word { option, value: None }),
                (true, Some(delimiter)) => words.push(Word { option, value: Some(values.join(&delimiter)) }),
                (true, None) => {
                    words.extend(values.into_iter().map(|v| Word { option: option.clone(), value: Some(v) }));
                }
            }
        }
        Ok(RunWords { run, words })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
