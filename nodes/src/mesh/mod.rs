//! Meshes: reading, writing, unwrapping, cutting, baking.

mod bake;
mod bake_node;
mod bake_vertices_node;
pub mod sample;
pub mod space;
mod texels;
mod unwrap;
mod unwrap_node;
#[cfg(test)]
mod tests;

use breccia_engine::{Exporter, Node};

pub use bake::{BakeError, BakeSettings, MAX_TEXTURE, bake_solid, bake_vertices};
pub use sample::{Filter, SampleError, Sampled, sample_solid};
pub use space::{MAX_ORIGIN, MAX_RESOLUTION, Space, SpaceError};
pub use unwrap::{UnwrapError, UnwrapSettings, ensure_uvs, make_atlas, uv_problem};

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![
        Box::new(unwrap_node::Unwrap),
        Box::new(bake_node::Bake),
        Box::new(bake_vertices_node::BakeVertices),
    ]
}

/// The exporters of this family.
pub fn exporters() -> Vec<Exporter> {
    Vec::new()
}
