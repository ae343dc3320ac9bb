//! Lazy solid synthesis after Dong et al. 2008.

use breccia_engine::Node;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    Vec::new()
}
