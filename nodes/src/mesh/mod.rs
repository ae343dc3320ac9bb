//! Meshes: reading, writing, unwrapping, cutting, baking.

mod bake;
mod bake_node;
mod bake_vertices_node;
mod cap;
mod cut;
mod cut_node;
mod read;
mod read_gltf;
mod read_node;
mod read_obj;
mod read_ply;
pub mod sample;
pub mod space;
#[cfg(test)]
pub(crate) mod tests;
mod texels;
mod unwrap;
mod unwrap_node;
mod vector;
mod voxels;
mod voxels_node;
mod write;
mod write_glb;
mod write_obj;
mod write_ply;

use breccia_engine::{Exporter, Node};

pub use bake::{BakeError, BakeSettings, MAX_TEXTURE, bake_solid, bake_vertices};
pub use cut::{CutError, Halves, Plane, cut_mesh};
pub use read::{EXTENSIONS, MeshError, decode_mesh, smooth_normals};
pub use sample::{Filter, SampleError, Sampled, sample_solid};
pub use space::{MAX_ORIGIN, MAX_RESOLUTION, Space, SpaceError};
pub use unwrap::{UnwrapError, UnwrapSettings, ensure_uvs, make_atlas, uv_problem};
pub use voxels::{MAX_MILLIONS, VoxelsError, surface_voxels};
pub use write_glb::encode as encode_glb;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![
        Box::new(read_node::Read),
        Box::new(unwrap_node::Unwrap),
        Box::new(bake_node::Bake),
        Box::new(bake_vertices_node::BakeVertices),
        Box::new(voxels_node::Voxels),
        Box::new(cut_node::Cut),
    ]
}

/// The exporters of this family.
pub fn exporters() -> Vec<Exporter> {
    write::exporters()
}
