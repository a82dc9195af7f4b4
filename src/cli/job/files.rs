//! The files that a program is made of, copied into a bundle so that it runs anywhere.

use super::super::failure::{Failure, why};
use super::super::run::{Plan, RunArgs};
use super::super::source;
use super::manifest::Manifest;
use pse::internal::files::{self, Folders};
use pse::internal::host::absolute;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The bundle's folder of the program.
pub(super) const FOLDER: &str = "program";

/// Which files go where. Folders that imports and textures are looked for in keep their order.
pub(super) struct Files {
    /// The program's name in its folder; `None` if its lines are given as they are.
    pub program: Option<String>,
    /// From the place in the bundle's folder to the file.
    copies: BTreeMap<PathBuf, PathBuf>,
    /// The program's own file, which may be a link to anywhere.
    own: Option<PathBuf>,
    /// Where all others lie.
    readable: Folders,
    /// How many folders of `--path` there are.
    folders: usize,
    /// The images and the mesh that the job runs on, which are not copied.
    inputs: Vec<PathBuf>,
}

impl Files {
    /// The program's own text, what it imports, and the images that it looks up in any of the frames.
    pub fn of(run: &RunArgs, plan: &Plan) -> Result<Files, Failure> {
        let own = run.program.program.as_deref();
        let beside = own.and_then(Path::parent).unwrap_or(Path::new(""));
        let folders = run.program.path.iter().enumerate().map(|(i, path)| (absolute(path), folder(i)));
        let roots: Vec<(PathBuf, PathBuf)> =
            std::iter::once((absolute(beside), PathBuf::new())).chain(folders).collect();
        let mut copies = BTreeMap::new();
        let moving = plan.program.has_texture_sequence();
        let frames = if moving { &plan.frames[..] } else { &plan.frames[..1] };
        for file in frames.iter().flat_map(|frame| plan.program.files(*frame)) {
            if own.is_none() && !file.exists() {
                // The lines themselves.
                continue;
            }
            let whole = absolute(&file);
            // It is found in the first of several folders, but may be so called from any.
            let places: Vec<PathBuf> = roots
                .iter()
                .filter_map(|(root, place)| Some(place.join(whole.strip_prefix(root).ok()?)))
                .collect();
            if places.is_empty() {
                let shown = file.display();
                return Err(Failure::plain(format!("`{shown}` is outside the program's folders"))
                    .hint("A bundle contains the program's folder and the folders of --path. Name this file's folder with --path, and import it without `..`."));
            }
            copies.extend(places.into_iter().map(|place| (place, file.clone())));
        }
        let program = own.and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
        let inputs = run.images.paths().map(PathBuf::from).collect();
        let path = &run.program.path;
        let readable = Folders::new(std::iter::once(beside).chain(path.iter().map(PathBuf::as_path)));
        let own = own.map(Path::to_path_buf);
        Ok(Files { program, copies, own, readable, folders: path.len(), inputs })
    }

    /// Refuses sources that lie in the bundle, which would be replaced by their own copies, or removed. Pictures of its
    /// output may be run on.
    pub fn check_outside(&self, bundle: &Path) -> Result<(), Failure> {
        let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| absolute(path));
        let bundle = whole(bundle);
        let output = bundle.join("output");
        // An input with the frame's number in its name is no file by itself.
        let inputs = self.inputs.iter().map(|path| match path.parent().zip(path.file_name()) {
            Some((folder, name)) => whole(folder).join(name),
            None => whole(path),
        });
        let inputs = inputs.filter(|path| !path.starts_with(&output));
        let sources = self.copies.values().map(|path| whole(path)).chain(inputs);
        match sources.into_iter().find(|path| path.starts_with(&bundle)) {
            Some(path) => Err(Failure::plain(format!("`{}` is in the folder of the bundle", path.display()))
                .hint("Give another folder with -o, or the original of that file.")),
            None => Ok(()),
        }
    }

    /// The folders of `--path`, below the bundle's folder; its own too, if the program does not lie in it.
    pub fn paths(&self) -> Vec<String> {
        let own = self.program.is_none() && !self.copies.is_empty();
        let folders = (0..self.folders).map(|i| folder(i).display().to_string());
        own.then(String::new).into_iter().chain(folders).collect()
    }

    /// The places in the bundle of all that is copied, and of the folders.
    pub fn list(&self) -> Manifest {
        let mut list = Manifest::default();
        self.copies.keys().for_each(|place| list.add_place(&Path::new(FOLDER).join(place)));
        list.folders.extend((0..self.folders).map(|i| Path::new(FOLDER).join(folder(i))));
        if !list.folders.is_empty() {
            list.folders.insert(FOLDER.into());
        }
        list
    }

    /// Copies them into a folder, and looks whether the program is whole there.
    pub fn copy(&self, bundle: &Path) -> Result<(), Failure> {
        let folder = bundle.join(FOLDER);
        let fail = |what: &str, path: &Path, e: &std::io::Error| {
            Failure::plain(format!("cannot {what} `{}`: {}", path.display(), why(e)))
        };
        // An empty folder is a folder too: --path names it.
        let made = (0..self.folders).map(|i| folder.join(self::folder(i))).collect::<Vec<_>>();
        for (place, from) in &self.copies {
            let to = folder.join(place);
            std::fs::create_dir_all(to.parent().unwrap_or(&folder)).map_err(|e| fail("write", place, &e))?;
            let source = match self.own.as_ref() == Some(from) {
                true => files::given(from),
                false => self.readable.open(from),
            };
            let mut source = source.map_err(|e| fail("read", from, &e))?;
            let copied = std::fs::File::create(&to).and_then(|mut to| std::io::copy(&mut source, &mut to));
            copied.map_err(|e| fail("write a copy of", from, &e))?;
        }
        for path in &made {
            std::fs::create_dir_all(path).map_err(|e| fail("make the folder", path, &e))?;
        }
        let Some(name) = &self.program else { return Ok(()) };
        let (name, text) = source::read(&folder.join(name))?;
        source::compile(&name, &text, &made).map(drop).map_err(|_| {
            Failure::plain("the program would not find all of its files in a bundle").hint(
                "A bundle contains the program's folder, and each folder of --path separately. Name files without `..`, and folders with --path.",
            )
        })
    }
}

/// The folder in the bundle that stands for one of `--path`.
fn folder(number: usize) -> PathBuf {
    format!("path-{}", number + 1).into()
}
