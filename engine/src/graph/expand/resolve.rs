//! The links of the flat graph: where each begins and ends once groups and zones are written out.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::instance::Tree;
use crate::document::{Link, NodeEntry, split_path};
use crate::flow::{self, Flag};
use crate::graph::{Problem, ProblemKind};
use crate::node::Node;
use crate::registry::NodeType;
use crate::value::Data;

/// An output of the flat graph: node and socket.
type Output = (String, String);

/// How many groups a value may pass through without meeting a node.
const MAX_STEPS: usize = 3_000;

pub(super) struct Resolver<'t, 'a> {
    tree: &'t Tree<'a>,
    pub nodes: BTreeMap<String, NodeEntry>,
    pub links: Vec<String>,
    pub types: BTreeMap<String, Arc<NodeType>>,
    /// Inputs of the document that take a value: name and node.
    pub values: BTreeMap<String, String>,
    pub problems: Vec<Problem>,
    steps: std::cell::Cell<usize>,
}

impl<'t, 'a> Resolver<'t, 'a> {
    pub fn new(tree: &'t Tree<'a>) -> Self {
        Self {
            tree,
            nodes: BTreeMap::new(),
            links: Vec::new(),
            types: BTreeMap::new(),
            values: BTreeMap::new(),
            problems: Vec::new(),
            steps: std::cell::Cell::default(),
        }
    }

    /// Makes all nodes and links.
    pub fn connect(&mut self) {
        for instance in 0..self.tree.instances.len() {
            self.plain_nodes(instance);
        }
        self.values();
        // Gates of an inner zone are there before those of the outer one ask for their types.
        for instance in (0..self.tree.instances.len()).rev() {
            self.gates(instance);
        }
        for instance in 0..self.tree.instances.len() {
            for text in self.tree.instances[instance].links {
                self.link(instance, text);
            }
            self.fed(instance);
        }
    }

    fn plain_nodes(&mut self, instance: usize) {
        let here = &self.tree.instances[instance];
        for (name, entry) in here.entries.iter().filter(|(name, _)| !here.zones.contains_key(name.as_str())) {
            let params = self.tree.params(instance, name);
            let entry = NodeEntry { params, ..entry.clone() };
            self.nodes.insert(self.tree.path(instance, name), entry);
        }
    }

    /// A node for every input of the document that takes a value.
    fn values(&mut self) {
        for (name, input) in &self.tree.document.interface.inputs {
            if input.targets.is_empty() {
                continue;
            }
            let item = format!("interface input `{name}`");
            let Some(ty) = self.tree.registry.socket_type(&input.ty) else {
                let known = self.tree.registry.types().map(|ty| ty.name);
                let kind = ProblemKind::TypeMismatch;
                self.problems.push(Problem::unknown(kind, None, item, &input.ty, "types", known));
                continue;
            };
            let node = format!("={name}");
            self.add(&node, flow::VALUE, ty.name, flow::value);
            self.values.insert(name.clone(), node.clone());
            for target in &input.targets {
                self.ends(0, target, &(node.clone(), "value".to_owned()), &item);
            }
        }
    }

