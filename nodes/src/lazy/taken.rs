//! Voxels that another solid has, so that a synthesis need not compute them (Du et al. 2013, section 3.3).

use std::sync::Arc;

use crate::control::Control;
use crate::data::{BRICK_VOXELS, Solid, SolidError, VoxelSet, indices};

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
        let missing = set.difference(&self.known);
        if !missing.is_empty() {
            let answer = self.taken.0.evaluate(&missing, self.control)?;
            for brick in missing.bricks() {
                let (Some(mask), Some(slot)) = (missing.mask(brick), answer.slot(brick)) else { continue };
                let mut free = *mask;
                if let Some(map) = answer.map("color") {
                    let white =
                        |at: usize| map.samples.get_u8((slot * BRICK_VOXELS + at) * map.channels) > 127;
                    indices(mask).filter(|&at| white(at)).for_each(|at| free[at >> 6] &= !(1 << (at & 63)));
                }
                self.free.insert_mask(brick, &free);
            }
            self.known.union(&missing);
        }
        Ok(set.intersection(&self.free))
    }
}
