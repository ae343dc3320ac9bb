//! Lazy synthesis on a compute device: the same bits as on the processor.
//!
//! Data flows one way here too: [`plan`] says which bricks of each level take part, the masks of the voxels that matter are
//! made on the device from the finest level to the coarsest (`dilate`, `parents`), and the states from the coarsest to the finest
//! (`start`, `upsample`, `correct`). Nothing comes back before the finished bricks; where points are to be
//! sampled (`sample`), these stay there and only the samples come back.

mod level;
mod plan;
mod sample;
#[cfg(test)]
mod sampling_tests;
mod solid;
mod synthesis;
mod tables;
#[cfg(test)]
mod tests;
mod triples;

use sample::{Carried, Finished};
use synthesis::Request;
use tables::DeviceTables;
pub(super) use triples::DeviceStrips;
