//! `optimize.solid`: the result of an optimisation as a solid.

use std::sync::Arc;

use breccia_engine::{Context, Node, NodeError, NodeSpec, Sizing};

use super::field::Field;
use super::solid::{SolidSettings, field_volume};
use crate::data::SolidValue;
use crate::exemplar::Exemplar;
use crate::lazy::Pyramid;
use crate::solid::{Repeat, VolumeSolid};

pub(super) struct SolidNode;

impl Node for SolidNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "optimize.solid",
            1,
            "Optimised voxels as a solid, with all maps of the exemplar",
            "Looks up every map that the exemplar carries at the places that the voxels came from: colour, normal, \
             roughness and so on. Voxels of a coarse level have colours only.",
        )
        .paper("Chen & Wang 2010, section 3: source positions are kept")
        .memory_only()
        .input("field", "field", "The voxels.")
        .input("exemplar", "exemplar", "The exemplar, whose maps are looked up.")
        .input("pyramid", "pyramid", "The exemplar's levels.")
        .output("solid", "solid", "The solid: it repeats, or with a margin ends at its box.")
        .int("margin", 0..=64, 0, "voxels", "Voxels to cut off on every side; the margin that the optimisation was started with.")
        .flag("mixed", false, "Take the voxels' own colours, which the mean solver mixes, rather than those of the exemplar.")
        .flag("sources", false, "Add a map `source`: column, row and view that each voxel came from.")
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        Some(sizing.input("field")? / 2)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let field = context.input::<Field>("field")?;
        let exemplar = context.input::<Exemplar>("exemplar")?;
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let margin = context.int("margin")? as usize;
        let views = pyramid.levels.get(field.level).map_or(&[][..], Vec::as_slice);
        let inside =
            field.sources.iter().zip(views).all(|(sources, view)| sources.iter().all(|&s| view.holds(s)));
        if views.len() != field.sources.len() || !inside || exemplar.views.len() != views.len() {
            return Err(NodeError::Failed(
                "the voxels are of another exemplar; expected the one that they were optimised for".into(),
            ));
        }
        if field.size.iter().any(|&n| n <= 2 * margin) {
            return Err(NodeError::Failed(format!(
                "nothing is left of {:?} voxels without a margin of {margin} on every side",
                field.size
            )));
        }
        let (mixed, sources) = (context.flag("mixed")?, context.flag("sources")?);
        let volume = field_volume(&field, &exemplar, &pyramid, &SolidSettings { margin, mixed, sources });
        let repeat = if margin == 0 { Repeat::Periodic } else { Repeat::Clamp };
        let solid = VolumeSolid::new(Arc::new(volume), repeat).map_err(NodeError::failed)?;
        context.set("solid", SolidValue(Arc::new(solid)));
        Ok(())
    }
}
