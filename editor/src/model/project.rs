//! A document that is open: where it is kept, what was done to it, and whether it is saved.

use std::path::{Path, PathBuf};

use breccia_engine::Document;

use super::history::History;
use super::state::State;

/// An open document.
pub struct Project {
    state: State,
    history: History,
    /// The file it is kept in.
    pub path: Option<PathBuf>,
    /// What it is called if it has no file: a preset's name, or nothing.
    pub origin: Option<String>,
    /// Raised by every change.
    revision: u64,
    /// Raised by every change that can change what a run brings.
    content: u64,
}

impl Project {
    /// Opens a document.
    pub fn new(state: State, path: Option<PathBuf>, origin: Option<String>) -> Self {
        Self { state, history: History::new(), path, origin, revision: 0, content: 0 }
    }

    /// What can be edited.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Changes whenever the state does.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Changes whenever something changes that a run could notice: not where nodes lie.
    pub fn content(&self) -> u64 {
        self.content
    }

    /// Does something, as one step under a name. Steps with the same `merge` that follow each other are one.
    pub fn edit<T>(&mut self, name: &str, merge: Option<&str>, change: impl FnOnce(&mut State) -> T) -> T {
        let before = self.state.clone();
        let answer = change(&mut self.state);
        if self.history.record(name, merge, &before, &self.state) {
            let matters = matters(&before, &self.state);
            self.touched(matters);
        }
        answer
    }

    /// Does something that may not be possible, as one step under a name; if it is not, all stays as it was.
    ///
    /// # Errors
    /// Those of the change.
    pub fn try_edit<T, E>(
        &mut self,
        name: &str,
        change: impl FnOnce(&mut State) -> Result<T, E>,
    ) -> Result<T, E> {
        self.edit(name, None, |state| {
            let before = state.clone();
            let answer = change(state);
            if answer.is_err() {
                *state = before;
            }
            answer
        })
    }

    /// Changes what is no step of its own: places of nodes that had none.
    pub fn settle(&mut self, change: impl FnOnce(&mut State)) {
        change(&mut self.state);
        self.revision += 1;
    }

    /// Changes the document in a way that is no step of its own and holds for all that can be undone as well: its paths, when it is
    /// kept elsewhere.
    pub fn rewrite_files(&mut self, change: impl Fn(&mut State)) {
        self.history.rewrite_files(&self.state, &change);
        change(&mut self.state);
        self.revision += 1;
    }

    fn touched(&mut self, content: bool) {
        self.revision += 1;
        self.content += u64::from(content);
    }

    /// Ends a drag.
    pub fn seal(&mut self) {
        self.history.seal();
    }

    /// Undoes the last step; returns its name.
    pub fn undo(&mut self) -> Option<String> {
        let before = self.state.clone();
        let name = self.history.undo(&mut self.state)?.to_owned();
        let matters = matters(&before, &self.state);
        self.touched(matters);
        Some(name)
    }

    /// Does the last undone step again; returns its name.
    pub fn redo(&mut self) -> Option<String> {
        let before = self.state.clone();
        let name = self.history.redo(&mut self.state)?.to_owned();
        let matters = matters(&before, &self.state);
        self.touched(matters);
        Some(name)
    }

    /// What was done and undone.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Whether there is something to save.
    pub fn is_dirty(&self) -> bool {
        !self.history.is_saved()
    }

    /// Notes that it is saved now, in this file.
    pub fn saved(&mut self, path: &Path) {
        self.history.saved();
        self.path = Some(path.to_owned());
        self.origin = None;
    }

    /// Notes that it is not saved anywhere.
    pub fn unsaved(&mut self) {
        self.history.unsaved();
    }

    /// The folder that its relative paths begin at.
    pub fn folder(&self) -> Option<&Path> {
        self.path.as_deref().and_then(Path::parent)
    }

    /// What stands in the window's title.
    pub fn name(&self) -> String {
        let file =
            self.path.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
        file.or_else(|| self.origin.clone()).unwrap_or_else(|| "untitled".to_owned())
    }
}

/// Whether two states differ in something that a run, or what nodes look like, could notice.
fn matters(a: &State, b: &State) -> bool {
    let (a, b) = (&a.document, &b.document);
    a.nodes != b.nodes || a.links != b.links || a.interface != b.interface || a.groups != b.groups
}

/// The text of a state, as it is saved.
pub fn text_of(state: &State) -> String {
    let document: Document = state.to_document();
    document.to_ron()
}
