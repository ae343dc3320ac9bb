//! What a node looks like from outside: its sockets and parameters, from its type or from the graph that it stands for.

use std::collections::{BTreeMap, BTreeSet};

use breccia_engine::{Arity, Document, Group, Link, NodeEntry, ParamKind, ParamSpec, ParamValue, Registry};

use super::level::{Address, Level, body};

/// How deep groups are followed.
const MAX_DEPTH: usize = 16;

/// A socket of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Socket {
    /// Its name.
    pub name: String,
    /// Its type; empty if nobody knows.
    pub ty: String,
    /// How many links it takes.
    pub arity: Arity,
    /// What flows through it.
    pub docs: String,
}

/// A parameter of a node.
#[derive(Clone, Debug)]
pub struct ParamShape {
    /// Its name.
    pub name: String,
    /// The values it takes.
    pub kind: ParamKind,
    /// Its unit.
    pub unit: &'static str,
    /// The value where the document gives none; none if that depends on what the parameter sets.
    pub default: ParamValue,
    /// What it does.
    pub docs: String,
}

impl ParamShape {
    fn of(spec: &ParamSpec) -> Self {
        Self {
            name: spec.name.to_owned(),
            kind: spec.kind.clone(),
            unit: spec.unit,
            default: spec.default.clone(),
            docs: spec.docs.to_owned(),
        }
    }
}

/// What a node looks like from outside.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Whether the type is known, and so is the group where it stands for one.
    pub known: bool,
    /// The id of its type.
    pub ty: String,
    /// Its heading in palettes.
    pub category: String,
    /// One line.
    pub summary: String,
    /// Paragraphs in Markdown.
    pub docs: String,
    /// The paper and section.
    pub paper: Option<&'static str>,
    /// Inputs in display order.
    pub inputs: Vec<Socket>,
    /// Outputs in display order.
    pub outputs: Vec<Socket>,
    /// Parameters in display order.
    pub params: Vec<ParamShape>,
    /// The graph that it stands for.
    pub group: Option<Address>,
}

impl Shape {
    /// An input by name.
    pub fn input(&self, name: &str) -> Option<&Socket> {
        self.inputs.iter().find(|socket| socket.name == name)
    }

    /// An output by name.
    pub fn output(&self, name: &str) -> Option<&Socket> {
        self.outputs.iter().find(|socket| socket.name == name)
    }

    /// A parameter by name.
    pub fn param(&self, name: &str) -> Option<&ParamShape> {
        self.params.iter().find(|param| param.name == name)
    }
}

/// What a node looks like. `document` has its groups included, so that those in files are known too; `name` is the node's.
pub fn shape_of(
    document: &Document,
    registry: &Registry,
    at: &Address,
    name: &str,
    entry: &NodeEntry,
) -> Shape {
    shape(document, registry, at, name, entry, &mut Vec::new())
}

fn shape(
    document: &Document,
    registry: &Registry,
    at: &Address,
    name: &str,
    entry: &NodeEntry,
    way: &mut Vec<Address>,
) -> Shape {
    let Some(ty) = registry.node(&entry.ty) else { return placeholder(document, at, name, entry) };
    let spec = &ty.spec;
    let socket = |s: &breccia_engine::SocketSpec| Socket {
        name: s.name.to_owned(),
        ty: s.ty.to_owned(),
        arity: s.arity,
        docs: s.docs.to_owned(),
    };
    let mut found = Shape {
        known: true,
        ty: entry.ty.clone(),
        category: spec.category.to_owned(),
        summary: spec.summary.to_owned(),
        docs: spec.docs.to_owned(),
        paper: spec.paper,
        inputs: spec.inputs.iter().map(socket).collect(),
        outputs: spec.outputs.iter().map(socket).collect(),
        params: spec.params.iter().map(ParamShape::of).collect(),
        group: None,
    };
    let stands_for_graph = spec.params.iter().any(|param| param.name == "body") && spec.category == "flow";
    if stands_for_graph {
        // A group that holds itself has no end.
        match body(document, at, entry).filter(|(address, _)| way.len() < MAX_DEPTH && !way.contains(address))
        {
            Some((address, group)) => {
                way.push(address.clone());
                inside(&mut found, document, registry, &address, group, way);
                way.pop();
            }
            None => {
                let placeholder = placeholder(document, at, name, entry);
                found.known = false;
                (found.inputs, found.outputs) = (placeholder.inputs, placeholder.outputs);
            }
        }
    }
    found
}

