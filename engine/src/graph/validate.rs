//! From a document to a checked graph, or to all of its problems.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use petgraph::algo::toposort;
use petgraph::graph::{DiGraph, NodeIndex};

use super::expand::Off;
use super::{Graph, GraphNode, Problem, ProblemKind, Problems, Source, cycle, interface};
use crate::document::{Document, InterfaceInput, Link, NodeEntry, NodeMode, is_name, split_path};
use crate::files::join;
use crate::registry::{NodeType, Registry};
use crate::spec::{Arity, ParamKind, ParamValue};

/// A document without groups, and the names that are known.
pub(super) struct Flat<'a> {
    pub document: &'a Document,
    pub registry: &'a Registry,
    /// Types that are in no registry.
    pub types: &'a BTreeMap<String, Arc<NodeType>>,
    /// Nodes that stand for inputs that take a value, by input.
    pub values: &'a BTreeMap<String, String>,
    /// Nodes that are muted or bypassed. No link of the document leads to one or comes from one.
    pub off: &'a Off,
}

pub(super) fn build(flat: &Flat<'_>, folder: Option<&Path>) -> Result<Graph, Problems> {
    let &Flat { document, registry, types, values, off } = flat;
    let (nodes, problems) = (BTreeMap::new(), Vec::new());
    let mut builder = Builder { document, registry, types, values, off, folder, nodes, problems };
    for (name, entry) in &document.nodes {
        builder.node(name, entry);
    }
    let indices: BTreeMap<&str, usize> = builder.nodes.keys().copied().zip(0..).collect();
    for link in &document.links {
        builder.link(link, &indices);
    }
    builder.arities();
    let (topology, order) = builder.topology();
    let mut graph = Graph {
        title: document.title.clone(),
        docs: document.docs.clone(),
        nodes: Vec::new(),
        topology,
        order,
        inputs: BTreeMap::new(),
        outputs: BTreeMap::new(),
        params: BTreeMap::new(),
        passed: BTreeMap::new(),
        template: None,
    };
    builder.interface(&mut graph, &indices);
    builder.passed(&mut graph, &indices);
    graph.nodes = builder.nodes.into_values().map(|draft| draft.node).collect();
    if builder.problems.is_empty() { Ok(graph) } else { Err(Problems(builder.problems)) }
}

struct Builder<'a> {
    document: &'a Document,
    registry: &'a Registry,
    types: &'a BTreeMap<String, Arc<NodeType>>,
    values: &'a BTreeMap<String, String>,
    off: &'a Off,
    folder: Option<&'a Path>,
    /// Nodes of known types.
    nodes: BTreeMap<&'a str, Draft>,
    problems: Vec<Problem>,
}

struct Draft {
    node: GraphNode,
    /// For every input the links as they stand in the document, usable or not.
    written: Vec<Vec<String>>,
}

impl<'a> Builder<'a> {
    fn report(&mut self, problem: Problem) {
        self.problems.push(problem);
    }

    fn node(&mut self, name: &'a str, entry: &NodeEntry) {
        // Only machinery that a user cannot name, and what it is expanded from is checked already, has other names.
        if !is_name(name) && !name.contains(['/', '=']) {
            let expected = "letters, digits, `_` and `-`";
            self.report(Problem::new(ProblemKind::BadName, None, "node name", format!("`{name}`"), expected));
        }
        let Some(ty) = self.registry.node(&entry.ty).or_else(|| self.types.get(&entry.ty)) else {
            if entry.mode == NodeMode::Mute {
                return;
            }
            let known = self.registry.nodes().map(|t| t.spec.id);
            let kind = ProblemKind::UnknownType;
            self.report(Problem::unknown(kind, Some(name), "type", &entry.ty, "node types", known));
            return;
        };
        self.problems.extend(Problem::fields(name, entry));
        for (param, value) in &entry.other_params {
            let spec = ty.spec.params.iter().find(|p| p.name == param);
            let expected =
                spec.map_or("true, false, a number, a quoted text or a list".into(), |s| s.kind.describe());
            let found = match value {
                ron::Value::Unit => "a bare word or `()`; texts need quotes".to_owned(),
                other => ron::to_string(other).unwrap_or_else(|_| "something else".into()),
            };
            let item = format!("parameter `{param}`");
            self.report(Problem::new(ProblemKind::BadValue, Some(name), item, found, expected));
        }
        let mut params: BTreeMap<_, _> = ty.spec.params.iter().map(|p| (p.name, p.default.clone())).collect();
        for (param, value) in &entry.params {
            let Some(spec) = ty.spec.params.iter().find(|p| p.name == param) else {
                let known = ty.spec.params.iter().map(|p| p.name);
                let kind = ProblemKind::UnknownParam;
                self.report(Problem::unknown(kind, Some(name), "parameter", param, "parameters", known));
                continue;
            };
            match spec.kind.check(value) {
                Ok(value) => {
                    params.insert(spec.name, self.located(&spec.kind, value));
                }
                Err(mismatch) => {
                    self.report(Problem::mismatch(Some(name), format!("parameter `{param}`"), mismatch));
                }
            }
        }
        let node = GraphNode {
            name: name.to_owned(),
            params,
            links: vec![Vec::new(); ty.spec.inputs.len()],
            bound: vec![None; ty.spec.outputs.len()],
            ty: ty.clone(),
        };
        self.nodes.insert(name, Draft { written: vec![Vec::new(); node.links.len()], node });
    }

