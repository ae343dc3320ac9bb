//! Paths in documents: relative to the document's folder where the file lies within.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use breccia_engine::{Document, Group, NodeEntry, ParamKind, ParamValue, Registry};

/// A path as a document in a folder keeps it.
pub fn relative(path: &Path, folder: Option<&Path>) -> String {
    let within = folder.and_then(|folder| path.strip_prefix(folder).ok());
    let text = within.unwrap_or(path).to_string_lossy();
    if std::path::MAIN_SEPARATOR == '/' { text.into_owned() } else { text.replace(std::path::MAIN_SEPARATOR, "/") }
}

/// Rewrites the paths of a document that moves from one folder to another, so that they still name the same files.
pub fn rebase(document: &mut Document, registry: &Registry, from: Option<&Path>, to: Option<&Path>) {
    if from == to {
        return;
    }
    let moved = |path: &str| {
        if path.is_empty() || has_scheme(path) {
            return path.to_owned();
        }
        let whole: PathBuf = from.map_or_else(|| PathBuf::from(path), |from| from.join(path));
        relative(&whole, to)
    };
    nodes(&mut document.nodes, registry, &moved);
    groups(&mut document.groups, registry, &moved);
}

fn nodes(nodes: &mut BTreeMap<String, NodeEntry>, registry: &Registry, moved: &dyn Fn(&str) -> String) {
    for entry in nodes.values_mut() {
        let Some(ty) = registry.node(&entry.ty) else { continue };
        for param in ty.spec.params.iter().filter(|param| matches!(param.kind, ParamKind::File { .. })) {
            if let Some(ParamValue::Text(path)) = entry.params.get_mut(param.name) {
                *path = moved(path);
            }
        }
    }
}

fn groups(found: &mut BTreeMap<String, Group>, registry: &Registry, moved: &dyn Fn(&str) -> String) {
    for group in found.values_mut() {
        if !group.file.is_empty() {
            group.file = moved(&group.file);
        }
        nodes(&mut group.nodes, registry, moved);
        groups(&mut group.groups, registry, moved);
    }
}

/// Whether a path has a scheme such as `builtin:`. One letter is a Windows drive.
fn has_scheme(path: &str) -> bool {
    path.split_once(':').is_some_and(|(scheme, _)| scheme.len() > 1 && scheme.chars().all(|c| c.is_ascii_alphanumeric()))
}
