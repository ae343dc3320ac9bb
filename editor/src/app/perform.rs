//! Doing what the user asks for.

use std::collections::BTreeSet;

use breccia_engine::{Arity, Link, NodeEntry, ParamKind, ParamValue};
use eframe::egui::Context;

use super::{After, App, Want};
use crate::action::{Action, Joint, Kind, Pin, Selection};
use crate::canvas::size_of;
use crate::model::{self, Refusal, Shape};
use crate::palette::{self, Palette};
use crate::view::Subject;

impl App {
    /// Does one thing.
    pub(super) fn perform(&mut self, action: Action, ctx: &Context) {
        let at = self.address();
        if changes(&action) && self.refuses() {
            return;
        }
        match action {
            Action::Select(selection) => {
                self.project.seal();
                self.selection = selection;
            }
            Action::Add { kind, at: place, joint } => self.add(&kind, place, joint, ctx),
            Action::Connect(from, to) => self.connect(&from, &to, None),
            Action::Reconnect { link, from, to } => self.connect(&from, &to, Some(&link)),
            Action::Disconnect(links) => {
                self.project.edit("Disconnect", None, |state| model::disconnect(state, &at, &links))
            }
            Action::Move(by) => {
                let (nodes, frames) = (self.selection.nodes.clone(), self.selection.frames.clone());
                self.project
                    .edit("Move", Some("move"), |state| model::move_by(state, &at, &nodes, &frames, by));
            }
            Action::EndDrag => {
                self.project.seal();
                self.dragging = false;
            }
            Action::DropOnLink { node, link } => self.drop_on_link(&node, &link),
            Action::Bend(link, points) => {
                let merge = format!("bend {link}");
                self.project.edit("Bend link", Some(&merge), |state| model::bend(state, &at, &link, points));
            }
            Action::SizeFrame(id, size) => {
                self.project.edit("Size frame", Some(&format!("size {id}")), |state| {
                    if let Some(frame) = state.layout_mut(&at).frames.get_mut(&id) {
                        frame.size = size;
                    }
                });
            }
            Action::TitleFrame(id, title) => {
                self.project.edit("Title frame", Some(&format!("title {id}")), |state| {
                    if let Some(frame) = state.layout_mut(&at).frames.get_mut(&id) {
                        frame.title = title;
                    }
                });
            }
            Action::Enter(node) => self.enter(&node),
            Action::Leave(remaining) => self.leave(remaining),
            Action::Watch(pin) => self.watch(&pin),
            Action::Set { node, param, value, dragging } => {
                self.dragging = dragging;
                let merge = dragging.then(|| format!("set {node}.{param}"));
                let name = format!("Change {}", param.replace('_', " "));
                self.project.edit(&name, merge.as_deref(), |state| {
                    model::set_param(state, &at, &node, &param, value)
                });
            }
            Action::Expose { node, param } => self.expose(&node, &param),
            Action::Unexpose { node, param } => {
                self.project.edit(&format!("Take back {param}"), None, |state| {
                    model::unexpose(state, &at, &node, &param)
                });
            }
            Action::LinkParam { node, param, to } => self.link_param(&node, &param, &to),
            Action::PickFile { node, param } => self.pick_file(node, param),
            Action::Rename(node, name) => {
                let renamed =
                    self.project.edit("Rename", None, |state| model::rename(state, &at, &node, &name));
                if let Some(name) = renamed {
                    if self.selection.nodes.remove(&node) {
                        self.selection.nodes.insert(name.clone());
                    }
                    self.follow(&node, &name);
                }
            }
            Action::Title(title) => {
                self.project.edit("Change title", Some("title"), |state| state.document.title = title)
            }
            Action::Docs(docs) => {
                self.project.edit("Change description", Some("docs"), |state| state.document.docs = docs)
            }
            Action::Output(pin) => self.offer(&pin),
            Action::Align(to) => {
                let nodes = self.selection.nodes.clone();
                self.place("Align", |state, size| model::align(state, &at, &nodes, to, size));
            }
            Action::Reveal(path) => self.reveal(&path),
            Action::Palette { at: place, joint } => self.search_nodes(place, joint),
            Action::OpenPath(path) => self.leave_document(After::Open(path), ctx),
            Action::OpenPreset(name) => self.leave_document(After::Preset(name), ctx),
            Action::Say(text) => self.say(text),
            Action::Command(command) => self.command(command, ctx),
        }
    }

