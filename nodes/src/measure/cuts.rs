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
