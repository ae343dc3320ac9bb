//! What commands do to the selected nodes.

use std::collections::BTreeSet;
use std::path::Path;

use breccia_engine::{Arity, Link};

use super::App;
use crate::action::{Pin, Selection};
use crate::model::{self, Frame, Parts};

impl App {
    /// The nodes and frames that are selected.
    pub(super) fn selected_parts(&self) -> Parts {
        Parts { nodes: self.selection.nodes.clone(), frames: self.selection.frames.clone() }
    }

    fn select_parts(&mut self, made: Result<Parts, String>) {
        match made {
            Ok(Parts { nodes, frames }) => {
                self.selection = Selection { nodes, frames, ..Selection::default() };
            }
            Err(reason) => self.say(reason),
        }
    }

    /// Puts what was copied where the pointer is.
    pub(super) fn paste(&mut self, text: &str) {
        let at = self.address();
        let place = self.canvas.place_for_new();
        let made = self.project.edit("Paste", None, |state| model::paste(state, &at, text, place));
        self.select_parts(made);
    }

    pub(super) fn duplicate(&mut self) {
        let (at, parts) = (self.address(), self.selected_parts());
        let made =
            self.project.edit("Duplicate", None, |state| model::duplicate(state, &at, &parts, [30, 30]));
        self.select_parts(made);
    }

    /// Removes nodes and frames, and links with them, as one step.
    pub(super) fn remove(&mut self, name: &str, Parts { nodes, frames }: &Parts, links: &[String]) {
        let at = self.address();
        self.project.edit(name, None, |state| {
            model::delete(state, &at, nodes);
            model::disconnect(state, &at, links);
            if let Some(layout) = state.layouts.get_mut(&at.text()) {
                layout.frames.retain(|id, _| !frames.contains(id));
            }
        });
    }

    /// Selects the next node along a link, or the first or last.
    pub(super) fn step(&mut self, forward: bool) {
        let Some(level) = self.level() else { return };
        let links = level.links.iter().filter_map(|link| Link::parse(link));
        let current = self.selection.single().cloned();
        let next = match &current {
            Some(node) => links
                .filter(|l| if forward { l.from_node == *node } else { l.to_node == *node })
                .map(|l| if forward { l.to_node } else { l.from_node })
                .next(),
            None => None,
        };
        let next = next.or_else(|| {
            let names: Vec<&String> = self.shapes.keys().collect();
            let at = current.and_then(|node| names.iter().position(|name| **name == node));
            let n = names.len().max(1);
            let index = match at {
                Some(i) => {
                    if forward {
                        (i + 1) % n
                    } else {
                        (i + n - 1) % n
                    }
                }
                None => 0,
            };
            names.get(index).map(|name| (*name).clone())
        });
        if let Some(node) = next {
            self.selection = Selection::node(node);
        }
    }

    /// Links the selected nodes from left to right by the first sockets that fit and are free.
    pub(super) fn connect_selected(&mut self) {
        let at = self.address();
        let layout = self.project.state().layout(&at).cloned().unwrap_or_default();
        let mut nodes: Vec<String> = self.selection.nodes.iter().cloned().collect();
        nodes.sort_by_key(|node| layout.nodes.get(node).map_or([0, 0], |place| place.at));
        let mut made = 0;
        for pair in nodes.windows(2) {
            let [a, b] = pair else { continue };
            let (Some(from), Some(to)) = (self.shapes.get(a), self.shapes.get(b)) else { continue };
            let taken = |socket: &str| {
                self.level().is_some_and(|level| {
                    level
                        .links
                        .iter()
                        .filter_map(|l| Link::parse(l))
                        .any(|l| l.to_node == *b && l.to_socket == socket)
                })
            };
            let free = to.inputs.iter().filter(|input| input.arity == Arity::Many || !taken(&input.name));
            let found = free.into_iter().find_map(|input| {
                Some((
                    from.outputs.iter().find(|output| output.ty == input.ty)?.name.clone(),
                    input.name.clone(),
                ))
            });
            if let Some((output, input)) = found {
                let from = Pin { node: a.clone(), socket: output, output: true };
                let to = Pin { node: b.clone(), socket: input, output: false };
                self.connect(&from, &to, None);
                made += 1;
            }
        }
        if made == 0 {
            self.say("No free sockets of the same type in the selected nodes");
        }
    }

    pub(super) fn watch_next(&mut self) {
        let Some(node) = self.selection.single().cloned() else {
            self.say("Select one node to look at");
            return;
        };
        let outputs: Vec<String> = self
            .shapes
            .get(&node)
            .map_or(Vec::new(), |shape| shape.outputs.iter().map(|o| o.name.clone()).collect());
        let now = outputs
            .iter()
            .position(|socket| self.in_run(&node, socket) == self.watched && self.watched.is_some());
        let next = now.map_or(0, |i| (i + 1) % outputs.len().max(1));
        if let Some(socket) = outputs.get(next) {
            self.watch(&Pin { node, socket: socket.clone(), output: true });
        }
    }

    pub(super) fn frame(&mut self) {
        let at = self.address();
        let bounds = self.canvas.geometry().bounds(&self.selection.nodes);
        let Some(bounds) = bounds.filter(|_| !self.selection.nodes.is_empty()) else {
            self.say("Select the nodes to frame");
            return;
        };
        let bounds = bounds.expand(24.0);
        let frame = Frame {
            at: [bounds.left() as i32, (bounds.top() as i32).saturating_sub(20)],
            size: [bounds.width() as i32, (bounds.height() as i32).saturating_add(20)],
            title: "Frame".into(),
        };
        let id = self.project.edit("Frame", None, |state| model::add_frame(state, &at, frame));
        self.selection = Selection { frames: BTreeSet::from([id]), ..Selection::default() };
    }

    pub(super) fn keep_group(&mut self) {
        let selected = self
            .selection
            .single()
            .and_then(|node| Some((node.to_owned(), self.shapes.get(node)?.group.clone()?)));
        let Some((node, address)) = selected else {
            self.say("Select one group to keep");
            return;
        };
        // What is kept for all graphs names its files from anywhere.
        let folder = self.project.folder().map(Path::to_owned).unwrap_or_default();
        let mut whole = (*self.checked.included).clone();
        whole.change_paths(&self.registry, &folder, &mut |path| {
            Some(
                std::path::absolute(path).map_or(path.to_owned(), |path| path.to_string_lossy().into_owned()),
            )
        });
        let Some(group) = model::group_at(&whole, &address) else { return };
        // The node's name is the one that can be given; groups themselves are numbered.
        match self.library.keep(&node, group) {
            Ok(name) => self.say(format!("Kept as `{name}`; the node search finds it")),
            Err(reason) => self.say(format!("The group could not be kept: {reason}")),
        }
    }

    pub(super) fn localise(&mut self) {
        let selected = self
            .selection
            .single()
            .and_then(|node| self.shapes.get(node))
            .and_then(|shape| shape.group.clone());
        let address = selected.unwrap_or_else(|| self.address());
        // Paths in the group's file are relative to that file.
        let folder = self.project.folder().map(Path::to_owned);
        let mut included = (*self.checked.included).clone();
        included.change_paths(&self.registry, folder.as_deref().unwrap_or(Path::new("")), &mut |path| {
            Some(crate::files::relative(Path::new(path), folder.as_deref()))
        });
        let result = self
            .project
            .edit("Make group part of the graph", None, |state| model::localise(state, &included, &address));
        match result {
            Ok(()) => self.say("The group is part of the graph now"),
            Err(reason) => self.say(reason),
        }
    }
}
