//! The node `particles.neighbours`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::neighbours::Neighbours;
use super::particle::ParticleSet;

/// Finds which particles may lie next to which.
pub(super) struct NeighboursNode;

impl Node for NeighboursNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.neighbours",
            1,
            "Which particles may lie next to which, and where",
            "For each cross-section its nearest others in the picture, with their distance; two particles may be neighbours where \
             two of their cross-sections are.",
        )
        .paper("Du et al. 2013, section 3.2")
        .input("particles", ParticleSet::TYPE, "The particles.")
        .output("neighbours", Neighbours::TYPE, "The neighbour sets.")
        .int("near", 1..=64, 10, "count", "Nearest cross-sections of each cross-section.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let set = context.input::<ParticleSet>("particles")?;
        let neighbours = Neighbours::new(&set, context.int("near")? as usize, &*context)?;
        context.set("neighbours", neighbours);
        Ok(())
    }
}
