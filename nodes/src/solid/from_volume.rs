//! The node `solid.from_volume`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::{Repeat, VolumeSolid};
use crate::data::{SolidValue, Volume};

/// A dense volume as a solid.
pub struct FromVolume;

impl Node for FromVolume {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "solid.from_volume",
            1,
            "A dense volume as a solid",
            "Lets a volume that was read or synthesised serve wherever a solid is asked for: slices, meshes, \
             pictures, measures. The volume needs a map `color`; grey becomes RGB, alpha is dropped.",
        )
        .memory_only()
        .input("volume", Volume::TYPE, "The voxels.")
        .output("solid", SolidValue::TYPE, "The same voxels, continued beyond their box.")
        .choice(
            "repeat",
            &[
                ("periodic", "The box repeats along all axes."),
                ("clamp", "Voxels outside take the nearest voxel inside."),
            ],
            "What lies beyond the box.",
        )
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let volume = context.input::<Volume>("volume")?;
        let repeat = if context.text("repeat")? == "clamp" { Repeat::Clamp } else { Repeat::Periodic };
        let solid = VolumeSolid::new(volume, repeat).map_err(NodeError::failed)?;
        context.set("solid", SolidValue(std::sync::Arc::new(solid)));
        Ok(())
    }
}
