//! The flat view: pictures and slices, their pixels, and the exemplar beside or under them.

use std::sync::Arc;

use breccia_shaders::Gpu;
use eframe::egui::{self, Color32, Rect, Sense, Stroke, Ui, WidgetInfo, WidgetType, pos2, vec2};

use super::content::Content;
use super::layer::Layer;
use super::pan_zoom::PanZoom;
use super::pixels::Channel;
use super::slicing::{Slicing, sample};
use super::{marks, stage};

/// How a picture is compared with the exemplar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Compare {
    /// Not at all.
    #[default]
    Off,
    /// Beside it, at the same scale.
    Beside,
    /// The picture left of a divider, the exemplar right of it.
    Wipe,
}

type Key = (u64, String, Channel, Option<Slicing>);

/// The flat view.
pub struct Flat {
    main: Layer<Key>,
    exemplar: Layer<u64>,
    view: PanZoom,
    map: String,
    channel: Channel,
    slicing: Slicing,
    compare: Compare,
    /// Where the divider is, as a fraction of the width.
    pub divider: f32,
}

impl Flat {
    /// Nothing yet.
    pub fn new(gpu: Option<&Arc<Gpu>>) -> Self {
        Self {
            main: Layer::new("picture", gpu),
            exemplar: Layer::new("exemplar", gpu),
            view: PanZoom::default(),
            map: "color".to_owned(),
            channel: Channel::Color,
            slicing: Slicing::default(),
            compare: Compare::Off,
            divider: 0.5,
        }
    }

    /// The widgets for what is shown.
    pub fn controls(&mut self, ui: &mut Ui, content: &Content, exemplar: Option<&Content>) {
        let names: Vec<&str> = match content {
            Content::Images(images) => images.iter().map(|(name, _)| name.as_str()).collect(),
            Content::Body(body) => body.maps.iter().map(String::as_str).collect(),
            _ => Vec::new(),
        };
        super::toolbar::map_choice(ui, &names, &mut self.map);
        let channels = content.images().iter().find(|(name, _)| *name == self.map).map(|(_, i)| i.channels());
        if let Some(channels) = channels.filter(|&n| n > 1) {
            super::toolbar::choice(ui, "Channel", self.channel.name(channels), 70.0, |ui| {
                let all = std::iter::once(Channel::Color).chain((0..channels).map(Channel::One));
                for channel in all {
                    ui.selectable_value(&mut self.channel, channel, channel.name(channels));
                }
            })
            .on_hover_text("All channels as a colour, or one in grey");
        }
        if let Content::Body(body) = content {
            self.slicing.controls(ui, body);
        }
        ui.separator();
        if ui.button("Fit").on_hover_text("Show the whole picture; a double click does so too").clicked() {
            self.view.fit();
        }
        if ui.button("1:1").on_hover_text("A pixel of the picture as one of the screen").clicked() {
            self.view.one_to_one(ui.pixels_per_point());
        }
        if exemplar.is_some_and(|content| !content.images().is_empty()) {
            ui.separator();
            ui.label("Compare");
            let ways = [
                (Compare::Off, "Off", "The result alone"),
                (Compare::Beside, "Side by side", "The exemplar to the right, at the same scale"),
                (Compare::Wipe, "Wipe", "The exemplar right of a divider that can be dragged"),
            ];
            for (way, name, tip) in ways {
                if ui.selectable_label(self.compare == way, name).on_hover_text(tip).clicked() {
                    self.compare = way;
                }
            }
        }
    }

    /// Asks for what is to be shown.
    fn update(
        &mut self,
        ui: &Ui,
        version: u64,
        content: &Content,
        exemplar: Option<(u64, &Content)>,
    ) -> Option<String> {
        let ctx = ui.ctx();
        let mut problem = None;
        match content {
            Content::Images(images) => {
                let found = images.iter().find(|(name, _)| *name == self.map).or(images.first());
                if let Some((name, image)) = found {
                    let key = (version, name.clone(), self.channel, None);
                    self.main.want_image(ctx, key, image, self.channel);
                }
            }
            Content::Body(body) => {
                let map = if body.maps.contains(&self.map) { self.map.clone() } else { "color".to_owned() };
                match self.slicing.plane(body) {
                    Ok(plane) => {
                        let key = (version, map.clone(), Channel::Color, Some(self.slicing.settled()));
                        let solid = Arc::clone(&body.solid);
                        self.main.want(ctx, key, plane.1, move |pieces| sample(&solid, &map, plane, pieces));
                    }
                    Err(error) => problem = Some(error),
                }
            }
            _ => {}
        }
        if let Some((version, content)) = exemplar
            && let Some((_, image)) = content.images().first()
        {
            self.exemplar.want_image(ctx, version, image, Channel::Color);
        } else {
            self.compare = Compare::Off;
        }
        problem.or_else(|| self.main.error().or(self.exemplar.error()).map(str::to_owned))
    }

