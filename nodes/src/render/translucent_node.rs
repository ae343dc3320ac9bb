//! The node `render.translucent`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, Sizing};

use super::Background;
use super::translucent::{TranslucentSettings, translucent};
use crate::data::{Image, SolidValue};
use crate::solid::params::{box_of, picture_bytes, picture_of, with_box, with_picture};

/// A box, seen through.
pub(super) struct Translucent;

impl Node for Translucent {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "render.translucent",
            1,
            "A picture of a box with what is marked opaque and the rest translucent",
            "Shows particles in a matrix of glass, or without it. The front face is the first layer across z, x to the right and \
             y down; z leads away from the viewer.",
        )
        .on_device()
        .input("solid", SolidValue::TYPE, "What is shown.")
        .optional("marked", SolidValue::TYPE, "White where voxels are opaque, such as particles.")
        .optional("inside", SolidValue::TYPE, "White where there is anything at all; without it in the whole box.")
        .output("image", Image::TYPE, "The picture.");
        let spec = with_box(spec, 64)
            .float("opacity", 0.0..=1.0, 0.0, "fraction a voxel", "How much a voxel that is not marked hides of what lies behind it: 0 leaves it out, 1 makes it opaque.")
            .float("azimuth", -360.0..=360.0, 36.0, "degrees", "From how far to the right it is seen.")
            .float("elevation", -89.0..=89.0, 27.0, "degrees", "From how far above it is seen.");
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
        let marked = context.optional::<SolidValue>("marked")?;
        let inside = context.optional::<SolidValue>("inside")?;
        let (origin, size) = box_of(context)?;
        let settings = TranslucentSettings {
            picture: picture_of(context, "picture")?,
            opacity: context.float("opacity")?,
            view: [context.float("azimuth")?, context.float("elevation")?],
            background: Background::named(context.text("background")?),
        };
        let marked = marked.as_ref().map(|solid| &*solid.0);
        let inside = inside.as_ref().map(|solid| &*solid.0);
        let image = translucent(&*solid.0, marked, inside, origin, size, &settings, context)?;
        context.set("image", image);
        Ok(())
    }
}
