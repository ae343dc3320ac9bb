//! Graph documents: RON with an envelope that is read first, migrations, and canonical writing.

mod error;
mod group;
mod link;
mod migrate;
mod mode;
mod named;
mod node_entry;
mod paths;
mod write;

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Deserializer};

use crate::files::FileSource;
use crate::spec::ParamValue;
pub use error::DocumentError;
pub use group::{Group, IncludeError};
pub use link::Link;
pub(crate) use link::{is_name, split_path};
pub use mode::NodeMode;
pub use node_entry::NodeEntry;

/// The `format` of every graph document.
pub const FORMAT: &str = "breccia-graph";
/// The document version that this program writes, and the newest that it reads.
pub const VERSION: u32 = 2;
/// The oldest version whose texts are also texts of this version, word for word.
const COMPATIBLE: u32 = 1;

/// A graph as it stands in a file. Nothing of it is checked against the known node types yet.
///
/// Written documents are canonical: names sorted, links by where they end, links into the same socket
/// in the order that they had. What a program does not know (node types, node fields, `editor`) is
/// kept and written back.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// A heading.
    pub title: String,
    /// What the graph does, in Markdown.
    pub docs: String,
    /// What the graph offers to somebody who runs it.
    pub interface: Interface,
    /// The nodes by name.
    pub nodes: BTreeMap<String, NodeEntry>,
    /// Links such as `a.out -> b.in` ([`Link`]).
    pub links: Vec<String>,
    /// Graphs by name that nodes such as `flow.group` and `flow.repeat` stand for.
    pub groups: BTreeMap<String, Group>,
    /// Positions and the like, for editors alone.
    pub editor: ron::Value,
}

impl Default for Document {
    fn default() -> Self {
        Self {
            title: String::new(),
            docs: String::new(),
            interface: Interface::default(),
            nodes: BTreeMap::new(),
            links: Vec::new(),
            groups: BTreeMap::new(),
            editor: ron::Value::Unit,
        }
    }
}

/// The named inputs, outputs and parameters of a graph or a group.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Interface {
    /// Files or values to give.
    #[serde(deserialize_with = "named::map")]
    pub inputs: BTreeMap<String, InterfaceInput>,
    /// Values to ask for.
    #[serde(deserialize_with = "named::map")]
    pub outputs: BTreeMap<String, InterfaceOutput>,
    /// Parameters to set.
    #[serde(deserialize_with = "named::map")]
    pub params: BTreeMap<String, InterfaceParam>,
}

/// Something to give, under a name: either a file, which a node reads, or a value, which goes to sockets.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InterfaceInput {
    /// The socket type of the value, or of what the file holds.
    #[serde(rename = "type")]
    pub ty: String,
    /// What to give.
    #[serde(default)]
    pub docs: String,
    /// For a file: the node that reads it.
    #[serde(default)]
    pub node: String,
    /// For a file: the reader's file parameter.
    #[serde(default)]
    pub param: String,
    /// For a value: the sockets it goes to, each as `node.socket`.
    #[serde(default)]
    pub targets: Vec<String>,
}

/// An output of a node, under a name.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InterfaceOutput {
    /// What it is.
    #[serde(default)]
    pub docs: String,
    /// The node.
    pub node: String,
    /// Its output socket.
    pub socket: String,
}

/// A parameter of one or several nodes, under a name.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InterfaceParam {
    /// What it does.
    #[serde(default)]
    pub docs: String,
    /// The parameters it sets, each as `node.param`.
    pub targets: Vec<String>,
    /// A value for all targets, in place of what their nodes say.
    #[serde(default, deserialize_with = "given")]
    pub default: Option<ParamValue>,
}

fn given<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<ParamValue>, D::Error> {
    ParamValue::deserialize(deserializer).map(Some)
}