    /// The type of an output of the flat graph.
    fn type_of(&self, output: &Output) -> Option<&'static str> {
        let entry = self.nodes.get(&output.0)?;
        let ty = self.tree.registry.node(&entry.ty).or_else(|| self.types.get(&entry.ty))?;
        ty.spec.outputs.iter().find(|socket| socket.name == output.1).map(|socket| socket.ty)
    }

    /// Adds a node of a type that exists for every type of values.
    fn add(&mut self, name: &str, id: &str, ty: &'static str, make: fn(&'static str) -> Box<dyn Node>) {
        let id = format!("{id}:{ty}");
        self.types.entry(id.clone()).or_insert_with(|| {
            let node = make(ty);
            Arc::new(NodeType { spec: node.spec(), node })
        });
        self.nodes.insert(name.to_owned(), NodeEntry::new(id));
    }

    /// A link as it stands in an instance. Links into groups are made from within, see [`Self::fed`].
    fn link(&mut self, instance: usize, text: &str) {
        let Some(link) = Link::parse(text) else {
            let (found, expected) = (format!("`{text}`"), "a link such as `node.output -> node.input`");
            self.problems.push(Problem::new(ProblemKind::BadLink, None, "link", found, expected));
            return;
        };
        let here = &self.tree.instances[instance];
        let item = format!("link `{text}`");
        for node in [&link.from_node, &link.to_node] {
            if !here.entries.contains_key(node) {
                let known = here.entries.keys().map(String::as_str);
                let kind = ProblemKind::UnknownNode;
                self.problems.push(Problem::unknown(kind, None, item.clone(), node, "nodes", known));
                return;
            }
        }
        if let Some(zone) = here.zones.get(link.to_node.as_str()) {
            let Some(&inner) = zone.instances.first() else { return };
            let inputs = &self.tree.instances[inner].interface.inputs;
            if !inputs.contains_key(&link.to_socket) {
                let known = inputs.keys().map(String::as_str);
                let path = self.tree.path(instance, &link.to_node);
                let kind = ProblemKind::UnknownSocket;
                let problem = Problem::unknown(kind, Some(&path), "input", &link.to_socket, "inputs", known);
                self.problems.push(problem);
            }
        }
        if self.known_output(instance, &link.from_node, &link.from_socket)
            && !here.zones.contains_key(link.to_node.as_str())
            && let Some((node, socket)) = self.output(instance, &link.from_node, &link.from_socket)
        {
            let to = self.tree.path(instance, &link.to_node);
            self.links.push(format!("{node}.{socket} -> {to}.{}", link.to_socket));
        }
    }

    /// Whether a group has such an output; says so if not. Of other nodes the checks come later.
    fn known_output(&mut self, instance: usize, node: &str, socket: &str) -> bool {
        let Some(zone) = self.tree.instances[instance].zones.get(node) else { return true };
        let Some(&inner) = zone.instances.last() else { return true };
        let outputs = &self.tree.instances[inner].interface.outputs;
        if outputs.contains_key(socket) {
            return true;
        }
        let (known, path) = (outputs.keys().map(String::as_str), self.tree.path(instance, node));
        let kind = ProblemKind::UnknownSocket;
        self.problems.push(Problem::unknown(kind, Some(&path), "output", socket, "outputs", known));
        false
    }

    /// Where a value of an instance comes from. `None` where nothing is linked, or the name is unknown.
    pub fn output(&self, instance: usize, node: &str, socket: &str) -> Option<Output> {
        self.steps.set(self.steps.get() + 1);
        if self.steps.get() > MAX_STEPS {
            return None;
        }
        let found = self.output_step(instance, node, socket);
        self.steps.set(self.steps.get() - 1);
        found
    }

    fn output_step(&self, instance: usize, node: &str, socket: &str) -> Option<Output> {
        let here = &self.tree.instances[instance];
        let Some(zone) = here.zones.get(node) else {
            // The reader of an input that is linked gives way to what is linked.
            let reader = here
                .interface
                .inputs
                .iter()
                .find(|(_, input)| input.node == node && input.targets.is_empty());
            if let Some((name, _)) = reader.filter(|_| here.parent.is_some())
                && let Some(source) = self.incoming(instance, name).into_iter().next()
            {
                return Some(source);
            }
            return Some((self.tree.path(instance, node), socket.to_owned()));
        };
        let Some(&last) = zone.instances.last() else {
            // No iteration: what goes in comes out.
            return self.linked(instance, node, socket).into_iter().next();
        };
        if zone.must_stop {
            return Some((self.required(instance, node, socket), "value".to_owned()));
        }
        self.after(last, zone.stops, socket)
    }

    /// What an iteration gives: its own output, or that of a gate that knows whether the zone had stopped.
    fn after(&self, instance: usize, stops: bool, socket: &str) -> Option<Output> {
        let here = &self.tree.instances[instance];
        if stops && here.iteration > 0 {
            return Some((format!("{}={socket}", here.prefix), "value".to_owned()));
        }
        let output = here.interface.outputs.get(socket)?;
        self.output(instance, &output.node, &output.socket)
    }

    fn required(&self, instance: usize, node: &str, socket: &str) -> String {
        format!("{}/must_stop={socket}", self.tree.path(instance, node))
    }

    /// What is linked to a socket of a node of an instance.
    fn linked(&self, instance: usize, node: &str, socket: &str) -> Vec<Output> {
        let links = self.tree.instances[instance].links.iter().filter_map(|text| Link::parse(text));
        let links = links.filter(|link| link.to_node == node && link.to_socket == socket);
        let mut found: Vec<Output> =
            links.filter_map(|link| self.output(instance, &link.from_node, &link.from_socket)).collect();
        found.extend(self.through(instance, node, socket));
        found
    }

    /// What an input of the surrounding instance, or of the document, brings straight to a socket.
    fn through(&self, instance: usize, node: &str, socket: &str) -> Vec<Output> {
        let here = &self.tree.instances[instance];
        let target = format!("{node}.{socket}");
        let inputs = here.interface.inputs.iter().filter(|(_, input)| input.targets.contains(&target));
        inputs
            .flat_map(|(name, _)| match here.parent {
                Some(_) => self.incoming(instance, name),
                None => vec![(format!("={name}"), "value".to_owned())],
            })
            .collect()
    }

    /// What an instance is given for one of its inputs.
    fn incoming(&self, instance: usize, input: &str) -> Vec<Output> {
        self.steps.set(self.steps.get() + 1);
        if self.steps.get() > MAX_STEPS {
            return Vec::new();
        }
        let here = &self.tree.instances[instance];
        let Some((parent, node)) = here.parent else { return Vec::new() };
        let zone = &self.tree.instances[parent].zones[node];
        let found = if here.iteration > 0 && here.interface.outputs.contains_key(input) {
            let before = zone.instances[here.iteration - 1];
            self.after(before, zone.stops, input).into_iter().collect()
        } else {
            self.linked(parent, node, input)
        };
        self.steps.set(self.steps.get() - 1);
        found
    }

    /// Links what an instance is given to the sockets that it goes to.
    fn fed(&mut self, instance: usize) {
        let here = &self.tree.instances[instance];
        if here.parent.is_none() {
            return;
        }
        for (name, input) in &here.interface.inputs {
            let item = format!("input `{name}` of group at `{}`", here.prefix.trim_end_matches('/'));
            let sources = self.incoming(instance, name);
            for source in &sources {
                if let Some(found) = self.type_of(source).filter(|found| *found != input.ty) {
                    let found = format!("{found} from `{}.{}`", source.0, source.1);
                    let problem =
                        Problem::new(ProblemKind::TypeMismatch, None, item.clone(), found, input.ty.as_str());
                    self.problems.push(problem);
                }
            }
            for target in &input.targets {
                match sources.first() {
                    Some(_) => sources.iter().for_each(|source| self.ends(instance, target, source, &item)),
                    None => self.check_target(instance, target, &item),
                }
            }
        }
    }

    /// Links a value to a target of an interface, unless that is a group, which sees to it itself.
    fn ends(&mut self, instance: usize, target: &str, source: &Output, item: &str) {
        self.check_target(instance, target, item);
        let Some((node, socket)) = split_path(target) else { return };
        let here = &self.tree.instances[instance];
        if here.entries.contains_key(node) && !here.zones.contains_key(node) {
            let to = self.tree.path(instance, node);
            self.links.push(format!("{}.{} -> {to}.{socket}", source.0, source.1));
        }
    }

    fn check_target(&mut self, instance: usize, target: &str, item: &str) {
        let here = &self.tree.instances[instance];
        match split_path(target) {
            Some((node, _)) if here.entries.contains_key(node) => {}
            Some((node, _)) => {
                let known = here.entries.keys().map(String::as_str);
                let kind = ProblemKind::UnknownNode;
                self.problems.push(Problem::unknown(kind, None, item.to_owned(), node, "nodes", known));
            }
            None => {
                let (found, expected) = (format!("target `{target}`"), "a target such as `node.input`");
                self.problems.push(Problem::new(
                    ProblemKind::BadLink,
                    None,
                    item.to_owned(),
                    found,
                    expected,
                ));
            }
        }
    }

    /// The gates after an iteration of a zone that can stop, and what a zone that must stop needs.
    fn gates(&mut self, instance: usize) {
        let here = &self.tree.instances[instance];
        for (name, output) in &here.interface.outputs {
            if here.parent.is_some() && !here.entries.contains_key(&output.node) {
                let item = format!("output `{name}` of group at `{}`", here.prefix.trim_end_matches('/'));
                let known = here.entries.keys().map(String::as_str);
                let kind = ProblemKind::UnknownNode;
                self.problems.push(Problem::unknown(kind, None, item, &output.node, "nodes", known));
            }
        }
        let Some((parent, node)) = here.parent else { return };
        let zone = &self.tree.instances[parent].zones[node];
        let last = zone.instances.last() == Some(&instance);
        let names: Vec<&String> = here.interface.outputs.keys().collect();
        let stop = |iteration: usize| self.after(zone.instances[iteration], zone.stops, "stop");
        if zone.stops && here.iteration > 0 {
            let Some(stopped) = stop(here.iteration - 1) else { return };
            for name in &names {
                let before = self.after(zone.instances[here.iteration - 1], true, name);
                let output = &here.interface.outputs[*name];
                let own = self.output(instance, &output.node, &output.socket);
                let (Some(before), Some(own)) = (before, own) else { continue };
                let Some(ty) = self.type_of(&own) else { continue };
                let gate = format!("{}={name}", here.prefix);
                self.add(&gate, flow::GATE, ty, flow::gate);
                self.links.push(format!("{}.{} -> {gate}.stop", stopped.0, stopped.1));
                self.links.push(format!("{}.{} -> {gate}.kept", before.0, before.1));
                self.links.push(format!("{}.{} -> {gate}.next", own.0, own.1));
            }
        }
        if zone.stops && last {
            let stopped = self.after(instance, true, "stop");
            if let Some(ty) = stopped.as_ref().and_then(|s| self.type_of(s)).filter(|ty| *ty != Flag::TYPE) {
                let path = self.tree.path(parent, node);
                let (found, expected) = (format!("type {ty}"), Flag::TYPE);
                let problem =
                    Problem::new(ProblemKind::TypeMismatch, Some(&path), "output `stop`", found, expected);
                self.problems.push(problem);
            }
            if zone.must_stop {
                for name in &names {
                    let value = self.after(instance, true, name);
                    let (Some(stopped), Some(value)) = (&stopped, value) else { continue };
                    let Some(ty) = self.type_of(&value) else { continue };
                    let node = self.required(parent, node, name);
                    self.add(&node, flow::REQUIRE, ty, flow::require);
                    self.links.push(format!("{}.{} -> {node}.stop", stopped.0, stopped.1));
                    self.links.push(format!("{}.{} -> {node}.next", value.0, value.1));
                }
            }
        }
    }
}
