//! Doing commands: those of menus, keys and the command search.

use std::collections::BTreeSet;

use breccia_engine::{Link, NodeMode};
use eframe::egui::{Context, Theme};

use super::{After, App, Want};
use crate::action::{Action, Selection};
use crate::command::Command;
use crate::model::{self, Alignment};
use crate::palette::{self, Palette};

impl App {
    /// Does a command.
    pub(super) fn command(&mut self, command: Command, ctx: &Context) {
        let at = self.address();
        let nodes = self.selection.nodes.clone();
        if edits(command) && self.refuses() {
            return;
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
                if let Some(text) = model::copy(self.project.state(), &at, &self.selected_parts()) {
                    ctx.copy_text(text.clone());
                    self.copied = Some(text);
                    if command == Command::Cut {
                        // Links that are selected alone were not copied, and stay.
                        self.remove("Cut", &self.selected_parts(), &[]);
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
                let name = if nodes.len() == 1 { "Delete node" } else { "Delete" };
                let links: Vec<String> = self.selection.links.iter().cloned().collect();
                self.remove(name, &self.selected_parts(), &links);
            }
            Command::SelectAll => {
                let layout = self.project.state().layout(&at);
                let frames = layout.map_or_else(Default::default, |l| l.frames.keys().copied().collect());
                let nodes = self.shapes.keys().cloned().collect();
                self.selection = Selection { nodes, frames, ..Selection::default() };
            }
            Command::SelectNone => {
                self.selection = Selection::default();
                ctx.memory_mut(|memory| memory.stop_text_input());
            }
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
                let made = self.place("Group", |state, size| {
                    model::group(state, &at, &nodes, &|name| shapes.get(name).cloned(), size)
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
            Command::FocusInspector => {
                self.open.inspector = true;
                let first = if self.selection.single().is_some() { "node name field" } else { "graph title" };
                ctx.memory_mut(|memory| memory.request_focus(eframe::egui::Id::new(first)));
            }
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
