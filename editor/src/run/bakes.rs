//! Which solid a mesh was baked from, and how it lies in the mesh. Looked up in the graph as it runs, where groups, zones and
//! bypassed nodes are resolved already.

use std::collections::VecDeque;
use std::collections::btree_map::{BTreeMap, Entry};

use breccia_engine::{Graph, NodeSpec, ParamValue};
use breccia_nodes::data::Filter;

/// The nodes that give a mesh the looks of a solid.
const BAKERS: [&str; 2] = ["mesh.bake", "mesh.bake_vertices"];

/// How a solid lies in a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fit {
    /// Voxels along the mesh's longest side.
    pub resolution: u32,
    /// The voxel at the smallest corner of the mesh's box.
    pub origin: [i32; 3],
    /// How samples between voxel centres are found.
    pub filter: Filter,
}

/// The solid in a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bake {
    /// The output that gives it.
    pub solid: String,
    /// How it lies in the mesh.
    pub fit: Fit,
}

/// What is baked in a graph: the solid in each mesh, by the output that gives the mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bakes(BTreeMap<String, Bake>);

impl Bakes {
    /// Finds them. A mesh that was baked keeps its solid through other nodes, until another one is baked into it.
    pub fn of(graph: &Graph) -> Self {
        let specs: BTreeMap<&str, &NodeSpec> = graph.nodes().collect();
        let gives = |node: &str| {
            let outputs = specs.get(node).map_or(&[][..], |spec| &spec.outputs);
            outputs.iter().filter(|output| output.ty == "mesh").map(|output| output.name)
        };
        // Nearest first: a node that takes several meshes has what was baked into the nearest.
        let mut open: VecDeque<(&str, Bake)> = bakers(graph, &specs).into_iter().collect();
        let mut inside: BTreeMap<&str, Bake> = BTreeMap::new();
        while let Some((node, bake)) = open.pop_front() {
            let Entry::Vacant(entry) = inside.entry(node) else { continue };
            entry.insert(bake.clone());
            let hands_on = |next: &&str| {
                let takes = |spec: &&NodeSpec| spec.inputs.iter().any(|input| input.ty == "mesh");
                let is_baker = |spec: &&NodeSpec| BAKERS.contains(&spec.id);
                specs.get(next).is_some_and(|spec| takes(spec) && !is_baker(spec)) && gives(next).count() > 0
            };
            open.extend(graph.consumers(node).into_iter().filter(hands_on).map(|next| (next, bake.clone())));
        }
        let outputs = inside.into_iter().flat_map(|(node, bake)| {
            gives(node).map(move |mesh| (format!("{node}.{mesh}"), bake.clone())).collect::<Vec<_>>()
        });
        Self(outputs.collect())
    }

    /// The solid in the mesh that an output gives.
    pub fn inside(&self, mesh: &str) -> Option<&Bake> {
        self.0.get(mesh)
    }

    /// The first output that gives a mesh with this solid in it.
    pub fn mesh_of(&self, solid: &str) -> Option<&str> {
        self.0.iter().find(|(_, bake)| bake.solid == solid).map(|(mesh, _)| mesh.as_str())
    }

    /// How what an output gives is fitted: a mesh with the solid in it, a solid with the first mesh that it is baked into.
    pub fn fit(&self, output: &str) -> Option<Fit> {
        let mesh = if self.0.contains_key(output) { output } else { self.mesh_of(output)? };
        self.inside(mesh).map(|bake| bake.fit)
    }
}

/// The nodes that bake, each with what it bakes.
fn bakers<'a>(graph: &'a Graph, specs: &BTreeMap<&'a str, &'a NodeSpec>) -> BTreeMap<&'a str, Bake> {
    let mut found = BTreeMap::new();
    for (giver, spec) in specs {
        for solid in spec.outputs.iter().filter(|output| output.ty == "solid") {
            for node in graph.consumers(giver) {
                let bakes = specs.get(node).is_some_and(|spec| BAKERS.contains(&spec.id));
                if let Some(fit) = Some(node).filter(|_| bakes).and_then(|node| fit(graph, node)) {
                    found.insert(node, Bake { solid: format!("{giver}.{}", solid.name), fit });
                }
            }
        }
    }
    found
}

