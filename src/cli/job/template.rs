//! The job template: parameters, the step that runs frames and tiles, and the step that joins tiles.

use super::super::failure::Failure;
use super::super::frames::{self, Frames};
use super::super::input::InputArg;
use super::super::tiles::Tiles;
use super::words::Word;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The folder of the output that tiles lie in until they are joined.
const TILES: &str = "tiles";

/// The longest argument and the longest value of a parameter that a job template may have.
const LONGEST: [usize; 2] = [2048, 1024];

/// What is in a job.
pub(super) struct Template {
    pub name: String,
    /// As the template writes ranges.
    pub frames: Option<String>,
    pub chunk: Option<usize>,
    pub tiles: Option<Tiles>,
    /// File names in the folder of the output.
    pub pictures: Vec<PathBuf>,
    pub words: Vec<Word>,
    /// The program's name in the bundle's folder.
    pub program: Option<String>,
    /// Or the lines of the program.
    pub lines: Vec<String>,
    /// Folders of `--path` below that folder; empty for itself.
    pub paths: Vec<String>,
    pub inputs: Inputs,
}

impl Template {
    /// The template's text; `folder` is that of the program in the bundle.
    pub fn json(&self, folder: &str) -> Result<String, Failure> {
        let mut steps = vec![self.step("Run", self.run_words()?, self.tiles)];
        if self.tiles.is_some() {
            let mut join = self.step("Join", self.join_words()?, None);
            join["dependencies"] = json!([{ "dependsOn": "Run" }]);
            steps.push(join);
        }
        let mut template = json!({
            "specificationVersion": "jobtemplate-2023-09",
            "name": literal(&self.name)?,
            "parameterDefinitions": self.parameters(folder)?,
            "steps": steps,
        });
        if self.chunk.is_some() {
            template["extensions"] = json!(["TASK_CHUNKING"]);
        }
        Ok(format!("{template:#}\n"))
    }

    /// How many tasks there are, in words.
    pub fn tasks(&self, frames: Option<&Frames>) -> String {
        let frames = frames.map_or(1, |f| f.0.len());
        let chunks = frames.div_ceil(self.chunk.unwrap_or(1));
        let s = |n: usize| if n == 1 { "" } else { "s" };
        let run = chunks * self.tiles.map_or(1, Tiles::count);
        match self.tiles {
            Some(_) => format!("{run} task{} for tiles and {chunks} to join them", s(run)),
            None => format!("{run} task{}", s(run)),
        }
    }

    fn parameters(&self, program_folder: &str) -> Result<Vec<Value>, Failure> {
        let folder = |name: &str, flow: &str, about: &str| json!({ "name": name, "type": "PATH", "objectType": "DIRECTORY", "dataFlow": flow, "description": about });
        let mut list = vec![json!({
            "name": "Pse",
            "type": "STRING",
            "default": "pse",
            "description": "The command pse: its name, or its path on the machines of the farm.",
        })];
        if let Some(frames) = &self.frames {
            if frames.len() > LONGEST[1] {
                return Err(Failure::usage("the list of frames is too long for a job")
                    .hint("Give ranges, as in --frames 1-1000x2, or several jobs."));
            }
            list.push(json!({
                "name": "Frames",
                "type": "STRING",
                "default": frames,
                "description": "The frames to run: 1-24, -3-3, 1,5,9 or 1-20:2.",
            }));
        }
        if self.program.is_some() || !self.paths.is_empty() {
            let mut program = folder("ProgramDir", "IN", "The program, what it imports, and its textures.");
            program["default"] = json!(program_folder);
            list.push(program);
        }
        list.extend(
            self.inputs.folders.iter().map(|(name, _)| folder(name, "IN", "The folder of the input images.")),
        );
        let mut output = folder("OutputDir", "OUT", "The folder for the pictures.");
        output["default"] = json!("output");
        list.push(output);
        Ok(list)
    }