    /// A path of the document, made relative to the document's folder.
    fn located(&self, kind: &ParamKind, value: ParamValue) -> ParamValue {
        match (kind, &value, self.folder) {
            (ParamKind::File { .. }, ParamValue::Text(path), Some(folder)) => {
                ParamValue::Text(join(folder, path))
            }
            _ => value,
        }
    }

    fn unknown_node(&self, item: String, node: &str) -> Problem {
        let known = self.document.nodes.keys().map(String::as_str);
        Problem::unknown(ProblemKind::UnknownNode, None, item, node, "nodes", known)
    }

    fn link(&mut self, text: &str, indices: &BTreeMap<&str, usize>) {
        let item = format!("link `{text}`");
        let Some(link) = Link::parse(text) else {
            let expected = "a link such as `node.output -> node.input`";
            let found = format!("`{text}`");
            self.report(Problem::new(ProblemKind::BadLink, None, "link", found, expected));
            return;
        };
        for node in [&link.from_node, &link.to_node] {
            if !self.document.nodes.contains_key(node) {
                self.report(self.unknown_node(item.clone(), node));
            }
        }
        let input = self.socket(&link.to_node, &link.to_socket, "input");
        let output = self.socket(&link.from_node, &link.from_socket, "output");
        let Some((input, expected)) = input else { return };
        if let Some((_, found)) = output
            && found != expected
        {
            let item = format!("input `{}`", link.to_socket);
            let found = format!("{found} from `{}.{}`", link.from_node, link.from_socket);
            let node = Some(link.to_node.as_str());
            self.report(Problem::new(ProblemKind::TypeMismatch, node, item, found, expected));
        }
        let source = indices.get(link.from_node.as_str()).zip(output);
        if let Some(draft) = self.nodes.get_mut(link.to_node.as_str()) {
            draft.written[input].push(format!("{}.{}", link.from_node, link.from_socket));
            if let Some((&node, (output, _))) = source {
                draft.node.links[input].push(Source { node, output });
            }
        }
    }

    /// Index and type of a node's input or output; reports it if a node of a known type has none.
    fn socket(&mut self, node: &str, socket: &str, what: &str) -> Option<(usize, &'static str)> {
        let ty = self.nodes.get(node)?.node.ty.clone();
        let sockets = if what == "input" { &ty.spec.inputs } else { &ty.spec.outputs };
        let found = sockets.iter().enumerate().find(|(_, s)| s.name == socket).map(|(i, s)| (i, s.ty));
        if found.is_none() {
            let known = sockets.iter().map(|s| s.name);
            let kind = ProblemKind::UnknownSocket;
            self.report(Problem::unknown(kind, Some(node), what, socket, &format!("{what}s"), known));
        }
        found
    }