fn fit(graph: &Graph, node: &str) -> Option<Fit> {
    let params = graph.node_params(node)?;
    let Some(ParamValue::Int(resolution)) = params.get("resolution") else { return None };
    let Some(ParamValue::List(origin)) = params.get("origin") else { return None };
    let number =
        |item: &ParamValue| if let ParamValue::Int(n) = item { i32::try_from(*n).ok() } else { None };
    let origin: Vec<i32> = origin.iter().map(number).collect::<Option<_>>()?;
    let is_nearest = matches!(params.get("filter"), Some(ParamValue::Text(name)) if name == "nearest");
    Some(Fit {
        resolution: u32::try_from(*resolution).ok()?,
        origin: origin.try_into().ok()?,
        filter: if is_nearest { Filter::Nearest } else { Filter::Trilinear },
    })
}

#[cfg(test)]
mod tests {
    use breccia_engine::Document;

    use super::*;

    fn bakes(document: &str) -> Bakes {
        let document = Document::parse(document).unwrap();
        Bakes::of(&Graph::new(&document, &breccia_nodes::registry()).unwrap())
    }

    #[test]
    fn values_that_the_graph_offers_count_and_so_do_halves() {
        let found = bakes(
            r#"(format: "breccia-graph", version: 2,
            interface: (params: {"resolution": (targets: ["bake.resolution"], default: 96)}),
            nodes: {"shape": (type: "mesh.read", params: {"path": "a.glb"}), "checker": (type: "solid.checker"),
                "bake": (type: "mesh.bake", params: {"resolution": 7, "origin": [3, -4, 5], "filter": "nearest"}),
                "cut": (type: "mesh.cut"), "off": (type: "mesh.unwrap", mode: "bypass"), "picture": (type: "render.mesh")},
            links: ["shape.mesh -> bake.mesh", "checker.solid -> bake.solid", "bake.mesh -> off.mesh",
                "off.mesh -> cut.mesh", "cut.above -> picture.mesh"])"#,
        );
        let fit = Fit { resolution: 96, origin: [3, -4, 5], filter: Filter::Nearest };
        let bake = Bake { solid: "checker.solid".to_owned(), fit };
        for mesh in ["bake.mesh", "cut.above", "cut.below"] {
            assert_eq!(found.inside(mesh), Some(&bake), "{mesh}");
            assert_eq!(found.fit(mesh), Some(fit));
        }
        assert_eq!(found.fit("checker.solid"), Some(fit));
        for other in ["shape.mesh", "picture.image"] {
            assert!(found.inside(other).is_none() && found.fit(other).is_none(), "{other}");
        }
    }

    #[test]
    fn the_last_bake_counts_inside_groups_too() {
        let found = bakes(
            r#"(format: "breccia-graph", version: 2,
            nodes: {"shape": (type: "mesh.read", params: {"path": "a.glb"}), "first": (type: "solid.checker"),
                "bake": (type: "mesh.bake"), "again": (type: "flow.group", params: {"body": "vertices"})},
            links: ["shape.mesh -> bake.mesh", "first.solid -> bake.solid", "bake.mesh -> again.mesh"],
            groups: {"vertices": (
                interface: (inputs: {"mesh": (type: "mesh", targets: ["bake.mesh"])},
                    outputs: {"mesh": (node: "bake", socket: "mesh")}),
                nodes: {"second": (type: "solid.checker"), "bake": (type: "mesh.bake_vertices")},
                links: ["second.solid -> bake.solid"])})"#,
        );
        let solid = |mesh: &str| found.inside(mesh).map(|bake| bake.solid.as_str());
        assert_eq!(solid("bake.mesh"), Some("first.solid"));
        assert_eq!(solid("again/bake.mesh"), Some("again/second.solid"));
    }
}
