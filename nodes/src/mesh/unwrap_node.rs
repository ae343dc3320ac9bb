//! Node `mesh.unwrap`.

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::{MAX_TEXTURE, UnwrapSettings, ensure_uvs, make_atlas};
use crate::data::Mesh;

/// Gives a mesh texture coordinates.
pub(super) struct Unwrap;

impl Node for Unwrap {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "mesh.unwrap",
            1,
            "Gives a mesh texture coordinates without overlap",
            "UVs that the mesh has stay where they lie inside 0 to 1, unless `always` is set. Otherwise an atlas \
             is made: charts are grown by normal, flattened, and packed. Textures the mesh had are dropped with \
             its UVs.",
        )
        .input("mesh", "mesh", "The mesh.")
        .output("mesh", "mesh", "The mesh with UVs; vertices at the borders of charts are doubled.")
        .flag("always", false, "Makes an atlas even if the mesh has UVs.")
        .int(
            "texture_size",
            16..=i64::from(MAX_TEXTURE),
            2048,
            "texels",
            "Side of the texture the distance of charts is meant for.",
        )
        .int("padding", 0..=128, 4, "texels", "Empty texels around each chart.")
        .float("max_angle", 1.0..=89.0, 70.0, "degrees", "Largest angle of a triangle to its chart's mean.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let mesh = context.input::<Mesh>("mesh")?;
        let settings = UnwrapSettings {
            texture_size: context.int("texture_size")? as u32,
            padding: context.int("padding")? as u32,
            max_angle: context.float("max_angle")? as f32,
        };
        let make = if context.flag("always")? { make_atlas } else { ensure_uvs };
        let unwrapped = make(&mesh, settings).map_err(NodeError::failed)?;
        context.set("mesh", unwrapped);
        Ok(())
    }
}
