//! The window: menus above, canvas in the middle, viewport and parameters beside it, what happens below.

use std::time::Duration;

use eframe::egui::{
    self, Align, Button, Context, Key, Layout, Modifiers, Panel, ScrollArea, TextEdit, Ui, WidgetInfo,
    WidgetType,
};

use super::watch::Companions;
use super::{After, App};
use crate::action::Action;
use crate::canvas::Sight;
use crate::command::Command;
use crate::inspector;
use crate::model::Layout as Places;
use crate::theme::Palette as Colors;
use crate::view::{Scene, ViewAction};

impl App {
    /// What happens before anything is drawn.
    pub(super) fn before(&mut self, ctx: &Context) {
        self.take_news(ctx);
        self.take_answers(ctx);
        if ctx.input(|i| i.viewport().close_requested()) && !self.quitting && self.project.is_dirty() {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.ask_to_save(After::Quit);
        }
    }

    /// Ends a drag whose button was let go of, after what this frame brought has been done.
    pub(super) fn end_drag(&mut self, ctx: &Context) {
        if ctx.input(|i| i.pointer.any_released()) && self.dragging {
            self.dragging = false;
            self.project.seal();
        }
    }

    /// What happens after everything is drawn and done.
    pub(super) fn after(&mut self, ctx: &Context) {
        self.keep_safe(ctx);
        let mark = if self.project.is_dirty() { "* " } else { "" };
        let title = format!("{mark}{} - Breccia", self.project.name());
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        if self.busy.contains(&true) {
            // Progress and elapsed time.
            ctx.request_repaint_after(Duration::from_millis(100));
        }
    }

