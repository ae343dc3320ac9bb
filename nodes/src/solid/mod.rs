//! Consumers and simple kinds of solids.

use breccia_engine::Node;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    Vec::new()
}
