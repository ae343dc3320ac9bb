//! Slices of a volume: across the axes, and oblique ones of random directions.

use super::random::Random;
use super::views::{Pixels, Voxels};
use crate::control::{Cancelled, Control, check};
use crate::solid::Plane;

/// A direction closer to an axis than this cosine is not oblique.
const ALMOST: f64 = 0.94;

/// Slices through a box of voxels.
pub(super) struct Cuts {
    /// Whole slices across x, y and z.
    pub axis: [Vec<Pixels>; 3],
    /// Squares of random direction, place and rotation within the box, of the nearest voxels.
    pub oblique: Vec<Pixels>,
}

/// The edge of oblique squares in a box with this shortest edge. Half a diagonal is at most 0.4 of it, so that a square
/// of any direction fits in the middle.
pub(super) fn oblique_edge(shortest: usize) -> usize {
    shortest * 9 / 16
}

impl Cuts {
    /// `slices` across each axis, spread over it (all of a shorter axis), and three times as many oblique ones.
    pub fn new(
        voxels: &Voxels,
        slices: usize,
        random: Random,
        control: &dyn Control,
    ) -> Result<Self, Cancelled> {
        let mut axis = [const { Vec::new() }; 3];
        for (across, cuts) in axis.iter_mut().enumerate() {
            let n = voxels.size[across];
            let count = slices.clamp(1, n.max(1));
            for i in 0..count {
                check(control)?;
                let at = (i * n + random.below(n, [10, across as u64, i as u64])) / count;
                cuts.push(voxels.slice(across, at));
            }
        }
        let shortest = voxels.size.into_iter().min().unwrap_or(0);
        let mut oblique = Vec::new();
        for i in 0..3 * slices.clamp(1, shortest.max(1)) {
            check(control)?;
            let plane = oblique_plane(voxels.size, oblique_edge(shortest), random, i as u64);
            oblique.extend(plane.map(|plane| cut(voxels, &plane)));
        }
        Ok(Self { axis, oblique })
    }
}

/// A plane of random direction, rotation and place, whose square of this edge stays within the box.
pub(super) fn oblique_plane(size: [usize; 3], edge: usize, random: Random, index: u64) -> Option<Plane> {
    let normal = (0..64u64).map(|attempt| {
        let number = |k| random.fraction([41, index, 4 * attempt + k]);
        let z = 2.0 * number(0) - 1.0;
        let (sin, cos) = libm::sincos(2.0 * std::f64::consts::PI * number(1));
        let flat = libm::sqrt(1.0 - z * z);
        [flat * cos, flat * sin, z]
    });
    let normal = normal.into_iter().find(|n| n.iter().all(|c| c.abs() < ALMOST))?;
    let margin = edge as f64 * std::f64::consts::FRAC_1_SQRT_2;
    let center = std::array::from_fn(|c| {
        let room = (size[c] as f64 - 2.0 * margin).max(0.0);
        margin + room * random.fraction([42, index, c as u64])
    });
    Plane::new(center, normal, 360.0 * random.fraction([43, index, 0]), 1.0).ok()
}

/// The square of the nearest voxels.
fn cut(voxels: &Voxels, plane: &Plane) -> Pixels {
    let edge = oblique_edge(voxels.size.into_iter().min().unwrap_or(0));
    let pixel = |i: usize| {
        let point = plane.point([edge as u32; 2], (i % edge) as u32, (i / edge) as u32);
        voxels.get(std::array::from_fn(|c| (point[c].max(0.0) as usize).min(voxels.size[c] - 1)))
    };
    Pixels { width: edge, height: edge, data: (0..edge * edge).map(pixel).collect() }
}

/// The slices through the middle across x, y and z, and squares across three oblique directions.
pub(super) fn middle_cuts(voxels: &Voxels) -> Vec<Pixels> {
    let slices = (0..3).map(|axis| voxels.slice(axis, voxels.size[axis] / 2));
    let middle = voxels.size.map(|n| n as f64 / 2.0);
    let normals = [[1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 2.0, -1.0]].into_iter();
    let planes = normals.filter_map(|normal| Plane::new(middle, normal, 0.0, 1.0).ok());
    slices.chain(planes.map(|plane| cut(voxels, &plane))).collect()
}

