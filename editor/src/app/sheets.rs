//! Sheets over the window: presets, shortcuts, first steps, what can be recovered. All can be closed, none keeps the user from the rest.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use eframe::egui::{
    self, Align2, Context, Grid, Image, Response, RichText, ScrollArea, Sense, Vec2, WidgetInfo, WidgetType,
    vec2,
};

use super::{After, App, Appearing};
use crate::action::Action;
use crate::command::Command;

impl App {
    pub(super) fn sheets(&mut self, ctx: &Context, actions: &mut Vec<Action>) {
        self.gallery(ctx, actions);
        self.shortcut_sheet(ctx);
        self.tour(ctx, actions);
        self.leftovers(ctx);
    }

    fn gallery(&mut self, ctx: &Context, actions: &mut Vec<Action>) {
        let mut open = self.open.gallery;
        let fresh = self.open.appears(Appearing::Gallery, open);
        let size = ctx.content_rect().size();
        egui::Window::new("Start from a preset").id(egui::Id::new("gallery")).open(&mut open).collapsible(false).default_size(vec2((size.x * 0.72).min(900.0), (size.y * 0.72).min(640.0))).anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(ctx, |ui| {
            ui.label("Each opens as a graph of your own. Drop a picture on the window to use it in place of the built-in one.");
            ui.add_space(6.0);
            ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                ui.horizontal_wrapped(|ui| {
                    for (i, preset) in breccia_graphs::presets().iter().enumerate() {
                        let response = card(ui, preset, actions);
                        if fresh && i == 0 {
                            response.request_focus();
                        }
                    }
                });
            });
        });
        self.open.gallery = open;
    }

    fn shortcut_sheet(&mut self, ctx: &Context) {
        let mut open = self.open.shortcuts;
        egui::Window::new("Shortcuts")
            .id(egui::Id::new("shortcuts"))
            .open(&mut open)
            .collapsible(false)
            .default_size(vec2(620.0, 480.0))
            .show(ctx, |ui| {
                ScrollArea::vertical().auto_shrink([false, true]).show(ui, |ui| {
                    for menu in Command::MENUS {
                        ui.strong(menu);
                        Grid::new(("shortcuts", menu)).num_columns(3).striped(true).show(ui, |ui| {
                            for command in Command::ALL.iter().filter(|command| command.menu() == menu) {
                                ui.label(command.title());
                                ui.monospace(
                                    command
                                        .shortcut()
                                        .map_or(String::new(), |shortcut| ctx.format_shortcut(&shortcut)),
                                );
                                ui.weak(command.docs());
                                ui.end_row();
                            }
                        });
                        ui.add_space(8.0);
                    }
                    ui.strong("On the canvas");
                    for line in POINTER {
                        ui.label(*line);
                    }
                });
            });
        self.open.shortcuts = open;
    }

    fn tour(&mut self, ctx: &Context, actions: &mut Vec<Action>) {
        let mut open = self.open.tour;
        let fresh = self.open.appears(Appearing::Tour, open);
        egui::Window::new("First steps")
            .id(egui::Id::new("tour"))
            .open(&mut open)
            .collapsible(false)
            .resizable(false)
            .default_width(440.0)
            .anchor(Align2::LEFT_BOTTOM, [16.0, -48.0])
            .show(ctx, |ui| {
                ui.set_max_width(440.0);
                for (title, text) in TOUR {
                    ui.label(RichText::new(*title).strong());
                    ui.label(*text);
                    ui.add_space(4.0);
                }
                ui.horizontal(|ui| {
                    let presets = ui.button("Show the presets");
                    if fresh {
                        presets.request_focus();
                    }
                    if presets.clicked() {
                        actions.push(Action::Command(Command::Gallery));
                    }
                    if ui.button("Show the shortcuts").clicked() {
                        actions.push(Action::Command(Command::Shortcuts));
                    }
                    if ui.button("Close").clicked() {
                        actions.push(Action::Command(Command::Tour));
                    }
                });
            });
        self.open.tour &= open;
    }

    /// Documents that an earlier run of the program did not save.
    fn leftovers(&mut self, ctx: &Context) {
        let leftovers = self.memory.leftovers();
        let mut open = !self.open.later;
        let fresh = self.open.appears(Appearing::Recovery, open && !leftovers.is_empty());
        if leftovers.is_empty() || !open {
            return;
        }
        egui::Window::new("Not saved last time")
            .open(&mut open)
            .id(egui::Id::new("recovery"))
            .collapsible(true)
            .resizable(false)
            .anchor(Align2::CENTER_TOP, [0.0, 90.0])
            .show(ctx, |ui| {
                ui.label("The program ended before these were saved.");
                for (i, (title, path)) in leftovers.into_iter().enumerate() {
                    ui.horizontal(|ui| {
                        ui.label(&title);
                        let recover = ui.button("Recover");
                        if fresh && i == 0 {
                            recover.request_focus();
                        }
                        if recover.clicked() {
                            self.leave_document(After::Recover(path.clone()), ctx);
                        }
                        if ui.button("Discard").clicked() {
                            self.memory.discard(&path);
                        }
                    });
                }
            });
        self.open.later = !open;
    }
}

