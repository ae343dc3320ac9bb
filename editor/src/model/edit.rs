//! Changes to nodes, links and places.

use std::collections::{BTreeMap, BTreeSet};

use breccia_engine::{Arity, Interface, InterfaceOutput, Link, NodeEntry, NodeMode, Registry};

use super::layout::{Frame, Place};
use super::level::{Address, LevelMut};
use super::reach::reach;
use super::shape::{Shape, Socket};
use super::state::State;

/// Why a link cannot be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// In words.
    pub reason: String,
    /// Types of nodes that turn the one into the other, with their input and output.
    pub conversions: Vec<(String, String, String)>,
}

/// A name of that stem that is not taken: `stem`, `stem_2`, …
pub fn unique<V>(taken: &BTreeMap<String, V>, stem: &str) -> String {
    let stem: String =
        stem.chars().map(|c| if c.is_alphanumeric() || matches!(c, '_' | '-') { c } else { '_' }).collect();
    let stem = if stem.is_empty() { "node".to_owned() } else { stem };
    if !taken.contains_key(&stem) {
        return stem;
    }
    let base = stem.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('_');
    let base = if base.is_empty() { &stem } else { base };
    (2u64..).map(|i| format!("{base}_{i}")).find(|name| !taken.contains_key(name)).unwrap_or(stem)
}

/// Adds a node of a type and returns its name.
pub fn add_node(state: &mut State, at: &Address, entry: NodeEntry, place: [i32; 2]) -> Option<String> {
    let level = state.level_mut(at)?;
    let stem = entry.ty.rsplit('.').next().unwrap_or_default().to_owned();
    let name = unique(level.nodes, &stem);
    level.nodes.insert(name.clone(), entry);
    state.layout_mut(at).nodes.insert(name.clone(), Place { at: place, ..Place::default() });
    Some(name)
}

/// Whether a link may run from an output to an input.
///
/// # Errors
/// Why not, and what would convert the one into the other.
pub fn compatible(registry: &Registry, from: &Socket, to: &Socket) -> Result<(), Refusal> {
    if from.ty == to.ty || from.ty.is_empty() || to.ty.is_empty() {
        return Ok(());
    }
    let conversions = registry
        .nodes()
        .filter_map(|ty| {
            let spec = &ty.spec;
            let output = spec.outputs.iter().find(|output| output.ty == to.ty)?;
            let input = spec.inputs.iter().find(|input| input.ty == from.ty)?;
            let alone = spec.inputs.iter().all(|other| other.name == input.name || other.arity != Arity::One);
            alone.then(|| (spec.id.to_owned(), input.name.to_owned(), output.name.to_owned()))
        })
        .collect();
    let reason = format!("`{}` gives {}, `{}` takes {}", from.name, from.ty, to.name, to.ty);
    Err(Refusal { reason, conversions })
}

/// Whether one node is needed to compute another.
fn leads(links: &[String], from: &str, to: &str) -> bool {
    let links: Vec<Link> = links.iter().filter_map(|link| Link::parse(link)).collect();
    let mut next: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for link in &links {
        next.entry(&link.from_node).or_default().push(&link.to_node);
    }
    reach([from], |node| next.get(node).into_iter().flatten().copied()).contains(&to)
}

/// Makes a link; what the input took before gives way if it takes only one.
///
/// # Errors
/// If the two nodes would wait for each other.
pub fn connect(state: &mut State, at: &Address, link: &Link, arity: Arity) -> Result<(), Refusal> {
    let Some(level) = state.level_mut(at) else { return Ok(()) };
    if leads(level.links, &link.to_node, &link.from_node) {
        let reason =
            format!("`{}` needs `{}` already: they would wait for each other", link.from_node, link.to_node);
        return Err(Refusal { reason, conversions: Vec::new() });
    }
    let text = link.to_string();
    if level.links.contains(&text) {
        return Ok(());
    }
    if arity != Arity::Many {
        level.links.retain(|old| {
            Link::parse(old).is_none_or(|old| old.to_node != link.to_node || old.to_socket != link.to_socket)
        });
    }
    level.links.push(text);
    tidy(state, at);
    Ok(())
}

