//! The nodes `particles.select`, `particles.recolor` and `particles.deform`.

use std::sync::Arc;

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, ParamKind};

use super::deform::{DeformedSolid, Part};
use super::deformation::{Deformation, Kind};
use super::packing::Packing;
use super::recolor::{RecolorSettings, RecolorSolid};
use super::select::{SelectSettings, select};
use crate::data::{Solid, SolidValue};
use crate::solid::params::ints;

/// Fewer or other particles.
pub(super) struct SelectNode;

impl Node for SelectNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.select",
            1,
            "Particles removed, thinned out or scaled",
            "Keeps a fraction of the particles, those within limits of volume, and all but some by number; scales what stays. Scaled up, particles may \
             overlap: `particles.fill` parts them.",
        )
        .paper("Du et al. 2013, section 4.2")
        .input("packing", Packing::TYPE, "The particles in their places.")
        .output("packing", Packing::TYPE, "Those that stay; numbers count anew.")
        .float("keep", 0.0..=1.0, 1.0, "fraction", "How many stay, drawn by their places.")
        .int("least", 0..=1 << 40, 0, "voxels", "Smaller particles are removed.")
        .int("most", 0..=1 << 40, 1 << 40, "voxels", "Larger particles are removed.")
        .param(
            "remove",
            ParamKind::Ints { min_len: 0, max_len: 4096, min: 1, max: i64::from(u32::MAX) },
            ints([]),
            "numbers",
            "Particles that are removed, by their numbers in `particles.list`.",
        )
        .float("scale", 0.05..=4.0, 1.0, "1", "How much what stays is scaled.")
        .int("seed", 0..=i64::MAX, 1, "count", "Seed of the draw.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        let settings = SelectSettings {
            keep: context.float("keep")?,
            least: context.int("least")? as u64,
            most: context.int("most")? as u64,
            remove: context.ints("remove")?.iter().map(|&n| n as u32).collect(),
            scale: context.float("scale")?,
            seed: context.int("seed")? as u64,
        };
        context.set("packing", select(&packing, &settings));
        Ok(())
    }
}

/// New colours.
pub(super) struct RecolorNode;

impl Node for RecolorNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.recolor",
            1,
            "Particles and matrix in the colours of other solids",
            "Any solid can give its colours: a lazy synthesis, a checkerboard, one colour. Other maps stay as they are.",
        )
        .paper("Du et al. 2013, section 4.2, Fig. 15")
        .memory_only()
        .input("packing", Packing::TYPE, "The particles in their places.")
        .input("solid", SolidValue::TYPE, "The solid of these particles.")
        .optional("particles", SolidValue::TYPE, "Where particles take their colours from.")
        .optional("matrix", SolidValue::TYPE, "Where the matrix takes its colours from.")
        .output("solid", SolidValue::TYPE, "The solid in its new colours.")
        .choice(
            "each",
            &[("particle", "A particle takes the colour at its centre."), ("voxel", "Every voxel takes its own.")],
            "Which colour a particle takes.",
        )
        .float("strength", 0.0..=1.0, 1.0, "fraction", "How much of the new colours shows.")
        .float("detail", 0.0..=1.0, 1.0, "fraction", "How much of a particle's own light and dark stays.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        let base = Arc::clone(&context.input::<SolidValue>("solid")?.0);
        let texture = |name: &str| -> Result<Option<Arc<dyn Solid>>, NodeError> {
            Ok(context.optional::<SolidValue>(name)?.map(|solid| Arc::clone(&solid.0)))
        };
        let (particles, matrix) = (texture("particles")?, texture("matrix")?);
        let settings = RecolorSettings {
            whole: context.text("each")? == "particle",
            strength: context.float("strength")?,
            detail: context.float("detail")?,
        };
        let solid = RecolorSolid::new(packing, base, particles, matrix, settings, &*context)?;
        context.set("solid", SolidValue(Arc::new(solid)));
        Ok(())
    }
}

/// A deformed box.
pub(super) struct DeformNode;

impl Node for DeformNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.deform",
            1,
            "A box of particles bent, twisted or tapered, the particles kept rigid",
            "Deforms the packing's domain. Centres of particles go where the deformation takes them; particles themselves are \
             turned, and deformed only as far as `rigidity` lets them. The matrix takes the rest.",
        )
        .paper("Du et al. 2013, section 4.2, Fig. 14")
        .memory_only()
        .input("packing", Packing::TYPE, "The particles in their places.")
        .optional("matrix", SolidValue::TYPE, "What lies between them; without one it is black.")
        .output("solid", SolidValue::TYPE, "The deformed solid.")
        .output("particles", SolidValue::TYPE, "White where particles are.")
        .output("inside", SolidValue::TYPE, "White where the domain is.")
        .choice(
            "kind",
            &[
                ("bend", "The axis becomes an arc towards the axis after it (x, y, z, x)."),
                ("twist", "The far end is turned around the axis."),
                ("taper", "The far end is scaled across the axis."),
            ],
            "What is done.",
        )
        .choice("axis", &[("x", "Along x."), ("y", "Along y."), ("z", "Along z.")], "The axis along which the deformation varies.")
        .float("angle", -360.0..=360.0, 60.0, "degrees", "Angle of the arc, or of the far end's turn.")
        .float("end", 0.05..=4.0, 0.5, "1", "Scale of the far end, for `taper`.")
        .float("rigidity", 0.0..=1.0, 1.0, "fraction", "1 keeps particles' shapes, 0 deforms them like the matrix.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let packing = context.input::<Packing>("packing")?;
        let matrix = context.optional::<SolidValue>("matrix")?.map(|matrix| Arc::clone(&matrix.0));
        let angle = context.float("angle")?.to_radians();
        let kind = match context.text("kind")? {
            "twist" => Kind::Twist(angle),
            "taper" => Kind::Taper(context.float("end")?),
            _ => Kind::Bend(angle),
        };
        let axis = match context.text("axis")? {
            "y" => 1,
            "z" => 2,
            _ => 0,
        };
        let deformation = Deformation { kind, axis, size: packing.size.map(f64::from) };
        let rigidity = context.float("rigidity")?;
        for (name, part) in [("solid", Part::All), ("particles", Part::Particles), ("inside", Part::Box)] {
            let matrix = matrix.clone().filter(|_| part == Part::All);
            let solid = DeformedSolid::new(Arc::clone(&packing), matrix, deformation, rigidity, part);
            context.set(name, SolidValue(Arc::new(solid)));
        }
        Ok(())
    }
}
