//! The node `render.mesh`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, Sizing};

use super::{Background, PortraitSettings, portrait};
use crate::data::{Image, Mesh as MeshData};
use crate::solid::params::{picture_bytes, picture_of, with_picture};

/// A picture of a textured mesh.
pub struct Mesh;

impl Node for Mesh {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "render.mesh",
            1,
            "A picture of a textured mesh",
            "Shows the maps `color`, `normal`, `roughness` and `metallic` where the mesh has them, else vertex \
             colours, else grey clay; lit by a soft key light from the upper left, a fill, a rim light and a bright \
             room, with shadows on the mesh and on the ground. Drawn on the CPU, antialiased, the same on every machine.",
        )
        .input("mesh", MeshData::TYPE, "What is shown; y is up.")
        .output("image", Image::TYPE, "The picture.");
        with_picture(spec, "size", 800)
            .float(
                "azimuth",
                -360.0..=360.0,
                35.0,
                "degrees",
                "Where the viewer stands: 0 looks along −z, 90 along −x.",
            )
            .float("elevation", -90.0..=90.0, 18.0, "degrees", "How far the viewer looks down.")
            .float("zoom", 0.05..=50.0, 1.0, "1", "1 fits the whole mesh, 2 shows it twice as large.")
            .choice("background", Background::CHOICES, "What lies behind the mesh.")
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        picture_bytes(sizing, "size")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let mesh = context.input::<MeshData>("mesh")?;
        let settings = PortraitSettings {
            picture: picture_of(context, "size")?,
            azimuth: context.float("azimuth")?,
            elevation: context.float("elevation")?,
            zoom: context.float("zoom")?,
            background: Background::named(context.text("background")?),
        };
        context.set("image", portrait(&mesh, &settings, context)?);
        Ok(())
    }
}
