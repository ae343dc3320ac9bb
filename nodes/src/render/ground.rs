//! The shadow that an object casts on the ground it stands on.

use rayon::prelude::*;

use super::Camera;
use super::light::Lights;
use super::vector::{Vec3, add, scale};
use crate::control::{Cancelled, Control, check};

/// Cells along the edge of the grid.
const CELLS: usize = 288;
/// Half the edge of the grid, in radii of the object.
const REACH: f64 = 3.6;
/// How far the room's part is smoothed, in cells: its beams are few and would leave the outlines of as
/// many shadows.
const BLUR: usize = 3;

/// The shadow on the ground, on a grid.
pub(super) struct Ground {
    height: f64,
    center: [f64; 2],
    radius: f64,
    shadow: Vec<f64>,
}

impl Ground {
    /// The shadow of an object within a sphere on the ground at that height.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        lights: &Lights,
        (center, radius): (Vec3, f64),
        height: f64,
        control: &dyn Control,
    ) -> Result<Self, Cancelled> {
        let mut ground = Self { height, center: [center[0], center[2]], radius, shadow: Vec::new() };
        let rows = (0..CELLS).into_par_iter().map(|row| {
            check(control)?;
            Ok((0..CELLS).map(|column| lights.kept_away(ground.point(column, row))).collect::<Vec<_>>())
        });
        let cells = rows.collect::<Result<Vec<_>, Cancelled>>()?.concat();
        let mut room: Vec<f64> = cells.iter().map(|&[room, _]| room).collect();
        for _ in 0..3 {
            room = transposed(&smoothed_rows(&transposed(&smoothed_rows(&room))));
        }
        ground.shadow =
            room.iter().zip(&cells).map(|(room, [_, key])| (room + key).clamp(0.0, 1.0)).collect();
        Ok(ground)
    }

    /// The middle of a cell.
    fn point(&self, column: usize, row: usize) -> Vec3 {
        let place = |cell: usize| ((cell as f64 + 0.5) / CELLS as f64 * 2.0 - 1.0) * REACH * self.radius;
        [self.center[0] + place(column), self.height, self.center[1] + place(row)]
    }

    /// The shadow that is seen at a place of the picture, 0 to 1, fading out far from the object.
    pub fn seen(&self, camera: &Camera, x: f64, y: f64) -> f64 {
        let (eye, ray) = (camera.eye(), camera.ray(x, y));
        let t = (self.height - eye[1]) / ray[1];
        if !(t > 0.0 && t.is_finite()) {
            return 0.0;
        }
        let point = add(eye, scale(ray, t));
        let (dx, dz) = ((point[0] - self.center[0]) / self.radius, (point[2] - self.center[1]) / self.radius);
        let fade = 1.0 - ((dx * dx + dz * dz).sqrt() - 1.4).clamp(0.0, 2.0) / 2.0;
        let cell = |d: f64| (d / REACH + 1.0) / 2.0 * CELLS as f64 - 0.5;
        let (x, y) = (cell(dx), cell(dz));
        let last = (CELLS - 1) as f64;
        if fade <= 0.0 || !(0.0..last).contains(&x) || !(0.0..last).contains(&y) {
            return 0.0;
        }
        let (column, row, fx, fy) = (x as usize, y as usize, x.fract(), y.fract());
        let get =
            |i: usize, j: usize| self.shadow.get((row + j) * CELLS + column + i).copied().unwrap_or(0.0);
        let above = get(0, 0) * (1.0 - fx) + get(1, 0) * fx;
        let below = get(0, 1) * (1.0 - fx) + get(1, 1) * fx;
        (above * (1.0 - fy) + below * fy) * fade * fade
    }
}

/// Each cell the mean of its neighbours within `BLUR` along the row.
fn smoothed_rows(cells: &[f64]) -> Vec<f64> {
    let mean = |row: &[f64], at: usize| {
        let near = at.saturating_sub(BLUR)..(at + BLUR + 1).min(row.len());
        let count = near.len() as f64;
        row[near].iter().sum::<f64>() / count
    };
    cells.chunks(CELLS).flat_map(|row| (0..row.len()).map(move |at| mean(row, at))).collect()
}

fn transposed(cells: &[f64]) -> Vec<f64> {
    (0..CELLS).flat_map(|column| cells.iter().skip(column).step_by(CELLS).copied()).collect()
}
