//! The node `particles.list`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::list::ParticleList;
use super::packing::Packing;

/// The particles as a table.
pub(super) struct ListNode;

impl Node for ListNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.list",
            1,
            "A table of the particles",
            "Number (as in label volumes), centre, volume, axes, sphericity, source cross-sections and neighbours of every particle, for CSV and \
             JSON.",
        )
        .input("packing", Packing::TYPE, "The particles in their places.")
        .output("list", ParticleList::TYPE, "The table.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        context.set("list", ParticleList::of(&packing));
        Ok(())
    }
}
