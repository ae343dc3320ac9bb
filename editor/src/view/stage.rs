//! Where objects are shown: camera, light, background, and the picture that egui is given.

use eframe::egui::{self, Rect, Response, TextureId, Ui};
use eframe::egui_wgpu::RenderState;
use eframe::wgpu;

use super::camera::Orbit;
use super::geometry::Vertex;
use super::gpu_parts::{Material, Shape};
use super::renderer::{Frame, Light, Renderer};
use super::target::Target;
use super::vector::{add, scale, unit_or};

/// What lies behind an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Behind {
    /// Nearly black.
    #[default]
    Dark,
    /// Middle grey.
    Neutral,
    /// Nearly white.
    Light,
    /// Grey, darker below.
    Gradient,
    /// Nothing: pictures get an alpha channel.
    Transparent,
}

impl Behind {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Dark, Self::Neutral, Self::Light, Self::Gradient, Self::Transparent];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dark => "Dark",
            Self::Neutral => "Neutral",
            Self::Light => "Light",
            Self::Gradient => "Gradient",
            Self::Transparent => "Transparent",
        }
    }

    fn colors(self) -> [[f32; 4]; 2] {
        let grey = |v: f32| [v, v, v * 1.01, 1.0];
        match self {
            Self::Dark => [grey(0.115); 2],
            Self::Neutral => [grey(0.46); 2],
            Self::Light => [grey(0.93); 2],
            Self::Gradient => [grey(0.56), grey(0.17)],
            Self::Transparent => [[0.0; 4]; 2],
        }
    }
}

/// How things are lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// What lies behind.
    pub behind: Behind,
    /// Strength of the light.
    pub brightness: f32,
    /// Degrees from the viewer to the light, to the left.
    pub direction: f32,
    /// Colours as they are.
    pub flat: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self { behind: Behind::Dark, brightness: 1.0, direction: 40.0, flat: false }
    }
}

/// The first view: of boxes their faces across x, y and z, of meshes what the renderings of the presets show.
fn home(is_mesh: bool) -> Orbit {
    if is_mesh { Orbit { azimuth: 145.0, distance: 3.3, ..Orbit::default() } } else { Orbit::default() }
}

/// What is to be drawn, without the way it is looked at.
#[derive(Clone, Default)]
pub struct Props {
    /// Surfaces.
    pub parts: Vec<(Shape, Material)>,
    /// Ends of lines; these and what is not opaque are for the window alone, pictures that are saved lack them.
    pub lines: Vec<Vertex>,
    /// See [`Frame::clip`].
    pub clip: Option<([f32; 3], f32)>,
    /// See [`Frame::inside`].
    pub inside: [u8; 3],
}

/// The stage.
pub struct Stage {
    /// Draws.
    pub renderer: Renderer,
    /// Looks.
    pub camera: Orbit,
    /// Lights.
    pub look: Look,
    /// The camera of meshes while that of boxes is in use, and the other way round.
    other: Orbit,
    is_mesh: bool,
    state: RenderState,
    target: Option<(Target, TextureId)>,
    drawn: Option<Frame>,
}

impl Stage {
    /// A stage on the device of the window.
    pub fn new(state: RenderState) -> Self {
        let renderer = Renderer::new(&state.adapter, state.device.clone(), state.queue.clone());
        let (camera, look) = (home(false), Look::default());
        Self { renderer, camera, look, other: home(true), is_mesh: false, state, target: None, drawn: None }
    }

    /// Takes the camera of meshes, or that of boxes, as it was left.
    pub fn turn_to(&mut self, is_mesh: bool) {
        if self.is_mesh != is_mesh {
            self.is_mesh = is_mesh;
            std::mem::swap(&mut self.camera, &mut self.other);
        }
    }

    /// The first view again.
    pub fn reset(&mut self) {
        self.camera = home(self.is_mesh);
    }

    /// The frame that shows these things from a camera.
    pub fn frame(&self, props: &Props, camera: Orbit, size: egui::Vec2) -> Frame {
        let (sin, cos) = self.look.direction.to_radians().sin_cos();
        let across = add(scale(camera.right(), -sin), scale(camera.back(), cos));
        let key = unit_or(add(across, scale(camera.up(), 0.7)), [0.0, 1.0, 0.0]);
        let light = Light {
            key,
            brightness: self.look.brightness,
            flat: self.look.flat,
            behind: self.look.behind.colors(),
        };
        Frame {
            view_projection: camera.view_projection(size),
            eye: camera.eye(),
            light,
            clip: props.clip,
            inside: props.inside,
            parts: props.parts.clone(),
            lines: props.lines.clone(),
        }
    }

