//! Groups: several nodes as one, and back.

use std::collections::{BTreeMap, BTreeSet};

use breccia_engine::{
    Document, Group, InterfaceInput, InterfaceOutput, InterfaceParam, Link, NodeEntry, NodeMode, ParamValue,
};

use super::arrange::{SizeOf, arrange};
use super::edit::{add_frame, tidy, unique};
use super::layout::{Frame, Layout, Place, SMALLEST_FRAME};
use super::level::{Address, body, free_group_name};
use super::reach::reach;
use super::shape::Shape;
use super::state::State;

/// The size of a node that nobody has drawn yet.
const USUAL: [i32; 2] = [184, 120];

/// Makes nodes a group of their own, with what lies between them, for which one node stands. Nodes that read the graph's input files stay
/// outside. `shape` tells what nodes look like, `size` how large they are. Returns the new node's name.
pub fn group(
    state: &mut State,
    at: &Address,
    nodes: &BTreeSet<String>,
    shape: &dyn Fn(&str) -> Option<Shape>,
    size: SizeOf<'_>,
) -> Option<String> {
    let nodes = &closed(state, at, nodes);
    let shapes: BTreeMap<String, Shape> = nodes.iter().filter_map(|n| Some((n.clone(), shape(n)?))).collect();
    let sources: BTreeMap<String, String> = {
        let level = state.level(at)?;
        let ends = level.links.iter().filter_map(|link| Link::parse(link));
        ends.filter_map(|link| {
            let ty = shape(&link.from_node)?.output(&link.from_socket)?.ty.clone();
            Some((format!("{}.{}", link.from_node, link.from_socket), ty))
        })
        .collect()
    };
    let body_name = free_group_name(&state.document, "group");
    let level = state.level_mut(at)?;
    let readers: BTreeSet<&String> = level.interface.inputs.values().map(|input| &input.node).collect();
    let nodes: BTreeSet<String> =
        nodes.iter().filter(|n| level.nodes.contains_key(*n) && !readers.contains(n)).cloned().collect();
    if nodes.is_empty() {
        return None;
    }
    let mut made = Group::default();
    for node in &nodes {
        if let Some(entry) = level.nodes.remove(node) {
            made.nodes.insert(node.clone(), entry);
        }
    }
    let stand_in = unique(level.nodes, "group");

    // Links that cross the border go through the interface.
    let mut outside = Vec::new();
    let mut taken: BTreeMap<String, String> = BTreeMap::new();
    let mut given: BTreeMap<String, String> = BTreeMap::new();
    // What links that cross the border are called afterwards, for their bends.
    let mut crossing: BTreeMap<String, String> = BTreeMap::new();
    for text in std::mem::take(level.links) {
        let Some(link) = Link::parse(&text) else {
            outside.push(text);
            continue;
        };
        match (nodes.contains(&link.from_node), nodes.contains(&link.to_node)) {
            (true, true) => made.links.push(text),
            (false, false) => outside.push(text),
            (false, true) => {
                let source = format!("{}.{}", link.from_node, link.from_socket);
                let name = taken
                    .entry(source.clone())
                    .or_insert_with(|| unique(&made.interface.inputs, &link.to_socket))
                    .clone();
                let input = made.interface.inputs.entry(name.clone()).or_insert_with(|| InterfaceInput {
                    ty: sources.get(&source).cloned().unwrap_or_default(),
                    docs: docs(
                        shapes.get(&link.to_node).and_then(|s| Some(s.input(&link.to_socket)?.docs.clone())),
                    ),
                    ..InterfaceInput::default()
                });
                let first = input.targets.is_empty();
                input.targets.push(format!("{}.{}", link.to_node, link.to_socket));
                if first {
                    let link = Link { to_node: stand_in.clone(), to_socket: name, ..link }.to_string();
                    crossing.insert(text, link.clone());
                    outside.push(link);
                }
            }
            (true, false) => {
                let name = output(&mut made, &mut given, &shapes, &link.from_node, &link.from_socket);
                let link = Link { from_node: stand_in.clone(), from_socket: name, ..link }.to_string();
                crossing.insert(text, link.clone());
                outside.push(link);
            }
        }
    }
    *level.links = outside;
    // So does what the graph's own interface says of the nodes.
    for found in level.interface.outputs.values_mut().filter(|found| nodes.contains(&found.node)) {
        found.socket = output(&mut made, &mut given, &shapes, &found.node, &found.socket);
        found.node.clone_from(&stand_in);
    }
    for (name, param) in level.interface.params.iter_mut() {
        let (inner, outer): (Vec<_>, Vec<_>) = std::mem::take(&mut param.targets)
            .into_iter()
            .partition(|target| target.split_once('.').is_some_and(|(node, _)| nodes.contains(node)));
        param.targets = outer;
        if !inner.is_empty() {
            let inner_name = unique(&made.interface.params, name);
            param.targets.push(format!("{stand_in}.{inner_name}"));
            let exposed = InterfaceParam { docs: param.docs.clone(), targets: inner, default: None };
            made.interface.params.insert(inner_name, exposed);
        }
    }
    for input in level.interface.inputs.values_mut() {
        for target in &mut input.targets {
            let Some((node, socket)) = target.split_once('.').filter(|(node, _)| nodes.contains(*node))
            else {
                continue;
            };
            let inner_name = unique(&made.interface.inputs, socket);
            let inner = InterfaceInput {
                ty: input.ty.clone(),
                docs: input.docs.clone(),
                targets: vec![format!("{node}.{socket}")],
                ..InterfaceInput::default()
            };
            made.interface.inputs.insert(inner_name.clone(), inner);
            *target = format!("{stand_in}.{inner_name}");
        }
    }
    let entry = NodeEntry::new("flow.group").with("body", ParamValue::Text(body_name.clone()));
    level.nodes.insert(stand_in.clone(), entry);
    let inner_links = made.links.clone();
    level.groups.insert(body_name.clone(), made);

    // Places, bends and frames go along, the new node lies in the middle.
    let mut inner = Layout::default();
    let layout = state.layout_mut(at);
    let frames = layout.frames.iter().filter(|(_, frame)| is_around(frame, layout, &nodes, size));
    let frames: Vec<u32> = frames.map(|(number, _)| *number).collect();
    inner.frames.extend(frames.into_iter().filter_map(|number| layout.frames.remove_entry(&number)));
    for node in &nodes {
        if let Some(place) = layout.nodes.remove(node) {
            inner.nodes.insert(node.clone(), place);
        }
    }
    inner.bends.extend(inner_links.into_iter().filter_map(|link| layout.bends.remove_entry(&link)));
    for (old, new) in crossing {
        if let Some(points) = layout.bends.remove(&old) {
            layout.bends.insert(new, points);
        }
    }
    layout.nodes.insert(stand_in.clone(), Place { at: middle(&inner), ..Place::default() });
    state.layouts.insert(at.within(&body_name).text(), inner);
    tidy(state, at);
    tidy(state, &at.within(&body_name));
    Some(stand_in)
}

