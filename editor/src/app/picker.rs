//! Asking for files with the system's own dialogs, without waiting for the answer.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::Instant;

use super::ears::Ears;
use crate::model::Address;

/// What a file is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Want {
    /// A graph to open.
    Open,
    /// A file to save the graph in.
    Save(String),
    /// A bundle to open.
    Import,
    /// A file to pack the graph into.
    Export(String),
    /// A file for a parameter.
    Param {
        /// Where the node stands.
        at: Address,
        /// The node.
        node: String,
        /// Its parameter.
        param: String,
        /// What can be read.
        extensions: Vec<String>,
    },
    /// A file for a result: its output, and the extensions that its type can be written to.
    Output(String, Vec<String>),
    /// A file, or a folder for several, for what the viewport made.
    Made(Vec<(String, Vec<u8>)>),
}

impl Want {
    /// Whether the answer means nothing to any other document than the one that was open when it was asked for.
    pub fn is_about_the_document(&self) -> bool {
        !matches!(self, Self::Open | Self::Import | Self::Made(_))
    }

    /// Whether a file is written.
    pub fn writes(&self) -> bool {
        matches!(self, Self::Save(_) | Self::Export(_) | Self::Output(..) | Self::Made(_))
    }

    /// The names of the files, if they are several, which go into a folder.
    pub fn several(&self) -> Option<impl Iterator<Item = &str>> {
        match self {
            Self::Made(files) if files.len() > 1 => Some(files.iter().map(|(name, _)| name.as_str())),
            _ => None,
        }
    }

    /// What the file of a result is called if nobody says otherwise.
    pub fn name_of_result(output: &str, extensions: &[String]) -> String {
        let name = output.rsplit(['/', '.']).next().unwrap_or("result");
        format!("{name}.{}", extensions.first().map_or("bin", String::as_str))
    }

    /// The path with the extension that somebody left out. Not every dialog adds one.
    pub fn complete(&self, path: &Path) -> PathBuf {
        let extension = match self {
            Self::Save(_) => Some("ron"),
            Self::Export(_) => Some("zip"),
            Self::Output(_, extensions) => extensions.first().map(String::as_str),
            Self::Made(files) => match files.as_slice() {
                [(name, _)] => Path::new(name).extension().and_then(|extension| extension.to_str()),
                _ => None,
            },
            Self::Open | Self::Import | Self::Param { .. } => None,
        };
        match extension {
            Some(extension) if path.extension().is_none() => path.with_extension(extension),
            _ => path.to_owned(),
        }
    }
}

/// An answer that is waited for.
pub struct Picked {
    /// What was asked for.
    pub want: Want,
    /// Where the answer comes: a path, or none if the user thought better of it. It breaks off if there is no dialog.
    pub answer: Receiver<Option<PathBuf>>,
    /// When it was asked for.
    pub asked: Instant,
}

/// Something that asks the user for a file.
pub trait Picker {
    /// Asks, beginning in a folder.
    fn ask(&self, want: &Want, folder: Option<&Path>) -> Receiver<Option<PathBuf>>;
}

/// The system's dialogs.
pub struct NativePicker;

impl Picker for NativePicker {
    fn ask(&self, want: &Want, folder: Option<&Path>) -> Receiver<Option<PathBuf>> {
        let (sender, receiver) = channel();
        let want = want.clone();
        let folder = folder.filter(|folder| folder.is_dir()).map(Path::to_owned);
        // A dialog may stand open for minutes; the window goes on.
        std::thread::spawn(move || {
            let ears = Ears::open();
            let dialog = rfd::FileDialog::new();
            let dialog = match folder {
                Some(folder) => dialog.set_directory(folder),
                None => dialog,
            };
            let strings = |list: &[&str]| list.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();
            let found = match &want {
                Want::Open => dialog.set_title("Open a graph").add_filter("Graphs", &["ron"]).pick_file(),
                Want::Save(name) => dialog
                    .set_title("Save the graph")
                    .set_file_name(name)
                    .add_filter("Graphs", &["ron"])
                    .save_file(),
                Want::Import => {
                    dialog.set_title("Import a bundle").add_filter("Bundles", &["zip"]).pick_file()
                }
                Want::Export(name) => dialog
                    .set_title("Export a bundle")
                    .set_file_name(name)
                    .add_filter("Bundles", &["zip"])
                    .save_file(),
                Want::Param { extensions, .. } => {
                    let extensions = if extensions.is_empty() { strings(&["*"]) } else { extensions.clone() };
                    dialog.set_title("Pick a file").add_filter("Files", &extensions).pick_file()
                }
                Want::Output(output, extensions) => {
                    let name = Want::name_of_result(output, extensions);
                    let dialog = extensions
                        .iter()
                        .fold(dialog, |dialog, e| dialog.add_filter(e.clone(), std::slice::from_ref(e)));
                    dialog.set_title("Export a result").set_file_name(name).save_file()
                }
                Want::Made(files) => match files.as_slice() {
                    [(name, _)] => dialog.set_title("Save").set_file_name(name).save_file(),
                    _ => dialog.set_title("Save into a folder").pick_folder(),
                },
            };
            if found.is_none() && ears.heard() {
                return;
            }
            // The window may be closed by now.
            let _ = sender.send(found);
        });
        receiver
    }
}
