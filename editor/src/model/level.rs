//! The graphs of a document: its own, and those of its groups.

use std::collections::BTreeMap;

use breccia_engine::{Document, Group, Interface, NodeEntry, ParamValue};

use super::state::State;

/// Where a graph stands in a document: the names of the groups that it lies in, outermost first.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Address(pub Vec<String>);

impl Address {
    /// The address as the layouts name it.
    pub fn text(&self) -> String {
        self.0.join("/")
    }

    /// The address of a group of this graph.
    pub fn within(&self, group: &str) -> Self {
        let mut names = self.0.clone();
        names.push(group.to_owned());
        Self(names)
    }
}

/// One step of the way into groups.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Crumb {
    /// The node that was entered.
    pub node: String,
    /// The graph that it stands for.
    pub address: Address,
}

/// The way to the graph that is looked at; empty for the document's own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trail(pub Vec<Crumb>);

impl Trail {
    /// The graph that is looked at.
    pub fn address(&self) -> Address {
        self.0.last().map(|crumb| crumb.address.clone()).unwrap_or_default()
    }

    /// What the names of the nodes that are looked at begin with in a run.
    pub fn prefix(&self) -> String {
        self.0.iter().map(|crumb| format!("{}/", crumb.node)).collect()
    }
}

/// One graph of a document.
#[derive(Clone, Copy)]
pub struct Level<'a> {
    /// Its nodes.
    pub nodes: &'a BTreeMap<String, NodeEntry>,
    /// Its links.
    pub links: &'a [String],
    /// What it offers.
    pub interface: &'a Interface,
}

/// One graph of a document, to be changed.
pub(super) struct LevelMut<'a> {
    pub nodes: &'a mut BTreeMap<String, NodeEntry>,
    pub links: &'a mut Vec<String>,
    pub interface: &'a mut Interface,
    pub groups: &'a mut BTreeMap<String, Group>,
}

impl<'a> Level<'a> {
    /// The graph at an address.
    pub fn of(document: &'a Document, at: &Address) -> Option<Self> {
        let Some(group) = find(document, at)? else {
            return Some(Self {
                nodes: &document.nodes,
                links: &document.links,
                interface: &document.interface,
            });
        };
        Some(Self { nodes: &group.nodes, links: &group.links, interface: &group.interface })
    }
}

/// The group at an address; `Some(None)` for the document's own graph.
fn find<'a>(document: &'a Document, at: &Address) -> Option<Option<&'a Group>> {
    let mut groups = &document.groups;
    let mut found = None;
    for name in &at.0 {
        let group = groups.get(name)?;
        groups = &group.groups;
        found = Some(group);
    }
    Some(found)
}

/// The group that a node of a graph stands for, and where it is; the innermost of that name that can be seen from there.
pub(super) fn body<'a>(
    document: &'a Document,
    at: &Address,
    entry: &NodeEntry,
) -> Option<(Address, &'a Group)> {
    let Some(ParamValue::Text(name)) = entry.params.get("body") else { return None };
    (0..=at.0.len()).rev().find_map(|depth| {
        let address = Address(at.0.get(..depth)?.to_vec()).within(name);
        let group = find(document, &address)??;
        Some((address, group))
    })
}

/// A name for a group that no other group of the document has, so that it means the same from everywhere.
pub fn free_group_name(document: &Document, stem: &str) -> String {
    fn gather(groups: &BTreeMap<String, Group>, taken: &mut BTreeMap<String, ()>) {
        for (name, group) in groups {
            taken.insert(name.clone(), ());
            gather(&group.groups, taken);
        }
    }
    let mut taken = BTreeMap::new();
    gather(&document.groups, &mut taken);
    super::edit::unique(&taken, stem)
}

/// Whether the graph at an address, or one that it lies in, stands in a file of its own.
pub(super) fn in_file(document: &Document, at: &Address) -> Option<String> {
    (1..=at.0.len()).find_map(|depth| {
        let group = find(document, &Address(at.0.get(..depth)?.to_vec()))??;
        (!group.file.is_empty()).then(|| group.file.clone())
    })
}

impl State {
    /// The graph at an address.
    pub fn level(&self, at: &Address) -> Option<Level<'_>> {
        Level::of(&self.document, at)
    }

    pub(super) fn level_mut(&mut self, at: &Address) -> Option<LevelMut<'_>> {
        let Document { nodes, links, interface, groups, .. } = &mut self.document;
        let Some((last, outer)) = at.0.split_last() else {
            return Some(LevelMut { nodes, links, interface, groups });
        };
        let mut scope = groups;
        for name in outer {
            scope = &mut scope.get_mut(name)?.groups;
        }
        let Group { nodes, links, interface, groups, .. } = scope.get_mut(last)?;
        Some(LevelMut { nodes, links, interface, groups })
    }

    /// The file that the graph at an address stands in, if it is not the document's own: then it cannot be edited here.
    pub fn foreign(&self, at: &Address) -> Option<String> {
        in_file(&self.document, at)
    }
}
