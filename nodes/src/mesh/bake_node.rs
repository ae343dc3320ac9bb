//! Node `mesh.bake`.

use breccia_engine::{Context, Node, NodeError, NodeSpec, ParamKind, ParamValue, Sizing};

use super::{BakeSettings, Filter, MAX_ORIGIN, MAX_RESOLUTION, MAX_TEXTURE, bake_solid};
use crate::data::{Mesh, SolidValue};

const DOCS: &str = "Each texel asks the solid for the voxels at its place on the surface, so that only voxels near \
the surface are ever synthesised. The mesh's own UVs are used where they lie inside 0 to 1, else an atlas is made.\n\n\
All maps of the solid but labels become textures of the same name. A `normal` map is passed through as stored: its \
vectors stand in the tangent frame of the exemplar.\n\n\
The mesh's bounding box (of a part: that of the whole it was cut from) has its smallest corner at voxel `origin`, \
and its longest side spans `resolution` voxels.";

pub(super) const FILTERS: &[(&str, &str)] = &[
    ("trilinear", "weighted mean of the eight nearest voxels"),
    ("nearest", "the voxel that holds the point"),
];

/// Bakes a solid into the textures of a mesh.
pub(super) struct Bake;

impl Node for Bake {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new("mesh.bake", 2, "Bakes a solid into the textures of a mesh", DOCS)
            .on_device()
            .input("mesh", "mesh", "The mesh.")
            .input("solid", "solid", "What it is to be carved out of.")
            .output("mesh", "mesh", "The mesh with a texture for each map of the solid.");
        with_resolution(spec)
            .int(
                "texture_size",
                1..=i64::from(MAX_TEXTURE),
                2048,
                "texels",
                "Texels along a side of the textures.",
            )
            .choice("filter", FILTERS, "How samples between voxel centres are found.")
            .int("gutter", 0..=256, 8, "texels", "How far colours are spread beyond the borders of charts.")
            .draft("texture_size", 4, 256)
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        // The mesh, and a texture of a colour's three bytes.
        Some(sizing.input("mesh").unwrap_or(0) + 3 * sizing.int("texture_size")?.unsigned_abs().pow(2))
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let (mesh, solid) = (context.input::<Mesh>("mesh")?, context.input::<SolidValue>("solid")?);
        let settings = BakeSettings {
            resolution: context.int("resolution")? as u32,
            texture_size: context.int("texture_size")? as u32,
            filter: filter(context)?,
            gutter: context.int("gutter")? as u32,
            origin: origin(context)?,
            ..BakeSettings::default()
        };
        let baked = bake_solid(&mesh, solid.0.as_ref(), settings, context)?;
        context.set("mesh", baked);
        Ok(())
    }
}

/// Adds the parameters that lay voxel space over a mesh.
pub(super) fn with_resolution(spec: NodeSpec) -> NodeSpec {
    let reach = i64::from(MAX_ORIGIN);
    let kind = ParamKind::Ints { min_len: 3, max_len: 3, min: -reach, max: reach };
    let zero = ParamValue::List(vec![ParamValue::Int(0); 3]);
    spec.int(
        "resolution",
        1..=i64::from(MAX_RESOLUTION),
        512,
        "voxels",
        "Voxels along the longest side of the mesh's bounding box.",
    )
    .param(
        "origin",
        kind,
        zero,
        "voxels",
        "The voxel at the smallest corner of the mesh's bounding box.",
    )
}

pub(super) fn origin(context: &Context<'_>) -> Result<[i32; 3], NodeError> {
    let found = context.ints("origin")?;
    let numbers: Vec<i32> = found.iter().filter_map(|&c| i32::try_from(c).ok()).collect();
    numbers
        .try_into()
        .map_err(|_| NodeError::Failed(format!("origin {found:?} is not three voxel coordinates")))
}

pub(super) fn filter(context: &Context<'_>) -> Result<Filter, NodeError> {
    Ok(if context.text("filter")? == "nearest" { Filter::Nearest } else { Filter::Trilinear })
}
