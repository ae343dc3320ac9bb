//! Colours and shapes: one of each for every socket type, one colour for every family of nodes.

use eframe::egui::{Color32, Context, Painter, Pos2, Shape, Stroke, Theme, Visuals, pos2, vec2};

/// The shape of a socket, so that colour is never the only sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A disc.
    Disc,
    /// A square.
    Square,
    /// A square on its corner.
    Diamond,
    /// A triangle that points to the right.
    Triangle,
    /// A hexagon.
    Hexagon,
}

const MARKS: [Mark; 5] = [Mark::Disc, Mark::Square, Mark::Diamond, Mark::Triangle, Mark::Hexagon];

/// How a socket type looks. Types that are not listed get a colour and a shape by their name.
pub fn socket(ty: &str) -> (Color32, Mark) {
    match ty {
        "image" => (Color32::from_rgb(230, 180, 60), Mark::Disc),
        "solid" => (Color32::from_rgb(70, 170, 200), Mark::Square),
        "volume" => (Color32::from_rgb(60, 120, 200), Mark::Square),
        "voxel_set" => (Color32::from_rgb(120, 150, 215), Mark::Square),
        "mesh" => (Color32::from_rgb(90, 185, 100), Mark::Diamond),
        "exemplar" => (Color32::from_rgb(215, 130, 60), Mark::Hexagon),
        "pyramid" => (Color32::from_rgb(205, 105, 90), Mark::Triangle),
        "report" | "curves" => (Color32::from_rgb(160, 160, 165), Mark::Disc),
        "" => (Color32::from_rgb(128, 128, 128), Mark::Disc),
        other => {
            let hash = hash(other);
            (hue(hash % 360), MARKS[(hash / 360) as usize % MARKS.len()])
        }
    }
}

/// The colour of a family of nodes.
pub fn category(name: &str) -> Color32 {
    match name {
        "io" => Color32::from_rgb(150, 118, 40),
        "exemplar" => Color32::from_rgb(160, 92, 40),
        "lazy" => Color32::from_rgb(44, 110, 140),
        "search" | "optimize" => Color32::from_rgb(110, 72, 140),
        "particles" => Color32::from_rgb(150, 62, 70),
        "solid" => Color32::from_rgb(46, 96, 150),
        "mesh" => Color32::from_rgb(52, 118, 66),
        "render" => Color32::from_rgb(96, 100, 52),
        "measure" => Color32::from_rgb(92, 94, 104),
        "flow" => Color32::from_rgb(70, 74, 90),
        other => hue(hash(other) % 360).gamma_multiply(0.6),
    }
}

fn hash(text: &str) -> u32 {
    text.bytes().fold(2_166_136_261, |hash: u32, byte| (hash ^ u32::from(byte)).wrapping_mul(16_777_619))
}

fn hue(degrees: u32) -> Color32 {
    eframe::egui::ecolor::Hsva::new(degrees as f32 / 360.0, 0.55, 0.75, 1.0).into()
}

/// Draws a socket.
pub fn mark(painter: &Painter, at: Pos2, radius: f32, mark: Mark, fill: Color32, line: Color32) {
    let stroke = Stroke::new((radius * 0.25).max(0.5), line);
    let polygon = |n: usize, turn: f32, radius: f32| {
        let corner = |i: usize| {
            let angle = turn + i as f32 / n as f32 * std::f32::consts::TAU;
            pos2(at.x + radius * angle.cos(), at.y + radius * angle.sin())
        };
        Shape::convex_polygon((0..n).map(corner).collect(), fill, stroke)
    };
    let quarter = std::f32::consts::FRAC_PI_4;
    painter.add(match mark {
        Mark::Disc => {
            Shape::Vec(vec![Shape::circle_filled(at, radius, fill), Shape::circle_stroke(at, radius, stroke)])
        }
        Mark::Square => polygon(4, quarter, radius * 1.25),
        Mark::Diamond => polygon(4, 0.0, radius * 1.25),
        Mark::Triangle => polygon(3, 0.0, radius * 1.3),
        Mark::Hexagon => polygon(6, 0.0, radius * 1.15),
    });
}

