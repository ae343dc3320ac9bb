//! Node `mesh.bake_vertices`.

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::bake_node::{FILTERS, filter, origin, with_resolution};
use super::{BakeSettings, bake_vertices};
use crate::data::{Mesh, SolidValue};

/// Gives the vertices of a mesh the colours of a solid.
pub(super) struct BakeVertices;

impl Node for BakeVertices {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "mesh.bake_vertices",
            2,
            "Gives the vertices of a mesh the colours of a solid",
            "An alternative to textures for finely tessellated meshes: each vertex asks the solid for the colour at \
             its position. Needs no UVs.",
        )
        .on_device()
        .input("mesh", "mesh", "The mesh.")
        .input("solid", "solid", "What it is to be carved out of.")
        .output("mesh", "mesh", "The mesh with vertex colours.");
        with_resolution(spec).choice("filter", FILTERS, "How samples between voxel centres are found.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let (mesh, solid) = (context.input::<Mesh>("mesh")?, context.input::<SolidValue>("solid")?);
        let settings = BakeSettings {
            resolution: context.int("resolution")? as u32,
            filter: filter(context)?,
            origin: origin(context)?,
            ..BakeSettings::default()
        };
        let baked = bake_vertices(&mesh, solid.0.as_ref(), settings, context)?;
        context.set("mesh", baked);
        Ok(())
    }
}
