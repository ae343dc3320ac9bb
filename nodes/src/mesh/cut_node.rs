//! Node `mesh.cut`.

use breccia_engine::{Context, Node, NodeError, NodeSpec, ParamKind, ParamValue};

use super::{Plane, cut_mesh};
use crate::data::Mesh;

const DOCS: &str = "Both halves are closed by a flat cap with UVs and normals of its own. They keep the voxel space of \
the whole, so baking them with one solid carries its pattern on through the cut.\n\nWhere the mesh has UVs, its \
atlas shrinks to make room for the cap's chart, and its textures are dropped: bake after cutting.";

const UNITS: &[(&str, &str)] = &[
    ("fraction", "0 to 1 from the smallest to the largest corner of the bounding box"),
    ("world", "the mesh's own units"),
];

/// Cuts a mesh by a plane.
pub(super) struct Cut;

impl Node for Cut {
    fn spec(&self) -> NodeSpec {
        let floats = |limit: f64| ParamKind::Floats { min_len: 3, max_len: 3, min: -limit, max: limit };
        let list = |numbers: [f64; 3]| ParamValue::List(numbers.map(ParamValue::Float).to_vec());
        NodeSpec::new("mesh.cut", 1, "Cuts a mesh by a plane into two closed halves", DOCS)
            .input("mesh", "mesh", "The mesh.")
            .output("above", "mesh", "The half that the normal points to.")
            .output("below", "mesh", "The other half.")
            .param("point", floats(1e9), list([0.5; 3]), "see `units`", "A point of the plane.")
            .choice("units", UNITS, "What the numbers of `point` mean.")
            .param("normal", floats(1e9), list([1.0, 0.0, 0.0]), "1", "The plane's normal, of any length.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let mesh = context.input::<Mesh>("mesh")?;
        let mut point = three(context, "point")?;
        if context.text("units")? == "fraction" {
            let (lo, hi) = mesh.bounds().unwrap_or_default();
            point = std::array::from_fn(|i| {
                let (lo, hi) = (f64::from(lo[i]), f64::from(hi[i]));
                lo + (hi - lo) * point[i]
            });
        }
        let plane = Plane { point, normal: three(context, "normal")? };
        let halves = cut_mesh(&mesh, plane).map_err(NodeError::failed)?;
        context.set("above", halves.above);
        context.set("below", halves.below);
        Ok(())
    }
}

fn three(context: &Context<'_>, name: &str) -> Result<[f64; 3], NodeError> {
    let found = context.floats(name)?;
    found.try_into().map_err(|found| NodeError::Failed(format!("{name} {found:?} is not three numbers")))
}
