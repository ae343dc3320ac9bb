//! The node `particles.fill`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::fill::{CellOf, FillSettings, fill};
use super::packing::Packing;
use super::room::check_room;

/// Scales particles towards their cells.
pub(super) struct FillNode;

impl Node for FillNode {
    fn spec(&self) -> NodeSpec {
        let defaults = FillSettings::default();
        NodeSpec::new(
            "particles.fill",
            1,
            "Particles scaled to fill their Voronoi cells, so that no two overlap",
            "Each particle is scaled by one factor, and in single directions by less where the border of its cell is near. Afterwards no two \
             overlap, and unless `clearance` is below half a voxel none touch.",
        )
        .paper("Du et al. 2013, section 3.4")
        .input("packing", Packing::TYPE, "The particles in their places.")
        .output("packing", Packing::TYPE, "The particles with their new shapes.")
        .choice(
            "cells",
            &[
                ("surface", "What is nearest to a particle's surface: large particles keep large cells."),
                ("center", "What is nearest to a particle's centre, as in the paper: for particles of one size."),
            ],
            "What a particle's cell is.",
        )
        .float("alpha", -0.7..=4.0, defaults.alpha, "1", "How far directions may exceed the uniform factor (α); used if `fraction` is 0.")
        .float("clearance", -1.0..=64.0, defaults.clearance, "voxels", "What stays free between a particle and the border of its cell; negative: half of how thin the matrix is between neighbours in the pictures.")
        .float("fraction", -1.0..=1.0, defaults.fraction, "fraction", "How much of the domain particles are to fill, by one factor for all within their cells, and where need be by less clearance; negative: as much as they cover of the pictures; 0: `alpha` decides.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        let settings = FillSettings {
            cells: if context.text("cells")? == "center" { CellOf::Center } else { CellOf::Surface },
            alpha: context.float("alpha")?,
            clearance: context.float("clearance")?,
            fraction: context.float("fraction")?,
        };
        // The label and owner of every voxel, its distance, and both once more while lines are gathered.
        check_room(packing.size, 20.0)?;
        let filled = fill(&packing, &settings, &*context)?;
        context.set("packing", filled);
        Ok(())
    }
}
