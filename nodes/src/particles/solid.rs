//! Particles in a matrix, as a solid: particles answer for their voxels, another solid for the rest.

use std::sync::Arc;

use breccia_engine::{Data, Digest};
use rayon::prelude::*;

use super::index::Index;
use super::packing::Packing;
use super::palette;
use crate::control::{Cancelled, Control, check};
use crate::data::{
    BRICK_VOXELS, Extent, Map, MapInfo, SampleType, Samples, Solid, SolidError, VoxelMap, VoxelSet, indices,
};

/// How particles look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// As the pictures show them.
    Pictures,
    /// Each in a colour of its own.
    Ids,
    /// White, and the matrix black: a mask.
    Mask,
}

/// The name of the map that says which particle a voxel belongs to: 0 the matrix, 1 the first.
pub const LABEL: &str = "label";

/// Particles in a matrix.
pub struct ParticleSolid {
    packing: Arc<Packing>,
    index: Arc<Index>,
    matrix: Option<Arc<dyn Solid>>,
    look: Look,
    label: bool,
    digest: Digest,
}

impl ParticleSolid {
    /// A solid of a packing's particles. Without a matrix the rest is black. With `label` there is a map of that name.
    pub fn new(packing: Arc<Packing>, matrix: Option<Arc<dyn Solid>>, look: Look, label: bool) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"particles").update(&packing.digest().0).update(&[look as u8, label.into()]);
        if let Some(matrix) = &matrix {
            hasher.update(&matrix.digest().0);
        }
        let index = Arc::new(Index::new(&packing));
        Self { packing, index, matrix, look, label, digest: hasher.finalize().into() }
    }

    /// The packing.
    pub fn packing(&self) -> &Arc<Packing> {
        &self.packing
    }

    /// The voxels of a set that lie in the matrix.
    pub fn matrix_voxels(&self, voxels: &VoxelSet) -> VoxelSet {
        let bricks = voxels.bricks();
        let masks: Vec<[u64; 8]> = bricks
            .par_iter()
            .map(|&brick| {
                let labels = self.index.label_brick(&self.packing, brick);
                matrix_mask(&labels, voxels.mask(brick).unwrap_or(&[0; 8]))
            })
            .collect();
        let mut set = VoxelSet::new();
        bricks.iter().zip(&masks).for_each(|(&brick, mask)| set.insert_mask(brick, mask));
        set
    }

    /// Fills one brick of every map where particles are; returns the wanted voxels of the matrix.
    fn fill(&self, brick: [i32; 3], wanted: &[u64; 8], maps: &mut [(&MapInfo, &mut [u8])]) -> [u64; 8] {
        let labels = self.index.label_brick(&self.packing, brick);
        let set = &self.packing.set;
        for (at, &(label, voxel)) in labels.iter().enumerate() {
            if label == 0 || wanted[at >> 6] >> (at & 63) & 1 == 0 {
                continue;
            }
            let placed = &self.packing.placed[label as usize - 1];
            let mut source = None;
            for (info, bytes) in maps.iter_mut() {
                let item = info.channels * info.ty.byte_size();
                let to = &mut bytes[at * item..][..item];
                if info.name == LABEL {
                    to.copy_from_slice(&label.to_ne_bytes());
                } else if info.name == "color" && self.look != Look::Pictures {
                    to.copy_from_slice(&if self.look == Look::Ids { palette(label) } else { [255; 3] });
                } else {
                    let source = *source.get_or_insert_with(|| self.packing.source(placed, voxel));
                    let Some((view, pixel)) = set.shown(source) else { continue };
                    if let Some((_, image)) = view.carried.iter().find(|(name, _)| *name == info.name) {
                        to.copy_from_slice(&image.samples().bytes()[pixel * item..][..item]);
                    }
                }
            }
        }
        matrix_mask(&labels, wanted)
    }
}

/// The wanted voxels of a brick that no particle has.
fn matrix_mask(labels: &[(u32, [i32; 3])], wanted: &[u64; 8]) -> [u64; 8] {
    let mut mask = [0u64; 8];
    for (at, (label, _)) in labels.iter().enumerate() {
        mask[at >> 6] |= u64::from(*label == 0) << (at & 63);
    }
    std::array::from_fn(|z| mask[z] & wanted[z])
}

