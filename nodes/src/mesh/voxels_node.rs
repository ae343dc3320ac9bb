//! Node `mesh.voxels`.

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::bake_node::{origin, with_resolution};
use super::voxels::VoxelsError;
use super::{Space, surface_voxels};
use crate::data::Mesh;

/// Collects the voxels that a mesh's surface runs through.
pub(super) struct Voxels;

impl Node for Voxels {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "mesh.voxels",
            1,
            "Collects the voxels that a mesh's surface runs through",
            "The voxels whose cubes, widened by `thickness` to every side, meet the surface. The mesh's bounding \
             box (of a part: that of the whole it was cut from) has its smallest corner at voxel `origin`.",
        )
        .input("mesh", "mesh", "The mesh.")
        .output("voxels", "voxel_set", "The voxels.");
        with_resolution(spec).float(
            "thickness",
            0.0..=64.0,
            0.0,
            "voxels",
            "How far the voxels' cubes are widened.",
        )
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let mesh = context.input::<Mesh>("mesh")?;
        let space = Space::of_mesh(&mesh, context.int("resolution")? as u32, origin(context)?)
            .map_err(NodeError::failed)?;
        let thickness = context.float("thickness")? as f32;
        let voxels = surface_voxels(&mesh, &space, thickness, context).map_err(|error| match error {
            VoxelsError::Cancelled(_) => NodeError::Cancelled,
            error => NodeError::failed(error),
        })?;
        context.set("voxels", voxels);
        Ok(())
    }
}
