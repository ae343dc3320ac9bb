//! How a node looks.

use breccia_engine::{CacheLevel, Device, NodeMode};
use eframe::egui::{
    Align2, Color32, CornerRadius, FontId, Painter, Pos2, Rect, Stroke, StrokeKind, TextureHandle, pos2, vec2,
};

use super::geometry::{FOOTER, HEADER, PICTURE, ROW};
use crate::model::{Place, Shape};
use crate::run::{NodeStatus, Phase};
use crate::theme::{self, Palette};

/// Zoom below which sockets have no names.
pub const NAMES: f32 = 0.45;
/// Zoom below which nodes are plain boxes.
pub const TEXT: f32 = 0.28;

/// All that the look of a node hangs on.
pub struct Look<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its sockets.
    pub shape: &'a Shape,
    /// How it is shown.
    pub place: Place,
    /// What is known of it.
    pub status: Option<&'a NodeStatus>,
    /// A small picture of its result.
    pub picture: Option<&'a TextureHandle>,
    /// Whether it runs.
    pub mode: NodeMode,
    /// Whether it is selected.
    pub selected: bool,
    /// Whether the viewport shows it.
    pub watched: bool,
    /// Whether it cannot run as it is wired.
    pub broken: bool,
}

/// Draws a node into a rectangle of the screen.
pub fn draw(painter: &Painter, rect: Rect, zoom: f32, look: &Look<'_>, colors: &Palette) {
    let faint = look.mode != NodeMode::Normal;
    let dim = |color: Color32| if faint { color.gamma_multiply(0.45) } else { color };
    let round = CornerRadius::same((5.0 * zoom).clamp(1.0, 12.0) as u8);
    let head = Rect::from_min_size(rect.min, vec2(rect.width(), (HEADER * zoom).min(rect.height())));
    painter.rect_filled(rect, round, dim(colors.node));
    let top = CornerRadius { sw: 0, se: 0, ..round };
    painter.rect_filled(
        head,
        if look.place.collapsed { round } else { top },
        dim(theme::category(&look.shape.category)),
    );
    let failed = look.status.is_some_and(|status| status.phase == Phase::Failed);
    let line = if look.selected {
        Stroke::new((2.2 * zoom.sqrt()).max(1.5), colors.selected)
    } else if failed || look.broken {
        Stroke::new(1.6, colors.error)
    } else {
        Stroke::new(1.0, colors.outline)
    };
    painter.rect_stroke(rect, round, line, StrokeKind::Outside);
    if zoom < TEXT {
        if let Some(color) = state_color(look, colors) {
            painter.rect_filled(
                Rect::from_min_max(pos2(rect.left(), rect.bottom() - 3.0), rect.max),
                0,
                color,
            );
        }
        return;
    }
    let inside = painter.with_clip_rect(painter.clip_rect().intersect(rect));
    let font = |size: f32| FontId::proportional(((size * zoom * 2.0).round() / 2.0).max(1.0));
    let white = dim(Color32::from_rgb(245, 245, 243));
    let mut x = head.left() + 8.0 * zoom;
    if look.watched {
        eye(&inside, pos2(x + 5.0 * zoom, head.center().y), 5.0 * zoom, white);
        x += 15.0 * zoom;
    }
    inside.text(pos2(x, head.center().y), Align2::LEFT_CENTER, look.name, font(13.0), white);
    let badge = match look.mode {
        NodeMode::Normal if !look.shape.known => "unknown",
        NodeMode::Normal if look.shape.group.is_some() => "group",
        NodeMode::Normal => "",
        NodeMode::Mute => "muted",
        NodeMode::Bypass => "bypassed",
    };
    if !badge.is_empty() {
        let at = pos2(head.right() - 7.0 * zoom, head.center().y);
        inside.text(at, Align2::RIGHT_CENTER, badge, font(10.0), white);
    }
    if look.place.collapsed {
        if let Some(color) = state_color(look, colors) {
            inside.rect_filled(
                Rect::from_min_max(pos2(rect.left(), rect.bottom() - 3.0 * zoom), rect.max),
                0,
                color,
            );
        }
        return;
    }
    let row = |i: usize| head.bottom() + (3.0 + ROW * (i as f32 + 0.5)) * zoom;
    if zoom >= NAMES {
        for (i, socket) in look.shape.inputs.iter().enumerate() {
            let at = pos2(rect.left() + 10.0 * zoom, row(i));
            inside.text(at, Align2::LEFT_CENTER, &socket.name, font(11.5), dim(colors.text));
        }
        for (i, socket) in look.shape.outputs.iter().enumerate() {
            let at = pos2(rect.right() - 10.0 * zoom, row(i));
            inside.text(at, Align2::RIGHT_CENTER, &socket.name, font(11.5), dim(colors.text));
        }
    }
    if look.place.picture {
        let rows = look.shape.inputs.len().max(look.shape.outputs.len());
        let top = head.bottom() + (3.0 + ROW * rows as f32 + 3.0) * zoom;
        let center = pos2(rect.center().x, top + PICTURE * zoom / 2.0);
        picture(&inside, center, zoom, look, colors, &font);
    }
    footer(&inside, rect, zoom, look, colors, &font);
}

