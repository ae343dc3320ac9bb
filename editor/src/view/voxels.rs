//! A set of voxels as something that can be looked at: labelled where the set is.

use std::sync::Arc;

use breccia_engine::{Data, Digest};
use breccia_nodes::control::{Control, check};
use breccia_nodes::data::{
    BRICK, BRICK_VOXELS, Extent, MapInfo, SampleType, Samples, Solid, SolidError, VoxelMap, VoxelSet, indices,
};

/// The colours of what is outside of the set and in it.
const COLORS: [[u8; 3]; 2] = [[40, 40, 46], [214, 190, 150]];

/// A set of voxels as a solid of the maps `color` and `label`: 1 in the set and 0 elsewhere.
pub struct SetSolid {
    set: Arc<VoxelSet>,
    bounds: ([i32; 3], [u32; 3]),
}

impl SetSolid {
    /// `None` if the set is empty.
    pub fn new(set: Arc<VoxelSet>) -> Option<Self> {
        let bricks = set.bricks();
        let first = *bricks.first()?;
        let fold = |pick: fn(i32, i32) -> i32| {
            bricks.iter().fold(first, |a, b| std::array::from_fn(|i| pick(a[i], b[i])))
        };
        let (low, high) = (fold(i32::min), fold(i32::max));
        let origin = low.map(|c| c.saturating_mul(BRICK));
        let size = std::array::from_fn(|i| {
            (high[i].abs_diff(low[i]).saturating_add(1)).saturating_mul(BRICK as u32)
        });
        Some(Self { set, bounds: (origin, size) })
    }
}

impl Solid for SetSolid {
    fn maps(&self) -> Vec<MapInfo> {
        vec![
            MapInfo { name: "color".to_owned(), channels: 3, ty: SampleType::U8 },
            MapInfo { name: "label".to_owned(), channels: 1, ty: SampleType::U32 },
        ]
    }

    fn extent(&self) -> Extent {
        Extent::Bounded(self.bounds.0, self.bounds.1)
    }

    fn evaluate(&self, voxels: &VoxelSet, control: &dyn Control) -> Result<VoxelMap, SolidError> {
        let bricks = voxels.bricks();
        let mut answer = VoxelMap::new(&bricks, &self.maps());
        for map in &mut answer.maps {
            match &mut map.samples {
                Samples::U8(colors) => colors.chunks_exact_mut(3).for_each(|c| c.copy_from_slice(&COLORS[0])),
                Samples::U32(_) | Samples::F32(_) => {}
            }
        }
        for (slot, &brick) in bricks.iter().enumerate() {
            check(control)?;
            let Some(mask) = self.set.mask(brick) else { continue };
            for at in indices(mask).map(|at| slot * BRICK_VOXELS + at) {
                for map in &mut answer.maps {
                    match &mut map.samples {
                        Samples::U8(colors) => {
                            if let Some(color) = colors.get_mut(3 * at..3 * at + 3) {
                                color.copy_from_slice(&COLORS[1]);
                            }
                        }
                        Samples::U32(labels) => {
                            if let Some(label) = labels.get_mut(at) {
                                *label = 1;
                            }
                        }
                        Samples::F32(_) => {}
                    }
                }
            }
        }
        Ok(answer)
    }

    fn digest(&self) -> Digest {
        self.set.digest()
    }

    fn summary(&self) -> String {
        self.set.summary()
    }

    fn byte_size(&self) -> u64 {
        self.set.byte_size()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voxels_of_the_set_are_labelled_and_no_others() {
        let set = VoxelSet::from_box([-3, 2, 5], [9, 4, 6]);
        let solid = SetSolid::new(Arc::new(set.clone())).unwrap();
        let Extent::Bounded(origin, size) = solid.extent() else { panic!("a set has bounds") };
        assert_eq!((origin, size), ([-8, 0, 0], [16, 8, 16]));
        let asked = VoxelSet::from_box(origin, size);
        let answer = solid.evaluate(&asked, &()).unwrap();
        let (color, label) = (answer.map("color").unwrap(), answer.map("label").unwrap());
        for voxel in asked.voxels() {
            let at = answer.index(voxel).unwrap();
            assert_eq!(label.samples.get(at) == 1.0, set.contains(voxel), "{voxel:?}");
            assert_eq!(color.samples.get_u8(3 * at), COLORS[usize::from(set.contains(voxel))][0]);
        }
        assert!(SetSolid::new(Arc::new(VoxelSet::new())).is_none());
    }
}
