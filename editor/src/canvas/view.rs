//! Where the canvas looks, and what the pointer and keys do to it.

use std::collections::{BTreeMap, BTreeSet};

use breccia_engine::{NodeEntry, NodeMode, Registry};
use eframe::egui::{
    Align2, Color32, FontId, Id, PointerButton, Pos2, Rect, Response, Sense, Stroke, StrokeKind,
    TextureHandle, Ui, Vec2, WidgetInfo, WidgetType, pos2, vec2,
};

use super::geometry::{Geometry, corner, place};
use super::gesture::Gesture;
use super::legend;
use super::links::{self, Course};
use super::minimap;
use crate::action::{Action, Pin, Selection};
use crate::model::{Layout, SMALLEST_FRAME, Shape};
use crate::run::Board;
use crate::theme::{self, Palette};

/// Smallest zoom at which a graph is shown at first.
const READABLE: f32 = 0.62;

/// What the canvas shows.
pub struct Sight<'a> {
    /// Known node types.
    pub registry: &'a Registry,
    /// Nodes as the document has them.
    pub nodes: &'a BTreeMap<String, NodeEntry>,
    /// Links as the document has them.
    pub links: &'a [String],
    /// Where nodes lie.
    pub layout: &'a Layout,
    /// What nodes look like from outside.
    pub shapes: &'a BTreeMap<String, Shape>,
    /// What is known of them.
    pub board: &'a Board,
    /// What their names begin with in a run.
    pub prefix: &'a str,
    /// Small pictures, by name in a run.
    pub pictures: &'a BTreeMap<String, TextureHandle>,
    /// What is wrong with nodes, by name in a run.
    pub problems: &'a BTreeMap<String, Vec<String>>,
    /// Nodes that cannot run, by name in a run.
    pub broken: &'a BTreeSet<String>,
    /// The output that the viewport shows, by name in a run.
    pub watched: Option<&'a str>,
    /// What is selected.
    pub selection: &'a Selection,
    /// Colours.
    pub colors: Palette,
}

/// The canvas and where it looks.
pub struct Canvas {
    /// Where the canvas's origin lies on the screen, from the corner of its rectangle.
    pan: Vec2,
    pub(super) zoom: f32,
    pub(super) gesture: Gesture,
    /// What a drag has left over from whole points.
    rest: Vec2,
    /// What shall be brought into view with the next frame.
    fit: Option<(BTreeSet<String>, bool)>,
    /// Where the pointer was last, in points of the canvas.
    pub(super) pointer: Pos2,
    /// The rectangle of the screen that it was drawn into.
    pub(super) rect: Rect,
    /// Whether the map in the corner is shown.
    pub map: bool,
    /// Whether the legend of sockets is shown.
    pub legend: bool,
    /// What the tests and the application ask for: where things lie.
    pub(super) geometry: Geometry,
}

impl Default for Canvas {
    fn default() -> Self {
        Self {
            pan: vec2(40.0, 40.0),
            zoom: 1.0,
            gesture: Gesture::None,
            rest: Vec2::ZERO,
            fit: Some((BTreeSet::new(), true)),
            pointer: Pos2::ZERO,
            rect: Rect::ZERO,
            map: true,
            legend: false,
            geometry: Geometry::default(),
        }
    }
}

impl Canvas {
    /// Brings nodes into view, or all if there are none.
    pub fn fit(&mut self, nodes: BTreeSet<String>) {
        self.fit = Some((nodes, false));
    }

    /// Brings a graph into view that was not looked at before: all of it, or what the viewport shows if all would be too small
    /// to read.
    pub fn arrive(&mut self) {
        self.fit = Some((BTreeSet::new(), true));
    }

    /// Lets go of whatever is being dragged.
    pub fn release(&mut self) {
        self.gesture = Gesture::None;
    }

    /// Zooms about the middle.
    pub fn zoom_by(&mut self, factor: f32) {
        self.zoom_about(self.rect.center(), factor);
    }