    /// Keys.
    pub(super) fn shortcuts(&mut self, ctx: &Context) -> Vec<Action> {
        let mut actions = Vec::new();
        if self.palette.is_some() {
            return actions;
        }
        // Before the key means anything else.
        if !self.path_sheets.is_empty()
            && !self.is_asking()
            && ctx.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape))
        {
            self.give_up_path();
        }
        let typing = ctx.text_edit_focused();
        // Copying and pasting come as events of their own.
        let events = ctx.input(|i| i.events.clone());
        for event in events {
            match event {
                egui::Event::Copy if !typing => actions.push(Action::Command(Command::Copy)),
                egui::Event::Cut if !typing => actions.push(Action::Command(Command::Cut)),
                egui::Event::Paste(text) if !typing && self.foreign().is_none() => {
                    self.paste(&text);
                }
                _ => {}
            }
        }
        // Longer combinations first, so that Ctrl+Shift+Z is not Ctrl+Z.
        let mut commands: Vec<_> = Command::ALL.iter().filter_map(|c| Some((*c, c.shortcut()?))).collect();
        commands.sort_by_key(|(_, shortcut)| std::cmp::Reverse(u8::from(shortcut.modifiers.shift)));
        for (command, shortcut) in commands {
            let by_event = matches!(command, Command::Copy | Command::Cut | Command::Paste);
            if by_event
                || (typing
                    && (command.is_plain()
                        || command == Command::SelectAll
                        || command == Command::Undo
                        || command == Command::Redo
                        || shortcut.modifiers == Modifiers::ALT))
            {
                continue;
            }
            // Where a control has the keyboard, Tab goes to the next one and Enter presses it.
            let walks =
                matches!(command, Command::AddNode | Command::Enter) && ctx.memory(|m| m.focused()).is_some();
            if walks {
                continue;
            }
            if ctx.input_mut(|i| i.consume_shortcut(&shortcut)) {
                actions.push(Action::Command(command));
            }
        }
        if !typing && ctx.input_mut(|i| i.consume_key(Modifiers::COMMAND, Key::Y)) {
            actions.push(Action::Command(Command::Redo));
        }
        // Where plus is the upper sign of a key it is meant without Shift as well.
        if ctx.input_mut(|i| i.consume_key(Modifiers::COMMAND, Key::Equals)) {
            actions.push(Action::Command(Command::ZoomIn));
        }
        if !typing && ctx.memory(|m| m.focused()).is_none() && !self.selection.is_empty() {
            let arrows = [
                (Key::ArrowLeft, [-10, 0]),
                (Key::ArrowRight, [10, 0]),
                (Key::ArrowUp, [0, -10]),
                (Key::ArrowDown, [0, 10]),
            ];
            for (key, by) in arrows {
                if ctx.input_mut(|i| i.consume_key(Modifiers::NONE, key)) {
                    actions.extend([Action::Move(by), Action::EndDrag]);
                }
            }
        }
        if actions.contains(&Action::Command(Command::AddNode)) {
            // Tab would go to the next control, too.
            ctx.memory_mut(|memory| memory.move_focus(egui::FocusDirection::None));
        }
        if actions.contains(&Action::Command(Command::SelectNone)) {
            self.open.shortcuts = false;
            self.open.tour = false;
            self.open.gallery = false;
            self.stay();
        }
        actions
    }

    /// Draws everything.
    pub(super) fn draw(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let ctx = ui.ctx().clone();
        Panel::top("menus").show(ui, |ui| self.menus(ui, actions));
        Panel::top("tools").show(ui, |ui| self.tools(ui, actions));
        Panel::bottom("line").show(ui, |ui| self.line(ui, actions));
        self.notices(ui, actions, &ctx);
        if self.open.problems {
            Panel::bottom("problems")
                .resizable(true)
                .default_size(110.0)
                .show(ui, |ui| self.problems(ui, actions));
        }
        let width = ui.available_width();
        if self.open.inspector {
            let panel = Panel::right("inspector")
                .resizable(true)
                .default_size(280.0)
                .size_range(200.0..=(width * 0.45).max(201.0));
            panel.show(ui, |ui| {
                ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| self.inspect(ui, actions));
            });
        }
        if let Some(viewport) = &mut self.viewport {
            let saved = viewport.go_on(&ctx);
            self.take_from_viewport(saved, actions);
        }
        if self.open.viewport && self.viewport.is_some() {
            let panel = Panel::right("viewport")
                .resizable(true)
                .default_size(430.0)
                .size_range(180.0..=(width * 0.7).max(181.0));
            let frame = egui::Frame::NONE.fill(ui.visuals().panel_fill);
            panel.frame(frame).show(ui, |ui| self.look(ui, actions));
        }
        egui::CentralPanel::no_frame().show(ui, |ui| {
            if !self.trail.0.is_empty() {
                self.crumbs(ui, actions);
            }
            self.draw_canvas(ui, actions);
        });
        self.sheets(&ctx, actions);
        if let Some(palette) = &mut self.palette {
            let (open, action) = palette.ui(&ctx);
            actions.extend(action);
            if !open {
                self.palette = None;
            }
        }
        self.path_sheet(&ctx);
        self.hint(&ctx);
    }

    fn menus(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        egui::MenuBar::new().ui(ui, |ui| {
            for menu in Command::MENUS {
                ui.menu_button(menu, |ui| {
                    for &command in Command::ALL.iter().filter(|command| command.menu() == menu) {
                        let mut button = Button::new(self.title_of(command));
                        if let Some(shortcut) = command.shortcut() {
                            button = button.shortcut_text(ui.ctx().format_shortcut(&shortcut));
                        }
                        if ui.add_enabled(self.can(command), button).on_hover_text(command.docs()).clicked() {
                            actions.push(Action::Command(command));
                            ui.close();
                        }
                    }
                    if menu == "File" {
                        self.recent(ui, actions);
                    }
                });
            }
        });
    }

    /// What a command is called now: undo says what it undoes.
    fn title_of(&self, command: Command) -> String {
        let history = self.project.history();
        let step = match command {
            Command::Undo => history.undoable(),
            Command::Redo => history.redoable(),
            _ => None,
        };
        match (command, step) {
            (_, Some(step)) => format!("{}: {step}", command.title()),
            (Command::Live, _) => if self.live { "Live (on)" } else { "Live (off)" }.to_owned(),
            _ => command.title().to_owned(),
        }
    }

    /// Whether a command would do anything.
    fn can(&self, command: Command) -> bool {
        match command {
            Command::Undo => self.project.history().undoable().is_some(),
            Command::Redo => self.project.history().redoable().is_some(),
            Command::Reload => self.project.path.is_some(),
            Command::Stop => self.busy.contains(&true),
            Command::Leave => !self.trail.0.is_empty(),
            Command::Delete => !self.selection.is_empty(),
            command if Command::OF_NODE.contains(&command) => !self.selection.nodes.is_empty(),
            _ => true,
        }
    }

    fn recent(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let recent = self.memory.recent();
        ui.menu_button("Open recent", |ui| {
            if recent.is_empty() {
                ui.weak("Nothing yet");
            }
            for path in recent {
                let name =
                    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
                let there = path.exists();
                let button = Button::new(if there { name } else { format!("{name} (gone)") });
                if ui.add_enabled(there, button).on_hover_text(path.display().to_string()).clicked() {
                    actions.push(Action::OpenPath(path));
                    ui.close();
                }
            }
        });
    }

    fn tools(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        ui.horizontal(|ui| {
            tool(ui, "Presets", Command::Gallery, actions);
            tool(ui, "Open", Command::Open, actions);
            tool(ui, "Save", Command::Save, actions);
            ui.separator();
            tool(ui, "Undo", Command::Undo, actions);
            tool(ui, "Redo", Command::Redo, actions);
            ui.separator();
            tool(ui, "Add node", Command::AddNode, actions);
            tool(ui, "Lay out", Command::Arrange, actions);
            tool(ui, "Show all", Command::FitAll, actions);
            ui.separator();
            tool(ui, "Run", Command::Run, actions);
            tool(ui, "Stop", Command::Stop, actions);
            let mut live = self.live;
            if ui.checkbox(&mut live, "Live").on_hover_text(Command::Live.docs()).changed() {
                actions.push(Action::Command(Command::Live));
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                tool(ui, "?", Command::Shortcuts, actions);
                tool(ui, "First steps", Command::Tour, actions);
                tool(ui, "◑", Command::Theme, actions);
            });
        });
    }

    fn inspect(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let at = self.address();
        let editable = self.foreign().is_none();
        let Some(level) = self.level() else { return };
        // A group that stands in a file is in the included document only.
        let included;
        let state = if editable {
            self.project.state()
        } else {
            included = crate::model::State {
                document: (*self.checked.included).clone(),
                layouts: Default::default(),
            };
            &included
        };
        let frame = self
            .selection
            .frames
            .first()
            .filter(|_| self.selection.nodes.is_empty() || self.selection.frames.len() == 1);
        if let Some((id, frame)) =
            frame.and_then(|id| Some((*id, self.project.state().layout(&at)?.frames.get(id)?)))
        {
            let mut title = frame.title.clone();
            ui.label("Title of the frame");
            let response = ui.add(TextEdit::singleline(&mut title).desired_width(f32::INFINITY));
            response.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Title of the frame"));
            if response.changed() {
                actions.push(Action::TitleFrame(id, title));
            }
            ui.separator();
        }
        match self.selection.single() {
            Some(name) => {
                let (Some(entry), Some(shape)) = (level.nodes.get(name), self.shapes.get(name)) else {
                    return;
                };
                let path = format!("{}{name}", self.trail.prefix());
                let problems = self.problems.get(&path).map_or(&[][..], Vec::as_slice);
                let subject = inspector::Subject {
                    state,
                    at: &at,
                    name,
                    entry,
                    shapes: &self.shapes,
                    shape,
                    status: self.board.get(&path),
                    problems,
                    editable,
                };
                ui.push_id(name, |ui| inspector::node(ui, &subject, actions));
            }
            None if self.selection.nodes.len() > 1 => {
                ui.heading(format!("{} nodes", self.selection.nodes.len()));
                for command in Command::OF_NODE.into_iter().chain([
                    Command::Connect,
                    Command::AlignLeft,
                    Command::AlignRight,
                    Command::AlignTop,
                    Command::AlignBottom,
                    Command::Arrange,
                ]) {
                    if ui.button(command.title()).on_hover_text(command.docs()).clicked() {
                        actions.push(Action::Command(command));
                    }
                }
            }
            None => inspector::document(ui, state, &at, &self.shapes, editable, actions),
        }
    }

    /// What is on its way to the viewport, in words.
    fn coming(&self) -> Option<String> {
        let watched = self.watched.as_ref().filter(|_| self.busy[0] || self.due && self.live)?;
        let running: Vec<String> = self
            .board
            .running()
            .map(|(node, fraction)| match (fraction * 100.0).round() {
                0.0 => node.to_owned(),
                percent => format!("{node}, {percent:.0} %"),
            })
            .collect();
        Some(format!("Computing {watched}\n{}", running.join("\n")))
    }

    /// The viewport.
    fn look(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let found = |output: Option<String>| output.and_then(|output| self.results.get(&output));
        let Companions { mesh, exemplar, inside } = self.companions();
        let coming = self.coming();
        let main = found(self.watched.clone());
        // A mesh that is new is not filled with the solid that is on its way out, nor the other way round.
        let inside = found(inside).filter(|inside| main.is_some_and(|main| main.stale == inside.stale));
        let scene =
            Scene { main, mesh: found(mesh), exemplar: found(exemplar), inside, coming: coming.as_deref() };
        let Some(viewport) = &mut self.viewport else { return };
        let asked = viewport.ui(ui, &scene);
        self.take_from_viewport(asked, actions);
    }

    fn take_from_viewport(&mut self, asked: Vec<ViewAction>, actions: &mut Vec<Action>) {
        for action in asked {
            match action {
                ViewAction::Save { files, .. } => self.want(super::Want::Made(files)),
                ViewAction::Say(text) => actions.push(Action::Say(text)),
            }
        }
    }

    fn crumbs(&self, ui: &mut Ui, actions: &mut Vec<Action>) {
        ui.horizontal(|ui| {
            if ui.button("Graph").on_hover_text("Back to the whole graph").clicked() {
                actions.push(Action::Leave(0));
            }
            for (i, crumb) in self.trail.0.iter().enumerate() {
                ui.label("›");
                if i + 1 == self.trail.0.len() {
                    ui.strong(&crumb.node);
                } else if ui.button(&crumb.node).clicked() {
                    actions.push(Action::Leave(i + 1));
                }
            }
            if let Some(file) = self.foreign() {
                ui.weak(format!("in {file}, read only"));
                if ui.button("Make part of the graph").clicked() {
                    actions.push(Action::Command(Command::LocaliseGroup));
                }
            }
        });
    }

    fn draw_canvas(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let at = self.address();
        let nowhere = Places::default();
        let Some(level) = crate::model::Level::of(&self.checked.included, &at) else { return };
        let prefix = self.trail.prefix();
        let watched = self.watched.as_deref().map(|output| match output.rsplit_once('.') {
            Some((node, socket)) => format!("{}.{socket}", crate::run::general(node)),
            None => output.to_owned(),
        });
        let sight = Sight {
            registry: &self.registry,
            nodes: level.nodes,
            links: level.links,
            layout: self.project.state().layout(&at).unwrap_or(&nowhere),
            shapes: &self.shapes,
            board: &self.board,
            prefix: &prefix,
            pictures: &self.pictures,
            problems: &self.problems,
            broken: &self.broken,
            watched: watched.as_deref(),
            selection: &self.selection,
            colors: Colors::of(ui.visuals()),
        };
        actions.extend(self.canvas.ui(ui, &sight));
    }
}

/// A button for a command, which is told on hovering with its keys.
fn tool(ui: &mut Ui, text: &str, command: Command, actions: &mut Vec<Action>) {
    let response = ui.button(text).on_hover_text(match command.shortcut() {
        Some(shortcut) => format!("{} ({})", command.docs(), ui.ctx().format_shortcut(&shortcut)),
        None => command.docs().to_owned(),
    });
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, command.title()));
    if response.clicked() {
        actions.push(Action::Command(command));
    }
}