    /// Lets the pointer and the arrow keys turn, pan and zoom.
    pub fn steer(&mut self, ui: &Ui, response: &Response) {
        let shift = ui.input(|input| input.modifiers.shift);
        let delta = response.drag_delta();
        let pans = response.dragged_by(egui::PointerButton::Middle)
            || (shift && response.dragged_by(egui::PointerButton::Primary));
        if pans {
            self.camera.pan(delta, response.rect);
        } else if response.dragged_by(egui::PointerButton::Primary) {
            self.camera.turn(delta);
        }
        if response.contains_pointer() {
            let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            self.camera.zoom((scroll * 0.004).exp() * pinch);
        }
        if response.clicked() || response.drag_started() {
            response.request_focus();
        }
        if response.has_focus() {
            let keys = [
                (egui::Key::ArrowLeft, egui::vec2(15.0, 0.0)),
                (egui::Key::ArrowRight, egui::vec2(-15.0, 0.0)),
                (egui::Key::ArrowUp, egui::vec2(0.0, 15.0)),
                (egui::Key::ArrowDown, egui::vec2(0.0, -15.0)),
            ];
            let filter = egui::EventFilter {
                horizontal_arrows: true,
                vertical_arrows: true,
                ..egui::EventFilter::default()
            };
            ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
            for (key, by) in keys {
                if ui.input(|input| input.key_pressed(key)) {
                    self.camera.turn(by);
                }
            }
        }
    }

    /// Shows things in a rectangle, drawing them anew only if something changed.
    pub fn show(&mut self, ui: &Ui, rect: Rect, props: &Props) {
        let scale = ui.pixels_per_point();
        let size = [rect.width(), rect.height()].map(|n| (n * scale).round().clamp(1.0, 8192.0) as u32);
        let frame = self.frame(props, self.camera, rect.size());
        let device = self.renderer.device();
        let fits = self.target.as_ref().is_some_and(|(target, _)| target.size() == size);
        if !fits {
            let target = Target::new(device, size, self.renderer.samples());
            let mut egui_renderer = self.state.renderer.write();
            let id = match self.target.take() {
                Some((_, id)) => {
                    egui_renderer.update_egui_texture_from_wgpu_texture(
                        device,
                        target.view(),
                        wgpu::FilterMode::Linear,
                        id,
                    );
                    id
                }
                None => {
                    egui_renderer.register_native_texture(device, target.view(), wgpu::FilterMode::Linear)
                }
            };
            self.target = Some((target, id));
            self.drawn = None;
        }
        let Some((target, id)) = &self.target else { return };
        if !self.drawn.as_ref().is_some_and(|drawn| drawn.same(&frame)) {
            self.renderer.draw(&frame, target);
            self.drawn = Some(frame);
        }
        if self.look.behind == Behind::Transparent {
            checkerboard(ui, rect);
        }
        let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
        ui.painter().image(*id, rect, whole, egui::Color32::WHITE);
    }

    /// Paints what lies behind, where something else than the renderer draws the object.
    pub fn paint_background(&self, ui: &Ui, rect: Rect) {
        if self.look.behind == Behind::Transparent {
            return checkerboard(ui, rect);
        }
        let [top, bottom] = self.look.behind.colors().map(|[r, g, b, _]| {
            let [r, g, b] = [r, g, b].map(|c| (c * 255.0).round().clamp(0.0, 255.0) as u8);
            egui::Color32::from_rgb(r, g, b)
        });
        let mut mesh = egui::Mesh::default();
        for (at, color) in [
            (rect.left_top(), top),
            (rect.right_top(), top),
            (rect.left_bottom(), bottom),
            (rect.right_bottom(), bottom),
        ] {
            mesh.colored_vertex(at, color);
        }
        mesh.add_triangle(0, 1, 2);
        mesh.add_triangle(1, 2, 3);
        ui.painter().add(mesh);
    }

    /// A picture of things from a camera: RGBA.
    ///
    /// # Errors
    /// What the device says.
    pub fn picture(
        &self,
        props: &Props,
        camera: Orbit,
        size: [u32; 2],
    ) -> Result<([u32; 2], Vec<u8>), String> {
        let target = Target::new(self.renderer.device(), size, self.renderer.samples());
        let [width, height] = target.size().map(|n| n as f32);
        // Lines and shades help in the window alone.
        let mut props = Props { lines: Vec::new(), ..props.clone() };
        props.parts.retain(|(_, material)| material.is_opaque());
        self.renderer.draw(&self.frame(&props, camera, egui::vec2(width, height)), &target);
        let pixels = target.read(self.renderer.device(), self.renderer.queue())?;
        Ok((target.size(), pixels))
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        if let Some((_, id)) = &self.target {
            self.state.renderer.write().free_texture(id);
        }
    }
}