    /// Where a new node would go: under the pointer if it is over the canvas, else in the middle of what is seen.
    pub fn place_for_new(&self) -> [i32; 2] {
        let seen = self.seen();
        place(if seen.contains(self.pointer) { self.pointer } else { seen.center() })
    }

    /// Where a point of the canvas is on the screen.
    pub fn to_screen(&self, at: Pos2) -> Pos2 {
        self.rect.min + self.pan + at.to_vec2() * self.zoom
    }

    fn to_canvas(&self, at: Pos2) -> Pos2 {
        ((at - self.rect.min - self.pan) / self.zoom).to_pos2()
    }

    pub(super) fn seen(&self) -> Rect {
        Rect::from_min_max(self.to_canvas(self.rect.min), self.to_canvas(self.rect.max))
    }

    /// Where nodes and sockets lie.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// How much larger than life the canvas is.
    pub fn zoom(&self) -> f32 {
        self.zoom
    }

    fn zoom_about(&mut self, at: Pos2, factor: f32) {
        let before = self.to_canvas(at);
        self.zoom = (self.zoom * factor).clamp(0.08, 3.0);
        self.pan = at - self.rect.min - before.to_vec2() * self.zoom;
    }

    /// Draws the canvas into all of `ui`; returns what the user asks for.
    pub fn ui(&mut self, ui: &mut Ui, sight: &Sight<'_>) -> Vec<Action> {
        let mut actions = Vec::new();
        let before = std::mem::replace(&mut self.rect, ui.available_rect_before_wrap());
        self.geometry = Geometry::new(sight.layout, sight.shapes);
        // Panels find their sizes in the first frames: what was asked for then is done when the rectangle stands still.
        if let Some((nodes, first)) = self.fit.clone() {
            self.look_at(&nodes, first, sight.watched);
            if before == self.rect {
                self.fit = None;
            } else {
                ui.ctx().request_repaint();
            }
        }
        let back = ui.interact(self.rect, Id::new("canvas"), Sense::click_and_drag());
        back.widget_info(|| WidgetInfo::labeled(WidgetType::Other, true, "Canvas"));
        ui.set_clip_rect(self.rect.intersect(ui.clip_rect()));
        self.navigate(ui, &back);
        if let Some(at) = ui.input(|i| i.pointer.latest_pos()) {
            self.pointer = self.to_canvas(at);
        }
        ui.painter().rect_filled(self.rect, 0, sight.colors.canvas);
        self.grid(ui, sight);
        self.frames(ui, sight, &mut actions);
        let courses = links::courses(sight.links, &sight.layout.bends, &self.geometry);
        self.background(ui, &back, sight, &courses, &mut actions);
        self.draw_links(ui, sight, &courses, &mut actions);
        self.draw_nodes(ui, sight, &courses, &mut actions);
        self.draw_gesture(ui, sight);
        if self.map
            && sight.nodes.len() > 1
            && let Some(to) = minimap::show(ui, self.rect, self.seen(), sight, &self.geometry)
        {
            self.pan = self.rect.size() / 2.0 - to.to_vec2() * self.zoom;
        }
        if self.legend {
            legend::show(ui, self.rect, sight);
        }
        ui.advance_cursor_after_rect(self.rect);
        actions
    }

    fn look_at(&mut self, nodes: &BTreeSet<String>, first: bool, watched: Option<&str>) {
        let Some(bounds) = self.geometry.bounds(nodes) else { return };
        let bounds = bounds.expand(30.0);
        let size = self.rect.size();
        let fits = (size.x / bounds.width()).min(size.y / bounds.height());
        self.zoom = fits.clamp(if first { READABLE } else { 0.08 }, 1.0);
        let watched = watched.and_then(|output| output.rsplit_once('.')).map(|(node, _)| node.to_owned());
        let near =
            watched.and_then(|node| self.geometry.nodes.get(&node)).filter(|_| first && fits < READABLE);
        let mut middle = near.map_or(bounds.center(), |node| node.center());
        // No more empty space than needs be.
        let half = size / self.zoom / 2.0;
        for (at, low, high, half) in [
            (&mut middle.x, bounds.left(), bounds.right(), half.x),
            (&mut middle.y, bounds.top(), bounds.bottom(), half.y),
        ] {
            *at = if high - low <= 2.0 * half {
                (low + high) / 2.0
            } else {
                at.max(low + half).min(high - half)
            };
        }
        self.pan = size / 2.0 - middle.to_vec2() * self.zoom;
    }

