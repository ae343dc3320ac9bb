//! The data types that flow between nodes.

mod codec;
mod curves;
mod image;
mod mesh;
mod report;
mod samples;
mod solid;
mod tap;
mod volume;
mod voxels;

pub use codec::{Reader, Writer, pack, unpack};
pub use curves::{Curves, Plot, Series};
pub use image::{Image, ImageError, linear_to_srgb, srgb_to_linear};
pub use mesh::Mesh;
pub use report::{Report, Row};
pub use samples::{Map, MapInfo, SampleType, Samples};
pub use solid::{Extent, Solid, SolidError, SolidValue};
pub use tap::{Filter, Tap, mean_byte};
pub use volume::Volume;
pub use voxels::{BRICK, BRICK_VOXELS, VoxelMap, VoxelSet, brick_of, indices, local_index, voxel_at};

use breccia_engine::TypeInfo;

/// The socket types of this crate's common data types.
pub fn types() -> Vec<TypeInfo> {
    vec![
        TypeInfo::of::<Image>(),
        TypeInfo::of::<Volume>(),
        TypeInfo::of::<VoxelSet>(),
        TypeInfo::of::<Mesh>(),
        TypeInfo::of::<SolidValue>(),
        TypeInfo::of::<Report>(),
        TypeInfo::of::<Curves>(),
        TypeInfo::of::<crate::exemplar::Exemplar>(),
    ]
}
