//! A box of a solid seen through, or its particles alone: rays marched behind the window, coarse while it is turned.

use std::sync::Arc;

use breccia_nodes::control::Control;
use breccia_nodes::data::{Image, Solid};
use breccia_nodes::render::{
    Background, Key, Scene, TranslucentSettings, march_on_device, translucent_scene,
};
use breccia_shaders::Gpu;
use eframe::egui::{self, Rect, TextureHandle, Ui};

use super::camera::Orbit;
use super::worker::Worker;

/// What is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    /// How much a voxel hides, 0 to 1.
    pub opacity: f32,
    /// Whether voxels of label 0 are left out and all others opaque.
    pub particles: bool,
}

type Boxed = ([i32; 3], [u32; 3]);
type PictureKey = (u64, Glass, [i32; 2], [u32; 2]);

/// The translucent view.
pub struct Translucent {
    scenes: Worker<(u64, Boxed, bool), Arc<Scene>>,
    scene: Option<(u64, Arc<Scene>)>,
    pictures: Worker<PictureKey, Image>,
    texture: Option<TextureHandle>,
    made: u64,
    /// The last picture, for saving.
    pub last: Option<Image>,
}

impl Translucent {
    /// Nothing yet.
    pub fn new(gpu: Option<&Arc<Gpu>>) -> Self {
        Self {
            scenes: Worker::new("scene", gpu.cloned()),
            scene: None,
            pictures: Worker::new("rays", gpu.cloned()),
            texture: None,
            made: 0,
            last: None,
        }
    }

    /// Asks for the scene and the picture, unless these are known or on their way; takes in what has come.
    pub fn update(
        &mut self,
        ui: &Ui,
        (version, solid, shown): (u64, &Arc<dyn Solid>, Boxed),
        glass: Glass,
        camera: Orbit,
        rect: Rect,
    ) {
        let solid = Arc::clone(solid);
        let key = if glass.particles { Key::Label } else { Key::Luminance };
        let new = self.scenes.want(ui.ctx(), (version, shown, glass.particles), move |job| {
            let scene = translucent_scene(&*solid, None, None, shown, key, job);
            job.send(Arc::new(scene.map_err(|error| error.to_string())?));
            Ok(())
        });
        if new {
            // The last picture stays until there is a new one, but no other is made of the old scene.
            self.scene = None;
        }
        for scene in self.scenes.poll() {
            self.made += 1;
            self.scene = Some((self.made, scene));
        }
        if let Some((number, scene)) = &self.scene {
            let scale = ui.pixels_per_point() * camera.magnification().clamp(0.5, 2.0);
            let size = [rect.width(), rect.height()].map(|n| (n * scale).round().clamp(16.0, 2048.0) as u32);
            let view = [camera.azimuth, camera.elevation].map(|degrees| (degrees * 10.0).round() as i32);
            let scene = Arc::clone(scene);
            self.pictures.want(ui.ctx(), (*number, glass, view, size), move |job| {
                for coarser in [6, 2, 1] {
                    let size = size.map(|n| (n / coarser).max(8));
                    job.send(picture(&scene, glass, view.map(|n| f64::from(n) / 10.0), size, job)?);
                }
                Ok(())
            });
        }
        for image in self.pictures.poll() {
            let size = [image.width() as usize, image.height() as usize];
            let rgba: Vec<u8> = super::export::rgba_with_alpha(&image);
            let shown = egui::ColorImage::from_rgba_unmultiplied(size, &rgba);
            match &mut self.texture {
                Some(texture) => texture.set(shown, egui::TextureOptions::LINEAR),
                None => {
                    let load = ui.ctx().load_texture("translucent", shown, egui::TextureOptions::LINEAR);
                    self.texture = Some(load);
                }
            }
            self.last = Some(image);
        }
    }

    /// Shows the picture, as large as the camera is close.
    pub fn show(&self, ui: &Ui, rect: Rect, camera: Orbit) {
        let Some(texture) = &self.texture else { return };
        let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
        let shift = camera.project([0.0; 3], rect).map_or(egui::Vec2::ZERO, |at| at - rect.center());
        let place = Rect::from_center_size(rect.center() + shift, rect.size() * camera.magnification());
        ui.painter_at(rect).image(texture.id(), place, whole, egui::Color32::WHITE);
    }

    /// The scene, if there is one: what a turntable is made of.
    pub fn scene(&self) -> Option<&Arc<Scene>> {
        self.scene.as_ref().map(|(_, scene)| scene)
    }

    /// Gives up what is on its way.
    pub fn rest(&mut self) {
        self.scenes.rest();
        self.pictures.rest();
    }

    /// Whether a finer picture is on its way.
    pub fn is_running(&self) -> bool {
        self.scenes.is_running() || self.pictures.is_running()
    }

    /// The fraction done of the scene.
    pub fn progress(&self) -> f32 {
        if self.scenes.is_running() { self.scenes.progress() } else { 0.0 }
    }

    /// What went wrong.
    pub fn error(&self) -> Option<&str> {
        self.scenes.error().or_else(|| self.pictures.error())
    }
}

/// A picture of a scene from azimuth and elevation, with an alpha channel.
///
/// # Errors
/// If cancelled, or an impossible size.
pub fn picture(
    scene: &Scene,
    glass: Glass,
    view: [f64; 2],
    size: [u32; 2],
    control: &dyn Control,
) -> Result<Image, String> {
    let opacity = f64::from(glass.opacity.clamp(0.0, 1.0));
    let opacities = if glass.particles { Key::Label.opacities(&[0.0, 1.0], 1.0) } else { [opacity; 256] };
    let settings = TranslucentSettings {
        picture: size,
        opacities,
        cuts: [None; 3],
        view,
        background: Background::Transparent,
    };
    let made = match control.gpu() {
        Some(gpu) => march_on_device(gpu, scene, &settings, control),
        None => scene.picture(&settings, control),
    };
    made.map_err(|error| error.to_string())
}