    /// Wheel zooms, middle button and space pan, two fingers pan with shift.
    fn navigate(&mut self, ui: &Ui, back: &Response) {
        let over = ui.rect_contains_pointer(self.rect);
        if over {
            let (zoom, scroll, shift, at) = ui.input(|i| {
                (i.zoom_delta(), i.smooth_scroll_delta(), i.modifiers.shift, i.pointer.latest_pos())
            });
            let at = at.unwrap_or(self.rect.center());
            if zoom != 1.0 {
                self.zoom_about(at, zoom);
            } else if shift {
                self.pan += scroll;
            } else if scroll.y != 0.0 {
                self.zoom_about(at, (scroll.y * 0.0025).exp());
            }
        }
        let space =
            ui.input(|i| i.key_down(eframe::egui::Key::Space)) && ui.memory(|m| m.focused().is_none());
        let pans = back.dragged_by(PointerButton::Middle)
            || back.dragged_by(PointerButton::Secondary)
            || (space && back.dragged_by(PointerButton::Primary));
        if pans {
            self.pan += back.drag_delta();
            if self.gesture != Gesture::None && space {
                self.gesture = Gesture::None;
            }
        }
    }

    fn grid(&self, ui: &Ui, sight: &Sight<'_>) {
        let step = if self.zoom < 0.35 { 200.0 } else { 50.0 };
        let seen = self.seen();
        let stroke = Stroke::new(1.0, sight.colors.grid);
        let lines = |from: f32, to: f32| {
            let first = (from / step).floor() as i64;
            let last = ((to / step).ceil() as i64).min(first + 400);
            (first..=last).map(move |i| i as f32 * step)
        };
        for x in lines(seen.left(), seen.right()) {
            ui.painter().vline(self.to_screen(pos2(x, 0.0)).x, self.rect.y_range(), stroke);
        }
        for y in lines(seen.top(), seen.bottom()) {
            ui.painter().hline(self.rect.x_range(), self.to_screen(pos2(0.0, y)).y, stroke);
        }
    }

    fn frames(&mut self, ui: &Ui, sight: &Sight<'_>, actions: &mut Vec<Action>) {
        for (&id, frame) in &sight.layout.frames {
            let [w, h] = frame.size.map(|n| n.max(SMALLEST_FRAME) as f32);
            let rect = Rect::from_min_size(corner(frame.at), vec2(w, h));
            let on_screen = Rect::from_min_max(self.to_screen(rect.min), self.to_screen(rect.max));
            if !on_screen.intersects(self.rect) {
                continue;
            }
            let selected = sight.selection.frames.contains(&id);
            let line = if selected { sight.colors.selected } else { sight.colors.weak.gamma_multiply(0.5) };
            ui.painter().rect_filled(on_screen, 6, sight.colors.frame);
            ui.painter().rect_stroke(on_screen, 6, Stroke::new(1.0, line), StrokeKind::Inside);
            let font = FontId::proportional((15.0 * self.zoom.max(0.5)).round());
            let at = on_screen.min + vec2(8.0, 5.0);
            ui.painter().text(at, Align2::LEFT_TOP, &frame.title, font.clone(), sight.colors.text);
            let bar = Rect::from_min_size(on_screen.min, vec2(on_screen.width(), font.size + 10.0));
            let grip = Rect::from_min_max(on_screen.max - vec2(14.0, 14.0), on_screen.max);
            ui.painter().line_segment(
                [pos2(grip.left(), grip.bottom() - 3.0), pos2(grip.right() - 3.0, grip.top())],
                Stroke::new(1.0, line),
            );
            let response = ui.interact(bar, Id::new(("frame", id)), Sense::click_and_drag());
            response.widget_info(|| {
                WidgetInfo::labeled(WidgetType::Other, true, format!("Frame {}", frame.title))
            });
            if response.clicked() || (response.drag_started_by(PointerButton::Primary) && !selected) {
                let mut selection = if ui.input(|i| i.modifiers.shift) {
                    sight.selection.clone()
                } else {
                    Selection::default()
                };
                selection.frames.insert(id);
                // A frame takes along what lies in it.
                selection.nodes.extend(
                    self.geometry
                        .nodes
                        .iter()
                        .filter(|(_, node)| rect.contains(node.center()))
                        .map(|(n, _)| n.clone()),
                );
                actions.push(Action::Select(selection));
            }
            self.drag_selection(&response, actions);
            let response = ui.interact(grip, Id::new(("frame grip", id)), Sense::drag());
            response.widget_info(|| {
                WidgetInfo::labeled(WidgetType::Other, true, format!("Size of frame {}", frame.title))
            });
            if response.drag_started_by(PointerButton::Primary) {
                self.gesture = Gesture::Size(id);
            }
            if self.gesture == Gesture::Size(id) {
                let to = place((self.pointer - corner(frame.at)).to_pos2());
                if response.dragged() && to != frame.size {
                    actions.push(Action::SizeFrame(id, to.map(|n| n.max(40))));
                }
                if response.drag_stopped() {
                    self.gesture = Gesture::None;
                    actions.push(Action::EndDrag);
                }
            }
        }
    }

