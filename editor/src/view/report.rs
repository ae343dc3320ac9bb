//! Numbers as a table, curves as plots.

use breccia_nodes::data::{Curves, Plot, Report};
use eframe::egui::{
    self, Align2, Color32, FontId, Pos2, Rect, RichText, Sense, Stroke, Ui, WidgetInfo, WidgetType, pos2,
    vec2,
};

/// A table of a report's numbers; those outside of what is good stand out.
pub fn report(ui: &mut Ui, report: &Report) {
    ui.add_space(6.0);
    ui.heading(&report.title);
    let compared = report.rows.iter().any(|row| row.reference.is_some());
    let judged = report.rows.iter().any(|row| row.good.is_some());
    egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        egui::Grid::new("report").striped(true).spacing([18.0, 5.0]).show(ui, |ui| {
            let heads =
                [("Name", true), ("Value", true), ("Unit", true), ("Reference", compared), ("Good", judged)];
            for (head, _) in heads.into_iter().filter(|(_, shown)| *shown) {
                ui.label(RichText::new(head).strong());
            }
            ui.end_row();
            for row in &report.rows {
                ui.label(&row.name);
                let value = RichText::new(number(row.value)).monospace();
                if row.flagged() {
                    ui.label(value.color(ui.visuals().warn_fg_color))
                        .on_hover_text("Outside of what is good");
                } else {
                    ui.label(value);
                }
                ui.label(&row.unit);
                if compared {
                    ui.label(RichText::new(row.reference.map(number).unwrap_or_default()).monospace());
                }
                if judged {
                    let range = |[low, high]: [f64; 2]| format!("{} to {}", number(low), number(high));
                    ui.label(row.good.map(range).unwrap_or_default());
                }
                ui.end_row();
            }
        });
    });
}

/// A number with as many digits as mean something.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == value.round() && size < 1e9 {
        format!("{value:.0}")
    } else if (1e-3..1e6).contains(&size) {
        let decimals = (4.0 - size.log10().floor()).clamp(0.0, 6.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
}

/// All plots, below each other.
pub fn curves(ui: &mut Ui, curves: &Curves) {
    ui.add_space(6.0);
    ui.heading(&curves.title);
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        for plot in &curves.plots {
            draw(ui, plot);
            ui.add_space(12.0);
        }
    });
}

/// Colours of curves.
const COLORS: [Color32; 6] = [
    Color32::from_rgb(86, 156, 230),
    Color32::from_rgb(230, 140, 70),
    Color32::from_rgb(110, 190, 110),
    Color32::from_rgb(210, 100, 160),
    Color32::from_rgb(170, 140, 220),
    Color32::from_rgb(190, 180, 80),
];

fn draw(ui: &mut Ui, plot: &Plot) {
    ui.strong(&plot.title);
    ui.horizontal_wrapped(|ui| {
        for (series, color) in plot.series.iter().zip(COLORS.iter().cycle()) {
            ui.colored_label(*color, &series.name);
        }
    });
    let size = vec2(ui.available_width().clamp(120.0, 900.0), 220.0);
    let (outer, response) = ui.allocate_exact_size(size, Sense::hover());
    let label = format!("{}: {} over {}", plot.title, plot.y, plot.x);
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Image, true, &label));
    let rect = Rect::from_min_max(outer.min + vec2(64.0, 18.0), outer.max - vec2(12.0, 34.0));
    let points = || plot.series.iter().flat_map(|s| &s.points).filter(|p| p.iter().all(|c| c.is_finite()));
    let far = [f64::INFINITY, f64::NEG_INFINITY];
    let bounds = points()
        .fold([far; 2], |[x, y], p| [[x[0].min(p[0]), x[1].max(p[0])], [y[0].min(p[1]), y[1].max(p[1])]]);
    let painter = ui.painter_at(outer);
    let (text, font) = (ui.visuals().text_color(), FontId::proportional(11.0));
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    if points().next().is_none() {
        painter.text(rect.center(), Align2::CENTER_CENTER, "no points", font, text);
        return;
    }
    let [x, y] = bounds.map(|[a, b]| if b > a { [a, b] } else { [a - 0.5, b + 0.5] });
    let place = |p: &[f64; 2]| -> Pos2 {
        let t = [(p[0] - x[0]) / (x[1] - x[0]), (p[1] - y[0]) / (y[1] - y[0])].map(|t| t as f32);
        pos2(rect.left() + t[0] * rect.width(), rect.bottom() - t[1] * rect.height())
    };
    let grid = Stroke::new(1.0, ui.visuals().weak_text_color().gamma_multiply(0.4));
    for i in 0..=4 {
        let t = f64::from(i) / 4.0;
        let (at_x, at_y) = (x[0] + t * (x[1] - x[0]), y[0] + t * (y[1] - y[0]));
        let at = place(&[at_x, at_y]);
        painter.hline(rect.x_range(), at.y, grid);
        painter.vline(at.x, rect.y_range(), grid);
        painter.text(pos2(rect.left() - 6.0, at.y), Align2::RIGHT_CENTER, short(at_y), font.clone(), text);
        painter.text(pos2(at.x, rect.bottom() + 4.0), Align2::CENTER_TOP, short(at_x), font.clone(), text);
    }
    painter.text(outer.center_bottom(), Align2::CENTER_BOTTOM, &plot.x, font.clone(), text);
    painter.text(outer.left_top(), Align2::LEFT_TOP, &plot.y, font, text);
    for (series, color) in plot.series.iter().zip(COLORS.iter().cycle()) {
        let finite = series.points.iter().filter(|p| p.iter().all(|c| c.is_finite()));
        let line: Vec<Pos2> = finite.map(place).collect();
        match line.as_slice() {
            [single] => {
                painter.circle_filled(*single, 3.0, *color);
            }
            _ => {
                painter.line(line, Stroke::new(1.8, *color));
            }
        }
    }
}

/// A number at an axis.
fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if (0.01..1e5).contains(&size) {
        let decimals = (2.0 - size.log10().floor()).clamp(0.0, 4.0) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_with_the_digits_that_mean_something() {
        let shown = [3.0, 0.123_456, 1234.567, 1e-7, f64::NAN].map(number);
        assert_eq!(shown, ["3", "0.12346", "1234.6", "1.000e-7", "NaN"]);
        assert_eq!([0.0, 0.25, 120.0, 1e9].map(short), ["0", "0.25", "120", "1.0e9"]);
    }
}