    /// What is looked at keeps being looked at under its new name.
    fn follow(&mut self, from: &str, to: &str) {
        if !self.trail.0.is_empty() {
            return;
        }
        if let Some(watched) = &mut self.watched {
            let rest = watched.strip_prefix(from).filter(|rest| rest.starts_with(['.', '/', '[']));
            if let Some(rest) = rest.map(str::to_owned) {
                let old = std::mem::replace(watched, format!("{to}{rest}"));
                // A node that is off gives no other result.
                if let Some(subject) = self.results.remove(&old) {
                    let label = watched.clone();
                    self.results.insert(label.clone(), Subject { label, ..subject });
                }
            }
        }
    }

    fn add(&mut self, kind: &Kind, place: [i32; 2], joint: Option<Joint>, ctx: &Context) {
        let at = self.address();
        let Some(shape) = self.shape_of_kind(kind) else {
            self.say("That node cannot be added here");
            return;
        };
        let links = joint.as_ref().map(|joint| self.joints(joint));
        let instead = match joint {
            Some(Joint::Between { instead, .. }) => instead,
            _ => None,
        };
        let preset = match kind {
            Kind::Preset(name) => self.library.group(name).ok().map(|group| (name.clone(), group)),
            _ => None,
        };
        let kind = kind.clone();
        let (added, refusal) = self.project.edit(&format!("Add {}", shape.ty), None, |state| {
            let entry = match kind {
                Kind::Type(id) => NodeEntry::new(id),
                Kind::Group(name) => NodeEntry::new("flow.group").with("body", ParamValue::Text(name)),
                Kind::Preset(_) => {
                    let Some((name, group)) = preset else { return (None, None) };
                    let free = model::free_group_name(&state.document, &name);
                    let groups = &mut state.document.groups;
                    let name = if groups.get(&name) == Some(&group) { name } else { free };
                    groups.insert(name.clone(), group);
                    NodeEntry::new("flow.group").with("body", ParamValue::Text(name))
                }
            };
            let Some(name) = model::add_node(state, &at, entry, place) else { return (None, None) };
            let refusal = links.and_then(|links| join(state, &at, &name, &shape, &links).err());
            if let Some(old) = instead.filter(|_| refusal.is_none()) {
                model::disconnect(state, &at, &[old]);
            }
            (Some(name), refusal)
        });
        if let Some(name) = added {
            self.selection = Selection::node(name);
        }
        if let Some(refusal) = refusal {
            self.say(refusal.reason);
        }
        ctx.memory_mut(|memory| memory.stop_text_input());
    }

    /// What a joint means: a socket with its type and arity, twice for two.
    fn joints(&self, joint: &Joint) -> Vec<(Pin, String, Arity)> {
        let told = |pin: &Pin| {
            let socket = self.socket(pin)?;
            Some((pin.clone(), socket.ty, socket.arity))
        };
        match joint {
            Joint::Pin(pin) => told(pin).into_iter().collect(),
            Joint::Between { from, to, .. } => [from, to].into_iter().filter_map(told).collect(),
            Joint::Link(link) => Link::parse(link).map_or(Vec::new(), |link| {
                let from = Pin { node: link.from_node, socket: link.from_socket, output: true };
                let to = Pin { node: link.to_node, socket: link.to_socket, output: false };
                [&from, &to].into_iter().filter_map(told).collect()
            }),
        }
    }