/// The whole file, envelope included.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: u32,
    #[serde(default)]
    title: String,
    #[serde(default)]
    docs: String,
    #[serde(default)]
    interface: Interface,
    #[serde(deserialize_with = "named::map")]
    nodes: BTreeMap<String, NodeEntry>,
    #[serde(default)]
    links: Vec<String>,
    #[serde(default, deserialize_with = "named::map")]
    groups: BTreeMap<String, Group>,
    #[serde(default = "unit")]
    editor: ron::Value,
}

fn unit() -> ron::Value {
    ron::Value::Unit
}

impl Document {
    /// Reads a document of this or any earlier version.
    ///
    /// ```
    /// let text = r#"(
    ///     format: "breccia-graph", version: 1,
    ///     nodes: { "read": (type: "io.read_image", params: { "path": "stone.png" }) },
    /// )"#;
    /// let document = breccia_engine::Document::parse(text).unwrap();
    /// assert_eq!(document.nodes["read"].ty, "io.read_image");
    /// ```
    ///
    /// # Errors
    /// Names line and column where the text is no RON or its fields are wrong, and both versions if
    /// the document is from a newer program.
    pub fn parse(text: &str) -> Result<Self, DocumentError> {
        let tree: ron::Value = text.parse().map_err(DocumentError::syntax)?;
        let version = envelope(&tree)?;
        let mut file: File = if version >= COMPATIBLE {
            // Reading the text again, not the tree, so that errors know line and column.
            ron::from_str(text).map_err(DocumentError::syntax)?
        } else {
            let tree = migrate::to_current(tree, version)?;
            tree.into_rust()
                .map_err(|error| DocumentError::Structure { version, message: error.to_string() })?
        };
        link::sort(&mut file.links);
        file.groups.values_mut().for_each(Group::sort);
        Ok(Self {
            title: file.title,
            docs: file.docs,
            interface: file.interface,
            nodes: file.nodes,
            links: file.links,
            groups: file.groups,
            editor: file.editor,
        })
    }

    /// Reads a document from bytes, which must be UTF-8.
    ///
    /// # Errors
    /// As [`Document::parse`], and where the bytes are no UTF-8.
    pub fn parse_bytes(bytes: &[u8]) -> Result<Self, DocumentError> {
        let text = std::str::from_utf8(bytes).map_err(|error| DocumentError::Utf8(error.valid_up_to()))?;
        Self::parse(text)
    }

    /// Reads the groups that stand in files of their own, and those of these files in turn. Paths of groups are
    /// relative to the folder of the document or file that names them.
    ///
    /// # Errors
    /// Names the group, and says what is wrong with its file.
    pub fn include(&mut self, folder: &Path, files: &dyn FileSource) -> Result<(), IncludeError> {
        group::include(&mut self.groups, folder, files, &mut Vec::new())
    }

    /// The canonical text, which reads back to the same document.
    pub fn to_ron(&self) -> String {
        write::document(self)
    }
}

/// Checks the format and returns the version.
fn envelope(tree: &ron::Value) -> Result<u32, DocumentError> {
    let field = |name: &str| match tree {
        ron::Value::Map(map) => map.get(&ron::Value::String(name.to_owned())),
        _ => None,
    };
    match field("format") {
        Some(ron::Value::String(format)) if format == FORMAT => {}
        Some(other) => return Err(DocumentError::Format(format!("format: {}", write::value_text(other)))),
        None => return Err(DocumentError::Format("no `format`".into())),
    }
    let version = match field("version") {
        Some(ron::Value::Number(number)) => {
            let number = number.into_f64();
            (number >= 0.0 && number.fract() == 0.0 && number <= f64::from(u32::MAX)).then_some(number as u32)
        }
        _ => None,
    };
    match version {
        Some(version) if version > VERSION => {
            Err(DocumentError::Newer { found: version, supported: VERSION })
        }
        Some(version) => Ok(version),
        None => {
            Err(DocumentError::Version(field("version").map_or("no `version`".into(), write::value_text)))
        }
    }
}

#[cfg(test)]
mod tests;