/// Colours that hang on whether the theme is light or dark.
#[derive(Clone, Copy)]
pub struct Palette {
    /// Behind everything.
    pub canvas: Color32,
    /// Lines of the grid.
    pub grid: Color32,
    /// Nodes.
    pub node: Color32,
    /// Text on nodes.
    pub text: Color32,
    /// Less important text.
    pub weak: Color32,
    /// Outlines.
    pub outline: Color32,
    /// What is selected.
    pub selected: Color32,
    /// What went wrong.
    pub error: Color32,
    /// What goes on.
    pub busy: Color32,
    /// What is done.
    pub done: Color32,
    /// Frames behind nodes.
    pub frame: Color32,
}

impl Palette {
    /// The colours of a theme.
    pub fn of(visuals: &Visuals) -> Self {
        if visuals.dark_mode {
            Self {
                canvas: Color32::from_rgb(26, 28, 31),
                grid: Color32::from_rgb(36, 38, 42),
                node: Color32::from_rgb(46, 49, 54),
                text: Color32::from_rgb(232, 232, 230),
                weak: Color32::from_rgb(168, 170, 174),
                outline: Color32::from_rgb(14, 15, 17),
                selected: Color32::from_rgb(250, 200, 90),
                error: Color32::from_rgb(232, 92, 80),
                busy: Color32::from_rgb(90, 180, 240),
                done: Color32::from_rgb(110, 190, 120),
                frame: Color32::from_rgba_unmultiplied(255, 255, 255, 10),
            }
        } else {
            Self {
                canvas: Color32::from_rgb(222, 223, 225),
                grid: Color32::from_rgb(209, 210, 213),
                node: Color32::from_rgb(247, 247, 246),
                text: Color32::from_rgb(28, 30, 33),
                weak: Color32::from_rgb(92, 95, 100),
                outline: Color32::from_rgb(150, 152, 156),
                selected: Color32::from_rgb(205, 120, 0),
                error: Color32::from_rgb(190, 40, 30),
                busy: Color32::from_rgb(20, 110, 190),
                done: Color32::from_rgb(40, 130, 60),
                frame: Color32::from_rgba_unmultiplied(0, 0, 0, 12),
            }
        }
    }
}

/// A point along a link, from 0 to 1: a curve that leaves to the right and comes in from the left.
pub fn curve(from: Pos2, to: Pos2, t: f32) -> Pos2 {
    let reach = ((to.x - from.x).abs() * 0.5).max(28.0_f32.min((to - from).length())).min(220.0);
    let (a, b) = (from + vec2(reach, 0.0), to - vec2(reach, 0.0));
    let s = 1.0 - t;
    let mix = |p: f32, q: f32, r: f32, u: f32| {
        s * s * s * p + 3.0 * s * s * t * q + 3.0 * s * t * t * r + t * t * t * u
    };
    pos2(mix(from.x, a.x, b.x, to.x), mix(from.y, a.y, b.y, to.y))
}

/// Sets up both themes: text that is less important must still be readable.
pub fn install(ctx: &Context) {
    for (theme, weak) in [(Theme::Dark, Color32::from_gray(160)), (Theme::Light, Color32::from_gray(90))] {
        ctx.style_mut_of(theme, |style| style.visuals.weak_text_color = Some(weak));
    }
}

/// The colour that panels have, and the window before anything is drawn.
pub fn panel(is_dark: bool) -> Color32 {
    if is_dark { Visuals::dark().panel_fill } else { Visuals::light().panel_fill }
}

/// Leaves panels unpainted, for a window that is cleared with their colour: a third fewer pixels in every frame, which counts where
/// software draws them.
pub fn leave_panels(ctx: &Context) {
    for theme in [Theme::Dark, Theme::Light] {
        ctx.style_mut_of(theme, |style| style.visuals.panel_fill = Color32::TRANSPARENT);
    }
}