/// The mean of the places of all nodes.
fn middle(layout: &Layout) -> [i32; 2] {
    let count = i64::try_from(layout.nodes.len().max(1)).unwrap_or(1);
    [0, 1].map(|i| (layout.nodes.values().map(|place| i64::from(place.at[i])).sum::<i64>() / count) as i32)
}

/// Whether a frame has only these nodes in it, and some of them. A node lies in a frame if its middle does.
fn is_around(frame: &Frame, layout: &Layout, nodes: &BTreeSet<String>, size: SizeOf<'_>) -> bool {
    let holds = |node: &str, place: &Place| {
        let size = size(node);
        (0..2).all(|i| {
            let [at, from] = [place.at[i], frame.at[i]].map(i64::from);
            (from..from + i64::from(frame.size[i].max(SMALLEST_FRAME)))
                .contains(&(at + i64::from(size[i] / 2)))
        })
    };
    let mut inside = layout.nodes.iter().filter(|(node, place)| holds(node, place)).peekable();
    inside.peek().is_some() && inside.all(|(node, _)| nodes.contains(node))
}

/// Nodes with all that lies between them: left outside, it would wait for the group and the group for it.
fn closed(state: &State, at: &Address, nodes: &BTreeSet<String>) -> BTreeSet<String> {
    let Some(level) = state.level(at) else { return BTreeSet::new() };
    let links: Vec<Link> = level.links.iter().filter_map(|link| Link::parse(link)).collect();
    let reached = |forward: bool| -> BTreeSet<&str> {
        let mut next: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for link in &links {
            let (from, to) =
                if forward { (&link.from_node, &link.to_node) } else { (&link.to_node, &link.from_node) };
            next.entry(from).or_default().push(to);
        }
        let next = |node: &str| next.get(node).into_iter().flatten().copied();
        reach(nodes.iter().map(String::as_str), next).into_iter().collect()
    };
    let between = &reached(true) & &reached(false);
    nodes.iter().cloned().chain(between.into_iter().map(str::to_owned)).collect()
}

fn docs(found: Option<String>) -> String {
    found.unwrap_or_default()
}

/// The group's output for a socket within.
fn output(
    made: &mut Group,
    given: &mut BTreeMap<String, String>,
    shapes: &BTreeMap<String, Shape>,
    node: &str,
    socket: &str,
) -> String {
    let source = format!("{node}.{socket}");
    if let Some(name) = given.get(&source) {
        return name.clone();
    }
    let name = unique(&made.interface.outputs, socket);
    let docs = docs(shapes.get(node).and_then(|shape| Some(shape.output(socket)?.docs.clone())));
    let output = InterfaceOutput { docs, node: node.to_owned(), socket: socket.to_owned() };
    made.interface.outputs.insert(name.clone(), output);
    given.insert(source, name.clone());
    name
}

