//! Which colour and shape is which type.

use eframe::egui::{Align2, FontId, Rect, Stroke, StrokeKind, Ui, pos2, vec2};

use super::view::Sight;
use crate::theme;

/// Draws the legend of the types that the graph has into a corner of the canvas.
pub fn show(ui: &Ui, canvas: Rect, sight: &Sight<'_>) {
    let mut types: Vec<&str> = sight
        .shapes
        .values()
        .flat_map(|s| s.inputs.iter().chain(&s.outputs))
        .map(|s| s.ty.as_str())
        .filter(|ty| !ty.is_empty())
        .collect();
    types.sort_unstable();
    types.dedup();
    let size = vec2(132.0, 12.0 + 18.0 * types.len() as f32);
    let rect = Rect::from_min_size(pos2(canvas.left() + 10.0, canvas.bottom() - size.y - 10.0), size);
    ui.painter().rect_filled(rect, 4, sight.colors.node.gamma_multiply(0.92));
    ui.painter().rect_stroke(rect, 4, Stroke::new(1.0, sight.colors.outline), StrokeKind::Inside);
    for (i, ty) in types.iter().enumerate() {
        let at = rect.min + vec2(14.0, 15.0 + 18.0 * i as f32);
        let (color, mark) = theme::socket(ty);
        theme::mark(ui.painter(), at, 5.0, mark, color, sight.colors.outline);
        ui.painter().text(
            at + vec2(12.0, 0.0),
            Align2::LEFT_CENTER,
            ty,
            FontId::proportional(12.0),
            sight.colors.text,
        );
    }
}
