//! The files that were open last.

use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::state;
use super::whole::write_private;

/// How many files are remembered.
pub const MOST: usize = 20;

/// The name of the list in the state folder.
const NAME: &str = "recent.ron";

/// The files that were open last, the newest first. Files that are not there any more stay in the list: they may lie
/// on a drive that is not there now.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Recent {
    files: Vec<PathBuf>,
}

impl Recent {
    /// Reads the list from the state folder. A list that is not there or damaged is an empty one.
    pub fn load(folder: &Path) -> Self {
        let text = state::read_text(&folder.join(NAME)).unwrap_or_default();
        let mut list: Self = ron::from_str(&text).unwrap_or_default();
        let mut seen = Vec::new();
        list.files.retain(|file| {
            let is_new = !seen.contains(file);
            seen.push(file.clone());
            is_new
        });
        list.files.truncate(MOST);
        list
    }

    /// Writes the list into the state folder.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn save(&self, folder: &Path) -> io::Result<()> {
        let text = ron::to_string(self).map_err(io::Error::other)?;
        write_private(&folder.join(NAME), text.as_bytes())
    }

    /// The files, the newest first.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// A file was opened or saved. Paths that are no text are not remembered.
    pub fn add(&mut self, file: &Path) {
        let file = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        if file.to_str().is_none() {
            return;
        }
        self.remove(&file);
        self.files.insert(0, file);
        self.files.truncate(MOST);
    }

    /// Takes a file out of the list.
    pub fn remove(&mut self, file: &Path) {
        self.files.retain(|known| known != file);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_comes_first_and_none_twice() {
        let mut recent = Recent::default();
        for name in ["/a", "/b", "/c", "/a"] {
            recent.add(Path::new(name));
        }
        assert_eq!(recent.files(), ["/a", "/c", "/b"].map(PathBuf::from));
        recent.remove(Path::new("/c"));
        assert_eq!(recent.files(), ["/a", "/b"].map(PathBuf::from));
        for i in 0..2 * MOST {
            recent.add(Path::new(&format!("/{i}")));
        }
        assert_eq!(recent.files().len(), MOST);
        assert_eq!(recent.files()[0], Path::new("/39"));
    }

    #[test]
    fn what_is_saved_is_loaded() {
        let folder = tempfile::tempdir().unwrap();
        let state = folder.path().join("not/there/yet");
        assert_eq!(Recent::load(&state), Recent::default());
        let mut recent = Recent::default();
        recent.add(Path::new("/with \"quotes\" and ü"));
        recent.add(Path::new("relative.ron"));
        assert!(recent.files()[0].is_absolute());
        recent.save(&state).unwrap();
        assert_eq!(Recent::load(&state), recent);
    }

    #[test]
    fn a_damaged_list_is_empty() {
        let folder = tempfile::tempdir().unwrap();
        for text in ["", "[1, 2]", "[\"/a\"", "\u{0}"] {
            std::fs::write(folder.path().join(NAME), text).unwrap();
            assert_eq!(Recent::load(folder.path()), Recent::default(), "{text}");
        }
        std::fs::write(folder.path().join(NAME), "[\"/a\", \"/b\", \"/a\"]").unwrap();
        assert_eq!(Recent::load(folder.path()).files().len(), 2);
    }
}
