//! `optimize.search`: the nearest neighbourhoods.

use breccia_engine::{Context, Node, NodeError, NodeSpec, Sizing};

use super::control_map::ControlMap;
use super::field::Field;
use super::search::{Method, SearchSettings, search};
use crate::data::Image;
use crate::lazy::Pyramid;
use crate::search::{Patches, SimilarSets};

pub(super) struct SearchNode;

impl Node for SearchNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "optimize.search",
            1,
            "The exemplar's neighbourhood nearest to each voxel's, in each direction",
            "The search phase. A k-coherence search compares the neighbourhoods that continue what the voxels around came \
             from, and for the voxels near the centre their similarity sets; an exhaustive one compares all, which pays at \
             the coarsest level: the former only proposes what is there already. With index histogram matching, \
             neighbourhoods that are matched more often than an even share count as farther away.",
        )
        .paper("Chen & Wang 2010, sections 4.3 and 4.4.2, equations 5 and 6")
        .on_device()
        .input("field", "field", "The voxels.")
        .input("patches", "patches", "The exemplar's neighbourhoods at the same level.")
        .optional("similar", "similar_sets", "Their similarity sets; without them each voxel proposes what continues it alone.")
        .optional("pyramid", "pyramid", "The exemplar's levels; needed with `phi`.")
        .optional("phi", "image", "Control map φ: the brighter, the more often neighbourhoods there are matched.")
        .output("matches", "matches", "The nearest neighbourhoods.")
        .memory_only()
        .choice(
            "method",
            &[
                ("coherent", "k-coherence search."),
                ("exhaustive", "Compares all neighbourhoods of the exemplar."),
            ],
            "Which neighbourhoods are compared.",
        )
        .int(
            "reach",
            0..=16,
            1,
            "voxels",
            "Voxels up to so far from the centre propose their whole similarity sets, those farther away what continues them.",
        )
        .float(
            "index",
            0.0..=1000.0,
            8.0,
            "1",
            "Strength of index histogram matching: the squared distance is multiplied by 1 + index · max(0, H/φ − 1), H/φ \
             being how often a neighbourhood is matched compared to an even share. 0 turns it off.",
        )
        .flag("x", true, "Whether slices across x are to look like the exemplar.")
        .flag("y", true, "Whether slices across y are to look like the exemplar.")
        .flag("z", true, "Whether slices across z are to look like the exemplar.")
        .int("seed", 0..=i64::MAX, 1, "count", "The order in which voxels are updated.")
        .int("sweep", 0..=i64::from(u32::MAX), 0, "count", "The number of the sweep; each has an order of its own.")
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        // Of the six bytes of a voxel twelve come.
        Some(sizing.input("field")? * 2)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let field = context.input::<Field>("field")?;
        let patches = context.input::<Patches>("patches")?;
        let sets = context.optional::<SimilarSets>("similar")?;
        let settings = SearchSettings {
            method: if context.text("method")? == "exhaustive" {
                Method::Exhaustive
            } else {
                Method::Coherent
            },
            reach: context.int("reach")? as i32,
            index: context.float("index")?,
            directions: [context.flag("x")?, context.flag("y")?, context.flag("z")?],
            seed: context.int("seed")? as u64,
            sweep: context.int("sweep")? as u32,
        };
        if settings.directions == [false; 3] {
            return Err(NodeError::Failed(
                "no direction is matched, expected at least one of x, y and z".into(),
            ));
        }
        let level = patches.basis.level;
        if field.level != level {
            return Err(NodeError::Failed(format!(
                "the neighbourhoods are of level {level}, the voxels of level {}; expected the same",
                field.level
            )));
        }
        let fits = |sets: &SimilarSets| {
            let mut pairs = sets.views.iter().zip(&patches.views);
            sets.views.len() == patches.views.len()
                && pairs.all(|(s, view)| s.len() == (view.width * view.height) as usize * sets.k)
        };
        if field.sources.len() != patches.views.len() || !sets.as_deref().is_none_or(fits) {
            return Err(NodeError::Failed(
                "voxels, neighbourhoods and similarity sets are of different exemplars; expected one".into(),
            ));
        }
        let phi = control_map(context, "phi", level)?;
        let matches = search(&field, &patches, sets.as_deref(), phi.as_ref(), &settings, context)?;
        context.set("matches", matches);
        Ok(())
    }
}

/// The control map linked to an input, if there is one.
pub(super) fn control_map(
    context: &Context<'_>,
    name: &str,
    level: usize,
) -> Result<Option<ControlMap>, NodeError> {
    let Some(image) = context.optional::<Image>(name)? else { return Ok(None) };
    let Some(pyramid) = context.optional::<Pyramid>("pyramid")? else {
        return Err(NodeError::Failed(format!("input `{name}` needs input `pyramid` as well")));
    };
    ControlMap::new(&image, &pyramid, level).map(Some).map_err(NodeError::input)
}
