//! Groups that the user keeps, to be used in any graph.

use std::io::ErrorKind;
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
        let fits = !name.is_empty() && name.chars().all(is_plain);
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

    /// Keeps a group under a name, or one like it if something else has that name already. Returns the name.
    ///
    /// # Errors
    /// If no name can be made of it, or the file cannot be written.
    pub fn keep(&self, name: &str, group: &Group) -> Result<String, String> {
        let plain = name.replace(|c: char| !is_plain(c), "_");
        let Group { docs, interface, nodes, links, groups, .. } = group.clone();
        let mut document = Document { docs, interface, nodes, links, groups, ..Document::default() };
        for i in 1.. {
            let name = if i == 1 { plain.clone() } else { format!("{plain}_{i}") };
            let path = self.path(&name).ok_or_else(|| format!("`{name}` is no name of a group"))?;
            document.title.clone_from(&name);
            let text = document.to_ron();
            match std::fs::read(&path) {
                Ok(found) if found == text.as_bytes() => return Ok(name),
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::NotFound => {
                    return super::write_whole(&path, text.as_bytes())
                        .map(|()| name)
                        .map_err(|error| format!("{}: {error}", path.display()));
                }
                Err(error) => return Err(format!("{}: {error}", path.display())),
            }
        }
        Err("all names are taken".to_owned())
    }
}

fn is_plain(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '-')
}

#[cfg(test)]
mod tests {
    use breccia_engine::NodeEntry;

    use super::*;

    #[test]
    fn no_group_takes_the_place_of_another() {
        let folder = tempfile::tempdir().unwrap();
        let library = Library::new(Some(folder.path().to_owned()));
        let group =
            |ty: &str| Group { nodes: [("a".to_owned(), NodeEntry::new(ty))].into(), ..Group::default() };
        let (first, second) = (group("solid.checker"), group("solid.constant"));
        assert_eq!(library.keep("group", &first).unwrap(), "group");
        assert_eq!(library.keep("group", &second).unwrap(), "group_2");
        assert_eq!(library.keep("group", &first).unwrap(), "group");
        assert_eq!((library.group("group"), library.group("group_2")), (Ok(first.clone()), Ok(second)));
        assert_eq!(library.keep("a group/b", &first).unwrap(), "a_group_b");
        assert!(library.keep("", &first).is_err());
    }
}
