//! The viewport: any result as a picture, or as an object that can be turned and cut open.

use std::sync::Arc;

use breccia_engine::Value;
use breccia_shaders::Gpu;
use eframe::egui;
use eframe::egui_wgpu::RenderState;

/// A result of a node, as it is looked at.
#[derive(Clone)]
pub struct Subject {
    /// `node.socket`.
    pub label: String,
    /// The value.
    pub value: Value,
    /// Whether the graph has changed since, and a new value is on its way.
    pub stale: bool,
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
    /// The solid that a mesh was made from: what is inside when the mesh is cut open.
    pub solid: Option<&'a Subject>,
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
pub struct Viewport {}

impl Viewport {
    /// `render` draws; `gpu` computes, where there is a device for that.
    pub fn new(render: RenderState, gpu: Option<Arc<Gpu>>) -> Self {
        let _ = (render, gpu);
        Self {}
    }

    /// Draws the viewport into all of `ui`.
    pub fn ui(&mut self, ui: &mut egui::Ui, scene: &Scene<'_>) -> Vec<ViewAction> {
        let _ = (ui, scene);
        Vec::new()
    }
}
