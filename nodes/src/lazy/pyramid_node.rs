//! `lazy.pyramid`: the exemplar at every level of resolution.

use breccia_engine::{Context, Node, NodeError, NodeSpec, Sizing};

use super::pyramid::Pyramid;
use crate::exemplar::Exemplar;

pub(super) struct PyramidNode;

impl Node for PyramidNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "lazy.pyramid",
            3,
            "The exemplar at every level of resolution",
            "Every level halves the one before by averaging 2 × 2 pixels. Synthesis starts at the coarsest level, so \
             their number decides how large the structures are that it sees at the start.",
        )
        .paper("Dong et al. 2008, section 4")
        .memory_only()
        .input("exemplar", "exemplar", "The exemplar.")
        .output("pyramid", "pyramid", "Its levels, finest first.")
        .int(
            "levels",
            0..=6,
            0,
            "count",
            "Number of levels; 0 takes as many as leave 32 pixels a side at the coarsest (the start level), or 64 if the exemplar \
             is one picture with neither mask nor guide, but two where there are 64 pixels.",
        )
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        // Four of an exemplar's seven bytes a pixel, and a third for the coarser levels.
        Some(sizing.input("exemplar")? * 16 / 21)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let exemplar = context.input::<Exemplar>("exemplar")?;
        let pyramid = Pyramid::new(&exemplar, context.int("levels")? as usize).map_err(NodeError::input)?;
        context.set("pyramid", pyramid);
        Ok(())
    }
}
