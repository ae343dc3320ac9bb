//! The application as a window: what it asks of the graphics driver, and of the system.

use std::sync::Arc;

use eframe::egui_wgpu::{SurfaceConfig, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use eframe::{egui, wgpu};

use crate::app::{App, Picker, Settings};

/// Under what name the system keeps which panels are open.
const HABITS: &str = "habits";

/// The application in its window.
pub struct Window(pub App);

impl Window {
    /// Opens a graph by the name of a file or a preset; the presets to choose from if there is none.
    ///
    /// # Errors
    /// If there is no such graph, or the engine cannot start.
    pub fn new(
        creation: &eframe::CreationContext<'_>,
        settings: Settings,
        picker: Box<dyn Picker>,
        graph: Option<&str>,
    ) -> Result<Self, Box<dyn std::error::Error + Send + Sync>> {
        egui_extras::install_image_loaders(&creation.egui_ctx);
        let mut app = App::new(&creation.egui_ctx, creation.wgpu_render_state.as_ref(), settings, picker)?;
        if let Some(habits) = creation.storage.and_then(|storage| storage.get_string(HABITS)) {
            app.set_habits(&habits);
        }
        match graph {
            Some(name) => app.open_named(name, &creation.egui_ctx)?,
            None => app.welcome(),
        }
        Ok(Self(app))
    }
}

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.0.ui(ui);
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        crate::theme::panel(visuals.dark_mode).to_normalized_gamma_f32()
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        storage.set_string(HABITS, self.0.habits());
    }

    fn on_exit(&mut self) {
        self.0.closed();
    }
}

/// A device with all that its adapter can do, since the engine computes on it too.
pub fn wgpu_options() -> WgpuConfiguration {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.power_preference = wgpu::PowerPreference::HighPerformance;
    setup.device_descriptor = Arc::new(|adapter| wgpu::DeviceDescriptor {
        label: Some("breccia"),
        required_limits: adapter.limits(),
        ..Default::default()
    });
    WgpuConfiguration {
        // Each frame that waits to be shown is one more between an input and its answer.
        surface: SurfaceConfig::LOW_LATENCY,
        wgpu_setup: WgpuSetup::CreateNew(setup),
        ..Default::default()
    }
}