/// Removes links, by their texts.
pub fn disconnect(state: &mut State, at: &Address, links: &[String]) {
    if let Some(level) = state.level_mut(at) {
        level.links.retain(|link| !links.contains(link));
    }
    tidy(state, at);
}

/// Sorts links as documents do, and forgets bends of links that are gone.
pub(super) fn tidy(state: &mut State, at: &Address) {
    let Some(level) = state.level_mut(at) else { return };
    level.links.sort_by_cached_key(|link| match Link::parse(link) {
        Some(link) => (false, link.to_node, link.to_socket),
        None => (true, String::new(), String::new()),
    });
    let links: BTreeSet<String> = level.links.iter().cloned().collect();
    if let Some(layout) = state.layouts.get_mut(&at.text()) {
        layout.bends.retain(|link, _| links.contains(link));
    }
}

/// Removes nodes with their links, and what the interface says of them.
pub fn delete(state: &mut State, at: &Address, nodes: &BTreeSet<String>) {
    let Some(level) = state.level_mut(at) else { return };
    level.nodes.retain(|name, _| !nodes.contains(name));
    level.links.retain(|link| {
        Link::parse(link)
            .is_none_or(|link| !nodes.contains(&link.from_node) && !nodes.contains(&link.to_node))
    });
    forget(level.interface, nodes);
    if let Some(layout) = state.layouts.get_mut(&at.text()) {
        layout.nodes.retain(|name, _| !nodes.contains(name));
    }
    tidy(state, at);
}

fn forget(interface: &mut Interface, nodes: &BTreeSet<String>) {
    let gone = |target: &String| target.split_once('.').is_some_and(|(node, _)| nodes.contains(node));
    interface.outputs.retain(|_, output| !nodes.contains(&output.node));
    interface.params.retain(|_, param| {
        let had = !param.targets.is_empty();
        param.targets.retain(|target| !gone(target));
        !had || !param.targets.is_empty()
    });
    interface.inputs.retain(|_, input| {
        let had = !input.targets.is_empty();
        input.targets.retain(|target| !gone(target));
        !nodes.contains(&input.node) && (!had || !input.targets.is_empty())
    });
}

/// Gives a node another name, wherever it is named. Returns the name it got.
pub fn rename(state: &mut State, at: &Address, node: &str, to: &str) -> Option<String> {
    let level = state.level_mut(at)?;
    let entry = level.nodes.remove(node)?;
    let name = unique(level.nodes, to);
    level.nodes.insert(name.clone(), entry);
    let renamed = |found: &mut String| {
        if found == node {
            name.clone_into(found);
        }
    };
    let target = |found: &mut String| {
        if let Some((_, rest)) = found.split_once('.').filter(|(owner, _)| *owner == node) {
            *found = format!("{name}.{rest}");
        }
    };
    let mut moved = BTreeMap::new();
    for text in level.links.iter_mut() {
        if let Some(mut link) = Link::parse(text) {
            renamed(&mut link.from_node);
            renamed(&mut link.to_node);
            moved.insert(text.clone(), link.to_string());
            *text = link.to_string();
        }
    }
    let LevelMut { interface, .. } = level;
    interface.outputs.values_mut().for_each(|output| renamed(&mut output.node));
    interface.params.values_mut().for_each(|param| param.targets.iter_mut().for_each(target));
    for input in interface.inputs.values_mut() {
        renamed(&mut input.node);
        input.targets.iter_mut().for_each(target);
    }
    if let Some(layout) = state.layouts.get_mut(&at.text()) {
        if let Some(place) = layout.nodes.remove(node) {
            layout.nodes.insert(name.clone(), place);
        }
        layout.bends = std::mem::take(&mut layout.bends)
            .into_iter()
            .map(|(link, bends)| (moved.get(&link).cloned().unwrap_or(link), bends))
            .collect();
    }
    tidy(state, at);
    Some(name)
}