    /// Shows it.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        rect: Rect,
        (version, content): (u64, &Content),
        exemplar: Option<(u64, &Content)>,
    ) {
        let problem = self.update(ui, version, content, exemplar);
        let response = ui.interact(rect, ui.id().with("picture"), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(WidgetType::Image, true, "Picture"));
        let size = self.main.size();
        let (place, other) = match self.compare {
            Compare::Beside => rect.split_left_right_at_fraction(0.5),
            _ => (rect, rect),
        };
        self.view.steer(ui, &response, size, place);
        if let Content::Body(body) = content
            && response.contains_pointer()
        {
            // Shift turns the wheel sideways.
            let sideways = ui.input(|input| input.smooth_scroll_delta().x);
            if sideways != 0.0 {
                self.slicing.step(f64::from(sideways / 12.0), body);
            }
        }
        ui.painter().rect_filled(rect, 0.0, ui.visuals().extreme_bg_color);
        let shown = self.view.place(size, place);
        match self.compare {
            Compare::Off => self.main.paint(&ui.painter_at(rect), shown),
            Compare::Beside => {
                self.main.paint(&ui.painter_at(place.shrink(1.0)), shown);
                self.paint_beside(ui, place, other);
                ui.painter().vline(other.left(), rect.y_range(), Stroke::new(1.0, Color32::from_gray(120)));
            }
            Compare::Wipe => self.wipe(ui, rect, shown),
        }
        if self.main.is_empty() && problem.is_none() {
            stage::checkerboard(ui, Rect::from_center_size(rect.center(), vec2(96.0, 96.0)));
        }
        marks::note(ui, rect, &self.under_pointer(&response, size, place));
        if self.main.is_running() {
            marks::working(ui, rect, "updating", 0.0);
        }
        if let Some(problem) = problem {
            marks::error(ui, rect, &problem);
        }
    }

    /// The exemplar at the scale of the picture beside it.
    fn paint_beside(&self, ui: &Ui, place: Rect, other: Rect) {
        let scale = self.view.scale(self.main.size(), place);
        let size = self.exemplar.size();
        let shown = self.view.place(self.main.size(), place);
        let shift = shown.center() - place.center();
        let extent = vec2(size[0] as f32, size[1] as f32) * scale;
        self.exemplar
            .paint(&ui.painter_at(other.shrink(1.0)), Rect::from_center_size(other.center() + shift, extent));
    }

    /// The picture left of the divider, the exemplar right of it, over the same place.
    fn wipe(&mut self, ui: &Ui, rect: Rect, shown: Rect) {
        let x = rect.left() + self.divider * rect.width();
        let left = Rect::from_min_max(rect.min, pos2(x, rect.bottom()));
        let right = Rect::from_min_max(pos2(x, rect.top()), rect.max);
        self.main.paint(&ui.painter_at(left), shown);
        self.exemplar.paint(&ui.painter_at(right), shown);
        ui.painter().vline(x, rect.y_range(), Stroke::new(2.0, Color32::WHITE));
        let grip = Rect::from_center_size(pos2(x, rect.center().y), vec2(16.0, 44.0));
        let line = Rect::from_center_size(pos2(x, rect.center().y), vec2(14.0, rect.height()));
        let response = ui
            .interact(line, ui.id().with("divider"), Sense::drag())
            .on_hover_and_drag_cursor(egui::CursorIcon::ResizeHorizontal);
        response
            .widget_info(|| WidgetInfo::slider(true, f64::from(self.divider), "Divider of the comparison"));
        ui.painter().rect_filled(grip, 6.0, Color32::from_black_alpha(170));
        ui.painter().rect_stroke(grip, 6.0, Stroke::new(1.5, Color32::WHITE), egui::StrokeKind::Inside);
        if response.dragged() {
            self.divider = (self.divider + response.drag_delta().x / rect.width().max(1.0)).clamp(0.02, 0.98);
        }
    }

    /// Place, channels and colour of the pixel under the pointer.
    fn under_pointer(&self, response: &egui::Response, size: [u32; 2], rect: Rect) -> String {
        let text = response.hover_pos().and_then(|at| {
            let pixel = self.view.pixel(at, size, rect);
            let inside = pixel.x >= 0.0 && pixel.y >= 0.0;
            let (x, y) = (pixel.x as u32, pixel.y as u32);
            let value = (inside && x < size[0] && y < size[1]).then(|| self.main.describe(x, y)).flatten()?;
            Some(format!("{x}, {y}   {value}"))
        });
        let zoom = self.view.scale(size, rect) * response.ctx.pixels_per_point() * 100.0;
        text.unwrap_or_else(|| format!("{} × {} · {zoom:.0} %", size[0], size[1]))
    }

    /// Gives up what is on its way.
    pub fn rest(&mut self) {
        self.main.rest();
        self.exemplar.rest();
    }

    /// Whether pieces are on their way.
    pub fn is_running(&self) -> bool {
        self.main.is_running() || self.exemplar.is_running()
    }

    /// What is shown, for saving.
    pub fn pieces(&self) -> Option<([u32; 2], Vec<super::layer::Patch>)> {
        (!self.main.is_empty()).then(|| self.main.pieces())
    }
}
