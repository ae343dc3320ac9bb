//! What is known of a node's outputs without having them.

use serde::{Deserialize, Serialize};

use crate::value::{Digest, Value};

/// What is known of the outputs that belong to a key, in the order of the node type's declaration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Record {
    pub outputs: Vec<OutputRecord>,
}

/// What is known of an output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct OutputRecord {
    pub ty: String,
    pub digest: Digest,
    /// Size in memory.
    pub bytes: u64,
    pub summary: String,
}

impl OutputRecord {
    pub fn of(value: &Value) -> Self {
        Self {
            ty: value.type_name().to_owned(),
            digest: value.digest(),
            bytes: value.byte_size(),
            summary: value.summary(),
        }
    }

    /// Under what the value is kept.
    pub fn value_id(&self) -> Digest {
        crate::keys::value_id(&self.ty, &self.digest)
    }
}

impl Record {
    pub fn bytes(&self) -> u64 {
        self.outputs.iter().fold(0, |sum, output| sum.saturating_add(output.bytes))
    }

    pub fn summary(&self) -> String {
        self.outputs.iter().map(|output| output.summary.as_str()).collect::<Vec<_>>().join("; ")
    }

    /// Whether both stand for the same content.
    pub fn same_content(&self, other: &Self) -> bool {
        let contents =
            |record: &Self| record.outputs.iter().map(|o| (o.ty.clone(), o.digest)).collect::<Vec<_>>();
        contents(self) == contents(other)
    }
}