fn picture(
    painter: &Painter,
    center: Pos2,
    zoom: f32,
    look: &Look<'_>,
    colors: &Palette,
    font: &dyn Fn(f32) -> FontId,
) {
    let Some(texture) = look.picture else {
        let frame = Rect::from_center_size(center, vec2(PICTURE, PICTURE) * zoom);
        painter.rect_stroke(frame, 2, Stroke::new(1.0, colors.grid), StrokeKind::Inside);
        painter.text(center, Align2::CENTER_CENTER, "no picture yet", font(10.5), colors.weak);
        return;
    };
    let size = texture.size_vec2();
    let scale = PICTURE / size.x.max(size.y).max(1.0);
    let stale = look.status.is_some_and(|status| status.stale);
    let tint = if stale { Color32::from_white_alpha(130) } else { Color32::WHITE };
    let full = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    painter.image(texture.id(), Rect::from_center_size(center, size * scale * zoom), full, tint);
}

fn footer(
    painter: &Painter,
    rect: Rect,
    zoom: f32,
    look: &Look<'_>,
    colors: &Palette,
    font: &dyn Fn(f32) -> FontId,
) {
    let strip = Rect::from_min_max(pos2(rect.left(), rect.bottom() - FOOTER * zoom), rect.max);
    if let Some(status) = look.status.filter(|status| status.phase == Phase::Running) {
        let done = strip.width() * status.fraction.clamp(0.0, 1.0);
        painter.rect_filled(
            Rect::from_min_size(strip.min, vec2(done, strip.height())),
            0,
            colors.busy.gamma_multiply(0.35),
        );
    }
    if let Some(color) = state_color(look, colors) {
        painter.circle_filled(pos2(strip.left() + 9.0 * zoom, strip.center().y), 3.2 * zoom, color);
    }
    if zoom >= NAMES {
        let at = pos2(strip.left() + 17.0 * zoom, strip.center().y);
        painter.text(at, Align2::LEFT_CENTER, state_text(look), font(10.0), colors.weak);
    }
}

fn state_color(look: &Look<'_>, colors: &Palette) -> Option<Color32> {
    if look.broken {
        return Some(colors.error);
    }
    let status = look.status?;
    let color = match status.phase {
        Phase::Idle => return None,
        Phase::Running => colors.busy,
        Phase::Done | Phase::Cached(_) => colors.done,
        Phase::Failed => colors.error,
        Phase::Skipped => colors.weak,
    };
    Some(if status.stale && status.phase != Phase::Running { color.gamma_multiply(0.4) } else { color })
}

/// A node's state in a few words.
pub fn state_text(look: &Look<'_>) -> String {
    match look.mode {
        NodeMode::Mute => return "muted".into(),
        NodeMode::Bypass => return "bypassed".into(),
        NodeMode::Normal => {}
    }
    if !look.shape.known {
        return "unknown type".into();
    }
    if look.broken {
        return "cannot run yet".into();
    }
    let Some(status) = look.status else { return String::new() };
    let text = match status.phase {
        Phase::Idle => String::new(),
        Phase::Running => format!("{:.0} %{}", status.fraction * 100.0, device(status)),
        Phase::Done => format!("{}, {}{}", seconds(status.seconds), bytes(status.bytes), device(status)),
        Phase::Cached(CacheLevel::Memory) => format!("in memory, {}", bytes(status.bytes)),
        Phase::Cached(CacheLevel::Disk) => format!("from disk, {}", bytes(status.bytes)),
        Phase::Cached(CacheLevel::Digest) => "known".into(),
        Phase::Failed => "failed".into(),
        Phase::Skipped => "waits for what failed".into(),
    };
    if status.stale && !matches!(status.phase, Phase::Running | Phase::Idle) {
        format!("{text} (stale)")
    } else {
        text
    }
}

fn device(status: &NodeStatus) -> &'static str {
    if status.device == Some(Device::Gpu) { ", GPU" } else { "" }
}

/// A duration for people.
pub fn seconds(seconds: f64) -> String {
    if seconds < 0.9995 {
        format!("{:.0} ms", seconds * 1e3)
    } else if seconds < 60.0 {
        format!("{seconds:.1} s")
    } else {
        format!("{:.0} min", seconds / 60.0)
    }
}

/// A size for people.
pub fn bytes(bytes: u64) -> String {
    let units = ["B", "kB", "MB", "GB", "TB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 999.5 && unit + 1 < units.len() {
        value /= 1000.0;
        unit += 1;
    }
    if unit == 0 || value >= 99.95 {
        format!("{value:.0} {}", units[unit])
    } else {
        format!("{value:.1} {}", units[unit])
    }
}

fn eye(painter: &Painter, at: Pos2, radius: f32, color: Color32) {
    painter.circle_stroke(at, radius, Stroke::new((radius * 0.3).max(0.6), color));
    painter.circle_filled(at, radius * 0.45, color);
}
