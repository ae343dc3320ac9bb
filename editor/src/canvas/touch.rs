//! Touching nodes and sockets: selecting, moving, drawing links from one to the other.

use eframe::egui::{
    Id, PointerButton, Rect, Sense, Stroke, StrokeKind, Ui, Vec2, WidgetInfo, WidgetType, vec2,
};

use super::geometry::place;
use super::gesture::Gesture;
use super::links::{self, Course};
use super::node::{self, Look, NAMES, TEXT};
use super::view::{Canvas, Sight, label, socket_type};
use crate::action::{Action, Joint, Pin, Selection};
use crate::command::Command;
use crate::model::{Refusal, Shape, compatible};
use crate::theme;

impl Canvas {
    pub(super) fn draw_nodes(
        &mut self,
        ui: &mut Ui,
        sight: &Sight<'_>,
        courses: &[Course],
        actions: &mut Vec<Action>,
    ) {
        let seen = self.seen();
        let names: Vec<(String, Rect)> = self
            .geometry
            .nodes
            .iter()
            .filter(|(_, rect)| seen.intersects(rect.expand(8.0)))
            .map(|(name, rect)| (name.clone(), *rect))
            .collect();
        // What is selected lies on top.
        let (top, below): (Vec<_>, Vec<_>) =
            names.into_iter().partition(|(name, _)| sight.selection.nodes.contains(name));
        for (name, rect) in below.into_iter().chain(top) {
            let (Some(shape), Some(entry)) = (sight.shapes.get(&name), sight.nodes.get(&name)) else {
                continue;
            };
            let on_screen = Rect::from_min_max(self.to_screen(rect.min), self.to_screen(rect.max));
            let path = format!("{}{name}", sight.prefix);
            let look = Look {
                name: &name,
                shape,
                place: sight.layout.nodes.get(&name).copied().unwrap_or_default(),
                status: sight.board.get(&path),
                picture: sight.pictures.get(&path),
                mode: entry.mode,
                selected: sight.selection.nodes.contains(&name),
                watched: sight
                    .watched
                    .and_then(|output| output.rsplit_once('.'))
                    .is_some_and(|(node, _)| node == path),
                broken: sight.broken.contains(&path),
            };
            node::draw(ui.painter(), on_screen, self.zoom, &look, &sight.colors);
            self.touch_node(ui, sight, &look, on_screen, rect, courses, actions);
            if self.zoom >= TEXT {
                self.pins(ui, sight, &name, shape, actions);
            }
        }
    }

    #[allow(clippy::too_many_arguments, reason = "one node, and all that its gestures hang on")]
    pub(super) fn touch_node(
        &mut self,
        ui: &mut Ui,
        sight: &Sight<'_>,
        look: &Look<'_>,
        on_screen: Rect,
        rect: Rect,
        courses: &[Course],
        actions: &mut Vec<Action>,
    ) {
        let name = look.name;
        let response = ui.interact(on_screen, Id::new(("node", name)), Sense::click_and_drag());
        response.widget_info(|| {
            let state = node::state_text(look);
            WidgetInfo::selected(
                WidgetType::SelectableLabel,
                true,
                look.selected,
                format!("Node {name}, {}, {state}", look.shape.ty),
            )
        });
        if response.has_focus() {
            let ring = Stroke::new(1.5, ui.visuals().strong_text_color());
            ui.painter().rect_stroke(on_screen.expand(4.0), 6, ring, StrokeKind::Outside);
        }
        let modifiers = ui.input(|i| i.modifiers);
        let toggles = modifiers.shift || modifiers.command;
        if response.double_clicked() {
            if look.shape.group.is_some() {
                actions.push(Action::Enter(name.to_owned()));
            } else if let Some(output) = look.shape.outputs.first() {
                actions.push(Action::Watch(Pin {
                    node: name.to_owned(),
                    socket: output.name.clone(),
                    output: true,
                }));
            }
        } else if response.clicked()
            || response.secondary_clicked()
            || (response.drag_started_by(PointerButton::Primary) && !look.selected)
        {
            let mut selection = if toggles { sight.selection.clone() } else { Selection::default() };
            let keep = response.secondary_clicked() && look.selected;
            if toggles && look.selected {
                selection.nodes.remove(name);
            } else {
                selection.nodes.insert(name.to_owned());
            }
            if !keep {
                actions.push(Action::Select(selection));
            }
        }
        let moved = self.gesture == Gesture::Move && response.drag_stopped_by(PointerButton::Primary);
        self.drag_selection(&response, actions);
        // A node that has no links yet and is dropped on one goes into it.
        let free = || !courses.iter().any(|course| course.from.node == name || course.to.node == name);
        if moved && sight.selection.nodes.len() <= 1 && free() {
            let hit = courses.iter().find(|course| links::distance(&course.points, rect.center()).0 < 18.0);
            if let Some(course) = hit {
                actions.push(Action::DropOnLink { node: name.to_owned(), link: course.text.clone() });
            }
        }
        if response.hovered() && self.gesture == Gesture::None {
            let problems = sight.problems.get(&format!("{}{name}", sight.prefix));
            let told = look
                .status
                .and_then(|status| status.error.as_ref())
                .into_iter()
                .chain(problems.into_iter().flatten());
            let told: Vec<&String> = told.collect();
            if !told.is_empty() || self.zoom < NAMES {
                response.clone().on_hover_ui(|ui| {
                    ui.set_max_width(420.0);
                    ui.label(format!("{name}: {}", look.shape.summary));
                    for problem in told {
                        ui.colored_label(sight.colors.error, problem);
                    }
                });
            }
        }
        response.context_menu(|ui| {
            for command in Command::OF_NODE {
                let mut button = eframe::egui::Button::new(command.title());
                if let Some(shortcut) = command.shortcut() {
                    button = button.shortcut_text(ui.ctx().format_shortcut(&shortcut));
                }
                if ui.add(button).clicked() {
                    actions.push(Action::Command(command));
                    ui.close();
                }
            }
            ui.menu_button("Look at", |ui| {
                for output in &look.shape.outputs {
                    if ui.button(&output.name).clicked() {
                        actions.push(Action::Watch(Pin {
                            node: name.to_owned(),
                            socket: output.name.clone(),
                            output: true,
                        }));
                        ui.close();
                    }
                }
            });
        });
    }