    /// Makes a link, in the place of another one if there is one to go. If it cannot be made all stays as it is.
    pub(super) fn connect(&mut self, from: &Pin, to: &Pin, instead: Option<&str>) {
        let at = self.address();
        let (Some(output), Some(input)) = (self.socket(from), self.socket(to)) else { return };
        if let Err(refusal) = model::compatible(&self.registry, &output, &input) {
            self.say(refusal.reason);
            return;
        }
        let link = link(from, to);
        let name = if instead.is_some() { "Reconnect" } else { "Connect" };
        let result = self.project.try_edit(name, |state| {
            if let Some(old) = instead {
                model::disconnect(state, &at, &[old.to_owned()]);
            }
            model::connect(state, &at, &link, input.arity)
        });
        if let Err(refusal) = result {
            self.say(refusal.reason);
        }
    }

    fn drop_on_link(&mut self, node: &str, link: &str) {
        let at = self.address();
        let Some(parsed) = Link::parse(link) else { return };
        let from = Pin { node: parsed.from_node, socket: parsed.from_socket, output: true };
        let to = Pin { node: parsed.to_node, socket: parsed.to_socket, output: false };
        let (Some(output), Some(input), Some(shape)) =
            (self.socket(&from), self.socket(&to), self.shapes.get(node).cloned())
        else {
            return;
        };
        let fits =
            shape.inputs.iter().any(|s| s.ty == output.ty) && shape.outputs.iter().any(|s| s.ty == input.ty);
        if !fits {
            return;
        }
        let result = self.project.try_edit("Insert into link", |state| {
            model::insert_on_link(state, &at, link, node, &shape, &output.ty, input.arity)
        });
        if let Err(refusal) = result {
            self.say(refusal.reason);
        }
    }

    fn expose(&mut self, node: &str, param: &str) {
        let at = self.address();
        let Some(shape) = self.shapes.get(node) else { return };
        let Some(found) = shape.param(param) else { return };
        let is_file = matches!(found.kind, ParamKind::File { .. });
        let file = shape.outputs.first().filter(|_| is_file).map(|output| output.ty.clone());
        let docs = found.docs.clone();
        let name = self.project.edit(&format!("Expose {param}"), None, |state| {
            model::expose(state, &at, node, param, file.as_deref(), &docs)
        });
        if let Some(name) = name {
            self.say(format!("The graph offers {node}.{param} as `{name}`"));
        }
    }

    fn link_param(&mut self, node: &str, param: &str, to: &str) {
        let at = self.address();
        let Some(level) = self.project.state().level(&at) else { return };
        let Some(exposed) = level.interface.params.get(to) else { return };
        let first = exposed.targets.iter().filter_map(|target| target.split_once('.')).next();
        let current = first.and_then(|(node, param)| {
            let own = level.nodes.get(node)?.params.get(param).cloned();
            own.or_else(|| Some(self.shapes.get(node)?.param(param)?.default.clone()))
        });
        let Some(current) = exposed.default.clone().or(current) else { return };
        self.project.edit(&format!("Link {param} to {to}"), None, |state| {
            model::link_param(state, &at, node, param, to, &current)
        });
    }

    fn pick_file(&mut self, node: String, param: String) {
        let kind = self.shapes.get(&node).and_then(|shape| Some(shape.param(&param)?.kind.clone()));
        let extensions = match kind {
            Some(ParamKind::File { extensions }) => extensions.iter().map(|e| (*e).to_owned()).collect(),
            _ => Vec::new(),
        };
        self.want(Want::Param { at: self.address(), node, param, extensions });
    }

    fn offer(&mut self, pin: &Pin) {
        let at = self.address();
        let Some(socket) = self.socket(pin) else { return };
        let name = format!("Offer {}", pin.socket);
        let pin = pin.clone();
        self.project.edit(&name, None, |state| {
            let Some(level) = state.level(&at) else { return };
            let taken = level.interface.outputs.clone();
            let found =
                taken.iter().find(|(_, output)| output.node == pin.node && output.socket == pin.socket);
            match found {
                Some((name, _)) => model::drop_output(state, &at, name),
                None => {
                    let name = model::unique(&taken, &pin.socket);
                    model::offer_output(state, &at, &name, &pin.node, &pin.socket, &socket.docs);
                }
            }
        });
    }