/// Squares of two greys, which stand for nothing.
pub fn checkerboard(ui: &Ui, rect: Rect) {
    const SIDE: f32 = 16.0;
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, egui::Color32::from_gray(96));
    let (columns, rows) = ((rect.width() / SIDE).ceil() as u32, (rect.height() / SIDE).ceil() as u32);
    for (x, y) in (0..rows.min(400)).flat_map(|y| (0..columns.min(400)).map(move |x| (x, y))) {
        if (x + y) % 2 == 0 {
            let at = rect.min + egui::vec2(x as f32, y as f32) * SIDE;
            painter.rect_filled(
                Rect::from_min_size(at, egui::Vec2::splat(SIDE)),
                0.0,
                egui::Color32::from_gray(120),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::geometry::{Geometry, WHITE};
    use super::super::gpu_parts::{Clip, Finish, PLAIN};
    use super::super::pixels::Pixels;
    use super::super::testing::render_state;
    use super::*;

    /// The pixel of a picture of so many pixels a side.
    fn at(bytes: &[u8], side: usize, x: usize, y: usize) -> [u8; 4] {
        let i = 4 * (y * side + x);
        [bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]
    }

    fn quad_of_four(stage: &Stage, clipped: bool) -> Props {
        let mut geometry = Geometry::default();
        geometry.quad([-0.5, 0.5, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [[0.0; 2], [1.0; 2]], WHITE);
        let colors = [[250, 10, 10, 255], [10, 250, 10, 255], [10, 10, 250, 255], [240, 240, 20, 255]];
        let finish = Finish { clip: if clipped { Clip::Kept } else { Clip::Whole }, sharp: true, ..PLAIN };
        let material = stage.renderer.material(&Pixels::new([2, 2], colors.concat()), finish);
        let shape = Shape::new(stage.renderer.device(), &geometry).unwrap();
        Props { parts: vec![(shape, material)], ..Props::default() }
    }

    #[test]
    fn a_textured_square_has_its_colours_at_their_places() {
        let Some(state) = render_state() else { return };
        let mut stage = Stage::new(state);
        stage.look.flat = true;
        stage.look.behind = Behind::Transparent;
        let camera = Orbit { azimuth: 0.0, elevation: 0.0, ..Orbit::default() };
        let props = quad_of_four(&stage, false);
        let (size, bytes) = stage.picture(&props, camera, [64, 64]).unwrap();
        assert_eq!(size, [64, 64]);
        // The ball of radius 1 fills the picture, so the square covers its middle half.
        assert_eq!(at(&bytes, 64, 24, 24), [250, 10, 10, 255]);
        assert_eq!(at(&bytes, 64, 40, 24), [10, 250, 10, 255]);
        assert_eq!(at(&bytes, 64, 24, 40), [10, 10, 250, 255]);
        assert_eq!(at(&bytes, 64, 40, 40), [240, 240, 20, 255]);
        assert_eq!(at(&bytes, 64, 5, 5), [0; 4]);
        assert_eq!(at(&bytes, 64, 60, 32), [0; 4]);
    }

    #[test]
    fn what_lies_beyond_the_plane_is_clipped() {
        let Some(state) = render_state() else { return };
        let mut stage = Stage::new(state);
        stage.look.flat = true;
        stage.look.behind = Behind::Transparent;
        let camera = Orbit { azimuth: 0.0, elevation: 0.0, ..Orbit::default() };
        let props = Props { clip: Some(([1.0, 0.0, 0.0], 0.0)), ..quad_of_four(&stage, true) };
        let (_, bytes) = stage.picture(&props, camera, [64, 64]).unwrap();
        assert_eq!(at(&bytes, 64, 24, 24), [250, 10, 10, 255]);
        assert_eq!(at(&bytes, 64, 40, 24), [0; 4]);
        // The same things without a plane are whole, and count as another frame.
        let whole = Props { clip: None, ..props.clone() };
        let frame = |props: &Props| stage.frame(props, camera, egui::vec2(64.0, 64.0));
        assert!(!frame(&whole).same(&frame(&props)) && frame(&props).same(&frame(&props)));
    }

    #[test]
    fn light_from_the_left_makes_the_left_brighter() {
        let Some(state) = render_state() else { return };
        let mut stage = Stage::new(state);
        let mut geometry = Geometry::default();
        for (x, z) in [(-0.6, 0.0), (0.0, 0.6)] {
            // Two walls that meet at an edge towards the viewer.
            let right = [0.6, 0.0, if x < -0.1 { 0.6 } else { -0.6 }];
            geometry.quad([x, 0.4, z], right, [0.0, -0.8, 0.0], [[0.0; 2], [1.0; 2]], WHITE);
        }
        let material = stage.renderer.material(&Pixels::flat([150; 3]), PLAIN);
        let shape = Shape::new(stage.renderer.device(), &geometry).unwrap();
        let props = Props { parts: vec![(shape, material)], ..Props::default() };
        let camera = Orbit { azimuth: 0.0, elevation: 0.0, ..Orbit::default() };
        let sides = |stage: &Stage| {
            let (_, bytes) = stage.picture(&props, camera, [64, 64]).unwrap();
            [20, 43].map(|x| i32::from(at(&bytes, 64, x, 32)[0]))
        };
        stage.look.direction = 70.0;
        let [left, right] = sides(&stage);
        assert!(left > right + 20, "{left} {right}");
        stage.look.direction = -70.0;
        let [left, right] = sides(&stage);
        assert!(right > left + 20, "{left} {right}");
    }
}
