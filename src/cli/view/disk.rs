//! What the program's file holds: looked at when it changes, and before it is replaced.

use pse::internal::files;
use pse::internal::host::read_text;
use pse::internal::syntax::MAX_TEXT;
use std::io::{self, ErrorKind};
use std::path::Path;
use std::time::SystemTime;

/// What stands at the program's path.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum OnDisk {
    /// Nothing, or a link that leads to nothing.
    Missing,
    /// A text.
    Text {
        /// With line feeds alone.
        text: String,
        /// Whether its lines end as those of Windows do.
        windows: bool,
    },
    /// A regular file that is no program's text.
    Unreadable {
        /// Why, as a clause.
        why: String,
        /// Its length and time, by which another change of it is seen.
        stamp: (u64, Option<SystemTime>),
    },
    /// A folder, a pipe, a device: what is never replaced.
    NoFile {
        /// What it is, as a clause.
        why: String,
    },
}

impl OnDisk {
    /// Looks. Nothing is waited for, and no more is read than a program may have.
    pub fn read(path: &Path) -> OnDisk {
        let about = match std::fs::metadata(path) {
            Ok(about) => about,
            Err(error) if error.kind() == ErrorKind::NotFound => return OnDisk::Missing,
            Err(error) => return OnDisk::NoFile { why: reason(&error) },
        };
        let text = match files::regular(path) {
            Ok(file) if file.metadata().is_ok_and(|about| about.len() > MAX_TEXT as u64) => {
                Err(io::Error::other(format!("it is longer than {} MiB", MAX_TEXT >> 20)))
            }
            Ok(file) => read_text(file),
            // It went away just now.
            Err(error) if error.kind() == ErrorKind::NotFound => return OnDisk::Missing,
            Err(error) if !about.is_file() => return OnDisk::NoFile { why: reason(&error) },
            Err(error) => Err(error),
        };
        match text {
            Ok(text) => {
                let windows = text.contains("\r\n");
                OnDisk::Text { text: if windows { text.replace("\r\n", "\n") } else { text }, windows }
            }
            Err(error) => {
                let stamp = (about.len(), about.modified().ok());
                OnDisk::Unreadable { why: reason(&error), stamp }
            }
        }
    }

    /// Its text, if it has one.
    pub fn text(&self) -> Option<&str> {
        match self {
            OnDisk::Text { text, .. } => Some(text),
            _ => None,
        }
    }

    /// Why it cannot be taken or replaced as it is, as a sentence.
    pub fn trouble(&self) -> String {
        match self {
            OnDisk::Missing => "the file was removed by another program, and was not written again".into(),
            OnDisk::Text { .. } => "the file was changed by another program, and was not replaced".into(),
            OnDisk::Unreadable { why, .. } => {
                format!(
                    "the file was changed by another program and cannot be read ({why}); it was not replaced"
                )
            }
            OnDisk::NoFile { why } => {
                format!("the file was changed by another program: {why}. Save under another name")
            }
        }
    }
}

fn reason(error: &io::Error) -> String {
    crate::cli::failure::why(error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn whatever_stands_there_is_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.pse");
        assert_eq!(OnDisk::read(&path), OnDisk::Missing);
        fs::write(&path, "a\r\nb\r\n").unwrap();
        assert_eq!(OnDisk::read(&path), OnDisk::Text { text: "a\nb\n".into(), windows: true });
        fs::write(&path, b"\xff\xfe").unwrap();
        let OnDisk::Unreadable { why, stamp } = OnDisk::read(&path) else { panic!("it is no text") };
        assert!(why.contains("UTF-8") && stamp.0 == 2, "{why}");
        let long = fs::File::create(&path).unwrap();
        long.set_len(MAX_TEXT as u64 + 1).unwrap();
        assert!(
            matches!(OnDisk::read(&path), OnDisk::Unreadable { why, .. } if why.contains("longer than 16 MiB"))
        );
        fs::remove_file(&path).unwrap();
        fs::create_dir(&path).unwrap();
        assert!(matches!(OnDisk::read(&path), OnDisk::NoFile { why } if why.contains("directory")));
        #[cfg(unix)]
        {
            fs::remove_dir(&path).unwrap();
            std::os::unix::fs::symlink("/dev/zero", &path).unwrap();
            assert!(matches!(OnDisk::read(&path), OnDisk::NoFile { why } if why.contains("device")));
        }
    }
}
