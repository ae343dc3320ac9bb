//! The node `particles.solid`.

use std::sync::Arc;

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::packing::Packing;
use super::solid::{Look, ParticleSolid};
use crate::data::SolidValue;

/// Particles in a matrix.
pub(super) struct SolidNode;

impl Node for SolidNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.solid",
            1,
            "Particles in a matrix, as a solid",
            "Voxels of particles show what the pictures show, maps included; for all others the matrix is asked, and only for those that \
             somebody wants to see.",
        )
        .paper("Du et al. 2013, section 3.3")
        .memory_only()
        .input("packing", Packing::TYPE, "The particles in their places.")
        .optional("matrix", SolidValue::TYPE, "What lies between them; without one it is black.")
        .output("solid", SolidValue::TYPE, "The solid.")
        .choice(
            "look",
            &[("pictures", "As the pictures show them."), ("ids", "Each in a colour of its own.")],
            "How particles look.",
        )
        .flag("label", false, "Adds a map `label` with the number of each voxel's particle, 0 in the matrix.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        let matrix = context.optional::<SolidValue>("matrix")?.map(|matrix| Arc::clone(&matrix.0));
        let look = if context.text("look")? == "ids" { Look::Ids } else { Look::Pictures };
        let solid = ParticleSolid::new(packing, matrix, look, context.flag("label")?);
        context.set("solid", SolidValue(Arc::new(solid)));
        Ok(())
    }
}