/// Puts the nodes of a group in the place of the node that stands for it. Returns their names.
///
/// # Errors
/// If the node stands for no group that is written out in the document.
pub fn ungroup(state: &mut State, at: &Address, node: &str) -> Result<Vec<String>, String> {
    let level = state.level(at).ok_or("there is no such graph")?;
    let stand_in = level.nodes.get(node).ok_or_else(|| format!("there is no node `{node}`"))?.clone();
    if stand_in.ty != "flow.group" {
        return Err(format!("`{node}` is no group that could be taken apart"));
    }
    if stand_in.mode == NodeMode::Bypass {
        return Err(format!(
            "`{node}` is bypassed as a whole, which its nodes cannot be: switch it on first"
        ));
    }
    let (address, found) =
        body(&state.document, at, &stand_in).ok_or_else(|| format!("`{node}` has no group"))?;
    if !found.file.is_empty() {
        return Err(format!(
            "the group stands in the file `{}`: make it part of the graph first",
            found.file
        ));
    }
    let found = found.clone();
    let inner_layout = state.layouts.get(&address.text()).cloned().unwrap_or_default();
    let Some(level) = state.level_mut(at) else { return Err("there is no such graph".into()) };
    let nested: Vec<_> =
        found.groups.iter().filter(|(name, group)| level.groups.get(*name) != Some(group)).collect();
    if let Some((name, _)) = nested.iter().find(|(name, _)| level.groups.contains_key(*name)) {
        return Err(format!("the group holds another group `{name}`, a name that is taken here"));
    }
    level.groups.extend(nested.into_iter().map(|(name, group)| (name.clone(), group.clone())));
    level.nodes.remove(node);
    let mut names = BTreeMap::new();
    for (inner, entry) in &found.nodes {
        let name = unique(level.nodes, inner);
        let mut inside = entry.clone();
        if stand_in.mode == NodeMode::Mute {
            inside.mode = NodeMode::Mute;
        }
        level.nodes.insert(name.clone(), inside);
        names.insert(inner.clone(), name);
    }
    let renamed = |target: &str| {
        let (node, rest) = target.split_once('.')?;
        Some(format!("{}.{rest}", names.get(node)?))
    };
    let mut links = Vec::new();
    // What links are called afterwards, for their bends: outside, and within the group.
    let (mut outer, mut inner) = (Vec::new(), Vec::new());
    for text in level.links.iter() {
        let Some(link) = Link::parse(text) else {
            links.push(text.clone());
            continue;
        };
        let from = if link.from_node == node {
            let output = found.interface.outputs.get(&link.from_socket);
            output.and_then(|output| renamed(&format!("{}.{}", output.node, output.socket)))
        } else {
            Some(format!("{}.{}", link.from_node, link.from_socket))
        };
        let to = if link.to_node == node {
            let input = found.interface.inputs.get(&link.to_socket);
            input.map(|input| input.targets.iter().filter_map(|t| renamed(t)).collect()).unwrap_or_default()
        } else {
            vec![format!("{}.{}", link.to_node, link.to_socket)]
        };
        for link in from.iter().flat_map(|from| to.iter().map(move |to| format!("{from} -> {to}"))) {
            outer.push((text.clone(), link.clone()));
            links.push(link);
        }
    }
    for (text, link) in found.links.iter().filter_map(|text| Some((text, Link::parse(text)?))) {
        if let (Some(from), Some(to)) = (names.get(&link.from_node), names.get(&link.to_node)) {
            let link = Link { from_node: from.clone(), to_node: to.clone(), ..link }.to_string();
            inner.push((text.clone(), link.clone()));
            links.push(link);
        }
    }
    *level.links = links;
    for output in level.interface.outputs.values_mut().filter(|output| output.node == node) {
        if let Some(inner) = found.interface.outputs.get(&output.socket) {
            output.node = names.get(&inner.node).cloned().unwrap_or_default();
            output.socket.clone_from(&inner.socket);
        }
    }
    // What the node and its group say of parameters becomes the inner nodes' own.
    for (name, param) in &found.interface.params {
        let value = stand_in.params.get(name).or(param.default.as_ref());
        for (inner, param) in param.targets.iter().filter_map(|target| target.split_once('.')) {
            if let (Some(value), Some(entry)) = (value, names.get(inner).and_then(|n| level.nodes.get_mut(n)))
            {
                entry.params.insert(param.to_owned(), value.clone());
            }
        }
    }
    for param in level.interface.params.values_mut() {
        param.targets = std::mem::take(&mut param.targets)
            .into_iter()
            .flat_map(|target| match target.split_once('.') {
                Some((owner, inner)) if owner == node => {
                    let inner = found.interface.params.get(inner).map_or(&[][..], |param| &param.targets);
                    inner.iter().filter_map(|target| renamed(target)).collect()
                }
                _ => vec![target],
            })
            .collect();
    }
    for input in level.interface.inputs.values_mut() {
        input.targets = std::mem::take(&mut input.targets)
            .into_iter()
            .flat_map(|target| match target.split_once('.') {
                Some((owner, inner)) if owner == node => {
                    let inner = found.interface.inputs.get(inner).map_or(&[][..], |input| &input.targets);
                    inner.iter().filter_map(|target| renamed(target)).collect()
                }
                _ => vec![target],
            })
            .collect();
    }
    let layout = state.layout_mut(at);
    // All comes to lie around the place where the node lay.
    let (from, to) = (middle(&inner_layout), layout.nodes.remove(node).unwrap_or_default().at);
    let moved = |at: [i32; 2]| [0, 1].map(|i| at[i].saturating_add(to[i].saturating_sub(from[i])));
    let mut placeless = BTreeSet::new();
    for (inner, name) in &names {
        let place = inner_layout.nodes.get(inner).copied();
        if place.is_none() {
            placeless.insert(name.clone());
        }
        let place = place
            .map_or(Place { at: to, ..Place::default() }, |place| Place { at: moved(place.at), ..place });
        layout.nodes.insert(name.clone(), place);
    }
    let bends = outer.into_iter().filter_map(|(old, new)| Some((new, layout.bends.get(&old)?.clone())));
    let bends: Vec<_> = bends.collect();
    layout.bends.extend(bends);
    for (old, new) in inner {
        if let Some(points) = inner_layout.bends.get(&old) {
            layout.bends.insert(new, points.iter().copied().map(moved).collect());
        }
    }
    for frame in inner_layout.frames.into_values() {
        add_frame(state, at, Frame { at: moved(frame.at), ..frame });
    }
    // The group itself stays while another node stands for it.
    let name = address.0.last().cloned().unwrap_or_default();
    if address == at.within(&name) && !used(&state.document, at, &name) {
        if let Some(level) = state.level_mut(at) {
            level.groups.remove(&name);
        }
        let prefix = format!("{}/", address.text());
        state.layouts.retain(|other, _| *other != address.text() && !other.starts_with(&prefix));
    }
    tidy(state, at);
    // Nobody ever looked into the group: its nodes find their places now, as part of this step.
    arrange(state, at, &placeless, &|_| USUAL);
    Ok(names.into_values().collect())
}

