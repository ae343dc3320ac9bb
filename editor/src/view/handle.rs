//! Handles: points in space that are dragged along a direction.

use eframe::egui::{self, Color32, Id, Rect, Sense, Stroke, Ui, WidgetInfo, WidgetType};

use super::camera::Orbit;
use super::vector::{Vec3, add, scale};

/// Colours of the axes x, y and z, and of what lies across none of them.
pub const COLORS: [Color32; 4] = [
    Color32::from_rgb(232, 92, 86),
    Color32::from_rgb(120, 196, 92),
    Color32::from_rgb(92, 148, 236),
    Color32::from_rgb(240, 184, 72),
];

/// A handle.
pub struct Handle<'a> {
    /// What it is called, for people who do not see it.
    pub label: &'a str,
    /// Where it is.
    pub at: Vec3,
    /// Along what it moves, unit length.
    pub along: Vec3,
    /// Its colour.
    pub color: Color32,
}

impl Handle<'_> {
    /// Shows it, and returns by how much it was dragged along its direction.
    pub fn show(&self, ui: &Ui, id: Id, camera: &Orbit, rect: Rect) -> Option<f32> {
        /// The length of the arrow, in units of the ball.
        const REACH: f32 = 0.16;
        let at = camera.project(self.at, rect)?;
        if !rect.shrink(4.0).contains(at) {
            return None;
        }
        let tip = camera.project(add(self.at, scale(self.along, REACH)), rect)?;
        let arrow = tip - at;
        let hit = Rect::from_center_size(at, egui::Vec2::splat(22.0));
        let response = ui.interact(hit, id, Sense::drag()).on_hover_cursor(egui::CursorIcon::Grab);
        response.widget_info(|| WidgetInfo::labeled(WidgetType::Other, true, self.label));
        let active = response.hovered() || response.dragged();
        let color = if active { Color32::WHITE } else { self.color };
        let painter = ui.painter_at(rect);
        let dark = Stroke::new(5.0, Color32::from_black_alpha(120));
        // Seen end on there is no arrow.
        if arrow.length() > 4.0 {
            for direction in [arrow, -arrow] {
                painter.line_segment([at, at + direction], dark);
                painter.arrow(at, direction, Stroke::new(2.5, color));
            }
        }
        painter.circle_filled(at, 7.5, Color32::from_black_alpha(120));
        painter.circle_filled(at, 6.0, color);
        let response = response.on_hover_text(self.label);
        let per_unit = arrow / REACH;
        let length = per_unit.length_sq();
        (response.dragged() && length > 1.0).then(|| response.drag_delta().dot(per_unit) / length)
    }
}