    /// Moves what is selected along with a drag, in whole points.
    pub(super) fn drag_selection(&mut self, response: &Response, actions: &mut Vec<Action>) {
        if response.drag_started_by(PointerButton::Primary) {
            self.gesture = Gesture::Move;
            self.rest = Vec2::ZERO;
        }
        if self.gesture == Gesture::Move && response.dragged_by(PointerButton::Primary) {
            self.rest += response.drag_delta() / self.zoom;
            let whole = vec2(self.rest.x.trunc(), self.rest.y.trunc());
            if whole != Vec2::ZERO {
                self.rest -= whole;
                actions.push(Action::Move(place(whole.to_pos2())));
            }
        }
        if self.gesture == Gesture::Move && response.drag_stopped_by(PointerButton::Primary) {
            self.gesture = Gesture::None;
            actions.push(Action::EndDrag);
        }
    }

    /// What happens where there is no node: links, selecting, the palette.
    fn background(
        &mut self,
        ui: &Ui,
        back: &Response,
        sight: &Sight<'_>,
        courses: &[Course],
        actions: &mut Vec<Action>,
    ) {
        let modifiers = ui.input(|i| i.modifiers);
        let under = || {
            courses
                .iter()
                .map(|course| (links::distance(&course.points, self.pointer), course))
                .filter(|((distance, _), _)| *distance < 6.0 / self.zoom)
                .min_by(|((a, _), _), ((b, _), _)| a.total_cmp(b))
        };
        if back.double_clicked() {
            if let Some(((_, stretch), course)) = under() {
                let mut bends = sight.layout.bends.get(&course.text).cloned().unwrap_or_default();
                bends.insert(stretch.min(bends.len()), place(self.pointer));
                actions.push(Action::Bend(course.text.clone(), bends));
                actions.push(Action::EndDrag);
            } else {
                actions.push(Action::Palette { at: place(self.pointer), joint: None });
            }
        } else if back.clicked() {
            let mut selection = if modifiers.shift || modifiers.command {
                sight.selection.clone()
            } else {
                Selection::default()
            };
            if let Some((_, course)) = under()
                && !selection.links.remove(&course.text)
            {
                selection.links.insert(course.text.clone());
            }
            actions.push(Action::Select(selection));
        }
        if back.drag_started_by(PointerButton::Primary) {
            // A drag is known as one only after some points of way; the rectangle begins where the button went down.
            let pressed = ui.input(|input| input.pointer.press_origin());
            self.gesture = Gesture::Box(pressed.map_or(self.pointer, |at| self.to_canvas(at)));
        }
        if let Gesture::Box(from) = self.gesture
            && back.drag_stopped()
        {
            let area = Rect::from_two_pos(from, self.pointer);
            let mut selection = if modifiers.shift { sight.selection.clone() } else { Selection::default() };
            let inside = self.geometry.nodes.iter().filter(|(_, rect)| area.intersects(**rect));
            selection.nodes.extend(inside.map(|(name, _)| name.clone()));
            actions.push(Action::Select(selection));
            self.gesture = Gesture::None;
        }
    }

