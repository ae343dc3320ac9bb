//! The node `particles.recolor`.

use std::sync::Arc;

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::packing::Packing;
use super::recolor::{RecolorSettings, RecolorSolid};
use crate::data::{Solid, SolidValue};

/// New colours.
pub(super) struct RecolorNode;

impl Node for RecolorNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.recolor",
            1,
            "Particles and matrix in the colours of other solids",
            "Any solid can give its colours: a lazy synthesis, a checkerboard, one colour. Other maps stay as they are.",
        )
        .paper("Du et al. 2013, section 4.2, Fig. 15")
        .memory_only()
        .input("packing", Packing::TYPE, "The particles in their places.")
        .input("solid", SolidValue::TYPE, "The solid of these particles.")
        .optional("particles", SolidValue::TYPE, "Where particles take their colours from.")
        .optional("matrix", SolidValue::TYPE, "Where the matrix takes its colours from.")
        .output("solid", SolidValue::TYPE, "The solid in its new colours.")
        .choice(
            "each",
            &[("particle", "A particle takes the colour at its centre."), ("voxel", "Every voxel takes its own.")],
            "Which colour a particle takes.",
        )
        .float("strength", 0.0..=1.0, 1.0, "fraction", "How much of the new colours shows.")
        .float("detail", 0.0..=1.0, 1.0, "fraction", "How much of a particle's own light and dark stays.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        let base = Arc::clone(&context.input::<SolidValue>("solid")?.0);
        let texture = |name: &str| -> Result<Option<Arc<dyn Solid>>, NodeError> {
            Ok(context.optional::<SolidValue>(name)?.map(|solid| Arc::clone(&solid.0)))
        };
        let (particles, matrix) = (texture("particles")?, texture("matrix")?);
        let settings = RecolorSettings {
            whole: context.text("each")? == "particle",
            strength: context.float("strength")?,
            detail: context.float("detail")?,
        };
        let solid = RecolorSolid::new(packing, base, particles, matrix, settings, &*context)?;
        context.set("solid", SolidValue(Arc::new(solid)));
        Ok(())
    }
}