    /// Checks that every input has as many links as it takes.
    fn arities(&mut self) {
        let off = |name: &str| self.document.nodes.get(name).is_some_and(|entry| entry.mode.is_off());
        for (name, draft) in self.nodes.iter().filter(|(name, _)| !off(name)) {
            for (socket, written) in draft.node.ty.spec.inputs.iter().zip(&draft.written) {
                let item = format!("input `{}`", socket.name);
                let (kind, found, expected) = match (socket.arity, written.len()) {
                    (Arity::One, 0) => {
                        let expected = format!("a link that brings {}", socket.ty);
                        let reason = self.off.lost.get(&((*name).to_owned(), socket.name.to_owned()));
                        let found =
                            reason.map_or("nothing".into(), |reason| format!("nothing, since {reason}"));
                        (ProblemKind::MissingInput, found, expected)
                    }
                    (Arity::One | Arity::Optional, 2..) => {
                        let found = format!("{} links, from {}", written.len(), written.join(", "));
                        (ProblemKind::TooManyLinks, found, "one link".to_owned())
                    }
                    _ => continue,
                };
                self.problems.push(Problem::new(kind, Some(name), item, found, expected));
            }
        }
    }

    /// The topology and an order in which sources come first.
    fn topology(&mut self) -> (DiGraph<usize, ()>, Vec<usize>) {
        let mut topology = DiGraph::new();
        for index in 0..self.nodes.len() {
            topology.add_node(index);
        }
        for (to, draft) in self.nodes.values().enumerate() {
            for source in draft.node.links.iter().flatten() {
                topology.update_edge(NodeIndex::new(source.node), NodeIndex::new(to), ());
            }
        }
        if let Ok(order) = toposort(&topology, None) {
            return (topology, order.into_iter().map(NodeIndex::index).collect());
        }
        let names: Vec<_> = self.nodes.keys().copied().collect();
        for nodes in cycle::loops(&topology) {
            let Some(&first) = nodes.first() else { continue };
            let way = nodes.iter().chain([&first]).map(|&n| format!("`{}`", names[n])).collect::<Vec<_>>();
            let found = format!("a loop {}", way.join(" -> "));
            let expected = "links that lead no node back to itself";
            self.report(Problem::new(ProblemKind::Cycle, Some(names[first]), "links", found, expected));
        }
        (topology, Vec::new())
    }

    /// What the nodes that are off pass on.
    fn passed(&self, graph: &mut Graph, indices: &BTreeMap<&str, usize>) {
        let at = |node: &str, socket: &str| {
            let sockets = &self.nodes.get(node)?.node.ty.spec.outputs;
            let output = sockets.iter().position(|output| output.name == socket)?;
            Some(Source { node: *indices.get(node)?, output })
        };
        for ((node, socket), passed) in &self.off.passed {
            let passed = match passed {
                Ok((node, socket)) => at(node, socket).map(Ok),
                Err(reason) => Some(Err(reason.clone())),
            };
            if let Some((here, passed)) = at(node, socket).zip(passed) {
                graph.passed.insert((here.node, here.output), passed);
            }
        }
    }

    fn interface(&mut self, graph: &mut Graph, indices: &BTreeMap<&str, usize>) {
        let interface = &self.document.interface;
        let names = interface.inputs.keys().map(|n| (n, "input"));
        let names = names.chain(interface.outputs.keys().map(|n| (n, "output")));
        for (name, what) in names.chain(interface.params.keys().map(|n| (n, "parameter"))) {
            if !is_name(name) {
                let (item, found) = (format!("name of an interface {what}"), format!("`{name}`"));
                self.report(Problem::new(
                    ProblemKind::BadName,
                    None,
                    item,
                    found,
                    "letters, digits, `_` and `-`",
                ));
            }
        }
        for (name, input) in &interface.inputs {
            if let Some(input) = self.interface_input(name, input, indices) {
                graph.inputs.insert(name.clone(), input);
            }
        }
        for (name, output) in &interface.outputs {
            let item = format!("interface output `{name}`");
            let Some(draft) = self.interface_node(&item, &output.node) else { continue };
            let sockets = &draft.node.ty.spec.outputs;
            match (sockets.iter().position(|s| s.name == output.socket), indices.get(output.node.as_str())) {
                (Some(socket), Some(&node)) => {
                    let docs = output.docs.clone();
                    graph.outputs.insert(name.clone(), interface::Output { docs, node, output: socket });
                }
                _ => {
                    let known: Vec<_> = sockets.iter().map(|s| s.name).collect();
                    let (kind, node) = (ProblemKind::UnknownSocket, Some(output.node.as_str()));
                    self.report(Problem::unknown(kind, node, item, &output.socket, "outputs", known));
                }
            }
        }
        for (name, param) in &interface.params {
            let item = format!("interface parameter `{name}`");
            if param.targets.is_empty() {
                let expected = "at least one `node.parameter`";
                self.report(Problem::new(ProblemKind::BadLink, None, item.clone(), "no targets", expected));
            }
            let mut targets = Vec::new();
            for target in &param.targets {
                targets.extend(self.interface_target(&item, target, param.default.as_ref(), indices));
            }
            if !targets.is_empty() {
                let docs = param.docs.clone();
                graph.params.insert(name.clone(), interface::Param { docs, targets, zone: None });
            }
        }
    }

