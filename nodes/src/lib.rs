//! Solid textures: data types, synthesis algorithms as plain functions, and the nodes that expose them.
//!
//! One folder is one family. In it, algorithm files hold plain functions on plain data without an
//! engine type in sight; a node file is the thin declaration that wires sockets and parameters to one of them.

pub mod control;
pub mod data;
pub mod device;
pub mod exemplar;
pub mod io;
pub mod lazy;
pub mod measure;
pub mod mesh;
pub mod optimize;
pub mod particles;
pub mod render;
pub mod search;
pub mod solid;

use breccia_engine::Registry;

/// A registry with every node, socket type and exporter of this crate.
pub fn registry() -> Registry {
    let mut registry = Registry::default();
    registry.add_types(breccia_engine::flow::types());
    registry.add_nodes(breccia_engine::flow::nodes());
    registry.add_types(data::types());
    registry.add_types(lazy::types());
    registry.add_types(search::types());
    registry.add_types(optimize::types());
    registry.add_types(particles::types());
    for nodes in [
        io::nodes(),
        exemplar::nodes(),
        lazy::nodes(),
        search::nodes(),
        optimize::nodes(),
        particles::nodes(),
        solid::nodes(),
        mesh::nodes(),
        measure::nodes(),
        render::nodes(),
    ] {
        registry.add_nodes(nodes);
    }
    registry.add_exporters(io::exporters());
    registry.add_exporters(mesh::exporters());
    registry
}
