//! The one currency: something that answers the colours of any voxels, always the same.

use std::sync::Arc;

use breccia_engine::{Data, Digest};
use breccia_shaders::{Gpu, GpuError};

use super::{Map, MapInfo, Tap, VoxelMap, VoxelSet};
use crate::control::{Cancelled, Control};

/// Where a solid has voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Everywhere, without repetition.
    Unbounded,
    /// Everywhere, repeating with this period along x, y and z.
    Periodic([u32; 3]),
    /// Only in this box (origin, size); voxels outside take the nearest voxel inside.
    Bounded([i32; 3], [u32; 3]),
}

/// Why a solid gave no answer.
#[derive(Clone, Debug, thiserror::Error)]
pub enum SolidError {
    /// The computation was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// The answer would not fit into memory.
    #[error("{0}")]
    TooLarge(String),
    /// The answer lacks what was asked for.
    #[error("the solid's answer lacks {0}")]
    Incomplete(String),
    /// The compute device could not do it.
    #[error(transparent)]
    Device(GpuError),
}

impl From<GpuError> for SolidError {
    fn from(error: GpuError) -> Self {
        match error {
            GpuError::Cancelled => Self::Cancelled,
            other => Self::Device(other),
        }
    }
}

impl From<Cancelled> for SolidError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<SolidError> for breccia_engine::NodeError {
    fn from(error: SolidError) -> Self {
        match error {
            SolidError::Cancelled => Self::Cancelled,
            other => Self::failed(other),
        }
    }
}

/// A solid texture: it answers the samples of *these* voxels, for any set, at any place, and always the
/// same, whatever was asked before and in whatever portions.
pub trait Solid: Send + Sync {
    /// The maps it answers; the first is `color`, three channels in sRGB encoding.
    fn maps(&self) -> Vec<MapInfo>;

    /// Where it has voxels.
    fn extent(&self) -> Extent;

    /// The samples of the voxels asked for. The bricks of the answer are those of `voxels`.
    ///
    /// # Errors
    /// [`SolidError::Cancelled`] if `control` asks for it; [`SolidError::TooLarge`] before allocating.
    fn evaluate(&self, voxels: &VoxelSet, control: &dyn Control) -> Result<VoxelMap, SolidError>;

    /// The samples of these maps at points, found on a compute device so that nothing else comes back from it: for each map an
    /// entry a point, the same bits as [`crate::solid::sample`] makes of [`Solid::evaluate`]. `None` where the solid cannot do
    /// that, or not for these maps.
    ///
    /// # Errors
    /// [`SolidError::Cancelled`] if `control` asks for it; [`SolidError::Device`].
    fn sample(
        &self,
        gpu: &Gpu,
        maps: &[MapInfo],
        taps: &[Tap],
        control: &dyn Control,
    ) -> Result<Option<Vec<Map>>, SolidError> {
        let _ = (gpu, maps, taps, control);
        Ok(None)
    }

    /// The digest of everything that determines the answers.
    fn digest(&self) -> Digest;

    /// A short human summary.
    fn summary(&self) -> String;

    /// Bytes held in memory.
    fn byte_size(&self) -> u64;
}

/// A shared [`Solid`], as it flows along links.
#[derive(Clone)]
pub struct SolidValue(pub Arc<dyn Solid>);

impl Data for SolidValue {
    const TYPE: &'static str = "solid";
    const DOCS: &'static str = "Anything that answers the colours of any voxels, always the same.";

    fn byte_size(&self) -> u64 {
        self.0.byte_size()
    }

    fn summary(&self) -> String {
        self.0.summary()
    }

    fn digest(&self) -> Digest {
        self.0.digest()
    }
}