    fn draw_links(&mut self, ui: &Ui, sight: &Sight<'_>, courses: &[Course], actions: &mut Vec<Action>) {
        let seen = self.seen();
        let picked = match &self.gesture {
            Gesture::Wire { picked: Some(link), .. } => Some(link.clone()),
            _ => None,
        };
        for course in courses {
            if picked.as_ref() == Some(&course.text) || !seen.intersects(links::bounds(&course.points)) {
                continue;
            }
            let ty = socket_type(sight, &course.from);
            let selected = sight.selection.links.contains(&course.text);
            let color = if selected { sight.colors.selected } else { theme::socket(ty).0 };
            let muted = [&course.from, &course.to]
                .iter()
                .any(|pin| sight.nodes.get(&pin.node).is_some_and(|n| n.mode == NodeMode::Mute));
            let color = if muted { color.gamma_multiply(0.35) } else { color };
            let width = (if selected { 3.2 } else { 2.0 } * self.zoom.sqrt()).max(1.0);
            let points: Vec<Pos2> = course.points.iter().map(|p| self.to_screen(*p)).collect();
            links::draw(ui.painter(), &points, Stroke::new(width, color), self.zoom > 0.3);
        }
        for (link, bends) in &sight.layout.bends {
            if !courses.iter().any(|course| course.text == *link) {
                continue;
            }
            for (index, at) in bends.iter().enumerate() {
                let at = self.to_screen(corner(*at));
                if !self.rect.contains(at) {
                    continue;
                }
                let rect = Rect::from_center_size(at, Vec2::splat(14.0));
                let response = ui.interact(rect, Id::new(("bend", link, index)), Sense::click_and_drag());
                response.widget_info(|| {
                    WidgetInfo::labeled(WidgetType::Other, true, format!("Bend {} of {link}", index + 1))
                });
                let fill = if response.hovered() { sight.colors.selected } else { sight.colors.text };
                ui.painter().circle_filled(at, 4.0 * self.zoom.clamp(0.6, 1.4), fill);
                let mut points = bends.clone();
                if response.double_clicked() || response.secondary_clicked() {
                    points.remove(index);
                    actions.push(Action::Bend(link.clone(), points));
                    actions.push(Action::EndDrag);
                    continue;
                }
                if response.drag_started_by(PointerButton::Primary) {
                    self.gesture = Gesture::Bend { link: link.clone(), index };
                }
                if self.gesture == (Gesture::Bend { link: link.clone(), index }) {
                    if response.dragged() {
                        points[index] = place(self.pointer);
                        actions.push(Action::Bend(link.clone(), points));
                    }
                    if response.drag_stopped() {
                        self.gesture = Gesture::None;
                        actions.push(Action::EndDrag);
                    }
                }
            }
        }
    }
}

pub(super) fn socket_type<'a>(sight: &'a Sight<'_>, pin: &Pin) -> &'a str {
    let shape = sight.shapes.get(&pin.node);
    let socket =
        shape.and_then(|shape| if pin.output { shape.output(&pin.socket) } else { shape.input(&pin.socket) });
    socket.map_or("", |socket| socket.ty.as_str())
}

pub(super) fn label(ui: &Ui, at: Pos2, text: &str, sight: &Sight<'_>) {
    let painter =
        ui.ctx().layer_painter(eframe::egui::LayerId::new(eframe::egui::Order::Tooltip, Id::new("refusal")));
    let galley = painter.layout(text.to_owned(), FontId::proportional(13.0), Color32::WHITE, 360.0);
    let rect = Rect::from_min_size(at, galley.size()).expand(5.0);
    painter.rect_filled(rect, 4, sight.colors.error);
    painter.galley(at, galley, Color32::WHITE);
}
