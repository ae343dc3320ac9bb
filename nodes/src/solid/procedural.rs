//! Solids that a formula answers, in integers: one colour, and a checkerboard with hashed shades.

use breccia_engine::Digest;
use rayon::prelude::*;

use crate::control::{Cancelled, Control, check};
use crate::data::{
    BRICK_VOXELS, Extent, MapInfo, SampleType, Samples, Solid, SolidError, VoxelMap, VoxelSet, voxel_at,
};

/// The maps of a solid that has nothing but colours.
fn color_only() -> Vec<MapInfo> {
    vec![MapInfo { name: "color".to_owned(), channels: 3, ty: SampleType::U8 }]
}

/// Answers the colours of whole bricks by a function of the voxel, in parallel.
///
/// # Errors
/// [`SolidError::Cancelled`] if `control` asks for it.
pub fn evaluate_by(
    voxels: &VoxelSet,
    control: &dyn Control,
    color: impl Fn([i32; 3]) -> [u8; 3] + Sync,
) -> Result<VoxelMap, SolidError> {
    let bricks = voxels.bricks();
    let mut answer = VoxelMap::new(&bricks, &color_only());
    let Some(Samples::U8(samples)) = answer.maps.first_mut().map(|map| &mut map.samples) else {
        return Ok(answer);
    };
    let filled: Result<(), Cancelled> =
        samples.par_chunks_mut(BRICK_VOXELS * 3).zip(&bricks).try_for_each(|(to, brick)| {
            check(control)?;
            for (at, rgb) in to.chunks_exact_mut(3).enumerate() {
                rgb.copy_from_slice(&color(voxel_at(*brick, at)));
            }
            Ok(())
        });
    filled?;
    Ok(answer)
}

/// One colour everywhere: a plain matrix for other things to lie in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConstantSolid {
    /// The colour, in sRGB encoding.
    pub color: [u8; 3],
}

impl Solid for ConstantSolid {
    fn maps(&self) -> Vec<MapInfo> {
        color_only()
    }

    fn extent(&self) -> Extent {
        Extent::Periodic([1; 3])
    }

    fn evaluate(&self, voxels: &VoxelSet, control: &dyn Control) -> Result<VoxelMap, SolidError> {
        evaluate_by(voxels, control, |_| self.color)
    }

    fn digest(&self) -> Digest {
        let [r, g, b] = self.color;
        Digest::of(&[b'c', r, g, b])
    }

    fn summary(&self) -> String {
        let [r, g, b] = self.color;
        format!("one colour, {r} {g} {b}")
    }

    fn byte_size(&self) -> u64 {
        3
    }
}

/// Cells of two colours in turn along all axes, each cell and each voxel a little lighter or darker by a
/// hash of its place: enough structure to see faces, cuts and seams by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CheckerSolid {
    /// The two colours, in sRGB encoding.
    pub colors: [[u8; 3]; 2],
    /// Voxels along a cell's edge, at least 1.
    pub cell: u32,
    /// The largest deviation of a cell's shade, and the same again of a voxel's, in grey levels.
    pub noise: u8,
    /// Selects the hash.
    pub seed: u64,
}

impl CheckerSolid {
    /// The colour of a voxel.
    pub fn color(&self, voxel: [i32; 3]) -> [u8; 3] {
        let cell = voxel.map(|c| i64::from(c).div_euclid(i64::from(self.cell.max(1))));
        let odd = cell.iter().sum::<i64>().rem_euclid(2) as usize;
        let span = u64::from(self.noise) * 2 + 1;
        let shade = |place: [i64; 3], purpose| {
            (hash(place, self.seed ^ purpose) % span) as i32 - i32::from(self.noise)
        };
        let shift = shade(cell, 1) + shade(voxel.map(i64::from), 2);
        self.colors[odd].map(|c| (i32::from(c) + shift).clamp(0, 255) as u8)
    }
}

/// A hash of a place, well mixed in every bit (the finaliser of MurmurHash3, once a coordinate).
fn hash(place: [i64; 3], seed: u64) -> u64 {
    place.iter().fold(seed, |state, &c| {
        let mut h = state.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ c as u64;
        h = (h ^ h >> 33).wrapping_mul(0xff51_afd7_ed55_8ccd);
        h = (h ^ h >> 33).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
        h ^ h >> 33
    })
}

impl Solid for CheckerSolid {
    fn maps(&self) -> Vec<MapInfo> {
        color_only()
    }

    fn extent(&self) -> Extent {
        Extent::Unbounded
    }

    fn evaluate(&self, voxels: &VoxelSet, control: &dyn Control) -> Result<VoxelMap, SolidError> {
        evaluate_by(voxels, control, |voxel| self.color(voxel))
    }

    fn digest(&self) -> Digest {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"checker").update(self.colors.as_flattened()).update(&self.cell.to_le_bytes());
        hasher.update(&[self.noise]).update(&self.seed.to_le_bytes());
        hasher.finalize().into()
    }

    fn summary(&self) -> String {
        format!("checkerboard of {} voxels a cell", self.cell)
    }

    fn byte_size(&self) -> u64 {
        size_of::<Self>() as u64
    }
}
