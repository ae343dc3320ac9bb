//! Graphs with groups and zones: how many nodes they have depends on their parameters, so that they are made again
//! when one changes.

use std::collections::BTreeMap;
use std::path::Path;

use super::expand::{self, Override};
use super::interface::Param;
use super::validate::{self, Flat};
use super::{Graph, Problems};
use crate::document::{Document, split_path};
use crate::registry::Registry;
use crate::spec::ParamValue;
use crate::value::Value;

/// A document, and all that has been set since it was read.
#[derive(Clone)]
pub(super) struct Template {
    document: Document,
    registry: Registry,
    overrides: Vec<Override>,
    bound: BTreeMap<String, Value>,
}

impl Template {
    /// Paths in the document become relative to the folder once and for all.
    pub fn new(document: &Document, registry: &Registry, folder: Option<&Path>) -> Self {
        let mut document = document.clone();
        let folder = folder.unwrap_or(Path::new(""));
        document.change_paths(registry, folder, &mut |path| Some(path.to_owned()));
        Self { document, registry: registry.clone(), overrides: Vec::new(), bound: BTreeMap::new() }
    }

    /// Expands and checks.
    pub fn build(self) -> Result<Graph, Problems> {
        let expanded = expand::expand(&self.document, &self.registry, &self.overrides);
        if !expanded.problems.is_empty() {
            return Err(Problems(expanded.problems));
        }
        let flat = Flat {
            document: &expanded.document,
            registry: &self.registry,
            types: &expanded.types,
            values: &expanded.values,
            off: &expanded.off,
        };
        let mut graph = validate::build(&flat, None).map_err(|found| Problems(expand::tidy(found.0)))?;
        for (name, zone) in expanded.params {
            let param = graph.params.entry(name.clone()).or_insert_with(|| Param {
                docs: self.document.interface.params.get(&name).map_or(String::new(), |p| p.docs.clone()),
                targets: Vec::new(),
                zone: None,
            });
            param.zone = Some(zone);
        }
        for (name, value) in &self.bound {
            graph.bind_input(name, value.clone())?;
        }
        graph.template = Some(self.into());
        Ok(graph)
    }

    /// The same with more set.
    pub fn with(&self, overrides: impl IntoIterator<Item = Override>) -> Self {
        let mut changed = self.clone();
        for new in overrides {
            changed.overrides.retain(|old| old.0 != new.0 || old.1 != new.1);
            changed.overrides.push(new);
        }
        changed
    }

    /// What an exposed parameter sets.
    pub fn targets(&self, name: &str) -> Vec<(String, String)> {
        let targets = self.document.interface.params.get(name).map_or(&[][..], |param| &param.targets);
        let split = targets.iter().filter_map(|target| split_path(target));
        split.map(|(node, param)| (node.to_owned(), param.to_owned())).collect()
    }

    /// Whether there is such a node: in the document, in the flat graph, or in every iteration of a zone.
    pub fn knows(&self, node: &str, graph: &Graph) -> bool {
        self.document.nodes.contains_key(node)
            || graph.index(node).is_some()
            || graph.nodes.iter().any(|n| {
                let general = expand::without_indices(&n.name);
                general == node || general.starts_with(node) && general[node.len()..].starts_with('/')
            })
    }

    /// Notes the path of an input's file.
    pub fn set_reader(&mut self, input: &str, param: &str, path: ParamValue) {
        self.bound.remove(input);
        let Some(input) = self.document.interface.inputs.get(input) else { return };
        let reader = (input.node.clone(), param.to_owned(), path);
        *self = self.with([reader]);
    }

    /// Notes a ready value for an input.
    pub fn bind(&mut self, input: &str, value: Value) {
        self.bound.insert(input.to_owned(), value);
    }
}