/// Whether a node of a graph, or of its groups, stands for a group of that name.
fn used(document: &Document, at: &Address, name: &str) -> bool {
    fn stands(nodes: &BTreeMap<String, NodeEntry>, groups: &BTreeMap<String, Group>, name: &str) -> bool {
        let body = |entry: &NodeEntry| entry.params.get("body") == Some(&ParamValue::Text(name.to_owned()));
        nodes.values().any(body) || groups.values().any(|group| stands(&group.nodes, &group.groups, name))
    }
    let mut found = (&document.nodes, &document.groups);
    for step in &at.0 {
        let Some(group) = found.1.get(step) else { return false };
        found = (&group.nodes, &group.groups);
    }
    stands(found.0, found.1, name)
}

/// Makes a group that stands in a file part of the document. `included` is the document with its groups read.
///
/// # Errors
/// If the group's file has not been read, or lies in a graph that stands in a file itself.
pub fn localise(state: &mut State, included: &Document, at: &Address) -> Result<(), String> {
    let (Some((name, outer)), Some(read)) = (at.0.split_last(), group_at(included, at)) else {
        return Err("there is no such group".into());
    };
    if !read.file.is_empty() {
        return Err(format!("the file `{}` could not be read", read.file));
    }
    let mut read = read.clone();
    clear_folders(&mut read);
    let outer = Address(outer.to_vec());
    if let Some(file) = state.foreign(&outer) {
        return Err(format!("it lies in the file `{file}`: make that part of the graph first"));
    }
    match state.level_mut(&outer) {
        Some(level) => level.groups.insert(name.clone(), read),
        None => return Err("there is no such group".into()),
    };
    Ok(())
}

fn clear_folders(group: &mut Group) {
    group.folder = None;
    group.groups.values_mut().for_each(clear_folders);
}

/// The group at an address.
pub fn group_at<'a>(document: &'a Document, at: &Address) -> Option<&'a Group> {
    let (first, rest) = at.0.split_first()?;
    rest.iter().try_fold(document.groups.get(first)?, |group, name| group.groups.get(name))
}
