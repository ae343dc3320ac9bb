//! The node `solid.constant`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, ParamKind};

use super::ConstantSolid;
use super::params::ints;
use crate::data::SolidValue;

/// One colour everywhere.
pub struct Constant;

impl Node for Constant {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "solid.constant",
            1,
            "One colour everywhere",
            "The plainest solid: a matrix for other things to lie in, and a stand-in while a graph is built.",
        )
        .memory_only()
        .output("solid", SolidValue::TYPE, "The solid.")
        .param(
            "color",
            ParamKind::Ints { min_len: 3, max_len: 3, min: 0, max: 255 },
            ints([128, 128, 128]),
            "levels",
            "Red, green and blue in sRGB encoding.",
        )
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let color = rgb(&context.ints("color")?)?;
        context.set("solid", SolidValue(std::sync::Arc::new(ConstantSolid { color })));
        Ok(())
    }
}

/// Three whole numbers as a colour.
pub(super) fn rgb(numbers: &[i64]) -> Result<[u8; 3], NodeError> {
    match *numbers {
        [r, g, b] => Ok([r, g, b].map(|c| c.clamp(0, 255) as u8)),
        ref other => Err(NodeError::Failed(format!("a colour takes 3 numbers, found {}", other.len()))),
    }
}
