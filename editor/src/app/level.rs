//! What hangs on the graph that is looked at.

use breccia_engine::{NodeEntry, ParamValue};

use super::App;
use crate::action::{Kind, Pin};
use crate::canvas::size_of;
use crate::model::{Address, Crumb, Level, Place, Shape, Socket, State, arrange_missing, shape_of};

impl App {
    /// The graph that is looked at.
    pub(super) fn address(&self) -> Address {
        self.trail.address()
    }

    /// The file that it stands in, if it is not the document's own: then it cannot be edited.
    pub(super) fn foreign(&self) -> Option<String> {
        self.project.state().foreign(&self.address())
    }

    /// Whether the graph that is looked at cannot be changed, which is then said.
    pub(super) fn refuses(&mut self) -> bool {
        let Some(file) = self.foreign() else { return false };
        self.say(format!(
            "This group stands in the file {file}; Node, \"Make group part of the graph\" lets you edit it here"
        ));
        true
    }

    /// The graph that is looked at, groups in files included.
    pub(super) fn level(&self) -> Option<Level<'_>> {
        Level::of(&self.checked.included, &self.address())
    }

    /// Brings up to date what hangs on the document.
    pub(super) fn refresh(&mut self) {
        if self.checked_for != self.project.content() {
            self.recheck();
        }
        while !self.trail.0.is_empty() && !self.leads_somewhere() {
            self.trail.0.pop();
            self.selection = Default::default();
        }
        let wanted = (self.project.content(), self.trail.clone());
        if self.shapes_for.as_ref() == Some(&wanted) {
            return;
        }
        let at = self.address();
        let Some(level) = Level::of(&self.checked.included, &at) else { return };
        let shape = |(name, entry): (&String, &NodeEntry)| {
            (name.clone(), shape_of(&self.checked.included, &self.registry, &at, name, entry))
        };
        self.shapes = level.nodes.iter().map(shape).collect();
        let there = |name: &String| self.shapes.contains_key(name);
        self.selection.nodes.retain(there);
        let links = level.links;
        self.selection.links.retain(|link| links.contains(link));
        let layout = self.project.state().layout(&at);
        self.selection.frames.retain(|id| layout.is_some_and(|layout| layout.frames.contains_key(id)));
        let prefix = self.trail.prefix();
        self.broken = if self.trail.0.is_empty() {
            self.checked.broken.clone()
        } else {
            let named = self.checked.problems.iter().filter_map(|problem| problem.node.as_deref());
            named.map(crate::run::general).filter(|node| node.starts_with(&prefix)).collect()
        };
        self.settle();
        self.shapes_for = Some(wanted);
    }

    /// Gives places to nodes that have none: of a document that was written by hand.
    fn settle(&mut self) {
        let at = self.address();
        let layout = self.project.state().layout(&at);
        let placed = |name: &String| layout.is_some_and(|layout| layout.nodes.contains_key(name));
        if self.shapes.keys().all(placed) {
            return;
        }
        let state: &State = self.project.state();
        let mut state = state.clone();
        // A graph in a file has its nodes in the included document only.
        let foreign = state.foreign(&at).is_some();
        if foreign {
            state.document = (*self.checked.included).clone();
        }
        let shapes = &self.shapes;
        let size = |name: &str| shapes.get(name).map_or([184, 80], |shape| size_of(shape, Place::default()));
        arrange_missing(&mut state, &at, &size);
        let found = state.layouts.remove(&at.text()).unwrap_or_default();
        self.project.settle(|state| *state.layout_mut(&at) = found);
    }

    fn leads_somewhere(&self) -> bool {
        let mut at = Address::default();
        self.trail.0.iter().all(|crumb| {
            let Some(level) = Level::of(&self.checked.included, &at) else { return false };
            let Some(entry) = level.nodes.get(&crumb.node) else { return false };
            let shape = shape_of(&self.checked.included, &self.registry, &at, &crumb.node, entry);
            at = crumb.address.clone();
            shape.group.as_ref() == Some(&at)
        })
    }

    /// Goes into a node's group.
    pub(super) fn enter(&mut self, node: &str) {
        match self.shapes.get(node).and_then(|shape| shape.group.clone()) {
            Some(address) => {
                self.trail.0.push(Crumb { node: node.to_owned(), address });
                self.selection = Default::default();
                self.canvas.arrive();
                self.canvas.release();
                self.refresh();
                if let Some(file) = self.foreign() {
                    self.say(format!(
                        "This group stands in the file {file}: it can be looked at, not changed"
                    ));
                }
            }
            None => self.say(format!("{node} is no group")),
        }
    }

    /// Goes back until so many steps of the way in remain.
    pub(super) fn leave(&mut self, remaining: usize) {
        if let Some(left) = self.trail.0.get(remaining).map(|crumb| crumb.node.clone()) {
            self.trail.0.truncate(remaining);
            self.selection = crate::action::Selection::node(left);
            self.canvas.arrive();
            self.canvas.release();
        }
    }

    /// A socket of the graph that is looked at.
    pub(super) fn socket(&self, pin: &Pin) -> Option<Socket> {
        let shape = self.shapes.get(&pin.node)?;
        let found = if pin.output { shape.output(&pin.socket) } else { shape.input(&pin.socket) };
        found.cloned()
    }

    /// What a node of a kind would look like here.
    pub(super) fn shape_of_kind(&self, kind: &Kind) -> Option<Shape> {
        let entry = match kind {
            Kind::Type(id) => NodeEntry::new(id.clone()),
            Kind::Group(name) => NodeEntry::new("flow.group").with("body", ParamValue::Text(name.clone())),
            Kind::Preset(name) => {
                let group = self.library.group(name).ok()?;
                let mut document = breccia_engine::Document::default();
                document.groups.insert(name.clone(), group);
                let entry = NodeEntry::new("flow.group").with("body", ParamValue::Text(name.clone()));
                return Some(shape_of(&document, &self.registry, &Address::default(), "new", &entry));
            }
        };
        Some(shape_of(&self.checked.included, &self.registry, &self.address(), "new", &entry))
    }
}
