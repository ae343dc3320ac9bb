//! What can go wrong with a picture.

use crate::control::Cancelled;
use crate::data::SolidError;
use crate::solid::PlaneError;

/// Why there is no picture.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RenderError {
    /// The picture has no pixels, or too many.
    #[error("a picture of {0} × {1} pixels cannot be made; edges go from 1 to 16384")]
    Size(u32, u32),
    /// The box has no voxels, or too many to be seen.
    #[error("a box of {0} × {1} × {2} voxels cannot be shown; edges go from 1 to 2048")]
    Box(u32, u32, u32),
    /// The mesh has nothing to show.
    #[error("the mesh has no triangle that could be shown ({0} vertices, {1} triangles)")]
    EmptyMesh(usize, usize),
    /// Opacities are to be looked up by labels that there are not.
    #[error("the solid has no map `label` to look opacities up by; choose `luminance`")]
    NoLabels,
    /// The solid gave no answer.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// The solid could not be sliced.
    #[error(transparent)]
    Slice(#[from] PlaneError),
}

impl From<Cancelled> for RenderError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Solid(cancelled.into())
    }
}

impl From<RenderError> for breccia_engine::NodeError {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Solid(error) => error.into(),
            RenderError::Slice(error) => error.into(),
            other => Self::failed(other),
        }
    }
}

/// Checks that a picture has pixels, and not too many.
pub(super) fn check_picture([width, height]: [u32; 2]) -> Result<(), RenderError> {
    let fits = |n| (1..=16_384).contains(&n);
    if fits(width) && fits(height) { Ok(()) } else { Err(RenderError::Size(width, height)) }
}
