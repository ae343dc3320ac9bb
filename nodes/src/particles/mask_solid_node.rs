//! The node `particles.mask_solid`.

use std::sync::Arc;

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::packing::Packing;
use super::solid::{Look, ParticleSolid};
use crate::data::SolidValue;

/// White where particles are.
pub(super) struct MaskSolidNode;

impl Node for MaskSolidNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.mask_solid",
            1,
            "A solid that is white where particles are and black elsewhere",
            "Tells a synthesis of the matrix where it need not compute anything, and other nodes where particles are.",
        )
        .memory_only()
        .input("packing", Packing::TYPE, "The particles in their places.")
        .output("mask", SolidValue::TYPE, "White in particles, black in the matrix.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        context.set("mask", SolidValue(Arc::new(ParticleSolid::new(packing, None, Look::Mask, false))));
        Ok(())
    }
}