/// Adds what the interface of a group offers.
fn inside(
    found: &mut Shape,
    document: &Document,
    registry: &Registry,
    address: &Address,
    group: &Group,
    way: &mut Vec<Address>,
) {
    // Each inner node once, however many entries of the interface name it.
    let named = group.interface.inputs.values().flat_map(|input| &input.targets);
    let named = named.chain(group.interface.params.values().flat_map(|param| &param.targets));
    let named = named.filter_map(|target| target.split_once('.')).map(|(node, _)| node);
    let named: BTreeSet<&str> =
        named.chain(group.interface.outputs.values().map(|o| o.node.as_str())).collect();
    let mut shapes = BTreeMap::new();
    for node in named {
        if let Some(entry) = group.nodes.get(node) {
            shapes.insert(node, shape(document, registry, address, node, entry, way));
        }
    }
    let inner = |node: &str| shapes.get(node);
    if !group.docs.is_empty() {
        found.docs = format!("{}\n\n{}", group.docs, found.docs);
    }
    for (name, input) in &group.interface.inputs {
        let arity = input.targets.iter().find_map(|target| {
            let (node, socket) = target.split_once('.')?;
            Some(inner(node)?.input(socket)?.arity)
        });
        found.inputs.push(Socket {
            name: name.clone(),
            ty: input.ty.clone(),
            arity: arity.unwrap_or(Arity::Optional),
            docs: input.docs.clone(),
        });
    }
    for (name, output) in &group.interface.outputs {
        let ty = inner(&output.node).and_then(|shape| Some(shape.output(&output.socket)?.ty.clone()));
        found.outputs.push(Socket {
            name: name.clone(),
            ty: ty.unwrap_or_default(),
            arity: Arity::One,
            docs: output.docs.clone(),
        });
    }
    for (name, param) in &group.interface.params {
        let first = param.targets.iter().find_map(|target| {
            let (node, inner_name) = target.split_once('.')?;
            let shape = inner(node)?;
            let own = group.nodes.get(node)?.params.get(inner_name).cloned();
            let mut found = shape.param(inner_name)?.clone();
            found.default = param.default.clone().or(own).unwrap_or(found.default);
            Some(found)
        });
        let Some(mut first) = first else { continue };
        name.clone_into(&mut first.name);
        if !param.docs.is_empty() {
            first.docs.clone_from(&param.docs);
        }
        found.params.push(first);
    }
    found.group = Some(address.clone());
}

/// A node of which nobody knows more than what links and parameters say.
fn placeholder(document: &Document, at: &Address, name: &str, entry: &NodeEntry) -> Shape {
    let (mut inputs, mut outputs) = (BTreeSet::new(), BTreeSet::new());
    let links = Level::of(document, at).map_or(&[][..], |level| level.links);
    for link in links.iter().filter_map(|link| Link::parse(link)) {
        if link.to_node == name {
            inputs.insert(link.to_socket);
        } else if link.from_node == name {
            outputs.insert(link.from_socket);
        }
    }
    let socket = |arity| {
        move |name: String| Socket {
            name,
            ty: String::new(),
            arity,
            docs: "Of a type that is not known here.".into(),
        }
    };
    Shape {
        known: false,
        ty: entry.ty.clone(),
        category: entry.ty.split('.').next().unwrap_or_default().to_owned(),
        summary: "A node of a type that this program does not know".into(),
        docs: "It is kept as it is and written back unchanged. What needs it cannot run here.".into(),
        paper: None,
        inputs: inputs.into_iter().map(socket(Arity::Many)).collect(),
        outputs: outputs.into_iter().map(socket(Arity::One)).collect(),
        params: Vec::new(),
        group: None,
    }
}
