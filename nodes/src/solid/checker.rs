//! The node `solid.checker`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, ParamKind};

use super::CheckerSolid;
use super::constant::rgb;
use super::params::ints;
use crate::data::SolidValue;

/// A three-dimensional checkerboard.
pub struct Checker;

impl Node for Checker {
    fn spec(&self) -> NodeSpec {
        let color = ParamKind::Ints { min_len: 3, max_len: 3, min: 0, max: 255 };
        NodeSpec::new(
            "solid.checker",
            1,
            "A three-dimensional checkerboard with noise",
            "Cells of two colours in turn, each cell and voxel a little lighter or darker by a hash of its place. \
             Good for trying meshes, cuts and pictures before a synthesis is at hand.",
        )
        .memory_only()
        .output("solid", SolidValue::TYPE, "The solid, without end.")
        .param("first", color.clone(), ints([62, 92, 118]), "levels", "First colour: red, green, blue in sRGB.")
        .param("second", color, ints([222, 205, 176]), "levels", "Second colour: red, green, blue in sRGB.")
        .int("cell", 1..=4096, 8, "voxels", "Edge of a cell.")
        .int("noise", 0..=127, 10, "levels", "Largest deviation of a cell's shade, and again of a voxel's.")
        .int("seed", 0..=i64::from(u32::MAX), 1, "count", "Selects the noise.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let solid = CheckerSolid {
            colors: [rgb(&context.ints("first")?)?, rgb(&context.ints("second")?)?],
            cell: context.int("cell")?.clamp(1, 4096) as u32,
            noise: context.int("noise")?.clamp(0, 127) as u8,
            seed: context.int("seed")? as u64,
        };
        context.set("solid", SolidValue(std::sync::Arc::new(solid)));
        Ok(())
    }
}
