//! The node `render.cube`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, Sizing};

use super::{Background, CutawaySettings, cutaway};
use crate::data::{Image, SolidValue};
use crate::solid::params::{box_of, picture_bytes, picture_of, with_box, with_picture};

/// A box with a corner cut out.
pub struct Cube;

impl Node for Cube {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "render.cube",
            1,
            "A picture of a box with one corner cut out",
            "Shows three outer faces and, through the missing corner, three inner ones; asks the solid only for the \
             voxels that are seen. The front face is the first layer across z, x to the right and y down, as an \
             image viewer shows `volume[0]`; z leads away from the viewer.",
        )
        .on_device()
        .input("solid", SolidValue::TYPE, "What is shown.")
        .output("image", Image::TYPE, "The picture.");
        let spec = with_box(spec, 64).float(
            "corner",
            0.0..=0.9,
            0.5,
            "fraction of the edges",
            "How much of the nearest corner is cut out; 0 leaves it.",
        );
        with_picture(spec, "picture", 640).choice(
            "background",
            Background::CHOICES,
            "What lies behind the box.",
        )
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        picture_bytes(sizing, "picture")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let solid = context.input::<SolidValue>("solid")?;
        let (origin, size) = box_of(context)?;
        let settings = CutawaySettings {
            picture: picture_of(context, "picture")?,
            corner: context.float("corner")?,
            background: Background::named(context.text("background")?),
        };
        let image = cutaway(&*solid.0, origin, size, &settings, context)?;
        context.set("image", image);
        Ok(())
    }
}