    /// A step that runs `pse` with these words for each frame, and each tile.
    fn step(&self, name: &str, words: Vec<String>, tiles: Option<Tiles>) -> Value {
        let mut parameters = Vec::new();
        if self.frames.is_some() {
            let mut frame = json!({ "name": "Frame", "type": "INT", "range": "{{Param.Frames}}" });
            if let Some(chunk) = self.chunk {
                frame["type"] = json!("CHUNK[INT]");
                frame["chunks"] = json!({ "defaultTaskCount": chunk, "rangeConstraint": "NONCONTIGUOUS" });
            }
            parameters.push(frame);
        }
        if let Some(tiles) = tiles {
            parameters
                .push(json!({ "name": "Tile", "type": "INT", "range": format!("1-{}", tiles.count()) }));
        }
        let mut step = json!({
            "name": name,
            "script": { "actions": { "onRun": { "command": "{{Param.Pse}}", "args": words } } },
        });
        if !parameters.is_empty() {
            step["parameterSpace"] = json!({ "taskParameterDefinitions": parameters });
        }
        step
    }

    fn run_words(&self) -> Result<Vec<String>, Failure> {
        let mut words = vec!["run".to_string()];
        match &self.program {
            Some(name) => words.push(format!("{{{{Param.ProgramDir}}}}/{}", literal(name)?)),
            None => {
                for line in &self.lines {
                    words.extend(["--expression".into(), literal_lines(line)?]);
                }
            }
        }
        for path in &self.paths {
            let below = if path.is_empty() { String::new() } else { format!("/{path}") };
            words.extend(["--path".into(), format!("{{{{Param.ProgramDir}}}}{below}")]);
        }
        for input in &self.inputs.words {
            words.extend(["--input".into(), input.clone()]);
        }
        if let Some(mesh) = &self.inputs.mesh {
            words.extend(["--mesh".into(), mesh.clone()]);
        }
        for Word { option, value } in self.words.iter().filter(|w| !(self.tiles.is_some() && of_joined(w))) {
            words.push(option.clone());
            words.extend(value.as_deref().map(literal_lines).transpose()?);
        }
        if self.frames.is_some() {
            words.extend(["--frames".into(), "{{Task.Param.Frame}}".into()]);
        }
        match self.tiles {
            Some(tiles) => {
                words.extend(["--tile".into(), format!("{{{{Task.Param.Tile}}}}/{tiles}")]);
                words.extend(["--output".into(), self.tile()?]);
            }
            None => words.extend(self.outputs()?),
        }
        words.extend(["--mkdir", "--progress", "openjd"].map(String::from));
        fits(words)
    }

    fn join_words(&self) -> Result<Vec<String>, Failure> {
        let mut words = vec!["join".to_string(), self.tile()?];
        if let Some(tiles) = self.tiles {
            words.extend(["--tiles".into(), tiles.to_string()]);
        }
        if self.frames.is_some() {
            words.extend(["--frames".into(), "{{Task.Param.Frame}}".into()]);
        }
        for Word { option, value } in self.words.iter().filter(|w| of_joined(w) || w.option == "--raw") {
            words.push(option.clone());
            words.extend(value.clone());
        }
        words.extend(self.outputs()?);
        words.push("--mkdir".into());
        fits(words)
    }

    /// `--output` for each picture.
    fn outputs(&self) -> Result<Vec<String>, Failure> {
        let mut words = Vec::new();
        for path in &self.pictures {
            let path = literal(&path.to_string_lossy())?;
            words.extend(["--output".into(), format!("{{{{Param.OutputDir}}}}/{path}")]);
        }
        Ok(words)
    }

    /// The name of the tiles of a picture: of all pictures of a frame there is one set.
    fn tile(&self) -> Result<String, Failure> {
        let stem = self.pictures.first().map(|p| p.with_extension("")).unwrap_or_default();
        Ok(format!("{{{{Param.OutputDir}}}}/{TILES}/{}.{{tile}}.exr", literal(&stem.to_string_lossy())?))
    }
}

/// Does the option say how the joined picture is written?
fn of_joined(word: &Word) -> bool {
    matches!(word.option.as_str(), "--half" | "--bits")
}

/// A text of one line that stands for itself in a template.
fn literal(text: &str) -> Result<String, Failure> {
    match text.contains('\n') {
        true => Err(control_character(text, "Rename it.")),
        false => literal_lines(text),
    }
}

