//! Groups that the user keeps, to be used in any graph.

use std::path::PathBuf;

use breccia_engine::{Document, Group};

/// The user's groups, each a document in a folder.
#[derive(Clone, Debug)]
pub struct Library {
    folder: Option<PathBuf>,
}

impl Library {
    /// The groups in the folder of what is remembered.
    pub fn new(state: Option<PathBuf>) -> Self {
        Self { folder: state.map(|state| state.join("groups")) }
    }

    fn path(&self, name: &str) -> Option<PathBuf> {
        let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-');
        let fits = !name.is_empty() && name.chars().all(plain);
        self.folder.as_ref().filter(|_| fits).map(|folder| folder.join(format!("{name}.ron")))
    }

    /// Names and docs, sorted. Files that are no documents are left out.
    pub fn list(&self) -> Vec<(String, String)> {
        let Some(entries) = self.folder.as_ref().and_then(|folder| std::fs::read_dir(folder).ok()) else {
            return Vec::new();
        };
        let names = entries.flatten().filter_map(|entry| {
            let path = entry.path();
            let is_graph = path.extension().is_some_and(|extension| extension == "ron");
            is_graph.then(|| path.file_stem().map(|stem| stem.to_string_lossy().into_owned())).flatten()
        });
        let mut found: Vec<_> =
            names.filter_map(|name| Some((name.clone(), self.group(&name).ok()?.docs))).collect();
        found.sort();
        found
    }

    /// A group by name.
    ///
    /// # Errors
    /// If there is none, or it cannot be read.
    pub fn group(&self, name: &str) -> Result<Group, String> {
        let path = self.path(name).ok_or_else(|| format!("`{name}` is no name of a group"))?;
        let bytes = std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let document =
            Document::parse_bytes(&bytes).map_err(|error| format!("{}: {error}", path.display()))?;
        let Document { docs, interface, nodes, links, groups, .. } = document;
        Ok(Group { docs, interface, nodes, links, groups, ..Group::default() })
    }

    /// Keeps a group under a name, in the place of one that was there.
    ///
    /// # Errors
    /// If the name is no name, or the file cannot be written.
    pub fn keep(&self, name: &str, group: &Group) -> Result<(), String> {
        let path = self.path(name).ok_or_else(|| format!("`{name}` is no name of a group"))?;
        let Group { docs, interface, nodes, links, groups, .. } = group.clone();
        let document =
            Document { title: name.to_owned(), docs, interface, nodes, links, groups, ..Document::default() };
        super::write_whole(&path, document.to_ron().as_bytes())
            .map_err(|error| format!("{}: {error}", path.display()))
    }
}
