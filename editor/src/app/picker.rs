//! Asking for files with the system's own dialogs, without waiting for the answer.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};
use std::time::Instant;

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
    /// A file for a parameter: node, parameter, extensions.
    Param(String, String, Vec<String>),
    /// A file for a result: its output, and the extensions that its type can be written to.
    Output(String, Vec<String>),
    /// A file, or a folder for several, for what the viewport made.
    Made(Vec<(String, Vec<u8>)>),
}

/// An answer that is waited for.
pub struct Picked {
    /// What was asked for.
    pub want: Want,
    /// Where the answer comes: a path, or none if the user thought better of it.
    pub answer: Receiver<Option<PathBuf>>,
    /// When it was asked for.
    pub asked: Instant,
}

/// Something that asks the user for a file.
pub trait Picker {
    /// Asks.
    fn ask(&self, want: &Want) -> Receiver<Option<PathBuf>>;
}

/// The system's dialogs.
pub struct NativePicker;

impl Picker for NativePicker {
    fn ask(&self, want: &Want) -> Receiver<Option<PathBuf>> {
        let (sender, receiver) = channel();
        let want = want.clone();
        // A dialog may stand open for minutes; the window goes on.
        std::thread::spawn(move || {
            let dialog = rfd::FileDialog::new();
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
                Want::Param(_, _, extensions) => {
                    let extensions = if extensions.is_empty() { strings(&["*"]) } else { extensions.clone() };
                    dialog.set_title("Pick a file").add_filter("Files", &extensions).pick_file()
                }
                Want::Output(name, extensions) => {
                    let dialog = extensions
                        .iter()
                        .fold(dialog, |dialog, e| dialog.add_filter(e.clone(), std::slice::from_ref(e)));
                    let extension = extensions.first().map_or("bin", String::as_str);
                    dialog
                        .set_title("Export a result")
                        .set_file_name(format!("{name}.{extension}"))
                        .save_file()
                }
                Want::Made(files) => match files.as_slice() {
                    [(name, _)] => dialog.set_title("Save").set_file_name(name).save_file(),
                    _ => dialog.set_title("Save into a folder").pick_folder(),
                },
            };
            // The window may be closed by now.
            let _ = sender.send(found);
        });
        receiver
    }
}