    fn interface_input(
        &mut self,
        name: &str,
        input: &InterfaceInput,
        indices: &BTreeMap<&str, usize>,
    ) -> Option<interface::Input> {
        let item = format!("interface input `{name}`");
        if let Some(node) = self.values.get(name) {
            let node = *indices.get(node.as_str())?;
            let (ty, docs) = (input.ty.clone(), input.docs.clone());
            return Some(interface::Input { ty, docs, node, param: None, output: 0 });
        }
        let spec = &self.interface_node(&item, &input.node)?.node.ty.clone().spec;
        let files = || spec.params.iter().filter(|p| matches!(p.kind, ParamKind::File { .. }));
        let node = Some(input.node.as_str());
        let param = files().find(|p| p.name == input.param);
        if param.is_none() {
            let known = files().map(|p| p.name);
            let kind = ProblemKind::UnknownParam;
            self.report(Problem::unknown(kind, node, item.clone(), &input.param, "file parameters", known));
        }
        let output = spec.outputs.iter().position(|o| o.ty == input.ty);
        if output.is_none() {
            let types: Vec<_> = spec.outputs.iter().map(|o| o.ty).collect();
            let expected = format!("the type of an output of the node: {}", types.join(", "));
            let found = format!("type {}", input.ty);
            self.report(Problem::new(ProblemKind::TypeMismatch, node, item, found, expected));
        }
        Some(interface::Input {
            ty: input.ty.clone(),
            docs: input.docs.clone(),
            node: *indices.get(input.node.as_str())?,
            param: Some(param?.name),
            output: output?,
        })
    }

    fn interface_target(
        &mut self,
        item: &str,
        target: &str,
        default: Option<&ParamValue>,
        indices: &BTreeMap<&str, usize>,
    ) -> Option<(usize, usize)> {
        let Some((node, param)) = split_path(target) else {
            let (found, expected) = (format!("target `{target}`"), "a target such as `node.parameter`");
            self.report(Problem::new(ProblemKind::BadLink, None, item, found, expected));
            return None;
        };
        let ty = self.interface_node(item, node)?.node.ty.clone();
        let Some(index) = ty.spec.params.iter().position(|p| p.name == param) else {
            let known = ty.spec.params.iter().map(|p| p.name);
            self.report(Problem::unknown(
                ProblemKind::UnknownParam,
                Some(node),
                item,
                param,
                "parameters",
                known,
            ));
            return None;
        };
        let spec = &ty.spec.params[index];
        match default.map(|value| spec.kind.check(value)) {
            Some(Ok(value)) => {
                let value = self.located(&spec.kind, value);
                // A value for all targets beats what their nodes say.
                if let Some(draft) = self.nodes.get_mut(node) {
                    draft.node.params.insert(spec.name, value);
                }
            }
            Some(Err(mismatch)) => self.report(Problem::mismatch(Some(node), item.to_owned(), mismatch)),
            None => {}
        }
        Some((*indices.get(node)?, index))
    }

    /// A node that the interface refers to; reports it if there is none.
    fn interface_node(&mut self, item: &str, node: &str) -> Option<&Draft> {
        if !self.document.nodes.contains_key(node) {
            let problem = self.unknown_node(item.to_owned(), node);
            self.report(problem);
        }
        self.nodes.get(node)
    }
}
