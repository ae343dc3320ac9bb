//! A node as it stands in a document, whether its type is known or not.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};

use super::{NodeMode, named};
use crate::spec::ParamValue;

/// A node of a document. What cannot be a node's is kept all the same and written back, since a newer
/// program may know what it means.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeEntry {
    /// The id of its type, such as `lazy.candidates`.
    pub ty: String,
    /// Whether it takes part.
    pub mode: NodeMode,
    /// The parameters that the document sets.
    pub params: BTreeMap<String, ParamValue>,
    /// Parameters whose value no parameter can have.
    pub other_params: BTreeMap<String, ron::Value>,
    /// Fields other than `type`, `mode` and `params`, and a `mode` that is none.
    pub other_fields: BTreeMap<String, ron::Value>,
}

impl NodeEntry {
    /// A node of this type with nothing set.
    pub fn new(ty: impl Into<String>) -> Self {
        Self { ty: ty.into(), ..Self::default() }
    }

    /// Sets a parameter.
    pub fn with(mut self, name: impl Into<String>, value: ParamValue) -> Self {
        self.params.insert(name.into(), value);
        self
    }
}

impl<'de> Deserialize<'de> for NodeEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(EntryVisitor)
    }
}

#[derive(serde::Deserialize)]
#[serde(transparent)]
struct Params(#[serde(deserialize_with = "named::map")] BTreeMap<String, ron::Value>);

struct EntryVisitor;

impl<'de> Visitor<'de> for EntryVisitor {
    type Value = NodeEntry;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a node such as (type: \"family.node\", params: {\"name\": value})")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<NodeEntry, A::Error> {
        let mut ty = None;
        let mut params: Option<Params> = None;
        let mut other_fields = BTreeMap::new();
        while let Some(name) = access.next_key::<String>()? {
            let seen = match name.as_str() {
                "type" => ty.is_some(),
                "params" => params.is_some(),
                _ => other_fields.contains_key(&name),
            };
            if seen {
                return Err(de::Error::custom(format!("`{name}` is there twice")));
            }
            match name.as_str() {
                "type" => ty = Some(access.next_value::<String>()?),
                "params" => params = Some(access.next_value()?),
                // Only such names can be written back as fields.
                _ if is_field(&name) => {
                    other_fields.insert(name, access.next_value()?);
                }
                _ => return Err(de::Error::custom(format!("`{name}` is no name of a field"))),
            }
        }
        let ty = ty.ok_or_else(|| de::Error::missing_field("type"))?;
        let mode = match other_fields.get("mode") {
            Some(ron::Value::String(name)) => NodeMode::from_name(name),
            _ => None,
        };
        if mode.is_some() {
            other_fields.remove("mode");
        }
        let mut entry =
            NodeEntry { ty, mode: mode.unwrap_or_default(), other_fields, ..NodeEntry::default() };
        for (name, value) in params.map(|p| p.0).unwrap_or_default() {
            match ParamValue::from_ron(&value) {
                Some(value) => {
                    entry.params.insert(name, value);
                }
                None => {
                    entry.other_params.insert(name, value);
                }
            }
        }
        Ok(entry)
    }
}

fn is_field(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        // RON reads these as values or prefixes, not as names.
        && !matches!(name, "r" | "b" | "br" | "true" | "false" | "Some" | "None" | "inf" | "NaN")
}
