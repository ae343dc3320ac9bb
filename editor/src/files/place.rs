//! Paths in documents: relative to the document's folder where the file lies within.

use std::collections::BTreeMap;
use std::path::Path;

use breccia_engine::{Document, Group, Registry};

/// A path as a document in a folder keeps it.
pub fn relative(path: &Path, folder: Option<&Path>) -> String {
    let within = folder.and_then(|folder| path.strip_prefix(folder).ok());
    let text = within.unwrap_or(path).to_string_lossy();
    if std::path::MAIN_SEPARATOR == '/' {
        text.into_owned()
    } else {
        text.replace(std::path::MAIN_SEPARATOR, "/")
    }
}

/// Rewrites the paths of a document that moves from one folder to another, so that they still name the same files.
pub fn rebase(document: &mut Document, registry: &Registry, from: Option<&Path>, to: Option<&Path>) {
    if from == to {
        return;
    }
    // A document without a folder has its paths from where the program was started.
    let here = std::env::current_dir().unwrap_or_default();
    let from = from.unwrap_or(&here);
    document.change_paths(registry, from, &mut |path| Some(relative(Path::new(path), to)));
    groups(&mut document.groups, from, to);
}

/// The files that groups stand in.
fn groups(found: &mut BTreeMap<String, Group>, from: &Path, to: Option<&Path>) {
    for group in found.values_mut() {
        // One letter before a colon is a Windows drive, more are a scheme such as `builtin:`.
        let has_scheme = group.file.find(':').is_some_and(|at| at > 1);
        if !group.file.is_empty() && !has_scheme {
            group.file = relative(&from.join(&group.file), to);
        }
        groups(&mut group.groups, from, to);
    }
}
