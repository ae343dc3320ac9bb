//! The links of the flat graph: where each begins and ends once groups and zones are written out.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::instance::Tree;
use super::off::Off;
use crate::document::{Link, NodeEntry, NodeMode, split_path};
use crate::flow::{self, Flag};
use crate::graph::{Problem, ProblemKind};
use crate::node::Node;
use crate::registry::NodeType;
use crate::value::Data;

/// An output of the flat graph: node and socket.
type Output = (String, String);

/// An output, or, where there is none because of a node that is muted or bypassed, the reason.
type Found = Result<Output, Option<String>>;

/// How many groups a value may pass through without meeting a node.
const MAX_STEPS: usize = 3_000;

pub(super) struct Resolver<'t, 'a> {
    tree: &'t Tree<'a>,
    pub nodes: BTreeMap<String, NodeEntry>,
    pub links: Vec<String>,
    pub types: BTreeMap<String, Arc<NodeType>>,
    /// Inputs of the document that take a value: name and node.
    pub values: BTreeMap<String, String>,
    /// Nodes that are muted or bypassed.
    pub off: Off,
    pub problems: Vec<Problem>,
    steps: Cell<usize>,
    /// What was found before, by instance, node and socket. What is being looked for is found to be nothing, so that
    /// a way that leads back to itself ends.
    known: RefCell<HashMap<(usize, String, String), Found>>,
    /// What iterations give, by instance and output.
    known_after: RefCell<HashMap<(usize, String), Found>>,
}

impl<'t, 'a> Resolver<'t, 'a> {
    pub fn new(tree: &'t Tree<'a>) -> Self {
        Self {
            tree,
            nodes: BTreeMap::new(),
            links: Vec::new(),
            types: BTreeMap::new(),
            values: BTreeMap::new(),
            off: Off::default(),
            problems: Vec::new(),
            steps: Cell::default(),
            known: RefCell::default(),
            known_after: RefCell::default(),
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
            self.passed(instance);
        }
    }

    /// Whether a node of an instance neither runs nor takes anything.
    fn is_off(&self, instance: usize, node: &str) -> bool {
        self.tree.instances[instance].entries.get(node).is_some_and(|entry| entry.mode.is_off())
    }

