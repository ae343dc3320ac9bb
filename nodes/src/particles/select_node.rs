//! The node `particles.select`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, ParamKind};

use super::packing::Packing;
use super::select::{SelectSettings, select};
use crate::solid::params::ints;

/// Fewer or other particles.
pub(super) struct SelectNode;

impl Node for SelectNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.select",
            1,
            "Particles removed, thinned out or scaled",
            "Keeps a fraction of the particles, those within limits of volume, and all but some by number; scales what stays. Scaled up, particles may \
             overlap: `particles.fill` parts them.",
        )
        .paper("Du et al. 2013, section 4.2")
        .input("packing", Packing::TYPE, "The particles in their places.")
        .output("packing", Packing::TYPE, "Those that stay; numbers count anew.")
        .float("keep", 0.0..=1.0, 1.0, "fraction", "How many stay, drawn by their places.")
        .int("least", 0..=1 << 40, 0, "voxels", "Smaller particles are removed.")
        .int("most", 0..=1 << 40, 1 << 40, "voxels", "Larger particles are removed.")
        .param(
            "remove",
            ParamKind::Ints { min_len: 0, max_len: 4096, min: 1, max: i64::from(u32::MAX) },
            ints([]),
            "numbers",
            "Particles that are removed, by their numbers in `particles.list`.",
        )
        .float("scale", 0.05..=4.0, 1.0, "1", "How much what stays is scaled.")
        .int("seed", 0..=i64::MAX, 1, "count", "Seed of the draw.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        let settings = SelectSettings {
            keep: context.float("keep")?,
            least: context.int("least")? as u64,
            most: context.int("most")? as u64,
            remove: context.ints("remove")?.iter().map(|&n| n as u32).collect(),
            scale: context.float("scale")?,
            seed: context.int("seed")? as u64,
        };
        context.set("packing", select(&packing, &settings));
        Ok(())
    }
}
