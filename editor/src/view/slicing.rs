//! Slices of solids as flat pictures, coarse to fine and then in tiles from the middle outwards.

use std::sync::Arc;

use breccia_nodes::data::{Filter, Solid};
use breccia_nodes::solid::{Plane, slice};
use eframe::egui::{self, Ui};

use super::content::Body;
use super::layer::{Patch, Pieces};
use super::pixels::Channel;
use super::toolbar;

/// Pixels along the edge of a tile.
const TILE: u32 = 96;

/// Across what a slice lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// One of the axes.
    Axis(usize),
    /// Any direction.
    Oblique,
}

/// Where a slice lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slicing {
    /// Across what.
    pub across: Across,
    /// Voxels along the normal: from the box's first layer, or from the origin.
    pub position: f64,
    /// Of an oblique normal: degrees from z towards x.
    pub turn: f64,
    /// Of an oblique normal: degrees towards y.
    pub tilt: f64,
    /// Pixels a side, where the solid has no end.
    pub edge: u32,
}

impl Default for Slicing {
    fn default() -> Self {
        Self { across: Across::Axis(2), position: 0.0, turn: 45.0, tilt: 35.0, edge: 256 }
    }
}

impl Slicing {
    /// The box it lies in.
    fn room(&self, body: &Body) -> ([f64; 3], [f64; 3]) {
        let (origin, size) = body.bounds.unwrap_or(([0; 3], [self.edge; 3]));
        (origin.map(f64::from), size.map(f64::from))
    }

    /// From where to where it can be moved.
    fn reach(&self, body: &Body) -> (f64, f64) {
        match (self.across, body.bounds) {
            (Across::Axis(axis), Some((_, size))) => {
                (0.0, f64::from(size.get(axis).copied().unwrap_or(1).max(1) - 1))
            }
            (Across::Oblique, Some((_, size))) => {
                let half = size.iter().map(|&n| f64::from(n).powi(2)).sum::<f64>().sqrt() / 2.0;
                (-half.ceil(), half.ceil())
            }
            (_, None) => (-1024.0, 1024.0),
        }
    }

    /// The plane with pixels of one voxel, how many there are, and how they are found.
    pub fn plane(&self, body: &Body) -> Result<(Plane, [u32; 2], Filter), String> {
        let (low, extent) = self.room(body);
        let middle: [f64; 3] = std::array::from_fn(|i| low[i] + extent[i] / 2.0);
        let pixels = |n: f64| n.round().clamp(1.0, 4096.0) as u32;
        match self.across {
            Across::Axis(axis) => {
                let [c, r] = super::faces::columns_and_rows(axis);
                let normal = std::array::from_fn(|i| if i == axis { 1.0 } else { 0.0 });
                let first = low.get(axis).copied().unwrap_or(0.0);
                let center = std::array::from_fn(|i| {
                    if i == axis { first + self.position.round() + 0.5 } else { middle[i] }
                });
                let plane = Plane::new(center, normal, 0.0, 1.0).map_err(|error| error.to_string())?;
                Ok((plane, [pixels(extent[c]), pixels(extent[r])], Filter::Nearest))
            }
            Across::Oblique => {
                let ((sin, cos), (sin_t, cos_t)) =
                    (self.turn.to_radians().sin_cos(), self.tilt.to_radians().sin_cos());
                let normal = [sin * cos_t, sin_t, cos * cos_t];
                let center = std::array::from_fn(|i| middle[i] + self.position * normal[i]);
                let plane = Plane::new(center, normal, 0.0, 1.0).map_err(|error| error.to_string())?;
                let side = pixels(extent.iter().fold(1.0, |a: f64, &b| a.max(b)));
                Ok((plane, [side; 2], Filter::Trilinear))
            }
        }
    }

    /// Widgets for all of it.
    pub fn controls(&mut self, ui: &mut Ui, body: &Body) {
        let names = [
            (Across::Axis(0), "x", "Across x: y to the right, z down"),
            (Across::Axis(1), "y", "Across y: x to the right, z down"),
            (Across::Axis(2), "z", "Across z: x to the right, y down"),
            (Across::Oblique, "Oblique", "Across any direction"),
        ];
        ui.label("Across");
        for (across, name, tip) in names {
            if ui.selectable_label(self.across == across, name).on_hover_text(tip).clicked() {
                self.across = across;
            }
        }
        let (low, high) = self.reach(body);
        self.position = self.position.clamp(low, high);
        toolbar::slider(ui, "Position", egui::Slider::new(&mut self.position, low..=high).step_by(1.0))
            .on_hover_text("Which layer of voxels; Shift and the wheel move it too");
        if self.across == Across::Oblique {
            toolbar::slider(
                ui,
                "Turn",
                egui::Slider::new(&mut self.turn, -180.0..=180.0).step_by(1.0).suffix("°"),
            )
            .on_hover_text("From z towards x");
            toolbar::slider(
                ui,
                "Tilt",
                egui::Slider::new(&mut self.tilt, -90.0..=90.0).step_by(1.0).suffix("°"),
            )
            .on_hover_text("Towards y");
        }
        if body.bounds.is_none() {
            toolbar::slider(ui, "Size", egui::Slider::new(&mut self.edge, 32..=2048).logarithmic(true))
                .on_hover_text("Pixels along a side; the solid has no end");
        }
    }