    /// Notes what the nodes that are off pass on.
    fn passed(&mut self, instance: usize) {
        let here = &self.tree.instances[instance];
        for (name, entry) in here.entries.iter().filter(|(_, entry)| entry.mode.is_off()) {
            let Some(ty) = self.tree.registry.node(&entry.ty) else { continue };
            for socket in ty.spec.outputs.iter().filter(|_| !here.zones.contains_key(name.as_str())) {
                let found = self.output(instance, name, socket.name).map_err(Option::unwrap_or_default);
                self.off.passed.insert((self.tree.path(instance, name), socket.name.to_owned()), found);
            }
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
        if !self.known_output(instance, &link.from_node, &link.from_socket)
            || here.zones.contains_key(link.to_node.as_str())
            || self.is_off(instance, &link.to_node)
        {
            return;
        }
        let to = self.tree.path(instance, &link.to_node);
        match self.output(instance, &link.from_node, &link.from_socket) {
            Ok((node, socket)) => self.links.push(format!("{node}.{socket} -> {to}.{}", link.to_socket)),
            Err(Some(reason)) => {
                self.off.lost.insert((to, link.to_socket), reason);
            }
            Err(None) => {}
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

    /// Where a value of an instance comes from. Nothing where nothing is linked, or the name is unknown.
    pub fn output(&self, instance: usize, node: &str, socket: &str) -> Found {
        let key = (instance, node.to_owned(), socket.to_owned());
        if let Some(known) = self.known.borrow().get(&key) {
            return known.clone();
        }
        if self.steps.get() >= MAX_STEPS {
            return Err(None);
        }
        self.known.borrow_mut().insert(key.clone(), Err(None));
        self.steps.set(self.steps.get() + 1);
        let found = self.output_step(instance, node, socket);
        self.steps.set(self.steps.get() - 1);
        self.known.borrow_mut().insert(key, found.clone());
        found
    }

    fn output_step(&self, instance: usize, node: &str, socket: &str) -> Found {
        let here = &self.tree.instances[instance];
        let mode = here.entries.get(node).map_or(NodeMode::Normal, |entry| entry.mode);
        if mode == NodeMode::Mute {
            return Err(Some(format!("node `{}` is muted", self.tree.path(instance, node))));
        }
        let Some(zone) = here.zones.get(node) else {
            // The reader of an input that is linked gives way to what is linked.
            let reader = here
                .interface
                .inputs
                .iter()
                .find(|(_, input)| input.node == node && input.targets.is_empty());
            if let Some((name, _)) = reader.filter(|_| here.parent.is_some())
                && let Some(source) = self.incoming(instance, name).into_iter().find(Found::is_ok)
            {
                return source;
            }
            if mode == NodeMode::Bypass {
                return self.bypassed(instance, node, socket);
            }
            return Ok((self.tree.path(instance, node), socket.to_owned()));
        };
        if mode == NodeMode::Bypass {
            return self.bypassed(instance, node, socket);
        }
        let Some(&last) = zone.instances.last() else {
            // No iteration: what goes in comes out.
            return first(self.linked(instance, node, socket));
        };
        let found = self.after(last, zone.stops, socket);
        if zone.must_stop && found.is_ok() {
            return Ok((self.required(instance, node, socket), "value".to_owned()));
        }
        found
    }

    /// What a bypassed node passes on.
    fn bypassed(&self, instance: usize, node: &str, socket: &str) -> Found {
        let bypassed = format!("node `{}` is bypassed, and", self.tree.path(instance, node));
        let Some(input) = self.tree.passing(instance, node, socket) else {
            return Err(Some(format!("{bypassed} has no input of the type of its output `{socket}`")));
        };
        match first(self.linked(instance, node, &input)) {
            Err(None) => Err(Some(format!("{bypassed} nothing goes into its input `{input}`"))),
            found => found,
        }
    }

    /// What an iteration gives: its own output, or that of a gate that knows whether the zone had stopped.
    fn after(&self, instance: usize, stops: bool, socket: &str) -> Found {
        let key = (instance, socket.to_owned());
        if let Some(known) = self.known_after.borrow().get(&key) {
            return known.clone();
        }
        let found = self.after_step(instance, stops, socket);
        self.known_after.borrow_mut().insert(key, found.clone());
        found
    }

    fn after_step(&self, instance: usize, stops: bool, socket: &str) -> Found {
        let here = &self.tree.instances[instance];
        let output = here.interface.outputs.get(socket).ok_or(None)?;
        let own = self.output(instance, &output.node, &output.socket)?;
        let Some((parent, node)) = here.parent.filter(|_| stops && here.iteration > 0) else {
            return Ok(own);
        };
        // There is a gate only where there is something for it to choose from.
        let before = self.tree.instances[parent].zones[node].instances[here.iteration - 1];
        self.after(before, stops, socket)?;
        if socket != "stop" {
            self.after(before, stops, "stop")?;
        }
        Ok((format!("{}={socket}", here.prefix), "value".to_owned()))
    }

    fn required(&self, instance: usize, node: &str, socket: &str) -> String {
        format!("{}/must_stop={socket}", self.tree.path(instance, node))
    }

    /// What is linked to a socket of a node of an instance.
    fn linked(&self, instance: usize, node: &str, socket: &str) -> Vec<Found> {
        let links = self.tree.instances[instance].links.iter().filter_map(|text| Link::parse(text));
        let links = links.filter(|link| link.to_node == node && link.to_socket == socket);
        let mut found: Vec<Found> =
            links.map(|link| self.output(instance, &link.from_node, &link.from_socket)).collect();
        found.extend(self.through(instance, node, socket));
        found
    }

    /// What an input of the surrounding instance, or of the document, brings straight to a socket.
    fn through(&self, instance: usize, node: &str, socket: &str) -> Vec<Found> {
        let here = &self.tree.instances[instance];
        let target = format!("{node}.{socket}");
        let inputs = here.interface.inputs.iter().filter(|(_, input)| input.targets.contains(&target));
        inputs
            .flat_map(|(name, _)| match here.parent {
                Some(_) => self.incoming(instance, name),
                None => vec![Ok((format!("={name}"), "value".to_owned()))],
            })
            .collect()
    }

    /// What an instance is given for one of its inputs.
    fn incoming(&self, instance: usize, input: &str) -> Vec<Found> {
        self.steps.set(self.steps.get() + 1);
        if self.steps.get() > MAX_STEPS {
            return Vec::new();
        }
        let here = &self.tree.instances[instance];
        let Some((parent, node)) = here.parent else { return Vec::new() };
        let zone = &self.tree.instances[parent].zones[node];
        let found = if here.iteration > 0 && here.interface.outputs.contains_key(input) {
            let before = zone.instances[here.iteration - 1];
            vec![self.after(before, zone.stops, input)]
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
            let (sources, lacks): (Vec<_>, Vec<_>) =
                self.incoming(instance, name).into_iter().partition(Result::is_ok);
            let sources: Vec<Output> = sources.into_iter().flatten().collect();
            let reason = lacks.into_iter().find_map(|lack| lack.err().flatten());
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
                    None => self.lacks(instance, target, &item, reason.as_deref()),
                }
            }
        }
    }

    /// Links a value to a target of an interface, unless that is a group, which sees to it itself.
    fn ends(&mut self, instance: usize, target: &str, source: &Output, item: &str) {
        self.check_target(instance, target, item);
        let Some((node, socket)) = split_path(target) else { return };
        let here = &self.tree.instances[instance];
        if here.entries.get(node).is_some_and(|entry| !entry.mode.is_off()) && !here.zones.contains_key(node)
        {
            let to = self.tree.path(instance, node);
            self.links.push(format!("{}.{} -> {to}.{socket}", source.0, source.1));
        }
    }

    /// Notes why there is nothing for a target of an interface.
    fn lacks(&mut self, instance: usize, target: &str, item: &str, reason: Option<&str>) {
        self.check_target(instance, target, item);
        if let Some(((node, socket), reason)) = split_path(target).zip(reason) {
            self.off.lost.insert((self.tree.path(instance, node), socket.to_owned()), reason.to_owned());
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
            let Ok(stopped) = stop(here.iteration - 1) else { return };
            for name in &names {
                let before = self.after(zone.instances[here.iteration - 1], true, name);
                let output = &here.interface.outputs[*name];
                let own = self.output(instance, &output.node, &output.socket);
                let (Ok(before), Ok(own)) = (before, own) else { continue };
                let Some(ty) = self.type_of(&own) else { continue };
                let gate = format!("{}={name}", here.prefix);
                self.add(&gate, flow::GATE, ty, flow::gate);
                self.links.push(format!("{}.{} -> {gate}.stop", stopped.0, stopped.1));
                self.links.push(format!("{}.{} -> {gate}.kept", before.0, before.1));
                self.links.push(format!("{}.{} -> {gate}.next", own.0, own.1));
            }
        }
        if zone.stops && last {
            let stopped = self.after(instance, true, "stop").ok();
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
                    let (Some(stopped), Ok(value)) = (&stopped, value) else { continue };
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

/// The first of several outputs, or the first reason why there is none.
fn first(all: Vec<Found>) -> Found {
    all.iter().find(|found| found.is_ok()).or(all.first()).cloned().unwrap_or(Err(None))
}
