//! Cache keys: what determines a node's outputs, and nothing else.

use std::collections::BTreeMap;

use crate::graph::GraphNode;
use crate::spec::{ParamKind, ParamValue};
use crate::value::Digest;

/// Raised whenever keys are made up in another way, so that old entries are not found any more.
const KEY_VERSION: u32 = 1;

/// Stands for a node's outputs for certain inputs.
pub(crate) type Key = Digest;

/// The key of a node: its type and version, its parameters, the contents of its files, and the digests
/// of the values linked to each of its inputs.
///
/// `device` names the compute device of a node that rounds otherwise there.
///
/// Of a path only the extension counts, since nodes choose the file format by it.
pub(crate) fn node_key(
    node: &GraphNode,
    files: &BTreeMap<&'static str, Digest>,
    inputs: &[Vec<Digest>],
    device: Option<&str>,
) -> Key {
    let mut hasher = Fields(blake3::Hasher::new());
    let spec = &node.ty.spec;
    hasher.text("breccia node");
    hasher.number(KEY_VERSION.into());
    hasher.text(spec.id);
    hasher.number(spec.version.into());
    hasher.number(node.params.len() as u64);
    for (name, value) in &node.params {
        hasher.text(name);
        let kind = spec.params.iter().find(|p| p.name == *name).map(|p| &p.kind);
        match (kind, value) {
            (Some(ParamKind::File { .. }), ParamValue::Text(path)) => {
                let extension = std::path::Path::new(path).extension();
                hasher.text(&extension.map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default());
                hasher.bytes(files.get(name).map_or(&[], |digest| &digest.0));
            }
            _ => hasher.param(value),
        }
    }
    hasher.number(inputs.len() as u64);
    for (socket, digests) in spec.inputs.iter().zip(inputs) {
        hasher.text(socket.name);
        hasher.number(digests.len() as u64);
        for digest in digests {
            hasher.bytes(&digest.0);
        }
    }
    if let Some(device) = device {
        hasher.text("device");
        hasher.text(device);
    }
    hasher.0.finalize().into()
}

/// Under what a value of this type and content is kept.
pub(crate) fn value_id(ty: &str, content: &Digest) -> Digest {
    let mut hasher = Fields(blake3::Hasher::new());
    hasher.text("breccia value");
    hasher.text(ty);
    hasher.bytes(&content.0);
    hasher.0.finalize().into()
}

/// Hashes fields so that no two sequences of fields hash the same bytes.
struct Fields(blake3::Hasher);

impl Fields {
    fn number(&mut self, number: u64) {
        self.0.update(&number.to_le_bytes());
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.number(bytes.len() as u64);
        self.0.update(bytes);
    }

    fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    fn param(&mut self, value: &ParamValue) {
        match value {
            ParamValue::Bool(b) => self.bytes(&[0, u8::from(*b)]),
            ParamValue::Int(i) => {
                self.bytes(&[1]);
                self.bytes(&i.to_le_bytes());
            }
            ParamValue::Float(x) => {
                self.bytes(&[2]);
                self.number(x.to_bits());
            }
            ParamValue::Text(text) => {
                self.bytes(&[3]);
                self.text(text);
            }
            ParamValue::List(items) => {
                self.bytes(&[4]);
                self.number(items.len() as u64);
                items.iter().for_each(|item| self.param(item));
            }
        }
    }
}