    pub(super) fn pins(
        &mut self,
        ui: &mut Ui,
        sight: &Sight<'_>,
        node: &str,
        shape: &Shape,
        actions: &mut Vec<Action>,
    ) {
        let all = shape.inputs.iter().map(|s| (false, s)).chain(shape.outputs.iter().map(|s| (true, s)));
        for (output, socket) in all {
            let pin = Pin { node: node.to_owned(), socket: socket.name.clone(), output };
            let Some(at) = self.geometry.pins.get(&pin).map(|at| self.to_screen(*at)) else { continue };
            let fits = match &self.gesture {
                Gesture::Wire { from, .. } => {
                    pair(from, &pin).is_some_and(|pair| joinable(sight, pair).is_ok())
                }
                _ => true,
            };
            let (color, shape) = theme::socket(&socket.ty);
            let color = if fits { color } else { color.gamma_multiply(0.25) };
            let response = ui.interact(
                Rect::from_center_size(at, Vec2::splat((15.0 * self.zoom).max(8.0))),
                Id::new(("pin", &pin.node, &pin.socket, output)),
                Sense::click_and_drag(),
            );
            response.widget_info(|| {
                let side = if output { "Output" } else { "Input" };
                WidgetInfo::labeled(
                    WidgetType::Other,
                    true,
                    format!("{side} {} of {node}, {}", socket.name, socket.ty),
                )
            });
            let radius = if response.hovered() || response.has_focus() { 6.0 } else { 4.6 } * self.zoom;
            theme::mark(ui.painter(), at, radius, shape, color, sight.colors.outline);
            if response.drag_started_by(PointerButton::Primary) {
                self.gesture = self.take_wire(sight, pin.clone());
            }
            if matches!(self.gesture, Gesture::Wire { .. }) && response.drag_stopped() {
                self.drop_wire(sight, actions);
            }
            if self.gesture == Gesture::None {
                let kind = if socket.ty.is_empty() { "unknown type" } else { &socket.ty };
                response.on_hover_text(format!("{}: {kind}\n{}", socket.name, socket.docs));
            }
        }
    }

    /// A drag from an input that has a link picks that link up.
    pub(super) fn take_wire(&self, sight: &Sight<'_>, pin: Pin) -> Gesture {
        let held =
            sight.links.iter().rev().filter_map(|text| Some((text, breccia_engine::Link::parse(text)?)));
        let held = held
            .into_iter()
            .find(|(_, link)| !pin.output && link.to_node == pin.node && link.to_socket == pin.socket);
        match held {
            Some((text, link)) => Gesture::Wire {
                from: Pin { node: link.from_node, socket: link.from_socket, output: true },
                picked: Some(text.clone()),
            },
            None => Gesture::Wire { from: pin, picked: None },
        }
    }

