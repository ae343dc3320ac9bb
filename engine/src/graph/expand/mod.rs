//! Replaces groups and zones by what they stand for, so that what is checked and run is one flat graph.
//!
//! Keys, caches, progress, errors, cancelling and checked runs then need no word of groups: a node of the third
//! iteration is a node like any other, under a name that tells the way to it.

mod instance;
mod off;
mod resolve;

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Problem, ProblemKind};
use crate::document::{Document, InterfaceOutput, InterfaceParam};
use crate::registry::{NodeType, Registry};
use crate::spec::{ParamSpec, ParamValue};
pub(crate) use off::Off;

/// The most nodes that a graph may have once it is expanded.
pub(crate) const MAX_NODES: usize = 20_000;

/// A value that was set after a document was read: node (or way to it), parameter, value. Later ones win.
pub(crate) type Override = (String, String, ParamValue);

/// A document without groups, and what is to be known of those it had.
pub(crate) struct Expanded {
    pub document: Document,
    /// Types of nodes that are in no registry, by the name that the document uses.
    pub types: BTreeMap<String, Arc<NodeType>>,
    /// Exposed parameters that a group or zone takes.
    pub params: BTreeMap<String, ZoneParam>,
    /// Inputs that take a value rather than a file: their node in the document.
    pub values: BTreeMap<String, String>,
    /// Nodes that are muted or bypassed.
    pub off: Off,
    pub problems: Vec<Problem>,
}

/// An exposed parameter of a group or zone.
#[derive(Clone)]
pub(crate) struct ZoneParam {
    pub spec: ParamSpec,
    pub value: ParamValue,
}

/// Whether a document needs expanding at all.
pub(crate) fn needed(document: &Document) -> bool {
    !document.groups.is_empty()
        || document
            .nodes
            .values()
            .any(|entry| entry.mode.is_off() || crate::flow::stands_for_graph(&entry.ty))
        || document.interface.inputs.values().any(|input| !input.targets.is_empty())
}

pub(crate) fn expand(document: &Document, registry: &Registry, overrides: &[Override]) -> Expanded {
    let mut tree = instance::Tree::new(document, registry, overrides);
    tree.grow();
    let mut flat = Document {
        title: document.title.clone(),
        docs: document.docs.clone(),
        interface: document.interface.clone(),
        editor: document.editor.clone(),
        ..Document::default()
    };
    let mut types = BTreeMap::new();
    let mut values = BTreeMap::new();
    let mut off = Off::default();
    if tree.problems.is_empty() {
        let mut links = resolve::Resolver::new(&tree);
        links.connect();
        for (name, output) in &mut flat.interface.outputs {
            match links.output(0, &output.node, &output.socket) {
                Ok((node, socket)) => {
                    *output = InterfaceOutput { node, socket, docs: std::mem::take(&mut output.docs) };
                }
                Err(Some(reason)) => {
                    let (item, expected) =
                        (format!("interface output `{name}`"), "an output that has a value");
                    let found = format!("nothing, since {reason}");
                    links.problems.push(Problem::new(ProblemKind::Muted, None, item, found, expected));
                }
                Err(None) => {}
            }
        }
        let found = links.problems;
        (flat.nodes, flat.links) = (links.nodes, links.links);
        (values, types, off) = (links.values, links.types, links.off);
        tree.problems.extend(found);
    }
    let mut params = BTreeMap::new();
    for (name, param) in &mut flat.interface.params {
        if let Some(zone) = zone_param(&mut tree, name, param) {
            params.insert(name.clone(), zone);
        } else if param.targets.iter().any(|target| tree.is_overridden(target)) {
            param.default = None;
        }
    }
    // What a group or zone takes stands in the nodes already.
    flat.interface.params.retain(|name, _| !params.contains_key(name));
    for input in flat.interface.inputs.values_mut() {
        input.targets.clear();
    }
    Expanded { document: flat, types, params, values, off, problems: tidy(tree.problems) }
}

/// What an exposed parameter takes, if one of its targets belongs to a group or zone.
fn zone_param(tree: &mut instance::Tree<'_>, name: &str, param: &InterfaceParam) -> Option<ZoneParam> {
    let target = param.targets.iter().find(|target| tree.zone_of(0, target).is_some())?;
    match tree.describe(0, target) {
        Some((spec, value)) => Some(ZoneParam { spec, value }),
        None => {
            let item = format!("interface parameter `{name}`");
            let expected = "a parameter of the group, such as `node.parameter`";
            let found = format!("target `{target}`");
            tree.problems.push(Problem::new(ProblemKind::UnknownParam, None, item, found, expected));
            None
        }
    }
}

/// Problems of a group that is used more than once, said once: `zone[3]/node` becomes `zone/node`.
pub(crate) fn tidy(problems: Vec<Problem>) -> Vec<Problem> {
    let stripped: Vec<Problem> = problems
        .iter()
        .map(|problem| Problem {
            node: problem.node.as_deref().map(without_indices),
            item: without_indices(&problem.item),
            found: without_indices(&problem.found),
            ..problem.clone()
        })
        .collect();
    let mut tidy: Vec<Problem> = Vec::new();
    for (problem, general) in problems.into_iter().zip(&stripped) {
        match stripped.iter().filter(|other| *other == general).count() {
            1 => tidy.push(problem),
            _ if tidy.contains(general) => {}
            _ => tidy.push(general.clone()),
        }
    }
    tidy
}

/// The way to a node without the iterations: `zone[3]/node` as `zone/node`.
pub(crate) fn without_indices(path: &str) -> String {
    let mut out = String::with_capacity(path.len());
    let mut rest = path;
    while let Some(open) = rest.find('[') {
        let close = rest[open..].find("]/").map(|end| open + end);
        match close {
            Some(close)
                if close > open + 1 && rest[open + 1..close].bytes().all(|byte| byte.is_ascii_digit()) =>
            {
                out.push_str(&rest[..open]);
                rest = &rest[close + 1..];
            }
            _ => {
                out.push_str(&rest[..=open]);
                rest = &rest[open + 1..];
            }
        }
    }
    out.push_str(rest);
    out
}
