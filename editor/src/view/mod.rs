//! The viewport: any result as a picture, or as an object that can be turned and cut open.
//!
//! Nothing here computes while the window waits: each kind of view has workers (`worker`) and shows what has come so far.

mod camera;
mod content;
mod cube;
mod cut;
mod export;
mod faces;
mod flat;
mod geometry;
mod gpu_parts;
mod handle;
mod layer;
mod marks;
mod objects;
mod on_mesh;
mod pan_zoom;
mod pixels;
mod renderer;
mod report;
mod slicing;
mod stage;
mod target;
#[cfg(test)]
mod testing;
mod toolbar;
mod translucent;
mod vector;
mod voxels;
mod worker;

use std::sync::Arc;

use breccia_engine::Value;
use breccia_shaders::Gpu;
use eframe::egui::{self, Rect, Ui};
use eframe::egui_wgpu::RenderState;

use self::content::{Content, Remembered};
use self::export::Export;
use self::flat::Flat;
use self::objects::{Objects, Seen};
use self::stage::Stage;
use self::toolbar::Ask;
pub use self::toolbar::Show;
use crate::run::Fit;

/// A result of a node, as it is looked at.
#[derive(Clone)]
pub struct Subject {
    /// `node.socket`.
    pub label: String,
    /// The value.
    pub value: Value,
    /// Whether the graph has changed since, and a new value is on its way.
    pub stale: bool,
    /// How it is fitted where it is baked: a mesh with the solid in it, a solid with the mesh that it is baked into.
    pub fit: Option<Fit>,
}

/// What the viewport may show.
#[derive(Clone, Copy, Default)]
pub struct Scene<'a> {
    /// What is looked at.
    pub main: Option<&'a Subject>,
    /// The mesh that a solid can be shown on.
    pub mesh: Option<&'a Subject>,
    /// The picture that results are compared with.
    pub exemplar: Option<&'a Subject>,
    /// The solid in a mesh that was baked.
    pub inside: Option<&'a Subject>,
    /// What is being computed, in words, for as long as there is nothing to look at.
    pub coming: Option<&'a str>,
}

/// What the viewport asks of the application.
pub enum ViewAction {
    /// Writes files: one to a place that the user picks, several into a folder that the user picks.
    Save {
        /// What is saved, in a few words.
        what: &'static str,
        /// File names and contents.
        files: Vec<(String, Vec<u8>)>,
    },
    /// Tells the user something.
    Say(String),
}

/// The viewport and what it remembers: camera, mode, cut, and the work that goes on behind it.
pub struct Viewport {
    main: Remembered,
    mesh: Remembered,
    exemplar: Remembered,
    inside: Remembered,
    /// How solids are shown, once that was chosen.
    show: Option<Show>,
    flat: Flat,
    stage: Stage,
    objects: Objects,
    export: Export,
}

impl Viewport {
    /// `render` draws; `gpu` computes, where there is a device for that.
    pub fn new(render: RenderState, gpu: Option<Arc<Gpu>>) -> Self {
        let gpu = gpu.as_ref();
        Self {
            main: Remembered::default(),
            mesh: Remembered::default(),
            exemplar: Remembered::default(),
            inside: Remembered::default(),
            show: None,
            flat: Flat::new(gpu),
            stage: Stage::new(render),
            objects: Objects::new(gpu),
            export: Export::new(gpu),
        }
    }

    /// Goes on with what is being saved, whether the viewport is drawn or not.
    pub fn go_on(&mut self, ctx: &egui::Context) -> Vec<ViewAction> {
        self.export.update(ctx, &self.stage)
    }

    /// Draws the viewport into all of `ui`.
    pub fn ui(&mut self, ui: &mut Ui, scene: &Scene<'_>) -> Vec<ViewAction> {
        self.main.update(scene.main);
        self.mesh.update(scene.mesh);
        self.exemplar.update(scene.exemplar);
        self.inside.update(scene.inside);
        let Some(content) = self.main.content().cloned() else {
            self.objects.rest_but(None);
            self.flat.rest();
            let nothing = "Nothing to look at yet: pick a node, or run the graph.";
            marks::empty(ui, scene.coming.unwrap_or(nothing));
            return Vec::new();
        };
        let show = self.shown(&content);
        let whole = ui.max_rect();
        let ask = ui.horizontal_wrapped(|ui| self.toolbar(ui, &content, show)).inner;
        // What was shown before a click on the toolbar is drawn no more.
        let show = self.shown(&content);
        let rect = ui.available_rect_before_wrap().intersect(whole);
        if rect.width() < 8.0 || rect.height() < 8.0 {
            return Vec::new();
        }
        let actions = ui.push_id("view", |ui| self.body(ui, rect, &content, show, ask)).inner;
        ui.expand_to_include_rect(rect);
        actions
    }

    /// Shows solids in another way from now on.
    pub fn show_as(&mut self, show: Show) {
        self.show = Some(show);
    }

    /// How fine things are shown from now on: texels a side of the texture of a surface, voxels along the edge of a box.
    pub fn set_detail(&mut self, texture: u32, edge: u32) {
        self.objects.set_detail(texture, edge);
    }

    /// Whether work goes on behind what is shown.
    pub fn is_working(&self) -> bool {
        self.flat.is_running() || self.objects.is_running() || self.export.is_running()
    }

    /// How a value is shown: as was chosen, as far as it can be.
    fn shown(&self, content: &Content) -> Show {
        match content {
            Content::Mesh(_) => Show::Mesh,
            Content::Body(body) => {
                let has_mesh = self.mesh.content().and_then(Content::mesh).is_some();
                let first = match (body.is_set, has_mesh) {
                    (true, _) => Show::Particles,
                    (_, true) => Show::Mesh,
                    _ => Show::Cube,
                };
                match self.show.unwrap_or(first) {
                    Show::Mesh if !has_mesh => Show::Cube,
                    Show::Particles if !body.has_labels() => Show::Translucent,
                    show => show,
                }
            }
            _ => Show::Slice,
        }
    }

