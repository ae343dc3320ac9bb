//! The files of a run: each read and hashed once, and let go of when no node needs it any more.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::files::FileSource;
use crate::value::Digest;

/// A file as a run knows it.
pub(crate) enum FileState {
    /// Being read.
    Pending,
    /// Read: its digest, and its contents while some node may need them.
    Known { digest: Digest, contents: Option<Arc<Vec<u8>>>, reading: bool },
    /// Unreadable.
    Failed(String),
}

/// What reading a file brought.
pub(crate) type FileRead = Result<(Digest, Arc<Vec<u8>>), String>;

/// Reads and hashes a file.
pub(crate) fn read(source: &dyn FileSource, path: &str) -> FileRead {
    match source.read(path) {
        Ok(contents) => Ok((Digest::of(&contents), contents)),
        Err(error) => Err(format!("cannot read `{path}`: {error}")),
    }
}

#[derive(Default)]
pub(crate) struct Files(BTreeMap<String, FileState>);

impl Files {
    /// Notes that a file is wanted; true if somebody has to read it now.
    pub fn want_digest(&mut self, path: &str) -> bool {
        if self.0.contains_key(path) {
            return false;
        }
        self.0.insert(path.to_owned(), FileState::Pending);
        true
    }

    /// Notes that a file's contents are wanted; true if somebody has to read it again.
    pub fn want_contents(&mut self, path: &str) -> bool {
        match self.0.get_mut(path) {
            Some(FileState::Known { contents: None, reading, .. }) if !*reading => {
                *reading = true;
                true
            }
            _ => false,
        }
    }

    pub fn done(&mut self, path: &str, read: FileRead) {
        let before = match self.0.get(path) {
            Some(FileState::Known { digest, .. }) => Some(*digest),
            _ => None,
        };
        let state = match read {
            Ok((digest, _)) if before.is_some_and(|before| before != digest) => {
                FileState::Failed(format!("`{path}` changed while it was in use"))
            }
            Ok((digest, contents)) => FileState::Known { digest, contents: Some(contents), reading: false },
            Err(message) => FileState::Failed(message),
        };
        self.0.insert(path.to_owned(), state);
    }

    pub fn get(&self, path: &str) -> Option<&FileState> {
        self.0.get(path)
    }

    /// Lets go of the contents of all files but these.
    pub fn release(&mut self, keep: impl Fn(&str) -> bool) {
        for (path, state) in &mut self.0 {
            if let FileState::Known { contents, .. } = state
                && !keep(path)
            {
                *contents = None;
            }
        }
    }
}
