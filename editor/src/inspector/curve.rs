//! Many fractions as a curve whose points can be dragged.

use eframe::egui::{Pos2, Rect, Sense, Stroke, StrokeKind, Ui, Vec2, WidgetInfo, pos2, vec2};

use super::widget::Change;

const HEIGHT: f32 = 96.0;

/// Shows fractions at even distances as a curve, the first on the left; dragging moves the nearest point up or down.
pub fn curve(ui: &mut Ui, label: &str, numbers: &mut [f64], change: &mut Change) {
    let width = ui.available_width().max(60.0);
    let (rect, _) = ui.allocate_exact_size(vec2(width, HEIGHT), Sense::hover());
    let inside = rect.shrink(6.0);
    let last = numbers.len().saturating_sub(1).max(1) as f32;
    let at = |i: usize, y: f64| {
        pos2(
            inside.left() + inside.width() * i as f32 / last,
            inside.bottom() - inside.height() * y.clamp(0.0, 1.0) as f32,
        )
    };
    let visuals = ui.visuals().clone();
    ui.painter().rect_filled(rect, 4, visuals.extreme_bg_color);
    ui.painter().rect_stroke(rect, 4, visuals.widgets.noninteractive.bg_stroke, StrokeKind::Inside);
    let points: Vec<Pos2> = numbers.iter().enumerate().map(|(i, y)| at(i, *y)).collect();
    ui.painter().line(points.clone(), Stroke::new(1.5, visuals.selection.bg_fill));
    for (i, (number, point)) in numbers.iter_mut().zip(points).enumerate() {
        let response = ui.interact(
            Rect::from_center_size(point, Vec2::splat(12.0)),
            ui.id().with((label, i)),
            Sense::drag(),
        );
        response.widget_info(|| WidgetInfo::slider(true, *number, format!("{label} {}", i + 1)));
        let color = if response.hovered() || response.dragged() {
            visuals.strong_text_color()
        } else {
            visuals.text_color()
        };
        ui.painter().circle_filled(point, 3.5, color);
        change.note(&response);
        if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            *number = f64::from(((inside.bottom() - pointer.y) / inside.height()).clamp(0.0, 1.0));
        }
        response.on_hover_text(format!("{number:.3}"));
    }
}