    /// The same where it shows the same: between two layers there is none.
    pub fn settled(&self) -> Self {
        match self.across {
            Across::Axis(_) => Self { position: self.position.round(), turn: 0.0, tilt: 0.0, ..*self },
            Across::Oblique => *self,
        }
    }

    /// Moves the plane by so many voxels.
    pub fn step(&mut self, by: f64, body: &Body) {
        let (low, high) = self.reach(body);
        self.position = (self.position + by).clamp(low, high);
    }
}

/// Finds a slice: coarse, then tile by tile.
///
/// # Errors
/// The solid's own.
pub fn sample(
    solid: &Arc<dyn Solid>,
    map: &str,
    (plane, size, filter): (Plane, [u32; 2], Filter),
    pieces: &Pieces<'_>,
) -> Result<(), String> {
    let longest = size[0].max(size[1]);
    for step in [16u32, 4].into_iter().filter(|step| longest / step >= 12) {
        let coarse = size.map(|n| n.div_ceil(step));
        let part = part(&plane, size, [0, 0], coarse.map(|n| n * step), f64::from(step));
        let image = slice(&**solid, &part, coarse, filter, map, pieces.control());
        let image = Arc::new(image.map_err(|error| error.to_string())?);
        pieces.send(Patch { at: [0, 0], size, step, image, first: [0, 0], channel: Channel::Color });
    }
    let mut tiles: Vec<[u32; 2]> = (0..size[1])
        .step_by(TILE as usize)
        .flat_map(|y| (0..size[0]).step_by(TILE as usize).map(move |x| [x, y]))
        .collect();
    let from_middle = |at: &[u32; 2]| -> u64 {
        (0..2).map(|i| u64::from((at[i] + TILE / 2).abs_diff(size[i] / 2)).pow(2)).sum()
    };
    tiles.sort_by_key(from_middle);
    for at in tiles {
        let tile = [TILE.min(size[0] - at[0]), TILE.min(size[1] - at[1])];
        let image = slice(&**solid, &part(&plane, size, at, tile, 1.0), tile, filter, map, pieces.control());
        let image = Arc::new(image.map_err(|error| error.to_string())?);
        pieces.send(Patch { at, size: tile, step: 1, image, first: [0, 0], channel: Channel::Color });
    }
    Ok(())
}

/// The plane of a rectangle of a picture, with pixels `step` times as large.
fn part(plane: &Plane, size: [u32; 2], at: [u32; 2], extent: [u32; 2], step: f64) -> Plane {
    let middle: [f64; 2] =
        std::array::from_fn(|i| f64::from(at[i]) + f64::from(extent[i]) / 2.0 - f64::from(size[i]) / 2.0);
    Plane {
        center: std::array::from_fn(|i| {
            plane.center[i] + (middle[0] * plane.right[i] + middle[1] * plane.down[i])
        }),
        right: plane.right.map(|c| c * step),
        down: plane.down.map(|c| c * step),
    }
}

#[cfg(test)]
mod tests {
    use breccia_nodes::solid::CheckerSolid;

    use super::*;

    #[test]
    fn tiles_are_the_slice_in_pieces() {
        let solid = CheckerSolid { colors: [[200, 30, 20], [10, 60, 220]], cell: 3, noise: 20, seed: 5 };
        let plane = Plane::new([20.0, 30.0, 5.5], [0.0, 0.0, 1.0], 0.0, 1.0).unwrap();
        let whole = slice(&solid, &plane, [50, 31], Filter::Nearest, "color", &()).unwrap();
        for (at, tile) in [([0, 0], [7, 9]), ([33, 20], [17, 11])] {
            let part = part(&plane, [50, 31], at, tile, 1.0);
            let image = slice(&solid, &part, tile, Filter::Nearest, "color", &()).unwrap();
            for (x, y) in [(0, 0), (tile[0] - 1, tile[1] - 1), (3, 4)] {
                assert_eq!(image.rgb8(x, y), whole.rgb8(at[0] + x, at[1] + y));
            }
        }
    }
}
