//! The node `particles.repel`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::packing::Packing;
use super::repel::{RepelSettings, repel};

/// Moves particles out of crowds.
pub(super) struct RepelNode;

impl Node for RepelNode {
    fn spec(&self) -> NodeSpec {
        let defaults = RepelSettings::default();
        NodeSpec::new(
            "particles.repel",
            1,
            "Particles moved away from where others crowd",
            "Every point of a particle is repelled by the points of others with a force that falls with the distance, over a \
             window of 17³ samples of a grid of 64³; particles move along the force, less far in every iteration.",
        )
        .paper("Du et al. 2013, section 3.4")
        .input("packing", Packing::TYPE, "The particles in their places.")
        .output("packing", Packing::TYPE, "The particles moved.")
        .int("iterations", 0..=100, defaults.iterations as i64, "count", "Iterations.")
        .float("step", 0.0..=64.0, defaults.step, "voxels", "How far a particle moves at most in the first iteration.")
        .float("decay", 0.1..=1.0, defaults.decay, "fraction", "The limit of each iteration against the one before.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        let settings = RepelSettings {
            iterations: context.int("iterations")? as usize,
            step: context.float("step")?,
            decay: context.float("decay")?,
        };
        let moved = repel(&packing, &settings, &*context)?;
        context.set("packing", moved);
        Ok(())
    }
}
