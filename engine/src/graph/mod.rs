//! Checked graphs: every name resolved, every value in range, no cycle.

mod cycle;
mod expand;
mod interface;
mod presence;
mod problem;
mod set;
mod template;
mod validate;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use petgraph::graph::{DiGraph, NodeIndex};

use crate::document::Document;
use crate::flow;
use crate::registry::{NodeType, Registry};
use crate::spec::{NodeSpec, ParamValue};
use crate::value::Value;
pub use interface::{InputInfo, OutputInfo, ParamInfo};
pub(crate) use presence::Presence;
pub use problem::{Problem, ProblemKind, Problems};

/// A graph that can run: a document whose names, types, values and links have been checked against a
/// registry. Runs work on a snapshot ([`Arc<Graph>`]); changing a graph means cloning it, which is cheap.
#[derive(Clone)]
pub struct Graph {
    pub(crate) title: String,
    pub(crate) docs: String,
    /// Sorted by name.
    pub(crate) nodes: Vec<GraphNode>,
    /// The weight is the index into `nodes`.
    pub(crate) topology: DiGraph<usize, ()>,
    /// Indices into `nodes`, sources first.
    pub(crate) order: Vec<usize>,
    pub(crate) inputs: BTreeMap<String, interface::Input>,
    pub(crate) outputs: BTreeMap<String, interface::Output>,
    pub(crate) params: BTreeMap<String, interface::Param>,
    /// For the outputs (node and index) of nodes that are off what they pass on, or why nothing.
    passed: BTreeMap<(usize, usize), Result<Source, String>>,
    /// What the graph is made from again when something changes, if it has groups or zones.
    template: Option<Arc<template::Template>>,
}

/// Where a link starts: a node and the index of its output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Source {
    pub node: usize,
    pub output: usize,
}

#[derive(Clone)]
pub(crate) struct GraphNode {
    pub name: String,
    pub ty: Arc<NodeType>,
    /// Every parameter of the type, in canonical form.
    pub params: BTreeMap<&'static str, ParamValue>,
    /// For every input of the type the links into it, in the order of the document.
    pub links: Vec<Vec<Source>>,
    /// For every output of the type a value given from outside; if there is one, the node does not run.
    pub bound: Vec<Option<Value>>,
}

impl GraphNode {
    pub fn is_bound(&self) -> bool {
        self.bound.iter().any(Option::is_some)
    }

    /// Whether only one of its inputs is needed, which depends on another.
    pub fn is_gate(&self) -> bool {
        self.ty.spec.id == flow::GATE
    }

    /// Whether it is part of the machinery of zones, of which nobody wants to hear.
    pub fn is_machinery(&self) -> bool {
        [flow::GATE, flow::REQUIRE, flow::VALUE].contains(&self.ty.spec.id)
    }
}

impl Graph {
    /// Checks a document. Paths in it stay as they are.
    ///
    /// # Errors
    /// All problems at once.
    pub fn new(document: &Document, registry: &Registry) -> Result<Self, Problems> {
        Self::checked(document, registry, None)
    }

    fn checked(document: &Document, registry: &Registry, folder: Option<&Path>) -> Result<Self, Problems> {
        if expand::needed(document) {
            return template::Template::new(document, registry, folder).build();
        }
        let (types, values, off) = (BTreeMap::new(), BTreeMap::new(), expand::Off::default());
        let flat = validate::Flat { document, registry, types: &types, values: &values, off: &off };
        validate::build(&flat, folder)
    }

    /// Checks a document whose relative paths are relative to `folder`. Paths with a scheme, such as
    /// `builtin:stone.png`, stay as they are.
    ///
    /// # Errors
    /// All problems at once.
    pub fn with_folder(document: &Document, registry: &Registry, folder: &Path) -> Result<Self, Problems> {
        Self::checked(document, registry, Some(folder))
    }

    /// The heading.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// What the graph does, in Markdown.
    pub fn docs(&self) -> &str {
        &self.docs
    }

    /// The nodes by name.
    pub fn nodes(&self) -> impl Iterator<Item = (&str, &NodeSpec)> {
        self.nodes.iter().map(|node| (node.name.as_str(), &node.ty.spec))
    }

    /// A node's parameters in canonical form, defaults included.
    pub fn node_params(&self, node: &str) -> Option<&BTreeMap<&'static str, ParamValue>> {
        self.index(node).map(|i| &self.nodes[i].params)
    }

    /// The nodes that take values directly from this one.
    pub fn consumers(&self, node: &str) -> Vec<&str> {
        let Some(index) = self.index(node) else { return Vec::new() };
        let mut names: Vec<_> = self
            .topology
            .neighbors(NodeIndex::new(index))
            .filter_map(|i| self.topology.node_weight(i))
            .map(|&i| self.nodes[i].name.as_str())
            .collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    pub(crate) fn index(&self, node: &str) -> Option<usize> {
        self.nodes.binary_search_by(|n| n.name.as_str().cmp(node)).ok()
    }
}

impl std::fmt::Debug for Graph {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names: Vec<_> = self.nodes.iter().map(|n| n.name.as_str()).collect();
        f.debug_struct("Graph").field("title", &self.title).field("nodes", &names).finish_non_exhaustive()
    }
}
