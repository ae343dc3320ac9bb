//! The node `particles.deform`.

use std::sync::Arc;

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::deform::{DeformedSolid, Part};
use super::deformation::{Deformation, Kind};
use super::packing::Packing;
use crate::data::SolidValue;

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
