//! Nodes and frames as text, to be put elsewhere: in another graph, another window, a mail. The text is a document.

use std::collections::{BTreeMap, BTreeSet};

use breccia_engine::{Document, Group, Link, NodeEntry, ParamValue};

use super::edit::{add_frame, tidy, unique};
use super::layout::{Frame, Layout};
use super::level::{Address, body, free_group_name};
use super::state::State;

/// What of a graph can be copied, and what was made by it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Parts {
    /// Nodes by name.
    pub nodes: BTreeSet<String>,
    /// Frames by number.
    pub frames: BTreeSet<u32>,
}

/// The nodes with the links between them, the bends of those, the places and the groups that the nodes stand for, and the frames, as
/// the text of a document.
pub fn copy(state: &State, at: &Address, Parts { nodes, frames }: &Parts) -> Option<String> {
    let level = state.level(at)?;
    let mut document = Document::default();
    let mut layout = state.layout(at).cloned().unwrap_or_default();
    for (name, entry) in level.nodes.iter().filter(|(name, _)| nodes.contains(*name)) {
        document.nodes.insert(name.clone(), entry.clone());
        gather(state, at, entry, &mut document.groups);
    }
    layout.nodes.retain(|name, _| document.nodes.contains_key(name));
    layout.frames.retain(|id, _| frames.contains(id));
    if document.nodes.is_empty() && layout.frames.is_empty() {
        return None;
    }
    let inside = |link: &&String| {
        Link::parse(link).is_some_and(|link| nodes.contains(&link.from_node) && nodes.contains(&link.to_node))
    };
    document.links = level.links.iter().filter(inside).cloned().collect();
    layout.bends.retain(|link, _| document.links.contains(link));
    let layouts = BTreeMap::from([(String::new(), layout)]);
    Some(State { document, layouts }.to_document().to_ron())
}

/// The groups that a node needs.
fn gather(state: &State, at: &Address, entry: &NodeEntry, groups: &mut BTreeMap<String, Group>) {
    let Some((address, group)) = body(&state.document, at, entry) else { return };
    let Some(name) = address.0.last() else { return };
    if groups.contains_key(name) {
        return;
    }
    groups.insert(name.clone(), group.clone());
    for inner in group.nodes.values() {
        // What the group holds itself comes along with it.
        if let Some((found, _)) =
            body(&state.document, &address, inner).filter(|(found, _)| found.0.len() <= at.0.len() + 1)
        {
            let owner = Address(found.0[..found.0.len().saturating_sub(1)].to_vec());
            gather(state, &owner, inner, groups);
        }
    }
}

/// Puts what was copied into a graph, its leftmost uppermost corner at a place. Returns what was made.
///
/// # Errors
/// If the text is no document with nodes or frames.
pub fn paste(state: &mut State, at: &Address, text: &str, place: [i32; 2]) -> Result<Parts, String> {
    let (names, frames) = paste_named(state, at, text, place)?;
    Ok(Parts { nodes: names.into_values().collect(), frames })
}

/// As [`paste`], with what each node was called.
fn paste_named(
    state: &mut State,
    at: &Address,
    text: &str,
    place: [i32; 2],
) -> Result<(BTreeMap<String, String>, BTreeSet<u32>), String> {
    let copied =
        State::new(Document::parse(text).map_err(|error| format!("what was copied is no graph: {error}"))?);
    let mut layout = copied.layouts.get("").cloned().unwrap_or_default();
    if copied.document.nodes.is_empty() && layout.frames.is_empty() {
        return Err("what was copied holds no nodes".into());
    }
    let corner = corner(&layout);
    let moved = |from: [i32; 2]| [0, 1].map(|i| from[i].saturating_sub(corner[i]).saturating_add(place[i]));
    let mut groups = BTreeMap::new();
    for (name, group) in copied.document.groups {
        let free = free_group_name(&state.document, &name);
        let Some(level) = state.level_mut(at) else { return Err("there is no such graph".into()) };
        let same = level.groups.get(&name) == Some(&group);
        let new = if same { name.clone() } else { free };
        level.groups.insert(new.clone(), group);
        groups.insert(name, new);
    }
    let Some(level) = state.level_mut(at) else { return Err("there is no such graph".into()) };
    let mut names = BTreeMap::new();
    let (mut places, mut bends) = (Vec::new(), Vec::new());
    for (i, (old, mut entry)) in copied.document.nodes.into_iter().enumerate() {
        if let Some(ParamValue::Text(body)) = entry.params.get_mut("body")
            && let Some(new) = groups.get(body)
        {
            body.clone_from(new);
        }
        let name = unique(level.nodes, &old);
        level.nodes.insert(name.clone(), entry);
        let offset = i32::try_from(i).unwrap_or(0).saturating_mul(24);
        let mut found = layout.nodes.get(&old).copied().unwrap_or_default();
        let from =
            if layout.nodes.contains_key(&old) { found.at } else { corner.map(|c| c.saturating_add(offset)) };
        found.at = moved(from);
        places.push((name.clone(), found));
        names.insert(old, name);
    }
    for (old, link) in copied.document.links.iter().filter_map(|text| Some((text, Link::parse(text)?))) {
        if let (Some(from), Some(to)) = (names.get(&link.from_node), names.get(&link.to_node)) {
            let new = Link { from_node: from.clone(), to_node: to.clone(), ..link }.to_string();
            level.links.push(new.clone());
            if let Some(points) = layout.bends.remove(old) {
                bends.push((new, points.into_iter().map(moved).collect()));
            }
        }
    }
    let target = state.layout_mut(at);
    target.nodes.extend(places);
    target.bends.extend(bends);
    let mut frames = BTreeSet::new();
    for frame in layout.frames.into_values() {
        frames.insert(add_frame(state, at, Frame { at: moved(frame.at), ..frame }));
    }
    tidy(state, at);
    Ok((names, frames))
}

/// The left upper corner of all that has a place.
fn corner(layout: &Layout) -> [i32; 2] {
    let places = || layout.nodes.values().map(|place| place.at).chain(layout.frames.values().map(|f| f.at));
    [0, 1].map(|i| places().map(|at| at[i]).min().unwrap_or(0))
}

/// Puts copies beside the originals, with the same links into them. Returns what was made.
///
/// # Errors
/// As [`paste`].
pub fn duplicate(state: &mut State, at: &Address, parts: &Parts, by: [i32; 2]) -> Result<Parts, String> {
    let text = copy(state, at, parts).ok_or("nothing is selected that can be copied")?;
    let outside: Vec<Link> = state.level(at).map_or(Vec::new(), |level| {
        let links = level.links.iter().filter_map(|link| Link::parse(link));
        links
            .filter(|link| !parts.nodes.contains(&link.from_node) && parts.nodes.contains(&link.to_node))
            .collect()
    });
    let mut layout = state.layout(at).cloned().unwrap_or_default();
    layout.nodes.retain(|name, _| parts.nodes.contains(name));
    layout.frames.retain(|id, _| parts.frames.contains(id));
    let from = corner(&layout);
    let place = [0, 1].map(|i| from[i].saturating_add(by[i]));
    let (names, frames) = paste_named(state, at, &text, place)?;
    if let Some(level) = state.level_mut(at) {
        for link in outside {
            if let Some(name) = names.get(&link.to_node) {
                level.links.push(Link { to_node: name.clone(), ..link }.to_string());
            }
        }
    }
    tidy(state, at);
    Ok(Parts { nodes: names.into_values().collect(), frames })
}
