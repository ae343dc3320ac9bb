//! `search.patches`: all neighbourhoods of an exemplar in few coefficients.

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::basis::PatchBasis;
use super::patches::patches;
use crate::lazy::Pyramid;

pub(super) struct PatchesNode;

impl Node for PatchesNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "search.patches",
            1,
            "All neighbourhoods of an exemplar, in few coefficients",
            "Projects the neighbourhood of every pixel of a level on the basis, in integers: what searches compare with. \
             Where the picture does not continue at its edges, only pixels whose whole neighbourhood lies inside are \
             found by searches.",
        )
        .paper("Chen & Wang 2010, section 4.3")
        .input("pyramid", "pyramid", "The exemplar's levels.")
        .input("basis", "patch_basis", "The level, the neighbourhood and its components.")
        .output("patches", "patches", "The coefficients, with their basis.")
        .memory_only()
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let basis = context.input::<PatchBasis>("basis")?;
        let views = pyramid.levels.get(basis.level);
        let fits = |view| basis.window.fits(view);
        if !views.is_some_and(|views| views.len() == basis.weights.len() && views.iter().all(fits)) {
            return Err(NodeError::Failed(format!(
                "the basis is one of level {} with {} views, which this pyramid ({} levels) does not have; expected \
                 the pyramid that the basis was made from",
                basis.level,
                basis.weights.len(),
                pyramid.levels.len()
            )));
        }
        let found = patches(&pyramid, &basis, context)?;
        context.set("patches", found);
        Ok(())
    }
}