    /// Changes places, with the sizes of nodes known.
    pub(super) fn place<T>(
        &mut self,
        name: &str,
        change: impl FnOnce(&mut model::State, &dyn Fn(&str) -> [i32; 2]) -> T,
    ) -> T {
        let at = self.address();
        let places = self.project.state().layout(&at).map(|layout| layout.nodes.clone()).unwrap_or_default();
        let shapes = self.shapes.clone();
        let size = move |node: &str| {
            let place = places.get(node).copied().unwrap_or_default();
            shapes.get(node).map_or([184, 80], |shape| size_of(shape, place))
        };
        self.project.edit(name, None, |state| change(state, &size))
    }

    /// Shows a node, in whatever group it is.
    fn reveal(&mut self, path: &str) {
        let path = crate::run::general(path);
        let mut parts: Vec<&str> = path.split('/').collect();
        let Some(node) = parts.pop() else { return };
        self.leave(0);
        self.trail.0.clear();
        self.refresh();
        for part in parts {
            if self.shapes.get(part).is_none_or(|shape| shape.group.is_none()) {
                break;
            }
            self.enter(part);
        }
        if self.shapes.contains_key(node) {
            self.selection = Selection::node(node);
            self.canvas.fit(BTreeSet::from([node.to_owned()]));
        }
    }

    pub(super) fn search_nodes(&mut self, at: [i32; 2], joint: Option<Joint>) {
        let groups = self.checked.included.groups.iter();
        let entries = palette::nodes(&self.registry, groups, &self.library.list());
        let (title, entries) = match &joint {
            Some(joint) => {
                let fitting = palette::fitting(entries, joint, &|pin| self.socket(pin), &|kind| {
                    self.shape_of_kind(kind)
                });
                (
                    if matches!(joint, Joint::Between { .. }) {
                        "Convert with"
                    } else {
                        "Add a node that fits"
                    },
                    fitting,
                )
            }
            None => ("Add a node", entries),
        };
        self.palette = Some(Palette::new(title, entries, at, joint));
    }
}

fn link(from: &Pin, to: &Pin) -> Link {
    Link {
        from_node: from.node.clone(),
        from_socket: from.socket.clone(),
        to_node: to.node.clone(),
        to_socket: to.socket.clone(),
    }
}

/// Joins a new node to sockets.
fn join(
    state: &mut model::State,
    at: &model::Address,
    node: &str,
    shape: &Shape,
    ends: &[(Pin, String, Arity)],
) -> Result<(), Refusal> {
    let pin = |socket: &str, output| Pin { node: node.to_owned(), socket: socket.to_owned(), output };
    for (end, ty, arity) in ends {
        let sockets = if end.output { &shape.inputs } else { &shape.outputs };
        let Some(socket) = sockets.iter().find(|socket| socket.ty == *ty || ty.is_empty()) else { continue };
        if end.output {
            model::connect(state, at, &link(end, &pin(&socket.name, false)), socket.arity)?;
        } else {
            model::connect(state, at, &link(&pin(&socket.name, true), end), *arity)?;
        }
    }
    Ok(())
}

/// Whether an action changes the graph that is looked at.
fn changes(action: &Action) -> bool {
    !matches!(
        action,
        Action::Select(_)
            | Action::EndDrag
            | Action::Enter(_)
            | Action::Leave(_)
            | Action::Watch(_)
            | Action::Reveal(_)
            | Action::OpenPath(_)
            | Action::OpenPreset(_)
            | Action::Say(_)
            | Action::Command(_)
            | Action::Move(_)
            | Action::Title(_)
            | Action::Docs(_)
    )
}
