//! Reading and writing pictures and volumes.

use breccia_engine::{Exporter, Node};

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    Vec::new()
}

/// The exporters of this family.
pub fn exporters() -> Vec<Exporter> {
    Vec::new()
}
