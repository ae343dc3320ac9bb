//! Pictures of textured meshes and volumes.

use breccia_engine::Node;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    Vec::new()
}
