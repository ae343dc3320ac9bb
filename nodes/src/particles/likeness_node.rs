//! The node `particles.likeness`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::likeness::likeness;
use super::packing::Packing;
use super::room::check_room;
use crate::data::{Curves, Report};

/// Particles against the pictures.
pub(super) struct LikenessNode;

impl Node for LikenessNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.likeness",
            1,
            "How well packed particles resemble the pictures",
            "Volume fraction against the pictures' area fraction; the Kolmogorov-Smirnov distance between the sizes of cross-sections in \
             every fourth slice and in the picture, view by view; half of the summed difference between the histograms (12 \
             sectors) of the directions to the six nearest cross-sections; mean shape. Sections at the border of a picture are \
             left out, and those within weighted by how often their size is (Miles 1974).",
        )
        .paper("Du et al. 2013, section 4; Miles 1974; Wadell 1932")
        .input("packing", Packing::TYPE, "The particles in their places.")
        .output("report", Report::TYPE, "The measures.")
        .output("curves", Curves::TYPE, "The distributions of sizes.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        check_room(packing.size, 4.0)?;
        let (report, curves) = likeness(&packing, &*context)?;
        context.set("report", report);
        context.set("curves", curves);
        Ok(())
    }
}
