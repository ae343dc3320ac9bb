//! Links: where they run, which one lies under the pointer.

use std::collections::BTreeMap;

use breccia_engine::Link;
use eframe::egui::{Painter, Pos2, Rect, Shape, Stroke};

use super::geometry::{Geometry, corner};
use crate::action::Pin;
use crate::theme::curve;

/// Straight pieces of a curve between two points.
const PIECES: usize = 18;

/// A link as it runs over the canvas.
pub struct Course {
    /// Its text in the document.
    pub text: String,
    /// Where it starts.
    pub from: Pin,
    /// Where it ends.
    pub to: Pin,
    /// Where it runs through, ends included; in points of the canvas.
    pub points: Vec<Pos2>,
}

/// All links with both ends on the canvas.
pub fn courses(
    links: &[String],
    bends: &BTreeMap<String, Vec<[i32; 2]>>,
    geometry: &Geometry,
) -> Vec<Course> {
    links
        .iter()
        .filter_map(|text| {
            let link = Link::parse(text)?;
            let from = Pin { node: link.from_node, socket: link.from_socket, output: true };
            let to = Pin { node: link.to_node, socket: link.to_socket, output: false };
            let mut points = vec![*geometry.pins.get(&from)?];
            points.extend(bends.get(text).into_iter().flatten().map(|at| corner(*at)));
            points.push(*geometry.pins.get(&to)?);
            Some(Course { text: text.clone(), from, to, points })
        })
        .collect()
}

/// The points of a curve through others.
pub fn polyline(points: &[Pos2], pieces: usize) -> Vec<Pos2> {
    let mut line = Vec::with_capacity(points.len() * pieces + 1);
    line.extend(points.first());
    for pair in points.windows(2) {
        line.extend((1..=pieces).map(|i| curve(pair[0], pair[1], i as f32 / pieces as f32)));
    }
    line
}

/// Draws a curve through points of the screen; as one straight line each where it is small.
pub fn draw(painter: &Painter, points: &[Pos2], stroke: Stroke, fine: bool) {
    painter.add(Shape::line(polyline(points, if fine { PIECES } else { 6 }), stroke));
}

/// Distance of a point to a link, with the number of the stretch between bends that is nearest.
pub fn distance(points: &[Pos2], at: Pos2) -> (f32, usize) {
    let mut best = (f32::INFINITY, 0);
    for (stretch, pair) in points.windows(2).enumerate() {
        let line = polyline(pair, PIECES);
        for piece in line.windows(2) {
            let along = piece[1] - piece[0];
            let t = ((at - piece[0]).dot(along) / along.length_sq().max(1e-6)).clamp(0.0, 1.0);
            let distance = (at - (piece[0] + along * t)).length();
            if distance < best.0 {
                best = (distance, stretch);
            }
        }
    }
    best
}

/// A rectangle around a link.
pub fn bounds(points: &[Pos2]) -> Rect {
    Rect::from_points(points).expand2(eframe::egui::vec2(220.0, 4.0))
}
