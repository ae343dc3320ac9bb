//! Groups: graphs within a document, or in files of their own, that a node can stand for.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{Document, DocumentError, Interface, NodeEntry, link, named};
use crate::files::{FileSource, join};

/// A graph that a node of another graph stands for. What it takes and gives is its interface.
///
/// Either the group is written out, or `file` names a document whose graph it is.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Group {
    /// What the group does, in Markdown.
    pub docs: String,
    /// What it takes and gives.
    pub interface: Interface,
    /// The nodes by name.
    #[serde(deserialize_with = "named::map")]
    pub nodes: BTreeMap<String, NodeEntry>,
    /// Links such as `a.out -> b.in`.
    pub links: Vec<String>,
    /// Groups that only this group sees.
    #[serde(deserialize_with = "named::map")]
    pub groups: BTreeMap<String, Group>,
    /// A document whose graph this is; empty for a group that is written out.
    pub file: String,
    /// What paths within the group are relative to, if it came from a file.
    #[serde(skip)]
    pub folder: Option<PathBuf>,
}

impl Group {
    /// Brings the links into canonical order.
    pub(super) fn sort(&mut self) {
        link::sort(&mut self.links);
        self.groups.values_mut().for_each(Self::sort);
    }
}

/// A group whose file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum IncludeError {
    /// It cannot be read.
    #[error("group `{group}`: cannot read `{path}`: {error}")]
    Read {
        /// The group.
        group: String,
        /// Its file.
        path: String,
        /// What went wrong.
        error: std::io::Error,
    },
    /// It is no document.
    #[error("group `{group}`: `{path}`: {error}")]
    Document {
        /// The group.
        group: String,
        /// Its file.
        path: String,
        /// What is wrong with it.
        error: DocumentError,
    },
    /// It includes itself.
    #[error("group `{group}`: `{path}` includes itself, found {way}, expected files that do not lead back")]
    Cycle {
        /// The group.
        group: String,
        /// Its file.
        path: String,
        /// The files on the way.
        way: String,
    },
}

/// Replaces every group that names a file by what is in the file. `way` are the files that are being read.
pub(super) fn include(
    groups: &mut BTreeMap<String, Group>,
    folder: &Path,
    files: &dyn FileSource,
    way: &mut Vec<String>,
) -> Result<(), IncludeError> {
    for (name, group) in groups {
        if group.file.is_empty() {
            include(&mut group.groups, folder, files, way)?;
            continue;
        }
        let path = join(folder, &group.file);
        let group_name = name.clone();
        if way.contains(&path) {
            way.push(path.clone());
            return Err(IncludeError::Cycle { group: group_name, path, way: way.join(" -> ") });
        }
        let bytes = match files.read(&path) {
            Ok(bytes) => bytes,
            Err(error) => return Err(IncludeError::Read { group: group_name, path, error }),
        };
        let document = match Document::parse_bytes(&bytes) {
            Ok(document) => document,
            Err(error) => return Err(IncludeError::Document { group: group_name, path, error }),
        };
        // A name with a scheme has no folder: what it names in turn stands beside it.
        let own = path.rfind('/').map_or(PathBuf::new(), |end| PathBuf::from(&path[..end]));
        let Document { docs, interface, nodes, links, mut groups, .. } = document;
        way.push(path);
        include(&mut groups, &own, files, way)?;
        way.pop();
        *group = Group { docs, interface, nodes, links, groups, file: String::new(), folder: Some(own) };
    }
    Ok(())
}