/// Moves nodes and frames.
pub fn move_by(
    state: &mut State,
    at: &Address,
    nodes: &BTreeSet<String>,
    frames: &BTreeSet<u32>,
    by: [i32; 2],
) {
    let layout = state.layout_mut(at);
    let shift = |p: &mut [i32; 2]| *p = [p[0].saturating_add(by[0]), p[1].saturating_add(by[1])];
    layout
        .nodes
        .iter_mut()
        .filter(|(name, _)| nodes.contains(*name))
        .for_each(|(_, place)| shift(&mut place.at));
    layout
        .frames
        .iter_mut()
        .filter(|(id, _)| frames.contains(id))
        .for_each(|(_, frame)| shift(&mut frame.at));
}

/// Shows only headings, or all.
pub fn set_collapsed(state: &mut State, at: &Address, nodes: &BTreeSet<String>, collapsed: bool) {
    let layout = state.layout_mut(at);
    nodes.iter().for_each(|node| layout.nodes.entry(node.clone()).or_default().collapsed = collapsed);
}

/// Shows or hides small pictures of results.
pub fn set_picture(state: &mut State, at: &Address, nodes: &BTreeSet<String>, picture: bool) {
    let layout = state.layout_mut(at);
    nodes.iter().for_each(|node| layout.nodes.entry(node.clone()).or_default().picture = picture);
}

/// Mutes nodes, bypasses them, or lets them run.
pub fn set_mode(state: &mut State, at: &Address, nodes: &BTreeSet<String>, mode: NodeMode) {
    let Some(level) = state.level_mut(at) else { return };
    level.nodes.iter_mut().filter(|(name, _)| nodes.contains(*name)).for_each(|(_, entry)| entry.mode = mode);
}

/// Puts the points that a link runs through.
pub fn bend(state: &mut State, at: &Address, link: &str, points: Vec<[i32; 2]>) {
    let layout = state.layout_mut(at);
    if points.is_empty() {
        layout.bends.remove(link);
    } else {
        layout.bends.insert(link.to_owned(), points);
    }
}

/// Adds a frame and returns its number.
pub fn add_frame(state: &mut State, at: &Address, frame: Frame) -> u32 {
    let layout = state.layout_mut(at);
    let id = layout.frames.keys().last().map_or(0, |last| last.saturating_add(1));
    layout.frames.insert(id, frame);
    id
}

/// Puts a node between an output and an input: the node's first input of the right type takes the one, its first output of the right
/// type goes to the other.
///
/// # Errors
/// If the nodes would wait for each other.
pub fn insert_between(
    state: &mut State,
    at: &Address,
    link: &Link,
    node: &str,
    shape: &Shape,
    types: [&str; 2],
    arity: Arity,
) -> Result<(), Refusal> {
    let input = shape.inputs.iter().find(|input| input.ty == types[0]);
    let output = shape.outputs.iter().find(|output| output.ty == types[1]);
    let (Some(input), Some(output)) = (input, output) else {
        let reason = format!("`{}` does not turn {} into {}", shape.ty, types[0], types[1]);
        return Err(Refusal { reason, conversions: Vec::new() });
    };
    let into = Link { to_node: node.to_owned(), to_socket: input.name.clone(), ..link.clone() };
    let out = Link { from_node: node.to_owned(), from_socket: output.name.clone(), ..link.clone() };
    connect(state, at, &into, input.arity)?;
    connect(state, at, &out, arity)
}

/// Puts a node into a link.
///
/// # Errors
/// If the node does not fit there.
pub fn insert_on_link(
    state: &mut State,
    at: &Address,
    link: &str,
    node: &str,
    shape: &Shape,
    ty: &str,
    arity: Arity,
) -> Result<(), Refusal> {
    let Some(parsed) = Link::parse(link) else { return Ok(()) };
    disconnect(state, at, &[link.to_owned()]);
    insert_between(state, at, &parsed, node, shape, [ty, ty], arity)
}

/// Offers a node's output on the graph.
pub fn offer_output(state: &mut State, at: &Address, name: &str, node: &str, socket: &str, docs: &str) {
    if let Some(level) = state.level_mut(at) {
        let output =
            InterfaceOutput { docs: docs.to_owned(), node: node.to_owned(), socket: socket.to_owned() };
        level.interface.outputs.insert(name.to_owned(), output);
    }
}

/// Takes an output of the graph back.
pub fn drop_output(state: &mut State, at: &Address, name: &str) {
    if let Some(level) = state.level_mut(at) {
        level.interface.outputs.remove(name);
    }
}
