//! Pan and zoom of flat pictures.

use eframe::egui::{self, Pos2, Rect, Response, Ui, Vec2, vec2};

/// How a picture lies in its place.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct PanZoom {
    /// Screen points a pixel; none fits the whole picture.
    zoom: Option<f32>,
    /// The pixel in the middle, from the picture's middle.
    center: Vec2,
}

impl PanZoom {
    /// Shows the whole picture.
    pub fn fit(&mut self) {
        *self = Self::default();
    }

    /// Shows a pixel of the picture as one of the screen.
    pub fn one_to_one(&mut self, pixels_per_point: f32) {
        self.zoom = Some(1.0 / pixels_per_point.max(0.1));
        self.center = Vec2::ZERO;
    }

    /// Screen points a pixel.
    pub fn scale(&self, size: [u32; 2], rect: Rect) -> f32 {
        let fit = (rect.width() / size[0].max(1) as f32).min(rect.height() / size[1].max(1) as f32) * 0.97;
        self.zoom.unwrap_or(fit).clamp(1e-3, 512.0)
    }

    /// Where a picture of that size lies.
    pub fn place(&self, size: [u32; 2], rect: Rect) -> Rect {
        let scale = self.scale(size, rect);
        let extent = vec2(size[0] as f32, size[1] as f32) * scale;
        Rect::from_center_size(rect.center() - self.center * scale, extent)
    }

    /// The pixel at a place of the screen, as a fraction.
    pub fn pixel(&self, at: Pos2, size: [u32; 2], rect: Rect) -> Vec2 {
        (at - self.place(size, rect).min) / self.scale(size, rect)
    }

    /// Zooms about a place of the screen, which stays where it is.
    pub fn zoom_about(&mut self, at: Pos2, factor: f32, size: [u32; 2], rect: Rect) {
        let before = self.scale(size, rect);
        let after = (before * factor).clamp(1e-2, 256.0);
        if !after.is_finite() {
            return;
        }
        let from_middle = at - rect.center();
        self.center += from_middle / before - from_middle / after;
        self.zoom = Some(after);
        self.keep(size);
    }

    /// Moves with a drag.
    pub fn pan(&mut self, delta: Vec2, size: [u32; 2], rect: Rect) {
        let scale = self.scale(size, rect);
        self.zoom = Some(scale);
        self.center -= delta / scale;
        self.keep(size);
    }

    /// Some of the picture stays in view.
    fn keep(&mut self, size: [u32; 2]) {
        let half = vec2(size[0] as f32, size[1] as f32) / 2.0;
        self.center = self.center.clamp(-half, half);
    }

    /// Lets the pointer pan and the wheel zoom.
    pub fn steer(&mut self, ui: &Ui, response: &Response, size: [u32; 2], rect: Rect) {
        if response.dragged() {
            self.pan(response.drag_delta(), size, rect);
        }
        if let Some(at) = response.hover_pos() {
            let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            let factor = (scroll * 0.005).exp() * pinch;
            if factor != 1.0 {
                self.zoom_about(at, factor, size, rect);
            }
        }
        if response.double_clicked() {
            self.fit();
        }
        let arrows = [
            (egui::Key::ArrowLeft, vec2(40.0, 0.0)),
            (egui::Key::ArrowRight, vec2(-40.0, 0.0)),
            (egui::Key::ArrowUp, vec2(0.0, 40.0)),
            (egui::Key::ArrowDown, vec2(0.0, -40.0)),
        ];
        if response.clicked() || response.drag_started() {
            response.request_focus();
        }
        if response.has_focus() {
            let filter = egui::EventFilter {
                horizontal_arrows: true,
                vertical_arrows: true,
                ..egui::EventFilter::default()
            };
            ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
            for (key, by) in arrows {
                if ui.input(|input| input.key_pressed(key)) {
                    self.pan(by, size, rect);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::pos2;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

        #[test]
        fn the_pixel_under_the_pointer_stays_when_zooming(x in 120f32..380.0, y in 120f32..280.0, factor in 0.8f32..4.0) {
            let (size, rect) = ([300, 200], Rect::from_min_size(pos2(100.0, 100.0), vec2(300.0, 200.0)));
            let mut view = PanZoom::default();
            let before = view.pixel(pos2(x, y), size, rect);
            view.zoom_about(pos2(x, y), factor, size, rect);
            // Unless the edge of the picture was reached, which zooming in from the whole does not.
            if factor >= 1.0 {
                let after = view.pixel(pos2(x, y), size, rect);
                prop_assert!((before - after).length() < 0.05, "{before:?} {after:?}");
            }
        }
    }

    #[test]
    fn fitting_shows_all_and_one_to_one_is_exact() {
        let rect = Rect::from_min_size(pos2(10.0, 20.0), vec2(400.0, 100.0));
        let mut view = PanZoom::default();
        assert!(rect.contains_rect(view.place([900, 700], rect)));
        view.one_to_one(2.0);
        assert_eq!(view.place([90, 70], rect).size(), vec2(45.0, 35.0));
    }
}
