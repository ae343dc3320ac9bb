//! Small marks over what is shown: work that goes on, results that are out of date, errors.

use eframe::egui::{self, Align2, Color32, FontId, Rect, Ui, WidgetInfo, WidgetType};

/// A mark in a corner.
fn mark(ui: &Ui, at: egui::Pos2, align: Align2, text: &str, color: Color32, id: &str) -> Rect {
    let galley = ui.painter().layout_no_wrap(text.to_owned(), FontId::proportional(12.0), color);
    let rect = align.anchor_size(at, galley.size() + egui::vec2(14.0, 6.0));
    ui.painter().rect_filled(rect, 8.0, Color32::from_black_alpha(170));
    ui.painter().galley(rect.min + egui::vec2(7.0, 3.0), galley, color);
    let response = ui.interact(rect, ui.id().with(("mark", id)), egui::Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Label, true, text));
    rect
}

/// Says that work goes on, with a wheel that turns and the fraction done if it is known.
pub fn working(ui: &Ui, rect: Rect, what: &str, progress: f32) {
    let text = if progress > 0.0 && progress < 1.0 {
        format!("{what} {:.0} %", progress * 100.0)
    } else {
        format!("{what} …")
    };
    let at = rect.right_top() + egui::vec2(-30.0, 8.0);
    let color = Color32::from_rgb(255, 214, 120);
    let shown = mark(ui, at, Align2::RIGHT_TOP, &text, color, what);
    let wheel =
        Rect::from_center_size(egui::pos2(rect.right() - 18.0, shown.center().y), egui::Vec2::splat(14.0));
    egui::Spinner::new().color(color).paint_at(ui, wheel);
}

/// Says that what is shown is out of date.
pub fn stale(ui: &Ui, rect: Rect) {
    let at = rect.left_top() + egui::vec2(8.0, 8.0);
    mark(ui, at, Align2::LEFT_TOP, "stale", Color32::from_rgb(255, 176, 96), "stale");
}

/// Says something at the lower left.
pub fn note(ui: &Ui, rect: Rect, text: &str) {
    if !text.is_empty() {
        let at = rect.left_bottom() + egui::vec2(8.0, -8.0);
        mark(ui, at, Align2::LEFT_BOTTOM, text, Color32::from_gray(225), "note");
    }
}

/// Says what went wrong, across the lower part.
pub fn error(ui: &mut Ui, rect: Rect, text: &str) {
    let width = (rect.width() - 60.0).max(80.0);
    let color = Color32::from_rgb(255, 150, 140);
    let galley = ui.painter().layout(text.to_owned(), FontId::proportional(13.0), color, width);
    let size = galley.size() + egui::vec2(20.0, 14.0);
    let place = Align2::CENTER_BOTTOM.anchor_size(rect.center_bottom() - egui::vec2(0.0, 40.0), size);
    ui.painter().rect_filled(place, 6.0, Color32::from_rgba_unmultiplied(40, 10, 10, 235));
    ui.painter().galley(place.min + egui::vec2(10.0, 7.0), galley, color);
    let response = ui.interact(place, ui.id().with(("error", text)), egui::Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Label, true, text));
}

/// Says something in the middle of an empty place.
pub fn empty(ui: &mut Ui, text: &str) {
    ui.centered_and_justified(|ui| ui.label(egui::RichText::new(text).weak()));
}
