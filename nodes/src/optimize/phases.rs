//! The order in which rows are updated: 64 phases by a hash of the row's place.

use crate::lazy::random::hash;

/// Phases of a sweep.
pub const PHASES: usize = 64;

/// The phase of a row of voxels along x.
pub fn phase(seed: u64, purpose: u32, y: usize, z: usize) -> usize {
    hash(seed, purpose, [0, y as i32, z as i32]) as usize % PHASES
}

/// Where a window's voxels lie, seen from a row: for each the start of its row, and the shift along x.
#[derive(Clone, Copy)]
pub struct Place {
    /// Index of the first voxel of the row.
    pub row: usize,
    /// Voxels further along x.
    pub shift: i32,
}

/// The place of a voxel `along` columns and `across` rows of a direction's exemplar away from those of row (y, z).
pub fn place(size: [usize; 3], direction: usize, y: usize, z: usize, along: i32, across: i32) -> Place {
    let mut at = [0, y as i32, z as i32];
    at[(direction + 1) % 3] += along;
    at[(direction + 2) % 3] += across;
    let [_, ny, nz] = size.map(|n| n as i32);
    let (y, z) = (at[1].rem_euclid(ny) as usize, at[2].rem_euclid(nz) as usize);
    Place { row: (z * size[1] + y) * size[0], shift: at[0] }
}

/// The farthest shift.
const REACH: i32 = 32;

/// Columns around the edges: where `x + shift` lies in a row that repeats.
pub struct Columns(Vec<u32>);

impl Columns {
    /// For rows of that many voxels.
    pub fn new(width: usize) -> Self {
        let n = width as i32;
        Self((-REACH..n + REACH).map(|x| x.rem_euclid(n) as u32).collect())
    }

    /// The index of a voxel of a place.
    #[inline(always)]
    pub fn at(&self, place: Place, x: usize) -> usize {
        place.row + self.0[(x as i32 + place.shift + REACH) as usize] as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_follow_the_cyclic_order_and_wrap() {
        let size = [5, 6, 7];
        let columns = Columns::new(5);
        let index = |x: usize, y: usize, z: usize| (z * 6 + y) * 5 + x;
        // Direction x: columns along y, rows along z.
        assert_eq!(columns.at(place(size, 0, 5, 0, 1, -1), 3), index(3, 0, 6));
        // Direction y: columns along z, rows along x.
        assert_eq!(columns.at(place(size, 1, 2, 6, 1, 3), 3), index(1, 2, 0));
        // Direction z: columns along x, rows along y.
        assert_eq!(columns.at(place(size, 2, 0, 3, -4, -1), 2), index(3, 5, 3));
    }

    #[test]
    fn every_phase_has_rows() {
        let mut counts = [0; PHASES];
        (0..64).for_each(|z| (0..64).for_each(|y| counts[phase(1, 7, y, z)] += 1));
        assert!(counts.iter().all(|&n| (30..110).contains(&n)), "{counts:?}");
    }
}