/// Squares of a picture at random places and angles, of the nearest pixels: what rotation alone does to it. A square of `edge`
/// pixels must fit into `area` (x, y, width, height) at any angle.
pub(super) fn turned_squares(
    picture: &Pixels,
    areas: &[[usize; 4]],
    edge: usize,
    count: usize,
    (random, key): (Random, u64),
) -> Vec<Pixels> {
    let half = edge as f64 * std::f64::consts::FRAC_1_SQRT_2;
    let square = |i: usize| {
        let number = |k| random.fraction([44 + key, i as u64, k]);
        let [x, y, w, h] = areas[random.below(areas.len().max(1), [44 + key, i as u64, 3])];
        let center = [[x, w], [y, h]].map(|[from, n]| (from as f64 + half, (n as f64 - 2.0 * half).max(0.0)));
        let center = [center[0].0 + center[0].1 * number(0), center[1].0 + center[1].1 * number(1)];
        let (sin, cos) = libm::sincos(2.0 * std::f64::consts::PI * number(2));
        let pixel = |k: usize| {
            let [u, v] = [k % edge, k / edge].map(|c| c as f64 + 0.5 - edge as f64 / 2.0);
            let (column, row) = (center[0] + u * cos - v * sin, center[1] + u * sin + v * cos);
            let inside = |at: f64, from: usize, n: usize| (at.max(0.0) as usize).clamp(from, from + n - 1);
            picture.get(inside(column, x, w), inside(row, y, h))
        };
        Pixels { width: edge, height: edge, data: (0..edge * edge).map(pixel).collect() }
    };
    (0..if areas.is_empty() { 0 } else { count }).map(square).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oblique_squares_stay_inside_and_turn_every_way() {
        let size = [40, 32, 64];
        let edge = oblique_edge(32) as u32;
        let mut tilts = [0.0f64; 3];
        for i in 0..200 {
            let plane = oblique_plane(size, edge as usize, Random(1), i).unwrap();
            for (c, r) in [(0, 0), (edge - 1, 0), (0, edge - 1), (edge - 1, edge - 1)] {
                let point = plane.point([edge; 2], c, r);
                assert!(point.iter().zip(size).all(|(p, n)| (0.0..n as f64).contains(p)), "{point:?}");
            }
            (0..3).for_each(|c| tilts[c] += plane.right[c].powi(2) / 200.0);
        }
        assert!(tilts.iter().all(|t| (t - 1.0 / 3.0).abs() < 0.08), "{tilts:?}");
    }

    #[test]
    fn turned_squares_stay_in_their_areas() {
        let data = (0..40 * 30).map(|i| [(i % 40) as u8, (i / 40) as u8, 0]).collect();
        let picture = Pixels { width: 40, height: 30, data };
        let squares = turned_squares(&picture, &[[20, 15, 20, 15]], 10, 50, (Random(1), 0));
        let pixels = squares.iter().flat_map(|square| &square.data);
        assert!(pixels.clone().all(|[x, y, _]| *x >= 20 && *y >= 15) && pixels.count() == 5000);
        // Steps are as long as a pixel on average.
        let steps = squares.iter().map(|s| {
            let [a, b] = [s.get(0, 0), s.get(9, 0)].map(|p| [f64::from(p[0]), f64::from(p[1])]);
            libm::hypot(a[0] - b[0], a[1] - b[1]) / 9.0
        });
        assert!((steps.sum::<f64>() / 50.0 - 1.0).abs() < 0.05);
    }

    #[test]
    fn slices_show_their_voxels() {
        let size = [5, 16, 17];
        let data = (0..size.iter().product()).map(|i: usize| [i as u8, (i >> 8) as u8, 0]).collect();
        let cuts = Cuts::new(&Voxels { size, data }, 8, Random(2), &()).unwrap();
        assert_eq!([0, 1, 2].map(|a| cuts.axis[a].len()), [5, 8, 8]);
        assert_eq!((cuts.axis[2][0].width, cuts.axis[2][0].height), (5, 16));
        assert_eq!((cuts.axis[0][0].width, cuts.axis[0][0].height), (16, 17));
        assert_eq!(cuts.oblique.len(), 15);
    }
}
