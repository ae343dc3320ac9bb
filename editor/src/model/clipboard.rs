//! Nodes as text, to be put elsewhere: in another graph, another window, a mail. The text is a document.

use std::collections::{BTreeMap, BTreeSet};

use breccia_engine::{Document, Group, Link, NodeEntry, ParamValue};

use super::edit::{tidy, unique};
use super::level::{Address, body, free_group_name};
use super::state::State;

/// The nodes with the links between them, their places and the groups that they stand for, as the text of a document.
pub fn copy(state: &State, at: &Address, nodes: &BTreeSet<String>) -> Option<String> {
    let level = state.level(at)?;
    let mut document = Document::default();
    let mut layout = super::Layout::default();
    for (name, entry) in level.nodes.iter().filter(|(name, _)| nodes.contains(*name)) {
        document.nodes.insert(name.clone(), entry.clone());
        if let Some(place) = state.layout(at).and_then(|layout| layout.nodes.get(name)) {
            layout.nodes.insert(name.clone(), *place);
        }
        gather(state, at, entry, &mut document.groups);
    }
    if document.nodes.is_empty() {
        return None;
    }
    let inside = |link: &&String| {
        Link::parse(link).is_some_and(|link| nodes.contains(&link.from_node) && nodes.contains(&link.to_node))
    };
    document.links = level.links.iter().filter(inside).cloned().collect();
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

/// Puts copied nodes into a graph, the leftmost uppermost at a place. Returns their names.
///
/// # Errors
/// If the text is no document with nodes.
pub fn paste(
    state: &mut State,
    at: &Address,
    text: &str,
    place: [i32; 2],
) -> Result<BTreeSet<String>, String> {
    paste_named(state, at, text, place).map(|names| names.into_values().collect())
}

/// As [`paste`], with what each node was called.
fn paste_named(
    state: &mut State,
    at: &Address,
    text: &str,
    place: [i32; 2],
) -> Result<BTreeMap<String, String>, String> {
    let copied =
        State::new(Document::parse(text).map_err(|error| format!("what was copied is no graph: {error}"))?);
    if copied.document.nodes.is_empty() {
        return Err("what was copied holds no nodes".into());
    }
    let layout = copied.layouts.get("").cloned().unwrap_or_default();
    let corner = |i: usize| layout.nodes.values().map(|place| place.at[i]).min().unwrap_or(0);
    let corner = [corner(0), corner(1)];
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
    let mut places = Vec::new();
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
        found.at = [0, 1].map(|i| from[i].saturating_sub(corner[i]).saturating_add(place[i]));
        places.push((name.clone(), found));
        names.insert(old, name);
    }
    for link in copied.document.links.iter().filter_map(|link| Link::parse(link)) {
        if let (Some(from), Some(to)) = (names.get(&link.from_node), names.get(&link.to_node)) {
            level.links.push(Link { from_node: from.clone(), to_node: to.clone(), ..link }.to_string());
        }
    }
    state.layout_mut(at).nodes.extend(places);
    tidy(state, at);
    Ok(names)
}

/// Puts copied nodes beside the originals, with the same links into them. Returns their names.
///
/// # Errors
/// As [`paste`].
pub fn duplicate(
    state: &mut State,
    at: &Address,
    nodes: &BTreeSet<String>,
    text: &str,
    place: [i32; 2],
) -> Result<BTreeSet<String>, String> {
    let outside: Vec<Link> = state.level(at).map_or(Vec::new(), |level| {
        let links = level.links.iter().filter_map(|link| Link::parse(link));
        links.filter(|link| !nodes.contains(&link.from_node) && nodes.contains(&link.to_node)).collect()
    });
    let names = paste_named(state, at, text, place)?;
    if let Some(level) = state.level_mut(at) {
        for link in outside {
            if let Some(name) = names.get(&link.to_node) {
                level.links.push(Link { to_node: name.clone(), ..link }.to_string());
            }
        }
    }
    tidy(state, at);
    Ok(names.into_values().collect())
}