impl Solid for ParticleSolid {
    fn maps(&self) -> Vec<MapInfo> {
        let color = MapInfo { name: "color".to_owned(), channels: 3, ty: SampleType::U8 };
        let mut maps = match self.look {
            Look::Pictures => self.packing.set.maps(),
            Look::Ids | Look::Mask => vec![color],
        };
        if self.label {
            maps.push(MapInfo { name: LABEL.to_owned(), channels: 1, ty: SampleType::U32 });
        }
        maps
    }

    fn extent(&self) -> Extent {
        if !self.packing.wrap {
            return Extent::Bounded([0; 3], self.packing.size);
        }
        // The whole repeats if the matrix does so at least as often.
        let divides =
            |period: [u32; 3]| (0..3).all(|a| self.packing.size[a].is_multiple_of(period[a].max(1)));
        match self.matrix.as_ref().map(|matrix| matrix.extent()) {
            None => Extent::Periodic(self.packing.size),
            Some(Extent::Periodic(period)) if divides(period) => Extent::Periodic(self.packing.size),
            Some(_) => Extent::Unbounded,
        }
    }

    fn evaluate(&self, voxels: &VoxelSet, control: &dyn Control) -> Result<VoxelMap, SolidError> {
        let infos = self.maps();
        let bricks = voxels.bricks();
        let mut answer = VoxelMap::new(&bricks, &infos);
        let items: Vec<usize> = infos.iter().map(|i| i.channels * i.ty.byte_size() * BRICK_VOXELS).collect();
        // For each brick, its piece of every map.
        let mut pieces: Vec<Vec<(&MapInfo, &mut [u8])>> = bricks.iter().map(|_| Vec::new()).collect();
        for ((map, info), item) in answer.maps.iter_mut().zip(&infos).zip(&items) {
            for (pieces, bytes) in pieces.iter_mut().zip(map.samples.bytes_mut().chunks_mut(*item)) {
                pieces.push((info, bytes));
            }
        }
        let masks: Vec<[u64; 8]> = pieces
            .par_iter_mut()
            .zip(&bricks)
            .map(|(maps, &brick)| {
                check(control)?;
                Ok(self.fill(brick, voxels.mask(brick).unwrap_or(&[0; 8]), maps))
            })
            .collect::<Result<_, Cancelled>>()?;
        let Some(matrix) = &self.matrix else { return Ok(answer) };
        let mut set = VoxelSet::new();
        bricks.iter().zip(&masks).for_each(|(&brick, mask)| set.insert_mask(brick, mask));
        if set.is_empty() || self.look == Look::Mask {
            return Ok(answer);
        }
        let rest = matrix.evaluate(&set, control)?;
        for map in &mut answer.maps {
            let from = rest.map(&map.name).filter(|from| from.info() == map.info());
            for (slot, (&brick, mask)) in bricks.iter().zip(&masks).enumerate() {
                copy_masked(map, slot, from.zip(rest.slot(brick)), mask);
            }
        }
        Ok(answer)
    }

    fn digest(&self) -> Digest {
        self.digest
    }

    fn summary(&self) -> String {
        let matrix = self.matrix.as_ref().map_or_else(|| "nothing".to_owned(), |matrix| matrix.summary());
        format!("{} in a matrix of {matrix}", self.packing.summary())
    }

    fn byte_size(&self) -> u64 {
        self.packing.byte_size() + self.index.byte_size() + self.matrix.as_ref().map_or(0, |m| m.byte_size())
    }
}

/// Copies the voxels of a mask from a brick of another answer. What the matrix has no map for is zero, but for normals, which
/// then point straight out.
pub(super) fn copy_masked(to: &mut Map, slot: usize, from: Option<(&Map, usize)>, mask: &[u64; 8]) {
    let n = to.channels;
    let flat = to.name == "normal" && n == 3;
    for at in indices(mask) {
        let place = (slot * BRICK_VOXELS + at) * n;
        match (from, &mut to.samples) {
            (Some((map, other)), samples) => {
                samples.copy_from(place, &map.samples, (other * BRICK_VOXELS + at) * n, n)
            }
            (None, Samples::U8(v)) if flat => v[place..place + 3].copy_from_slice(&[128, 128, 255]),
            _ => {}
        }
    }
}
