//! How large nodes are, and where their sockets lie. In points of the canvas, whatever its zoom.

use std::collections::BTreeMap;

use eframe::egui::{Pos2, Rect, pos2, vec2};

use crate::action::Pin;
use crate::model::{Layout, Place, Shape};

/// Width of a node.
pub const WIDTH: f32 = 184.0;
/// Height of a node's heading.
pub const HEADER: f32 = 26.0;
/// Height of a row of sockets.
pub const ROW: f32 = 19.0;
/// Height of the line that tells a node's state.
pub const FOOTER: f32 = 18.0;
/// Edge of a small picture.
pub const PICTURE: f32 = 128.0;
const MARGIN: f32 = 6.0;

/// The size of a node.
pub fn size_of(shape: &Shape, place: Place) -> [i32; 2] {
    let height = if place.collapsed {
        HEADER
    } else {
        let rows = shape.inputs.len().max(shape.outputs.len()) as f32;
        let picture = if place.picture { PICTURE + MARGIN } else { 0.0 };
        HEADER + MARGIN + rows * ROW + picture + FOOTER
    };
    [WIDTH as i32, height as i32]
}

/// Where everything of a graph lies.
#[derive(Default)]
pub struct Geometry {
    /// Rectangles of nodes.
    pub nodes: BTreeMap<String, Rect>,
    /// Middles of sockets.
    pub pins: BTreeMap<Pin, Pos2>,
}

impl Geometry {
    /// Lays out a graph.
    pub fn new(layout: &Layout, shapes: &BTreeMap<String, Shape>) -> Self {
        let mut found = Self::default();
        for (name, shape) in shapes {
            let place = layout.nodes.get(name).copied().unwrap_or_default();
            let [width, height] = size_of(shape, place).map(|n| n as f32);
            let rect = Rect::from_min_size(corner(place.at), vec2(width, height));
            found.nodes.insert(name.clone(), rect);
            for (output, sockets) in [(false, &shape.inputs), (true, &shape.outputs)] {
                let x = if output { rect.right() } else { rect.left() };
                for (i, socket) in sockets.iter().enumerate() {
                    let y = if place.collapsed {
                        rect.top() + HEADER * (i as f32 + 1.0) / (sockets.len() as f32 + 1.0)
                    } else {
                        rect.top() + HEADER + MARGIN / 2.0 + ROW * (i as f32 + 0.5)
                    };
                    let pin = Pin { node: name.clone(), socket: socket.name.clone(), output };
                    found.pins.insert(pin, pos2(x, y));
                }
            }
        }
        found
    }

    /// The smallest rectangle around nodes; around all if there is none of these.
    pub fn bounds<'a>(&self, nodes: impl IntoIterator<Item = &'a String>) -> Option<Rect> {
        let around = |rects: &mut dyn Iterator<Item = Rect>| rects.reduce(Rect::union);
        around(&mut nodes.into_iter().filter_map(|name| self.nodes.get(name).copied()))
            .or_else(|| around(&mut self.nodes.values().copied()))
    }
}

/// A place as a point.
pub fn corner(at: [i32; 2]) -> Pos2 {
    pos2(at[0] as f32, at[1] as f32)
}

/// A point as a place.
pub fn place(at: Pos2) -> [i32; 2] {
    // Casts of floats saturate.
    [at.x.round() as i32, at.y.round() as i32]
}
