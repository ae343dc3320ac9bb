//! Voxels that another solid has, so that a synthesis need not compute them (Du et al. 2013, section 3.3).

use std::sync::Arc;

use crate::control::Control;
use crate::data::{BRICK_VOXELS, Samples, Solid, SolidError, VoxelSet};

/// A solid that is white where voxels are taken.
pub(super) struct Taken(pub Arc<dyn Solid>);

/// Which voxels are free, as far as somebody asked within one request.
pub(super) struct Free<'a> {
    taken: &'a Taken,
    control: &'a dyn Control,
    known: VoxelSet,
    /// The free ones among the known.
    pub free: VoxelSet,
}

impl Taken {
    /// Nothing known yet.
    pub fn free<'a>(&'a self, control: &'a dyn Control) -> Free<'a> {
        Free { taken: self, control, known: VoxelSet::new(), free: VoxelSet::new() }
    }
}

impl Free<'_> {
    /// The free voxels of a set.
    pub fn of(&mut self, set: &VoxelSet) -> Result<VoxelSet, SolidError> {
        let mut missing = VoxelSet::new();
        for brick in set.bricks() {
            let known = self.known.mask(brick).copied().unwrap_or_default();
            let mask = set.mask(brick).copied().unwrap_or_default();
            missing.insert_mask(brick, &std::array::from_fn(|z| mask[z] & !known[z]));
        }
        if !missing.is_empty() {
            let answer = self.taken.0.evaluate(&missing, self.control)?;
            for brick in missing.bricks() {
                let (Some(mask), Some(slot)) = (missing.mask(brick), answer.slot(brick)) else { continue };
                let mut free = *mask;
                if let Some(map) = answer.map("color") {
                    for at in 0..BRICK_VOXELS {
                        let first = (slot * BRICK_VOXELS + at) * map.channels;
                        let white = match &map.samples {
                            Samples::U8(v) => v[first] > 127,
                            other => other.get_u8(first) > 127,
                        };
                        if white {
                            free[at >> 6] &= !(1 << (at & 63));
                        }
                    }
                }
                self.free.insert_mask(brick, &free);
            }
            self.known.union(&missing);
        }
        let mut found = VoxelSet::new();
        for brick in set.bricks() {
            let free = self.free.mask(brick).copied().unwrap_or_default();
            let mask = set.mask(brick).copied().unwrap_or_default();
            found.insert_mask(brick, &std::array::from_fn(|z| mask[z] & free[z]));
        }
        Ok(found)
    }
}
