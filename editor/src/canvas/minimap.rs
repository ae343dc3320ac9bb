//! All of the graph, small, in a corner; a click or drag there moves the view.

use eframe::egui::{Id, Pos2, Rect, Sense, Stroke, StrokeKind, Ui, WidgetInfo, WidgetType, pos2, vec2};

use super::geometry::Geometry;
use super::view::Sight;
use crate::theme;

/// Draws the map; returns the point of the canvas that shall come into the middle.
pub fn show(ui: &Ui, canvas: Rect, seen: Rect, sight: &Sight<'_>, geometry: &Geometry) -> Option<Pos2> {
    let all = geometry.bounds(&[])?.expand(120.0).union(seen);
    let size = vec2(168.0, 108.0);
    let rect = Rect::from_min_size(canvas.max - size - vec2(10.0, 10.0), size);
    let scale = (size.x / all.width()).min(size.y / all.height());
    let to = |p: Pos2| rect.center() + (p - all.center()) * scale;
    let response = ui.interact(rect, Id::new("minimap"), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Other, true, "Map of the graph"));
    let painter = ui.painter().with_clip_rect(rect.expand(1.0));
    painter.rect_filled(rect, 4, sight.colors.node.gamma_multiply(0.85));
    painter.rect_stroke(rect, 4, Stroke::new(1.0, sight.colors.outline), StrokeKind::Inside);
    for (name, node) in &geometry.nodes {
        let small = Rect::from_min_max(to(node.min), to(node.max)).expand(0.3);
        let category = sight.shapes.get(name).map_or("", |shape| shape.category.as_str());
        let color = if sight.selection.nodes.contains(name) {
            sight.colors.selected
        } else {
            theme::category(category)
        };
        painter.rect_filled(small, 0, color);
    }
    let window = Rect::from_min_max(to(seen.min), to(seen.max)).intersect(rect);
    painter.rect_stroke(window, 0, Stroke::new(1.0, sight.colors.text), StrokeKind::Inside);
    let pressed = response.dragged() || response.clicked();
    let at = response.interact_pointer_pos().filter(|_| pressed)?;
    Some(all.center() + (at - rect.center()) / scale).filter(|p| pos2(p.x, p.y).is_finite())
}
