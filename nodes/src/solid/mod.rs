//! Consumers and simple kinds of solids.
//!
//! Voxel (i, j, k) covers the cube from i, j, k (inclusive) to i + 1, j + 1, k + 1 (exclusive); its centre lies
//! at i + ½, j + ½, k + ½. Whole voxel coordinates therefore lie on the boundary between two voxels.

mod box_statistics;
mod box_volume;
mod checker;
mod constant;
mod dense;
pub(crate) mod device;
mod from_volume;
mod memory;
pub(crate) mod params;
mod plane;
mod procedural;
mod sample;
mod shape;
mod slice;
mod statistics;
mod to_volume;

pub use crate::data::Filter;
pub use box_statistics::{ChannelStatistics, box_statistics};
pub use box_volume::box_volume;
pub use dense::{NotASolid, Repeat, VolumeSolid};
pub use memory::available_memory;
pub use plane::{Plane, PlaneError, slice};
pub use procedural::{CheckerSolid, ConstantSolid, evaluate_by};
pub use sample::sample;
pub(crate) use sample::voxels_of;
pub use shape::{Shape, ShapeSolid};

use breccia_engine::Node;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![
        Box::new(from_volume::FromVolume),
        Box::new(constant::Constant),
        Box::new(checker::Checker),
        Box::new(shape::ShapeNode),
        Box::new(to_volume::ToVolume),
        Box::new(slice::Slice),
        Box::new(statistics::Statistics),
    ]
}