    /// The socket near the pointer that a link could end at.
    pub(super) fn near(&self, from: &Pin) -> Option<Pin> {
        let reach = 16.0 / self.zoom.max(0.4);
        self.geometry
            .pins
            .iter()
            .filter(|(pin, _)| pin.output != from.output)
            .map(|(pin, at)| ((*at - self.pointer).length(), pin))
            .filter(|(distance, _)| *distance < reach)
            .min_by(|(a, _), (b, _)| a.total_cmp(b))
            .map(|(_, pin)| pin.clone())
    }

    pub(super) fn drop_wire(&mut self, sight: &Sight<'_>, actions: &mut Vec<Action>) {
        let Gesture::Wire { from, picked } = std::mem::take(&mut self.gesture) else { return };
        let target = self.near(&from);
        if let (Some(picked), Some(target)) = (&picked, &target) {
            // Put back where it was.
            if breccia_engine::Link::parse(picked)
                .is_some_and(|link| link.to_node == target.node && link.to_socket == target.socket)
            {
                return;
            }
        }
        match target {
            Some(target) => {
                let Some((output, input)) = pair(&from, &target) else { return };
                match joinable(sight, (output.clone(), input.clone())) {
                    Ok(()) => actions.push(match picked {
                        Some(link) => Action::Reconnect { link, from: output, to: input },
                        None => Action::Connect(output, input),
                    }),
                    // A link that fits nowhere stays where it was.
                    Err(refusal) if refusal.conversions.is_empty() => {
                        actions.push(Action::Say(refusal.reason))
                    }
                    Err(refusal) => {
                        actions.push(Action::Say(format!("{}: pick a node that converts", refusal.reason)));
                        actions.push(Action::Palette {
                            at: place(self.pointer),
                            joint: Some(Joint::Between { from: output, to: input, instead: picked }),
                        });
                    }
                }
            }
            None => actions.push(match picked {
                Some(link) => Action::Disconnect(vec![link]),
                None => Action::Palette { at: place(self.pointer), joint: Some(Joint::Pin(from)) },
            }),
        }
    }

    pub(super) fn draw_gesture(&mut self, ui: &Ui, sight: &Sight<'_>) {
        match &self.gesture {
            Gesture::Box(from) => {
                let rect = Rect::from_two_pos(self.to_screen(*from), self.to_screen(self.pointer));
                ui.painter().rect_filled(rect, 0, sight.colors.selected.gamma_multiply(0.12));
                ui.painter().rect_stroke(
                    rect,
                    0,
                    Stroke::new(1.0, sight.colors.selected),
                    StrokeKind::Inside,
                );
            }
            Gesture::Wire { from, .. } => {
                let Some(start) = self.geometry.pins.get(from).map(|at| self.to_screen(*at)) else {
                    self.gesture = Gesture::None;
                    return;
                };
                let target = self.near(from);
                let end = target
                    .as_ref()
                    .and_then(|pin| self.geometry.pins.get(pin))
                    .map_or(self.pointer, |at| *at);
                let end = self.to_screen(end);
                let refusal = target.and_then(|pin| joinable(sight, pair(from, &pin)?).err());
                let color = if refusal.is_some() {
                    sight.colors.error
                } else {
                    theme::socket(socket_type(sight, from)).0
                };
                let points = if from.output { [start, end] } else { [end, start] };
                links::draw(ui.painter(), &points, Stroke::new(2.5, color), true);
                if let Some(refusal) = refusal {
                    label(ui, end + vec2(12.0, 14.0), &refusal.reason, sight);
                }
                // Escape lets go.
                if ui.input(|i| i.key_pressed(eframe::egui::Key::Escape))
                    || !ui.input(|i| i.pointer.any_down() || i.pointer.any_released())
                {
                    self.gesture = Gesture::None;
                }
            }
            _ => {}
        }
    }
}

/// Output and input of two sockets.
fn pair(a: &Pin, b: &Pin) -> Option<(Pin, Pin)> {
    match (a.output, b.output) {
        (true, false) => Some((a.clone(), b.clone())),
        (false, true) => Some((b.clone(), a.clone())),
        _ => None,
    }
}

/// Whether a link from an output to an input would fit.
fn joinable(sight: &Sight<'_>, (output, input): (Pin, Pin)) -> Result<(), Refusal> {
    if output.node == input.node {
        return Err(Refusal { reason: "a node cannot wait for itself".into(), conversions: Vec::new() });
    }
    let from = sight.shapes.get(&output.node).and_then(|shape| shape.output(&output.socket));
    let to = sight.shapes.get(&input.node).and_then(|shape| shape.input(&input.socket));
    match (from, to) {
        (Some(from), Some(to)) => compatible(sight.registry, from, to),
        _ => Ok(()),
    }
}
