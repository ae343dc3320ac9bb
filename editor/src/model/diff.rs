//! What differs between two states, small where the change is small, so that a long history stays small.

use std::collections::BTreeMap;

use breccia_engine::{Group, Interface, NodeEntry, ParamValue};

use super::layout::{Frame, Layout, Place};
use super::state::State;

/// The entries of a map that differ: what they were, and what they are.
type Entries<K, V> = Vec<(K, Option<V>, Option<V>)>;

/// The change from one state to another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diff {
    title: Option<(String, String)>,
    docs: Option<(String, String)>,
    interface: Option<Box<(Interface, Interface)>>,
    nodes: Entries<String, NodeEntry>,
    links: Option<Run>,
    groups: Entries<String, Group>,
    editor: Option<Box<(ron::Value, ron::Value)>>,
    layouts: Vec<(String, LayoutDiff)>,
}

fn is_text(value: &ParamValue) -> bool {
    match value {
        ParamValue::Text(_) => true,
        ParamValue::List(items) => items.iter().any(is_text),
        ParamValue::Bool(_) | ParamValue::Int(_) | ParamValue::Float(_) => false,
    }
}

/// A stretch of a list that was replaced.
#[derive(Clone, Debug, PartialEq)]
struct Run {
    at: usize,
    old: Vec<String>,
    new: Vec<String>,
}

#[derive(Clone, Debug, PartialEq)]
struct LayoutDiff {
    /// Whether the layout was there, and is there.
    there: [bool; 2],
    nodes: Entries<String, Place>,
    frames: Entries<u32, Frame>,
    bends: Entries<String, Vec<[i32; 2]>>,
}

fn changed<T: Clone + PartialEq>(old: &T, new: &T) -> Option<(T, T)> {
    (old != new).then(|| (old.clone(), new.clone()))
}

fn entries<K: Ord + Clone, V: Clone + PartialEq>(
    old: &BTreeMap<K, V>,
    new: &BTreeMap<K, V>,
) -> Entries<K, V> {
    let mut found: Entries<K, V> = Vec::new();
    for (key, was) in old {
        match new.get(key) {
            Some(is) if is == was => {}
            is => found.push((key.clone(), Some(was.clone()), is.cloned())),
        }
    }
    let added = new.iter().filter(|(key, _)| !old.contains_key(key));
    found.extend(added.map(|(key, is)| (key.clone(), None, Some(is.clone()))));
    found
}

fn apply<K: Ord + Clone, V: Clone>(map: &mut BTreeMap<K, V>, entries: &Entries<K, V>, forward: bool) {
    for (key, old, new) in entries {
        match if forward { new } else { old } {
            Some(value) => {
                map.insert(key.clone(), value.clone());
            }
            None => {
                map.remove(key);
            }
        }
    }
}

fn run(old: &[String], new: &[String]) -> Option<Run> {
    if old == new {
        return None;
    }
    let at = old.iter().zip(new).take_while(|(a, b)| a == b).count();
    let (old, new) = (&old[at..], &new[at..]);
    let same = old.iter().rev().zip(new.iter().rev()).take_while(|(a, b)| a == b).count();
    Some(Run { at, old: old[..old.len() - same].to_vec(), new: new[..new.len() - same].to_vec() })
}

impl Diff {
    /// What leads from one state to the other.
    pub fn between(old: &State, new: &State) -> Self {
        let (a, b) = (&old.document, &new.document);
        let mut layouts = Vec::new();
        let none = Layout::default();
        for name in
            old.layouts.keys().chain(new.layouts.keys().filter(|name| !old.layouts.contains_key(*name)))
        {
            let (was, is) = (old.layouts.get(name), new.layouts.get(name));
            if was != is {
                let there = [was.is_some(), is.is_some()];
                let (was, is) = (was.unwrap_or(&none), is.unwrap_or(&none));
                let diff = LayoutDiff {
                    there,
                    nodes: entries(&was.nodes, &is.nodes),
                    frames: entries(&was.frames, &is.frames),
                    bends: entries(&was.bends, &is.bends),
                };
                layouts.push((name.clone(), diff));
            }
        }
        Self {
            title: changed(&a.title, &b.title),
            docs: changed(&a.docs, &b.docs),
            interface: changed(&a.interface, &b.interface).map(Box::new),
            nodes: entries(&a.nodes, &b.nodes),
            links: run(&a.links, &b.links),
            groups: entries(&a.groups, &b.groups),
            editor: changed(&a.editor, &b.editor).map(Box::new),
            layouts,
        }
    }

    /// Whether the two states are the same.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether names of files may differ, or what nodes make of them. Certain only if not.
    pub fn may_name_files(&self) -> bool {
        let same_numbers = |old: &Option<NodeEntry>, new: &Option<NodeEntry>| match (old, new) {
            (Some(old), Some(new)) => {
                old.ty == new.ty && !old.params.values().chain(new.params.values()).any(is_text)
            }
            _ => false,
        };
        self.interface.is_some()
            || !self.groups.is_empty()
            || !self.nodes.iter().all(|(_, old, new)| same_numbers(old, new))
    }

    /// Turns the one state into the other, or the other into the one.
    pub fn apply(&self, state: &mut State, forward: bool) {
        let side = |pair: &(String, String)| if forward { pair.1.clone() } else { pair.0.clone() };
        let document = &mut state.document;
        if let Some(pair) = &self.title {
            document.title = side(pair);
        }
        if let Some(pair) = &self.docs {
            document.docs = side(pair);
        }
        if let Some(pair) = &self.interface {
            document.interface = if forward { pair.1.clone() } else { pair.0.clone() };
        }
        if let Some(pair) = &self.editor {
            document.editor = if forward { pair.1.clone() } else { pair.0.clone() };
        }
        apply(&mut document.nodes, &self.nodes, forward);
        apply(&mut document.groups, &self.groups, forward);
        if let Some(run) = &self.links {
            let (out, put) = if forward { (&run.old, &run.new) } else { (&run.new, &run.old) };
            let end = (run.at + out.len()).min(document.links.len());
            document.links.splice(run.at.min(end)..end, put.iter().cloned());
        }
        for (name, diff) in &self.layouts {
            if !diff.there[usize::from(forward)] {
                state.layouts.remove(name);
                continue;
            }
            let layout = state.layouts.entry(name.clone()).or_default();
            apply(&mut layout.nodes, &diff.nodes, forward);
            apply(&mut layout.frames, &diff.frames, forward);
            apply(&mut layout.bends, &diff.bends, forward);
        }
    }

    /// This change, and then the other, as one.
    pub fn then(&self, later: &Self, state_after: &State) -> Self {
        let mut middle = state_after.clone();
        later.apply(&mut middle, false);
        let mut first = middle;
        self.apply(&mut first, false);
        Self::between(&first, state_after)
    }
}
