//! The node `solid.to_volume`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, Sizing, Work};

use super::params::{box_bytes, box_of, with_box};
use super::{available_memory, box_volume};
use crate::data::{SolidValue, Volume};

/// A box of a solid as a dense volume.
pub struct ToVolume;

impl Node for ToVolume {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "solid.to_volume",
            1,
            "A box of a solid as a dense volume",
            "Asks the solid for every voxel of a box, all maps, block by block. A box that does not fit into \
             memory is refused before anything is computed.",
        )
        .on_device()
        .input("solid", SolidValue::TYPE, "Where the voxels come from.")
        .output("volume", Volume::TYPE, "The voxels of the box.");
        with_box(spec, 64)
            .float("spacing", 1e-9..=1e9, 1.0, "world units", "Edge of a voxel, kept in files that can.")
            .int("memory", 0..=1 << 30, 0, "MiB", "Most memory the volume may take; 0 means what is free.")
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        box_bytes(sizing)
    }

    fn work(&self, sizing: &Sizing<'_>) -> Option<Work> {
        let voxels = box_bytes(sizing)? / 3;
        // Lazy synthesis, which is what costs most, takes about a microsecond a voxel; twelve bytes of each come back.
        Some(Work { seconds: voxels as f64 * 1e-6, bytes: voxels.saturating_mul(12) })
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let solid = context.input::<SolidValue>("solid")?;
        let (origin, size) = box_of(context)?;
        let limit = match context.int("memory")? {
            0 => available_memory(),
            mebibytes => (mebibytes.max(0) as u64) << 20,
        };
        let mut volume = box_volume(&*solid.0, origin, size, limit, context)?;
        volume.spacing = [context.float("spacing")? as f32; 3];
        context.set("volume", volume);
        Ok(())
    }
}
