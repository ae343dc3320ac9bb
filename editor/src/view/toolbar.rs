//! The viewport's toolbar: what is shown, how, and what can be saved of it.

use eframe::egui::containers::menu::{MenuButton, MenuConfig};
use eframe::egui::{self, Slider, SliderClamping, Ui};

use super::export::{Film, TurnSettings};
use super::stage::{Behind, Look};

/// How a solid is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// A flat slice.
    Slice,
    /// On the mesh, or the mesh itself.
    Mesh,
    /// A box with a corner cut out.
    Cube,
    /// Three planes.
    Planes,
    /// A box seen through.
    Translucent,
    /// What is labelled, alone.
    Particles,
}

impl Show {
    /// All of them, with names and what they are.
    pub const ALL: [(Self, &'static str, &'static str); 6] = [
        (Self::Slice, "Slice", "A flat cut through the solid"),
        (Self::Mesh, "On mesh", "The mesh as if carved out of the solid"),
        (Self::Cube, "Cube", "A box of the solid with a corner cut out that can be dragged"),
        (Self::Planes, "Planes", "Three planes across the axes that can be dragged"),
        (Self::Translucent, "Translucent", "A box of the solid seen through"),
        (Self::Particles, "Particles", "What has a label, without what lies between"),
    ];
}

/// What a button asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ask {
    /// The first view again.
    Reset,
    /// A picture of what is shown.
    Screenshot,
    /// A full turn.
    Turntable(Film),
    /// An end to what is being saved.
    CancelExport,
}

/// Adds a slider to a row that wraps. A slider does not know its width before it is there, so it would not wrap by itself.
pub fn slider(ui: &mut Ui, name: &str, slider: Slider<'_>) -> egui::Response {
    let width = ui.spacing().slider_width + 120.0;
    if ui.available_size_before_wrap().x < width {
        ui.end_row();
    }
    let label = ui.label(name);
    ui.add(slider).labelled_by(label.id)
}

/// A choice with its name before it.
pub fn choice(
    ui: &mut Ui,
    name: &str,
    selected: &str,
    width: f32,
    contents: impl FnOnce(&mut Ui),
) -> egui::Response {
    let label = ui.label(name);
    let shown = egui::ComboBox::from_id_salt(name).selected_text(selected).width(width).show_ui(ui, contents);
    shown.response.labelled_by(label.id)
}

/// Three sliders from 0 to 1 in a menu, one an axis.
pub fn places(ui: &mut Ui, name: &str, tip: &str, at: &mut [f64; 3]) {
    menu(ui, name, |ui| {
        for (axis, at) in ["x", "y", "z"].into_iter().zip(at) {
            ui.add(Slider::new(at, 0.0..=1.0).text(format!("{name} {axis}")));
        }
    })
    .on_hover_text(tip);
}

/// A menu that stays open while its sliders are dragged.
fn menu<R>(ui: &mut Ui, name: &str, contents: impl FnOnce(&mut Ui) -> R) -> egui::Response {
    let stays = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    MenuButton::new(name).config(stays).ui(ui, contents).0
}

/// A choice among maps, where there are several.
pub fn map_choice(ui: &mut Ui, names: &[&str], chosen: &mut String) {
    let Some(first) = names.first() else { return };
    if !names.contains(&chosen.as_str()) {
        *chosen = (*first).to_owned();
    }
    if names.len() > 1 {
        let selected = chosen.clone();
        choice(ui, "Map", &selected, 90.0, |ui| {
            for name in names {
                ui.selectable_value(chosen, (*name).to_owned(), *name);
            }
        })
        .on_hover_text("Which map is shown");
    }
}

/// Light and background.
pub fn light(ui: &mut Ui, look: &mut Look) {
    menu(ui, "Light", |ui| {
        ui.set_min_width(240.0);
        ui.add_enabled(!look.flat, Slider::new(&mut look.brightness, 0.2..=2.0).text("Brightness"));
        ui.add_enabled(
            !look.flat,
            Slider::new(&mut look.direction, -180.0..=180.0).suffix("°").step_by(1.0).text("Direction"),
        )
        .on_hover_text("From the viewer to the left");
        ui.checkbox(&mut look.flat, "Colours as they are").on_hover_text("No light and no shade");
        ui.separator();
        ui.label("Background");
        ui.horizontal_wrapped(|ui| {
            for behind in Behind::ALL {
                ui.selectable_value(&mut look.behind, behind, behind.name());
            }
        });
    })
    .on_hover_text("Light and background");
}

/// What can be saved.
pub fn save(ui: &mut Ui, settings: &mut TurnSettings, can_turn: bool, running: bool) -> Option<Ask> {
    let mut ask = None;
    menu(ui, "Export", |ui| {
        ui.set_min_width(230.0);
        if ui.button("Screenshot (PNG)").on_hover_text("What is shown, without handles").clicked() {
            ask = Some(Ask::Screenshot);
            ui.close();
        }
        ui.add_enabled_ui(can_turn, |ui| {
            ui.separator();
            ui.label("Turntable");
            ui.add(Slider::new(&mut settings.frames, 8..=240).text("Frames"));
            ui.add(Slider::new(&mut settings.side, 128..=1024).text("Pixels"));
            ui.add(Slider::new(&mut settings.seconds, 1.0..=20.0).suffix(" s").text("A turn"));
            // Another one would put an end to the first.
            ui.add_enabled_ui(!running, |ui| {
                ui.horizontal(|ui| {
                    if ui.button("Turntable (GIF)").clicked() {
                        ask = Some(Ask::Turntable(Film::Gif));
                        ui.close();
                    }
                    if ui.button("Turntable (PNG sequence)").clicked() {
                        ask = Some(Ask::Turntable(Film::Pngs));
                        ui.close();
                    }
                })
            });
        });
    })
    .on_hover_text("Pictures of what is shown");
    if running && ui.button("Cancel export").clicked() {
        ask = Some(Ask::CancelExport);
    }
    ask
}

/// How finely a mesh is laid out in voxels: as the graph bakes it, or else as `usual`, until something is chosen.
pub fn resolution(ui: &mut Ui, chosen: &mut Option<u32>, baked: Option<u32>, usual: u32) {
    let mut shown = chosen.or(baked).unwrap_or(usual);
    // What is baked may lie beyond the slider's end, and is not to be changed by being shown.
    let range = Slider::new(&mut shown, 16..=1024).clamping(SliderClamping::Edits).logarithmic(true);
    let tip = "Voxels along the mesh's longest side: more make the structures finer on the mesh";
    if slider(ui, "Voxels", range).on_hover_text(tip).changed() {
        *chosen = Some(shown);
    }
    let Some(baked) = baked.filter(|baked| chosen.is_some_and(|chosen| chosen != *baked)) else { return };
    let tip = format!("{baked} voxels, as the graph bakes it");
    if ui.button("As baked").on_hover_text(tip).clicked() {
        *chosen = None;
    }
}

/// How fine textures become that are made for the eye.
pub fn texture(ui: &mut Ui, finest: &mut u32) {
    let selected = format!("{finest} px");
    choice(ui, "Texture", &selected, 72.0, |ui| {
        for size in [128, 256, 512, 1024, 2048] {
            ui.selectable_value(finest, size, format!("{size} px"));
        }
    })
    .on_hover_text("Edge of the texture that the surface, or the cut, ends at");
}