/// Titles and docs of the presets, which do not change.
fn about(name: &str) -> (&'static str, &'static str) {
    static ABOUT: OnceLock<BTreeMap<&'static str, (String, String)>> = OnceLock::new();
    let all = ABOUT.get_or_init(|| {
        let presets = breccia_graphs::presets().iter();
        presets
            .map(|preset| {
                let document = breccia_engine::Document::parse(preset.ron).unwrap_or_default();
                (preset.name, (document.title, document.docs))
            })
            .collect()
    });
    all.get(name).map_or(("", ""), |(title, docs)| (title, docs))
}

fn card(ui: &mut egui::Ui, preset: &breccia_graphs::Preset, actions: &mut Vec<Action>) -> Response {
    let size = vec2(208.0, 196.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Preset {}", preset.name)));
    if !ui.is_rect_visible(rect) {
        return response;
    }
    let visuals = *ui.style().interact(&response);
    ui.painter().rect(rect, 6, visuals.weak_bg_fill, visuals.bg_stroke, egui::StrokeKind::Inside);
    let picture = egui::Rect::from_min_size(rect.min + Vec2::splat(4.0), vec2(200.0, 150.0));
    let uri = format!("bytes://{}.jpg", preset.name);
    Image::from_bytes(uri, preset.picture).corner_radius(4).paint_at(ui, picture);
    let (title, docs) = about(preset.name);
    let text = |at: egui::Pos2, text: &str, size: f32, color| {
        ui.painter().with_clip_rect(rect.shrink(4.0)).text(
            at,
            Align2::LEFT_TOP,
            text,
            egui::FontId::proportional(size),
            color,
        );
    };
    text(rect.left_bottom() + vec2(8.0, -40.0), preset.name, 14.0, visuals.text_color());
    text(rect.left_bottom() + vec2(8.0, -21.0), title, 11.0, ui.visuals().weak_text_color());
    let response = response.on_hover_text(docs);
    if response.clicked() {
        actions.push(Action::OpenPreset(preset.name.to_owned()));
    }
    response
}

const TOUR: &[(&str, &str)] = &[
    (
        "1. Drop a photo on the window.",
        "It becomes the exemplar: the picture that the solid texture is made to look like. Or start from a preset.",
    ),
    (
        "2. Watch it grow.",
        "The viewport shows what is computed: a solid on a mesh, a cube with a corner cut out, a slice. Double-click a node to look at its result instead.",
    ),
    (
        "3. Turn knobs.",
        "Select a node and change its parameters; with nothing selected the inspector shows what the graph offers. Only what depends on a change is computed again, and a result that is out of date says so.",
    ),
    (
        "4. Cut it open.",
        "In the viewport switch the cut on and drag the plane: the inside is synthesised where you cut.",
    ),
    (
        "5. Build.",
        "Tab finds nodes. Drag from one socket to another; drop a link on empty canvas and only nodes that fit are offered.",
    ),
    ("6. Save.", "A saved graph runs from the command line too: breccia run FILE gives the same bytes."),
];

const POINTER: &[&str] = &[
    "Click selects, Shift adds; drag on empty canvas selects what it touches.",
    "Middle or right drag, or Space and drag, moves the view; the wheel zooms.",
    "Drag from a socket to make a link; drag from the end of a link to pick it up.",
    "Double-click a link for a bend, the bend to remove it; double-click empty canvas to add a node.",
    "Double-click a node to look at its result, a group to go into it; right-click for more.",
];

impl App {
    /// What stands there when no graph was asked for.
    pub fn welcome(&mut self) {
        // One page at a time: the first steps lead to the presets.
        self.open.tour = self.memory.is_first_time();
        self.open.gallery = !self.open.tour;
    }

    /// Which panels are open and whether runs are live, as a few words to be kept.
    pub fn habits(&self) -> String {
        let all = [
            ("inspector", self.open.inspector),
            ("viewport", self.open.viewport),
            ("problems", self.open.problems),
            ("map", self.canvas.map),
            ("legend", self.canvas.legend),
            ("live", self.live),
        ];
        all.iter().filter(|(_, on)| *on).map(|(name, _)| *name).collect::<Vec<_>>().join(" ")
    }

    /// Opens the panels that were open last time.
    pub fn set_habits(&mut self, habits: &str) {
        let has = |name: &str| habits.split(' ').any(|habit| habit == name);
        self.open.inspector = has("inspector");
        self.open.viewport = has("viewport");
        self.open.problems = has("problems");
        self.canvas.map = has("map");
        self.canvas.legend = has("legend");
        self.live = has("live");
    }

    /// The window is closed on purpose.
    pub fn closed(&mut self) {
        self.stop();
        self.memory.close();
    }
}
