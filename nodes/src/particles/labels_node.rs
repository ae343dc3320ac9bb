//! The node `particles.labels`.

use std::sync::Arc;

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, Sizing};

use super::packing::Packing;
use super::solid::{LABEL, Look, ParticleSolid};
use crate::data::Volume;
use crate::solid::params::{box_bytes, box_of, with_box};
use crate::solid::{available_memory, box_volume};

/// Which particle each voxel belongs to.
pub(super) struct LabelsNode;

impl Node for LabelsNode {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "particles.labels",
            1,
            "A label volume: which particle each voxel belongs to",
            "For measurements in other programs: 0 is the matrix, n the n-th particle of `particles.list`.",
        )
        .input("packing", Packing::TYPE, "The particles in their places.")
        .output("volume", Volume::TYPE, "One map, `label`, of whole numbers.");
        with_box(spec, 128).float(
            "spacing",
            1e-9..=1e9,
            1.0,
            "world units",
            "Edge of a voxel, kept in files that can.",
        )
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        box_bytes(sizing).map(|bytes| bytes / 3 * 4)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        let (origin, size) = box_of(context)?;
        let solid = ParticleSolid::new(Arc::clone(&packing), None, Look::Mask, true);
        let mut volume = box_volume(&solid, origin, size, available_memory(), context)?;
        volume.maps.retain(|map| map.name == LABEL);
        volume.spacing = [context.float("spacing")? as f32; 3];
        context.set("volume", volume);
        Ok(())
    }
}
