//! Presets made small, for tests.

use breccia_engine::{Graph, ParamValue, Registry, parse_value};

/// A preset.
pub fn graph(name: &str, registry: &Registry) -> Graph {
    Graph::new(&breccia_graphs::preset(name).unwrap().document().unwrap(), registry).unwrap()
}

/// Settings that make a preset fast, by type of node.
const SMALL: &[(&str, &str, i64)] = &[
    ("exemplar.make", "max_size", 32),
    ("lazy.candidates", "strips", 8),
    ("lazy.candidates", "best", 16),
    ("lazy.usage", "rounds", 1),
    ("lazy.usage", "size", 16),
    ("solid.to_volume", "size", 16),
    ("render.cube", "size", 16),
    ("render.cube", "picture", 64),
    ("render.sheet", "size", 16),
    ("measure.quality", "size", 24),
    ("measure.quality", "samples", 64),
    ("measure.volume", "samples", 64),
    ("solid.slice", "size", 24),
    ("mesh.bake", "resolution", 24),
    ("mesh.bake", "texture_size", 64),
    ("render.mesh", "size", 96),
    ("render.translucent", "picture", 64),
    ("render.translucent", "size", 16),
    ("particles.reconstruct", "most", 24),
    ("particles.reconstruct", "alignments", 1),
];

/// A preset with settings that make it fast.
pub fn small(name: &str, registry: &Registry) -> Graph {
    let mut graph = graph(name, registry);
    // With groups the number of nodes depends on these.
    for (param, value) in
        [("levels", "2"), ("iterations", "(2, 1)"), ("window", "(5, 4)"), ("size", "(16, 20, 12)")]
    {
        if name.starts_with("optimize") || name.starts_with("kopf") {
            graph.set(param, &parse_value(value).unwrap()).unwrap();
        }
    }
    // Where particles leave no room for coarser levels there is one; elsewhere small pictures still get two.
    let levels = name.starts_with("lazy") || name.starts_with("pbr") || name.starts_with("wood");
    let crowded = ["hybrid_mesh", "hybrid_slice", "particles_volume", "recolour"].contains(&name);
    let nodes: Vec<_> = graph.nodes().map(|(node, spec)| (node.to_owned(), spec.id)).collect();
    for (node, id) in nodes {
        if id == "lazy.pyramid" && levels {
            graph.set(&format!("{node}.levels"), &ParamValue::Int(2)).unwrap();
        }
        // A smaller crowd, in a solid that repeats with it.
        if crowded && id == "particles.pack" {
            graph.set(&format!("{node}.size"), &ParamValue::Int(64)).unwrap();
        }
        if crowded && id == "lazy.synthesis" {
            graph.set(&format!("{node}.period"), &ParamValue::Int(64)).unwrap();
        }
        for (_, param, value) in SMALL.iter().filter(|small| small.0 == id) {
            graph.set(&format!("{node}.{param}"), &ParamValue::Int(*value)).unwrap();
        }
    }
    graph
}
