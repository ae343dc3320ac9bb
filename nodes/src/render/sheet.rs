//! The node `render.sheet`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::contact_sheet;
use crate::data::{Image, SolidValue};
use crate::solid::params::{box_of, with_box};

/// Faces and an oblique cut side by side.
pub struct Sheet;

impl Node for Sheet {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "render.sheet",
            1,
            "Three faces and an oblique cut side by side",
            "For judging a solid by eye: the first layers of a cube across z, y and x, and the cut through its \
             centre across (1, 1, 1), each voxel a few pixels wide and nothing filtered.",
        )
        .on_device()
        .input("solid", SolidValue::TYPE, "What is shown.")
        .output("image", Image::TYPE, "The sheet.");
        with_box(spec, 64).int("enlarge", 1..=16, 2, "pixels", "Edge of a voxel.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let solid = context.input::<SolidValue>("solid")?;
        let (origin, [x, y, z]) = box_of(context)?;
        if x != y || y != z {
            return Err(NodeError::Failed(format!("a sheet shows a cube, `size` is {x} × {y} × {z}")));
        }
        let enlarge = context.int("enlarge")?.clamp(1, 16) as u32;
        let image = contact_sheet(&*solid.0, origin, x, enlarge, context)?;
        context.set("image", image);
        Ok(())
    }
}
