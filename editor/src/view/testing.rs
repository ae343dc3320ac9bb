//! What tests of the viewport need of a device.

use breccia_shaders::{GpuSettings, testing};
use eframe::egui_wgpu::{RenderState, RendererOptions};
use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};

/// A window's device without a window; `None` where there is no adapter and the test is to be skipped, which it says by name.
pub fn render_state() -> Option<RenderState> {
    testing::gpu(GpuSettings::default())?;
    Some(create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE))
}
