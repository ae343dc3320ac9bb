//! The lattice of a level: unbounded, or repeating with a period.

use crate::data::VoxelSet;

/// The lattice of one level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Domain {
    /// The period along x, y and z in voxels of this level.
    pub period: Option<[i32; 3]>,
}

impl Domain {
    /// The lattice of a level whose finest level has this period. Periods halve upwards, rounded up.
    pub fn at_level(period: Option<[u32; 3]>, level: usize) -> Self {
        Self { period: period.map(|p| p.map(|n| (n.div_ceil(1 << level)) as i32)) }
    }

    /// The representative of a coordinate along an axis.
    #[inline(always)]
    pub fn wrap(&self, axis: usize, c: i32) -> i32 {
        match self.period {
            Some(period) => c.rem_euclid(period[axis]),
            None => c,
        }
    }

    /// Whether bricks repeat as wholes, so that a wrapped row of a brick is a row of one brick.
    pub fn aligned(&self) -> bool {
        self.period.is_none_or(|p| p.iter().all(|n| n % 8 == 0))
    }

    /// The set with every voxel replaced by its representative.
    pub fn wrap_set(&self, set: &VoxelSet) -> VoxelSet {
        let Some(period) = self.period else { return set.clone() };
        let mut out = VoxelSet::new();
        if self.aligned() {
            for brick in set.bricks() {
                let wrapped = std::array::from_fn(|i| brick[i].rem_euclid(period[i] / 8));
                set.mask(brick).into_iter().for_each(|mask| out.insert_mask(wrapped, mask));
            }
        } else {
            set.voxels().for_each(|v| out.insert(std::array::from_fn(|i| self.wrap(i, v[i]))));
        }
        out
    }
}
