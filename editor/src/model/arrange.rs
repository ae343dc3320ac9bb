//! Laying out nodes: in columns from left to right, and along lines.

use std::collections::{BTreeMap, BTreeSet};

use breccia_engine::Link;

use super::layout::Place;
use super::level::Address;
use super::state::State;

/// From one column to the next.
const COLUMN: i32 = 226;
/// Between nodes of a column.
const GAP: i32 = 28;
/// How often columns are sorted by where their neighbours lie.
const SWEEPS: usize = 8;

/// A line that nodes are moved to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alignment {
    /// Left edges.
    Left,
    /// Right edges.
    Right,
    /// Upper edges.
    Top,
    /// Lower edges.
    Bottom,
}

/// The size of a node.
pub type SizeOf<'a> = &'a dyn Fn(&str) -> [i32; 2];

/// Lays out nodes in columns: each right of all that it needs, columns sorted so that few links cross. Where the nodes were, roughly, they stay.
pub fn arrange(state: &mut State, at: &Address, nodes: &BTreeSet<String>, size: SizeOf<'_>) {
    let Some(level) = state.level(at) else { return };
    let links: Vec<(String, String)> = level
        .links
        .iter()
        .filter_map(|link| Link::parse(link))
        .filter(|link| nodes.contains(&link.from_node) && nodes.contains(&link.to_node))
        .map(|link| (link.from_node, link.to_node))
        .collect();
    let columns = columns(nodes, &links);
    let layout = state.layout_mut(at);
    let places: Vec<[i32; 2]> = nodes.iter().filter_map(|n| Some(layout.nodes.get(n)?.at)).collect();
    let corner = [0, 1].map(|i| places.iter().map(|p| p[i]).min().unwrap_or(0));
    let mut x = corner[0];
    let tallest = columns.iter().map(|column| height(column, size)).max().unwrap_or(0);
    for column in &columns {
        let mut y = corner[1].saturating_add((tallest - height(column, size)) / 2);
        for node in column {
            layout.nodes.entry(node.clone()).or_default().at = [x, y];
            y = y.saturating_add(size(node)[1] + GAP);
        }
        let widest = column.iter().map(|node| size(node)[0]).max().unwrap_or(0);
        x = x.saturating_add(COLUMN.max(widest + 42));
    }
}

fn height(column: &[String], size: SizeOf<'_>) -> i32 {
    column.iter().map(|node| size(node)[1] + GAP).fold(0, i32::saturating_add)
}

/// The nodes by column: as far right as what they feed allows, so that links are short.
fn columns(nodes: &BTreeSet<String>, links: &[(String, String)]) -> Vec<Vec<String>> {
    let mut depth: BTreeMap<&str, usize> = nodes.iter().map(|n| (n.as_str(), 0)).collect();
    // As many rounds as the longest way has steps; links that lead in a circle stop at the number of nodes.
    for _ in 0..nodes.len() {
        let mut moved = false;
        for (from, to) in links {
            let wanted = depth.get(from.as_str()).map_or(0, |d| d + 1).min(nodes.len());
            if let Some(d) = depth.get_mut(to.as_str()).filter(|d| **d < wanted) {
                *d = wanted;
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    let last = depth.values().copied().max().unwrap_or(0);
    let mut late = depth.clone();
    let mut fed: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (from, to) in links {
        fed.entry(from).or_default().push(to);
    }
    for _ in 0..=last {
        for (from, to) in &fed {
            let next = to.iter().filter_map(|to| late.get(to)).min();
            if let Some(wanted) = next.and_then(|d| d.checked_sub(1))
                && let Some(d) = late.get_mut(from).filter(|d| **d < wanted)
            {
                *d = wanted;
            }
        }
    }
    let mut columns = vec![Vec::new(); last + 1];
    for node in nodes {
        if let Some(column) = late.get(node.as_str()).and_then(|d| columns.get_mut(*d)) {
            column.push(node.clone());
        }
    }
    columns.retain(|column| !column.is_empty());
    for sweep in 0..SWEEPS {
        let rank: BTreeMap<String, f64> = columns
            .iter()
            .flat_map(|column| {
                let n = column.len().max(1) as f64;
                column.iter().enumerate().map(move |(i, node)| (node.clone(), (i as f64 + 0.5) / n))
            })
            .collect();
        let mut towards: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for (from, to) in links {
            let (node, other) = if sweep % 2 == 0 { (to, from) } else { (from, to) };
            towards.entry(node).or_default().extend(rank.get(other));
        }
        for column in &mut columns {
            column.sort_by(|a, b| {
                let mean = |node: &String| match towards.get(node.as_str()) {
                    Some(ranks) if !ranks.is_empty() => ranks.iter().sum::<f64>() / ranks.len() as f64,
                    _ => rank.get(node).copied().unwrap_or(0.5),
                };
                mean(a).total_cmp(&mean(b))
            });
        }
    }
    columns
}

/// Lays out the nodes that have no place yet. Where none has one, all are laid out; else they go below the others.
pub fn arrange_missing(state: &mut State, at: &Address, size: SizeOf<'_>) {
    let Some(level) = state.level(at) else { return };
    let all: BTreeSet<String> = level.nodes.keys().cloned().collect();
    let layout = state.layout_mut(at);
    layout.nodes.retain(|name, _| all.contains(name));
    let missing: BTreeSet<String> = all.iter().filter(|n| !layout.nodes.contains_key(*n)).cloned().collect();
    if missing.is_empty() {
        return;
    }
    let below = layout.nodes.iter().map(|(n, p)| p.at[1].saturating_add(size(n)[1] + GAP)).max();
    arrange(state, at, &missing, size);
    if let Some(below) = below {
        for node in &missing {
            if let Some(place) = state.layout_mut(at).nodes.get_mut(node) {
                place.at[1] = place.at[1].saturating_add(below);
            }
        }
    }
}

/// Moves nodes to a common line.
pub fn align(state: &mut State, at: &Address, nodes: &BTreeSet<String>, to: Alignment, size: SizeOf<'_>) {
    let layout = state.layout_mut(at);
    let (axis, far) = match to {
        Alignment::Left => (0, false),
        Alignment::Right => (0, true),
        Alignment::Top => (1, false),
        Alignment::Bottom => (1, true),
    };
    let edge =
        |name: &str, place: &Place| place.at[axis].saturating_add(if far { size(name)[axis] } else { 0 });
    let edges = layout.nodes.iter().filter(|(n, _)| nodes.contains(*n)).map(|(n, p)| edge(n, p));
    let Some(line) = (if far { edges.max() } else { edges.min() }) else { return };
    for (name, place) in layout.nodes.iter_mut().filter(|(n, _)| nodes.contains(*n)) {
        place.at[axis] = line.saturating_sub(if far { size(name)[axis] } else { 0 });
    }
}
