//! Doing what the user asks for.

use std::collections::BTreeSet;
use std::time::Instant;

use breccia_engine::{Arity, Link, NodeEntry, NodeMode, ParamKind, ParamValue};
use eframe::egui::{Context, Theme};

use super::{After, App, Picked, Want};
use crate::action::{Action, Joint, Kind, Pin, Selection};
use crate::canvas::size_of;
use crate::command::Command;
use crate::model::{self, Alignment, Frame, Refusal, Shape};
use crate::palette::{self, Palette};

impl App {
    /// Does one thing.
    pub(super) fn perform(&mut self, action: Action, ctx: &Context) {
        let at = self.address();
        if changes(&action) {
            if let Some(file) = self.foreign() {
                self.say(format!("This group stands in the file {file}; Node, “Make group part of the graph” lets you edit it here"));
                return;
            }
        }
        match action {
            Action::Select(selection) => {
                self.project.seal();
                self.selection = selection;
            }
            Action::Add { kind, at: place, joint } => self.add(&kind, place, joint, ctx),
            Action::Connect(from, to) => self.connect(&from, &to),
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
                *watched = format!("{to}{rest}");
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
                    let groups = &mut state.document.groups;
                    let name =
                        if groups.get(&name) == Some(&group) { name } else { model::unique(groups, &name) };
                    groups.insert(name.clone(), group);
                    NodeEntry::new("flow.group").with("body", ParamValue::Text(name))
                }
            };
            let Some(name) = model::add_node(state, &at, entry, place) else { return (None, None) };
            let refusal = links.and_then(|links| join(state, &at, &name, &shape, &links).err());
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
            Joint::Between(a, b) => [a, b].into_iter().filter_map(told).collect(),
            Joint::Link(link) => Link::parse(link).map_or(Vec::new(), |link| {
                let from = Pin { node: link.from_node, socket: link.from_socket, output: true };
                let to = Pin { node: link.to_node, socket: link.to_socket, output: false };
                [&from, &to].into_iter().filter_map(told).collect()
            }),
        }
    }

    fn connect(&mut self, from: &Pin, to: &Pin) {
        let at = self.address();
        let (Some(output), Some(input)) = (self.socket(from), self.socket(to)) else { return };
        if let Err(refusal) = model::compatible(&self.registry, &output, &input) {
            self.say(refusal.reason);
            return;
        }
        let link = link(from, to);
        let result =
            self.project.edit("Connect", None, |state| model::connect(state, &at, &link, input.arity));
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
        let before = self.project.state().clone();
        let result = self.project.edit("Insert into link", None, |state| {
            let result = model::insert_on_link(state, &at, link, node, &shape, &output.ty, input.arity);
            if result.is_err() {
                *state = before;
            }
            result
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
        self.want(Want::Param(node, param, extensions));
    }

    /// Asks for a file.
    pub(super) fn want(&mut self, want: Want) {
        let answer = self.picker.ask(&want);
        self.picking.push(Picked { want, answer, asked: Instant::now() });
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
    fn place(&mut self, name: &str, change: impl FnOnce(&mut model::State, &dyn Fn(&str) -> [i32; 2])) {
        let at = self.address();
        let places = self.project.state().layout(&at).map(|layout| layout.nodes.clone()).unwrap_or_default();
        let shapes = self.shapes.clone();
        let size = move |node: &str| {
            let place = places.get(node).copied().unwrap_or_default();
            shapes.get(node).map_or([184, 80], |shape| size_of(shape, place))
        };
        self.project.edit(name, None, |state| change(state, &size));
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

    fn search_nodes(&mut self, at: [i32; 2], joint: Option<Joint>) {
        let groups = self.checked.included.groups.iter();
        let entries = palette::nodes(&self.registry, groups, &self.library.list());
        let (title, entries) = match &joint {
            Some(joint) => {
                let fitting = palette::fitting(entries, joint, &|pin| self.socket(pin), &|kind| {
                    self.shape_of_kind(kind)
                });
                (
                    if matches!(joint, Joint::Between(..)) { "Convert with" } else { "Add a node that fits" },
                    fitting,
                )
            }
            None => ("Add a node", entries),
        };
        self.palette = Some(Palette::new(title, entries, at, joint));
    }

    /// Does a command.
    pub(super) fn command(&mut self, command: Command, ctx: &Context) {
        let at = self.address();
        let nodes = self.selection.nodes.clone();
        if edits(command) {
            if let Some(file) = self.foreign() {
                self.say(format!("This group stands in the file {file}; Node, “Make group part of the graph” lets you edit it here"));
                return;
            }
        }
        match command {
            Command::New => self.leave_document(After::New, ctx),
            Command::Gallery => self.open.gallery = !self.open.gallery,
            Command::Open => self.leave_document(After::Pick, ctx),
            Command::Reload => self.reload(),
            Command::Save => self.save(),
            Command::SaveAs => self.save_as(),
            Command::ImportBundle => self.want(Want::Import),
            Command::ExportBundle => self.want(Want::Export(format!("{}.zip", self.stem()))),
            Command::ExportOutput => self.export_watched(),
            Command::Quit => self.leave_document(After::Quit, ctx),
            Command::Undo => {
                self.canvas.release();
                match self.project.undo() {
                    Some(name) => self.say(format!("Undone: {name}")),
                    None => self.say("Nothing to undo"),
                }
            }
            Command::Redo => {
                self.canvas.release();
                match self.project.redo() {
                    Some(name) => self.say(format!("Done again: {name}")),
                    None => self.say("Nothing to do again"),
                }
            }
            Command::Cut | Command::Copy => {
                if let Some(text) = model::copy(self.project.state(), &at, &nodes) {
                    ctx.copy_text(text.clone());
                    self.copied = Some(text);
                    if command == Command::Cut {
                        self.project.edit("Cut", None, |state| model::delete(state, &at, &nodes));
                    }
                }
            }
            Command::Paste => {
                if let Some(text) = self.copied.clone() {
                    self.paste(&text);
                }
            }
            Command::Duplicate => self.duplicate(),
            Command::Delete => {
                let links: Vec<String> = self.selection.links.iter().cloned().collect();
                let frames = self.selection.frames.clone();
                let name = if nodes.len() == 1 { "Delete node" } else { "Delete" };
                self.project.edit(name, None, |state| {
                    model::delete(state, &at, &nodes);
                    model::disconnect(state, &at, &links);
                    state.layout_mut(&at).frames.retain(|id, _| !frames.contains(id));
                });
            }
            Command::SelectAll => {
                self.selection =
                    Selection { nodes: self.shapes.keys().cloned().collect(), ..Selection::default() }
            }
            Command::SelectNone => self.selection = Selection::default(),
            Command::SelectNext => self.step(true),
            Command::SelectPrevious => self.step(false),
            Command::AddNode => self.search_nodes(self.canvas.place_for_new(), None),
            Command::Connect => self.connect_selected(),
            Command::DisconnectAll => {
                let of_node = |link: &&String| {
                    Link::parse(link)
                        .is_some_and(|link| nodes.contains(&link.from_node) || nodes.contains(&link.to_node))
                };
                let level = self.level();
                let links = level.map_or(Vec::new(), |level| {
                    level.links.iter().filter(of_node).chain(&self.selection.links).cloned().collect()
                });
                self.project.edit("Disconnect", None, |state| model::disconnect(state, &at, &links));
            }
            Command::Rename => {
                self.open.inspector = true;
                ctx.memory_mut(|memory| memory.request_focus(eframe::egui::Id::new("node name field")));
            }
            Command::Watch => self.watch_next(),
            Command::Mute | Command::Bypass => {
                let mode = if command == Command::Mute { NodeMode::Mute } else { NodeMode::Bypass };
                let is_so = |name: &String| {
                    self.level()
                        .and_then(|level| level.nodes.get(name))
                        .is_some_and(|entry| entry.mode == mode)
                };
                let to = if nodes.iter().all(is_so) { NodeMode::Normal } else { mode };
                self.project.edit(command.title(), None, |state| model::set_mode(state, &at, &nodes, to));
            }
            Command::Collapse | Command::Picture => {
                let layout = self.project.state().layout(&at).cloned().unwrap_or_default();
                let place = |name: &String| layout.nodes.get(name).copied().unwrap_or_default();
                if command == Command::Collapse {
                    let to = !nodes.iter().all(|name| place(name).collapsed);
                    self.project.edit("Collapse", None, |state| model::set_collapsed(state, &at, &nodes, to));
                } else {
                    let to = !nodes.iter().all(|name| place(name).picture);
                    self.project
                        .edit("Show picture", None, |state| model::set_picture(state, &at, &nodes, to));
                    self.due = true;
                }
            }
            Command::Group => {
                let shapes = self.shapes.clone();
                let made = self.project.edit("Group", None, |state| {
                    model::group(state, &at, &nodes, &|name| shapes.get(name).cloned())
                });
                match made {
                    Some(name) => self.selection = Selection::node(name),
                    None => self.say(
                        "Select the nodes to group; nodes that read the graph's input files stay outside",
                    ),
                }
            }
            Command::Ungroup => {
                let Some(node) = self.selection.single().cloned() else {
                    self.say("Select one group");
                    return;
                };
                match self.project.edit("Ungroup", None, |state| model::ungroup(state, &at, &node)) {
                    Ok(names) => self.selection.nodes = names.into_iter().collect(),
                    Err(reason) => self.say(reason),
                }
            }
            Command::Enter => {
                if let Some(node) = self.selection.single().cloned() {
                    self.enter(&node);
                }
            }
            Command::Leave => self.leave(self.trail.0.len().saturating_sub(1)),
            Command::SaveGroup => self.keep_group(),
            Command::LocaliseGroup => self.localise(),
            Command::Frame => self.frame(),
            Command::AlignLeft => self.perform(Action::Align(Alignment::Left), ctx),
            Command::AlignRight => self.perform(Action::Align(Alignment::Right), ctx),
            Command::AlignTop => self.perform(Action::Align(Alignment::Top), ctx),
            Command::AlignBottom => self.perform(Action::Align(Alignment::Bottom), ctx),
            Command::Arrange => {
                let nodes = if nodes.len() > 1 { nodes } else { self.shapes.keys().cloned().collect() };
                self.place("Lay out", |state, size| model::arrange(state, &at, &nodes, size));
            }
            Command::Run => self.run_all(ctx),
            Command::Stop => {
                self.stop();
                self.due = false;
                self.say("Stopped");
            }
            Command::Live => {
                self.live = !self.live;
                self.say(if self.live {
                    "Live: computes after every change"
                } else {
                    "Computes only when asked to (F5)"
                });
            }
            Command::ClearMemory => {
                self.stop();
                self.runner.engine().clear_memory();
                self.results.clear();
                self.board.clear();
                self.say("Results in memory are forgotten");
            }
            Command::FitAll => self.canvas.fit(BTreeSet::new()),
            Command::FitSelection => self.canvas.fit(nodes),
            Command::ZoomIn => self.canvas.zoom_by(1.25),
            Command::ZoomOut => self.canvas.zoom_by(0.8),
            Command::Minimap => self.canvas.map = !self.canvas.map,
            Command::Legend => self.canvas.legend = !self.canvas.legend,
            Command::Inspector => self.open.inspector = !self.open.inspector,
            Command::Viewport => self.open.viewport = !self.open.viewport,
            Command::Theme => {
                let theme = if ctx.theme() == Theme::Dark { Theme::Light } else { Theme::Dark };
                ctx.set_theme(theme);
            }
            Command::Larger => ctx.set_zoom_factor((ctx.zoom_factor() * 1.1).min(3.0)),
            Command::Smaller => ctx.set_zoom_factor((ctx.zoom_factor() / 1.1).max(0.5)),
            Command::Commands => {
                self.palette = Some(Palette::new("Find a command", palette::commands(), [0, 0], None))
            }
            Command::Shortcuts => self.open.shortcuts = !self.open.shortcuts,
            Command::Tour => self.open.tour = !self.open.tour,
        }
    }

    /// Puts copied nodes where the pointer is.
    pub(super) fn paste(&mut self, text: &str) {
        let at = self.address();
        let place = self.canvas.place_for_new();
        match self.project.edit("Paste", None, |state| model::paste(state, &at, text, place)) {
            Ok(names) => self.selection = Selection { nodes: names, ..Selection::default() },
            Err(reason) => self.say(reason),
        }
    }

    fn duplicate(&mut self) {
        let at = self.address();
        let nodes = self.selection.nodes.clone();
        let Some(text) = model::copy(self.project.state(), &at, &nodes) else { return };
        let corner = |i: usize| {
            let layout = self.project.state().layout(&at)?;
            nodes.iter().filter_map(|node| Some(layout.nodes.get(node)?.at[i])).min()
        };
        let place = [corner(0).unwrap_or(0).saturating_add(30), corner(1).unwrap_or(0).saturating_add(30)];
        let result =
            self.project.edit("Duplicate", None, |state| model::duplicate(state, &at, &nodes, &text, place));
        match result {
            Ok(names) => self.selection = Selection { nodes: names, ..Selection::default() },
            Err(reason) => self.say(reason),
        }
    }

    /// Selects the next node along a link, or the first or last.
    fn step(&mut self, forward: bool) {
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
    fn connect_selected(&mut self) {
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
                self.connect(&from, &to);
                made += 1;
            }
        }
        if made == 0 {
            self.say("No free sockets of the same type in the selected nodes");
        }
    }

    fn watch_next(&mut self) {
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

    fn frame(&mut self) {
        let at = self.address();
        let bounds = self.canvas.geometry().bounds(&self.selection.nodes);
        let Some(bounds) = bounds.filter(|_| !self.selection.nodes.is_empty()) else {
            self.say("Select the nodes to frame");
            return;
        };
        let bounds = bounds.expand(24.0);
        let frame = Frame {
            at: [bounds.left() as i32, bounds.top() as i32 - 20],
            size: [bounds.width() as i32, bounds.height() as i32 + 20],
            title: "Frame".into(),
        };
        let id = self.project.edit("Frame", None, |state| model::add_frame(state, &at, frame));
        self.selection = Selection { frames: BTreeSet::from([id]), ..Selection::default() };
    }

    fn keep_group(&mut self) {
        let node = self
            .selection
            .single()
            .and_then(|node| self.shapes.get(node))
            .and_then(|shape| shape.group.clone());
        let Some(address) = node else {
            self.say("Select one group to keep");
            return;
        };
        let (Some(name), Some(group)) =
            (address.0.last().cloned(), model::group_at(&self.checked.included, &address).cloned())
        else {
            return;
        };
        match self.library.keep(&name, &group) {
            Ok(()) => self.say(format!("Kept as `{name}`; the node search finds it")),
            Err(reason) => self.say(format!("The group could not be kept: {reason}")),
        }
    }

    fn localise(&mut self) {
        let selected = self
            .selection
            .single()
            .and_then(|node| self.shapes.get(node))
            .and_then(|shape| shape.group.clone());
        let address = selected.unwrap_or_else(|| self.address());
        let included = std::sync::Arc::clone(&self.checked.included);
        let result = self
            .project
            .edit("Make group part of the graph", None, |state| model::localise(state, &included, &address));
        match result {
            Ok(()) => self.say("The group is part of the graph now"),
            Err(reason) => self.say(reason),
        }
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

/// Whether a command changes the graph that is looked at.
fn edits(command: Command) -> bool {
    use Command as C;
    matches!(
        command,
        C::Cut
            | C::Paste
            | C::Duplicate
            | C::Delete
            | C::AddNode
            | C::Connect
            | C::DisconnectAll
            | C::Rename
            | C::Mute
            | C::Bypass
            | C::Group
            | C::Ungroup
    )
}
