//! The documents that are open, and the disk behind them.

use super::position::{Encoding, Lines};
use super::uri;
use gen_lsp_types::{Position, TextDocumentContentChangeEvent as Change, Uri};
use pse::Origin;
use pse::internal::assist::Reading;
use pse::internal::host::{Disk, Host, clean};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A document that is open in the editor.
pub(super) struct Document {
    /// What programs and messages call it: its path, or for an unsaved one its name in the editor's folder.
    pub name: String,
    /// Its text as it is now.
    pub text: String,
    /// The editor's number of this text.
    pub version: i32,
    /// What was made of the text.
    reading: Option<Arc<Reading>>,
}

/// All of them, and how to find others.
#[derive(Default)]
pub(super) struct Documents {
    /// By the URI that the editor gave, in a fixed order.
    pub open: BTreeMap<String, Document>,
    /// How columns are counted.
    pub encoding: Encoding,
    /// The editor's folder, where unsaved documents count as being.
    pub root: Option<PathBuf>,
    /// Folders for imports, after the importing file's own.
    pub path: Vec<PathBuf>,
}

impl Documents {
    /// Takes a new document, or a whole new text for one.
    pub fn put(&mut self, uri: &Uri, version: i32, text: String) {
        let name = match uri::path(uri) {
            Some(path) => path,
            None => {
                let name = uri.0.split_once(':').map_or(&uri.0[..], |(_, rest)| rest);
                self.root.clone().unwrap_or_default().join(name.trim_start_matches('/'))
            }
        };
        let name = name.display().to_string();
        self.open.insert(uri.0.clone(), Document { name, text, version, reading: None });
        self.forget();
    }

    /// Takes what has changed in a document. Gives the documents that may mean something else now.
    pub fn change(&mut self, uri: &Uri, version: i32, changes: Vec<Change>) -> Vec<String> {
        let affected = self.importers(uri);
        let encoding = self.encoding;
        let Some(document) = self.open.get_mut(&uri.0) else { return Vec::new() };
        for change in changes {
            match change {
                Change::TextDocumentContentChangeWholeDocument(whole) => document.text = whole.text,
                Change::TextDocumentContentChangePartial(part) => {
                    let lines = Lines::new(&document.text, encoding);
                    let (start, end) = (lines.offset(part.range.start), lines.offset(part.range.end));
                    document.text.replace_range(start..end.max(start), &part.text);
                }
            }
        }
        document.version = version;
        for uri in &affected {
            if let Some(document) = self.open.get_mut(uri) {
                document.reading = None;
            }
        }
        affected
    }

    /// What was made of any text may be wrong now.
    pub fn forget(&mut self) {
        self.open.values_mut().for_each(|document| document.reading = None);
    }

    /// The document itself, and those that import it.
    pub fn importers(&mut self, uri: &Uri) -> Vec<String> {
        let Some(changed) = self.open.get(&uri.0) else { return Vec::new() };
        let changed = clean(Path::new(&changed.name));
        let uris: Vec<String> = self.open.keys().cloned().collect();
        let imports =
            |reading: &Reading| reading.imported_files().any(|file| clean(Path::new(file)) == changed);
        uris.into_iter()
            .filter(|other| *other == uri.0 || self.reading(other).is_some_and(|reading| imports(&reading)))
            .collect()
    }

    /// A document, read.
    pub fn reading(&mut self, uri: &str) -> Option<Arc<Reading>> {
        let document = self.open.get(uri)?;
        if let Some(reading) = &document.reading {
            return Some(reading.clone());
        }
        let reading = Arc::new(Reading::new(&document.name, &document.text, &self.host()));
        self.open.get_mut(uri)?.reading = Some(reading.clone());
        Some(reading)
    }

    /// A document, read, and the byte of a position in it.
    pub fn at(&mut self, uri: &Uri, position: Position) -> Option<(Arc<Reading>, usize)> {
        let reading = self.reading(&uri.0)?;
        let offset = self.lines(reading.text()).offset(position);
        Some((reading, offset))
    }

    /// A text's lines, as this editor counts their columns.
    pub fn lines<'a>(&self, text: &'a str) -> Lines<'a> {
        Lines::new(text, self.encoding)
    }

    /// The URI of a text that a program is made of: an open document's, or a file's. `None` for what is no file.
    pub fn uri(&self, name: &str) -> Option<Uri> {
        let path = clean(Path::new(name));
        let open = self.open.iter().find(|(_, document)| clean(Path::new(&document.name)) == path);
        match open {
            Some((uri, _)) => Some(Uri(uri.clone())),
            None => path.is_file().then(|| uri::of(&path)),
        }
    }

    /// Where programs find files.
    pub fn host(&self) -> Overlay<'_> {
        Overlay { documents: &self.open, disk: Disk { path: self.path.clone() } }
    }
}

/// The disk, with open documents in the place of their files.
pub(super) struct Overlay<'a> {
    documents: &'a BTreeMap<String, Document>,
    disk: Disk,
}

impl Host for Overlay<'_> {
    fn import(&self, importing: &str, path: &str) -> Result<(String, String), pse::HostError> {
        self.disk.find(importing, path, &|file| {
            let open = self.documents.values().find(|d| clean(Path::new(&d.name)) == *file);
            open.map(|document| document.text.clone())
        })
    }

    fn hint(&self) -> Option<String> {
        self.disk.hint()
    }

    fn image(&self, program: &str, name: &str) -> Result<Origin, pse::HostError> {
        self.disk.image(program, name)
    }

    fn images(&self, program: &str, name: &str) -> Vec<String> {
        self.disk.images(program, name)
    }

    fn image_hint(&self) -> Option<String> {
        self.disk.image_hint()
    }
}
