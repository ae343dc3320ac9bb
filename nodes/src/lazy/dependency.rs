//! Which voxels a request depends on, backwards through sub-passes, passes and levels (Dong et al. 2008,
//! section 5.2).

use rayon::prelude::*;
use rustc_hash::FxHashSet;

use super::domain::Domain;
use super::schedule::Settings;
use crate::data::VoxelSet;

/// What one level must compute for a request.
pub struct Dependency {
    /// Voxels that must be there before the first sub-pass.
    pub before: VoxelSet,
    /// For each sub-pass in the order of time, the voxels it must correct.
    pub corrected: Vec<VoxelSet>,
}

/// What a level must compute so that `wanted` (wrapped already) is known after its last sub-pass.
pub fn dependency(settings: &Settings, domain: &Domain, level: usize, wanted: &VoxelSet) -> Dependency {
    match dependency_among(settings, domain, level, wanted, Ok::<_, std::convert::Infallible>) {
        Ok(found) => found,
        Err(never) => match never {},
    }
}

/// As [`dependency`], where `free` leaves of a set of voxels those that are corrected at all.
pub(super) fn dependency_among<E>(
    settings: &Settings,
    domain: &Domain,
    level: usize,
    wanted: &VoxelSet,
    mut free: impl FnMut(VoxelSet) -> Result<VoxelSet, E>,
) -> Result<Dependency, E> {
    let mut needed = wanted.clone();
    let mut corrected = Vec::new();
    for subset in settings.steps(level).iter().rev() {
        let mut step = VoxelSet::new();
        for brick in needed.bricks() {
            if let Some(mask) = needed.mask(brick) {
                step.insert_mask(brick, &std::array::from_fn(|z| mask[z] & subset[z]));
            }
        }
        let step = free(step)?;
        needed.union(&dilate(&step, domain));
        corrected.push(step);
    }
    corrected.reverse();
    Ok(Dependency { before: needed, corrected })
}

/// The voxels of the next coarser level that a set of voxels descends from.
pub(super) fn parents(set: &VoxelSet) -> VoxelSet {
    let mut out = VoxelSet::new();
    for brick in set.bricks() {
        let Some(mask) = set.mask(brick) else { continue };
        let mut coarse = [0u64; 8];
        for (z, word) in mask.iter().enumerate() {
            // Any child of a pair along x, then along y.
            let x = (word | word >> 1) & 0x5555_5555_5555_5555;
            let xy = (x | x >> 8) & 0x0055_0055_0055_0055;
            let target = (brick[2] & 1) as usize * 4 + z / 2;
            for y in 0..4 {
                let row = xy >> (16 * y) & 0x55;
                let packed = (row & 1) | (row >> 1 & 2) | (row >> 2 & 4) | (row >> 3 & 8);
                coarse[target] |= packed << ((brick[0] & 1) * 4 + (y + 4 * (brick[1] & 1)) * 8);
            }
        }
        out.insert_mask(brick.map(|b| b >> 1), &coarse);
    }
    out
}

/// The set grown by the crossbar: three orthogonal squares of 5 × 5 voxels, 61 in all.
pub(super) fn dilate(set: &VoxelSet, domain: &Domain) -> VoxelSet {
    let mut bricks: FxHashSet<[i32; 3]> = FxHashSet::default();
    let aligned = domain.aligned();
    for brick in set.bricks() {
        for d in 0..27 {
            let near = [brick[0] + d % 3 - 1, brick[1] + d / 3 % 3 - 1, brick[2] + d / 9 - 1];
            if aligned {
                bricks.insert(match domain.period {
                    Some(period) => std::array::from_fn(|i| near[i].rem_euclid(period[i] / 8)),
                    None => near,
                });
            } else {
                // A brick cut by the period's end reaches one brick further around it.
                for corner in 0..8 {
                    let voxel: [i32; 3] =
                        std::array::from_fn(|i| domain.wrap(i, near[i] * 8 + 7 * (corner >> i & 1)));
                    bricks.insert(voxel.map(|c| c >> 3));
                }
            }
        }
    }
    let mut bricks: Vec<_> = bricks.into_iter().collect();
    bricks.sort_unstable();
    let masks: Vec<_> = bricks.par_iter().map(|&brick| dilated_brick(set, domain, brick)).collect();
    let mut out = VoxelSet::new();
    bricks.iter().zip(&masks).for_each(|(&brick, mask)| out.insert_mask(brick, mask));
    out
}

/// One brick of the grown set, from the rows of twelve voxels around it.
fn dilated_brick(set: &VoxelSet, domain: &Domain, brick: [i32; 3]) -> [u64; 8] {
    let rows = window(set, domain, brick);
    let spread = |row: u16| row | row << 1 | row << 2 | row >> 1 | row >> 2;
    let mut wide = [[0u16; 12]; 12];
    for (wide, rows) in wide.iter_mut().zip(&rows) {
        for (w, &row) in wide.iter_mut().zip(rows) {
            *w = spread(row);
        }
    }
    let mut mask = [0u64; 8];
    for z in 0..8 {
        for y in 0..8 {
            let mut row = 0u16;
            for d in 0..5 {
                row |= wide[z + 2][y + d] | wide[z + d][y + 2];
                for e in 0..5 {
                    row |= rows[z + d][y + e];
                }
            }
            mask[z] |= u64::from(row >> 2 & 0xff) << (8 * y);
        }
    }
    if let Some(period) = domain.period {
        clip(&mut mask, brick, period);
    }
    mask
}

/// Drops the voxels of a brick that lie beyond the period.
fn clip(mask: &mut [u64; 8], brick: [i32; 3], period: [i32; 3]) {
    let left: [i32; 3] = std::array::from_fn(|i| (period[i] - brick[i] * 8).clamp(0, 8));
    if left == [8; 3] {
        return;
    }
    for (z, word) in mask.iter_mut().enumerate() {
        let row = (1u64 << left[0]) - 1;
        let layer = (0..left[1]).fold(0u64, |bits, y| bits | row << (8 * y));
        *word &= if (z as i32) < left[2] { layer } else { 0 };
    }
}

/// Bits of the 12³ voxels around a brick: `[z][y]`, bit x; two voxels beyond the brick on each side.
fn window(set: &VoxelSet, domain: &Domain, brick: [i32; 3]) -> [[u16; 12]; 12] {
    let mut rows = [[0u16; 12]; 12];
    let at = |axis: usize, i: usize| domain.wrap(axis, brick[axis] * 8 + i as i32 - 2);
    if domain.aligned() {
        let columns = [at(0, 0) >> 3, at(0, 2) >> 3, at(0, 11) >> 3];
        for (z, layer) in rows.iter_mut().enumerate() {
            let vz = at(2, z);
            for (y, row) in layer.iter_mut().enumerate() {
                let vy = at(1, y);
                let byte = |bx: i32| match set.mask([bx, vy >> 3, vz >> 3]) {
                    Some(mask) => (mask[(vz & 7) as usize] >> (8 * (vy & 7)) & 0xff) as u16,
                    None => 0,
                };
                *row = byte(columns[0]) >> 6 | byte(columns[1]) << 2 | (byte(columns[2]) & 3) << 10;
            }
        }
    } else {
        for (z, layer) in rows.iter_mut().enumerate() {
            for (y, row) in layer.iter_mut().enumerate() {
                for x in 0..12 {
                    *row |= u16::from(set.contains([at(0, x), at(1, y), at(2, z)])) << x;
                }
            }
        }
    }
    rows
}
