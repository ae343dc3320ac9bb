//! The node types, socket types and exporters that a program knows.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::export::Exporter;
use crate::node::Node;
use crate::spec::NodeSpec;
use crate::value::TypeInfo;

/// A registered node type: its description and its implementation.
pub struct NodeType {
    /// The description.
    pub spec: NodeSpec,
    /// The implementation.
    pub node: Box<dyn Node>,
}

/// The node types, socket types and exporters that a program knows.
#[derive(Clone, Default)]
pub struct Registry {
    nodes: BTreeMap<&'static str, Arc<NodeType>>,
    types: BTreeMap<&'static str, TypeInfo>,
    exporters: Vec<Exporter>,
}

impl Registry {
    /// Adds node types.
    pub fn add_nodes(&mut self, nodes: impl IntoIterator<Item = Box<dyn Node>>) {
        for node in nodes {
            let spec = node.spec();
            self.nodes.insert(spec.id, Arc::new(NodeType { spec, node }));
        }
    }

    /// Adds socket types.
    pub fn add_types(&mut self, types: impl IntoIterator<Item = TypeInfo>) {
        self.types.extend(types.into_iter().map(|ty| (ty.name, ty)));
    }

    /// Adds exporters.
    pub fn add_exporters(&mut self, exporters: impl IntoIterator<Item = Exporter>) {
        self.exporters.extend(exporters);
    }

    /// A node type by id.
    pub fn node(&self, id: &str) -> Option<&Arc<NodeType>> {
        self.nodes.get(id)
    }

    /// All node types, by id.
    pub fn nodes(&self) -> impl Iterator<Item = &Arc<NodeType>> {
        self.nodes.values()
    }

    /// A socket type by name.
    pub fn socket_type(&self, name: &str) -> Option<&TypeInfo> {
        self.types.get(name)
    }

    /// All socket types, by name.
    pub fn types(&self) -> impl Iterator<Item = &TypeInfo> {
        self.types.values()
    }

    /// All exporters, in the order of registration.
    pub fn exporters(&self) -> &[Exporter] {
        &self.exporters
    }
}