    fn toolbar(&mut self, ui: &mut Ui, content: &Content, show: Show) -> Option<Ask> {
        let mut ask = None;
        let mut show = show;
        ui.add_space(2.0);
        ui.label(egui::RichText::new(self.main.label()).weak()).on_hover_text("What is looked at");
        if let Content::Body(body) = content {
            let has_mesh = self.mesh.content().and_then(Content::mesh).is_some();
            for (way, name, tip) in Show::ALL {
                let (can, why) = match way {
                    Show::Mesh => (has_mesh, "There is no mesh in the graph"),
                    Show::Particles => (body.has_labels(), "The solid has no map of labels"),
                    _ => (true, ""),
                };
                let button = egui::Button::selectable(show == way, name);
                if ui.add_enabled(can, button).on_hover_text(tip).on_disabled_hover_text(why).clicked() {
                    self.show = Some(way);
                    show = way;
                }
            }
            ui.separator();
        }
        match content {
            Content::Report(_) | Content::Curves(_) | Content::Words(_) => return None,
            _ if show == Show::Slice => self.flat.controls(ui, content, self.exemplar.content()),
            _ => {
                self.objects.controls(ui, content, show, self.main.fit());
                ui.separator();
                toolbar::light(ui, &mut self.stage.look);
                if ui.button("Reset view").on_hover_text("The first view again").clicked() {
                    ask = Some(Ask::Reset);
                }
            }
        }
        let running = self.export.is_filming();
        ask.or(toolbar::save(ui, &mut self.export.settings, show != Show::Slice, running))
    }

    fn body(
        &mut self,
        ui: &mut Ui,
        rect: Rect,
        content: &Content,
        show: Show,
        ask: Option<Ask>,
    ) -> Vec<ViewAction> {
        let mut actions = Vec::new();
        let drawn = matches!(content, Content::Images(_) | Content::Body(_) | Content::Mesh(_));
        let flat = show == Show::Slice;
        self.objects.rest_but((drawn && !flat).then_some(show));
        if !(drawn && flat) {
            self.flat.rest();
        }
        match content {
            Content::Report(numbers) => report::report(ui, numbers),
            Content::Curves(curves) => report::curves(ui, curves),
            Content::Words(words) => {
                egui::ScrollArea::both().show(ui, |ui| ui.label(words));
            }
            _ if show == Show::Slice => {
                let exemplar = self.exemplar.content().map(|content| (self.exemplar.version, content));
                self.flat.show(ui, rect, (self.main.version, content), exemplar);
                if ask == Some(Ask::Screenshot)
                    && let Some(pieces) = self.flat.pieces()
                {
                    self.export.flat(ui.ctx(), pieces);
                }
            }
            _ => {
                let mesh = self.mesh.content().and_then(Content::mesh).map(|mesh| (self.mesh.version, mesh));
                let inside = self.inside.content().and_then(Content::body);
                let seen = Seen {
                    main: (self.main.version, content),
                    fit: self.main.fit(),
                    mesh,
                    inside: inside.map(|body| (self.inside.version, &body.solid)),
                };
                let props = self.objects.show(ui, rect, &mut self.stage, &seen, show);
                actions.extend(self.asked(ui, rect, props.as_ref(), ask));
            }
        }
        match ask {
            Some(Ask::Reset) => self.stage.reset(),
            Some(Ask::CancelExport) => self.export.cancel(),
            _ => {}
        }
        if self.export.is_filming() {
            let below = rect.translate(egui::vec2(0.0, 26.0));
            marks::working(ui, below, "exporting", self.export.progress());
        }
        if let Some(error) = self.export.error() {
            marks::error(ui, rect, &format!("The export failed: {error}"));
        }
        if self.main.is_stale() {
            marks::stale(ui, rect);
        }
        actions
    }

    /// Saves what is on the stage; without props it is seen through.
    fn asked(
        &mut self,
        ui: &Ui,
        rect: Rect,
        props: Option<&stage::Props>,
        ask: Option<Ask>,
    ) -> Option<ViewAction> {
        let (ctx, camera) = (ui.ctx(), self.stage.camera);
        match (ask, props) {
            (Some(Ask::Screenshot), Some(props)) => {
                let scale = ui.pixels_per_point();
                let size =
                    [rect.width(), rect.height()].map(|n| (n * scale).round().clamp(1.0, 8192.0) as u32);
                match self.stage.picture(props, camera, size) {
                    Ok(picture) => self.export.screenshot(ctx, picture),
                    Err(error) => return Some(ViewAction::Say(format!("There is no picture: {error}"))),
                }
            }
            (Some(Ask::Screenshot), None) => {
                let picture = self.objects.glass_picture();
                let picture =
                    picture.map(|image| ([image.width(), image.height()], export::rgba_with_alpha(image)));
                match picture {
                    Some(picture) => self.export.screenshot(ctx, picture),
                    None => return Some(ViewAction::Say("There is no picture yet.".to_owned())),
                }
            }
            (Some(Ask::Turntable(film)), Some(props)) => {
                self.export.turntable(ctx, (camera, props.clone()), film);
            }
            (Some(Ask::Turntable(film)), None) => match self.objects.glass_scene() {
                Some((scene, glass)) => self.export.glass_turntable(ctx, scene, glass, camera, film),
                None => return Some(ViewAction::Say("There is nothing to turn yet.".to_owned())),
            },
            _ => {}
        }
        None
    }
}
