//! Voxel space: how world positions and voxels of a solid belong together.
//!
//! One convention for baking, cutting, slicing and rendering:
//! - The mesh's bounding box (or that of the whole it was cut from) has its smallest corner at the corner
//!   of voxel `origin`; x, y and z of the mesh are x, y and z of the solid.
//! - The scale is uniform: the longest side of the box spans `resolution` voxels.
//! - Voxel (i, j, k) fills the cube from (i, j, k) to (i+1, j+1, k+1); its centre is at i + 0.5.

use crate::data::Mesh;

/// The largest resolution and the largest absolute value of an origin's coordinate.
pub const MAX_RESOLUTION: u32 = 1 << 16;
/// The largest absolute value of an origin's coordinate; leaves room so that no voxel's number overflows.
pub const MAX_ORIGIN: i32 = 1 << 30;

/// A map from world positions to voxel coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    /// The world position of the corner of voxel `origin`.
    pub corner: [f32; 3],
    /// Voxels in a world unit.
    pub voxels_per_unit: f64,
    /// The voxel at the box's smallest corner.
    pub origin: [i32; 3],
}

/// Voxel space cannot be laid over a box.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SpaceError {
    /// No vertex, so no bounding box.
    #[error("the mesh has no vertices, so it has no bounding box")]
    Empty,
    /// The box has no extent, or one that is not a number.
    #[error("the bounding box from {0:?} to {1:?} has no usable size")]
    NoSize([f32; 3], [f32; 3]),
    /// Too few or too many voxels.
    #[error("resolution {0} is not from 1 to {MAX_RESOLUTION} voxels")]
    Resolution(u32),
    /// The origin is too far out.
    #[error("origin {0:?} is more than {MAX_ORIGIN} voxels out")]
    Origin([i32; 3]),
}

impl Space {
    /// Lays `resolution` voxels along the longest side of a bounding box (smallest and largest corner).
    ///
    /// # Errors
    /// If a number is out of its range or the box has no size.
    pub fn new(bounds: ([f32; 3], [f32; 3]), resolution: u32, origin: [i32; 3]) -> Result<Self, SpaceError> {
        let (lo, hi) = bounds;
        if resolution == 0 || resolution > MAX_RESOLUTION {
            return Err(SpaceError::Resolution(resolution));
        }
        if origin.iter().any(|&c| c.unsigned_abs() > MAX_ORIGIN.unsigned_abs()) {
            return Err(SpaceError::Origin(origin));
        }
        let longest = (0..3).map(|i| f64::from(hi[i]) - f64::from(lo[i])).fold(0.0, f64::max);
        let voxels_per_unit = f64::from(resolution) / longest;
        if !longest.is_finite() || !voxels_per_unit.is_finite() || voxels_per_unit <= 0.0 {
            return Err(SpaceError::NoSize(lo, hi));
        }
        Ok(Self { corner: lo, voxels_per_unit, origin })
    }

    /// The space of a mesh, or of the whole that the mesh was cut from.
    ///
    /// # Errors
    /// As [`Space::new`], and if the mesh is empty.
    pub fn of_mesh(mesh: &Mesh, resolution: u32, origin: [i32; 3]) -> Result<Self, SpaceError> {
        Self::new(mesh.voxel_bounds().ok_or(SpaceError::Empty)?, resolution, origin)
    }

    /// Voxel coordinates of a world position.
    pub fn to_voxels(&self, position: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            (position[i] - f64::from(self.corner[i])) * self.voxels_per_unit + f64::from(self.origin[i])
        })
    }

    /// The world position of voxel coordinates.
    pub fn to_world(&self, coordinates: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            (coordinates[i] - f64::from(self.origin[i])) / self.voxels_per_unit + f64::from(self.corner[i])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_side_spans_the_resolution_from_the_origin() {
        let space = Space::new(([-1.0, 0.0, 2.0], [1.0, 4.0, 3.0]), 64, [10, -20, 30]).unwrap();
        assert_eq!(space.to_voxels([-1.0, 0.0, 2.0]), [10.0, -20.0, 30.0]);
        assert_eq!(space.to_voxels([1.0, 4.0, 3.0]), [42.0, 44.0, 46.0]);
        assert_eq!(space.to_world([42.0, 44.0, 46.0]), [1.0, 4.0, 3.0]);
    }

    #[test]
    fn boxes_without_size_are_refused() {
        assert!(Space::new(([1.0; 3], [1.0; 3]), 64, [0; 3]).is_err());
        assert!(Space::new(([0.0; 3], [f32::NAN; 3]), 64, [0; 3]).is_err());
        assert!(Space::new(([0.0; 3], [f32::INFINITY; 3]), 64, [0; 3]).is_err());
        assert!(Space::new(([0.0; 3], [1.0; 3]), 0, [0; 3]).is_err());
        assert!(Space::new(([0.0; 3], [1.0; 3]), 64, [i32::MIN; 3]).is_err());
        assert_eq!(Space::of_mesh(&Mesh::default(), 64, [0; 3]), Err(SpaceError::Empty));
    }
}