/// A text that stands for itself in a template. Lines of a program may follow each other in one argument.
fn literal_lines(text: &str) -> Result<String, Failure> {
    if text.contains("{{") || text.contains("}}") {
        let message = format!("`{text}` cannot be part of a job, where `{{{{` and `}}}}` enclose parameters");
        return Err(Failure::usage(message).hint("Rename it, or put the program's line into a file."));
    }
    match text.chars().find(|c| c.is_control() && *c != '\n') {
        Some('\t') => {
            Err(control_character(text, "Replace it by spaces, or put a line of the program into a file."))
        }
        Some(_) => Err(control_character(text, "Rename it, or put the line of the program into a file.")),
        None => Ok(text.to_string()),
    }
}

fn control_character(text: &str, hint: &str) -> Failure {
    let message = format!("`{}` cannot be part of a job: it has a control character", text.escape_debug());
    Failure::usage(message).hint(hint)
}

fn fits(words: Vec<String>) -> Result<Vec<String>, Failure> {
    match words.iter().find(|w| w.len() > LONGEST[0]) {
        Some(word) => {
            let start: String = word.chars().take(40).collect();
            Err(Failure::usage(format!("`{start}…` is too long for a job"))
                .hint("Put it into the program's file."))
        }
        None => Ok(words),
    }
}

/// The images that the job runs on.
#[derive(Default)]
pub(super) struct Inputs {
    /// What stands behind each `--input`.
    words: Vec<String>,
    /// What stands behind `--mesh`.
    mesh: Option<String>,
    /// The folders: the name of the parameter, and where it is here.
    folders: Vec<(String, PathBuf)>,
}

impl Inputs {
    /// A parameter for each folder that images or the mesh lie in.
    pub fn of(args: &[InputArg], mesh: Option<&str>) -> Result<Inputs, Failure> {
        let mut inputs = Inputs::default();
        for arg in args {
            let name = arg.name.as_ref().map_or(String::new(), |name| format!("{name}="));
            let file = inputs.place(&arg.path)?;
            inputs.words.push(name + &file);
        }
        // The built-in head is no file.
        inputs.mesh = match mesh {
            Some(path) if path == "head" && !Path::new(path).exists() => Some(path.into()),
            mesh => mesh.map(|path| inputs.place(path)).transpose()?,
        };
        Ok(inputs)
    }

    /// The file as the job names it, below a parameter for its folder.
    fn place(&mut self, given: &str) -> Result<String, Failure> {
        let path = pse::internal::host::absolute(Path::new(given));
        let (Some(folder), Some(file)) = (path.parent(), path.file_name()) else {
            return Err(Failure::usage(format!("`{given}` is not a file")));
        };
        // Folders have the number only beside a name with it.
        let filled = PathBuf::from(frames::fill(&path.to_string_lossy(), 1));
        if filled.parent() != Some(folder) {
            return Err(Failure::usage(format!("a folder of `{given}` has a frame number in its name"))
                .hint("In a job only the file name can contain it."));
        }
        let place = self.folders.iter().position(|(_, known)| known == folder).unwrap_or_else(|| {
            let number = self.folders.len() + 1;
            let name = if number == 1 { "InputDir".into() } else { format!("InputDir{number}") };
            self.folders.push((name, folder.to_path_buf()));
            number - 1
        });
        literal(&folder.to_string_lossy())?;
        let file = literal(&file.to_string_lossy())?;
        Ok(format!("{{{{Param.{}}}}}/{file}", self.folders[place].0))
    }

    /// The parameters and their folders.
    pub fn folders(&self) -> impl Iterator<Item = (&str, &Path)> {
        self.folders.iter().map(|(name, folder)| (name.as_str(), folder.as_path()))
    }

    /// The file of their values, as Deadline Cloud reads it beside the template.
    pub fn values(&self) -> Option<String> {
        let value =
            |(name, folder): (&str, &Path)| json!({ "name": name, "value": folder.to_string_lossy() });
        let values: Vec<Value> = self.folders().map(value).collect();
        (!values.is_empty()).then(|| format!("{:#}\n", json!({ "parameterValues": values })))
    }
}
