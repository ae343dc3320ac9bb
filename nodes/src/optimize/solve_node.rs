//! `optimize.solve`: colours from matches.

use breccia_engine::{Context, Node, NodeError, NodeSpec, Sizing};

use super::field::Field;
use super::matches::Matches;
use super::search_node::control_map;
use super::solve::{SolveSettings, Solver, solve};
use super::start_node::no_level;
use super::weights::WeightSettings;
use crate::lazy::Pyramid;

pub(super) struct SolveNode;

impl Node for SolveNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "optimize.solve",
            1,
            "Colours of voxels from the neighbourhoods that match around them",
            "The optimisation phase. Every voxel is overlapped by the matched neighbourhoods of the voxels around it; their \
             texels are averaged, those of close matches more (iteratively re-weighted least squares), those used too \
             often less (position and colour histogram matching). The discrete solver then copies the texel nearest to that mean, \
             with its place in the exemplar, so that other maps can follow. Strengths are relative to an even share, so \
             that they suit all sizes; (4) in the paper counts voxels instead.",
        )
        .paper("Chen & Wang 2010, sections 4.2 and 4.4.1, equations 1, 2 and 4; Kopf et al. 2007, equation 3 of the former")
        .on_device_apart()
        .input("matches", "matches", "The nearest neighbourhoods.")
        .input("pyramid", "pyramid", "The exemplar's levels.")
        .optional("field", "field", "The voxels that were matched: their histograms are the ones to start with.")
        .optional("theta", "image", "Control map θ: the brighter, the more often the exemplar's colours there appear.")
        .output("field", "field", "The voxels.")
        .choice(
            "solver",
            &[
                ("discrete", "The texel nearest to the mean is copied, with its place."),
                ("mean", "The mean, as in Kopf et al. 2007: smooth, and blurred."),
            ],
            "What becomes a voxel's colour.",
        )
        .float(
            "gamma",
            0.0..=2.0,
            0.8,
            "1",
            "Exponent γ of the energy: a match at distance r weighs r^(γ − 2); 2 weighs all alike.",
        )
        .float(
            "position",
            0.0..=1e6,
            300.0,
            "1",
            "Strength of position histogram matching: weights are divided by 1 + position · max(0, H/θ − 1). 0 turns it off.",
        )
        .int("smoothing", 0..=16, 0, "pixels", "Radius of the square over which the position histogram is averaged.")
        .float(
            "color",
            0.0..=1e6,
            5000.0,
            "1",
            "Strength of colour histogram matching: weights are divided by 1 + color · Σ max(0, H_s − H_e), shares of 16 bins a \
             channel. 0 turns it off.",
        )
        .int("seed", 0..=i64::MAX, 1, "count", "The order in which voxels are updated.")
        .int("sweep", 0..=i64::from(u32::MAX), 0, "count", "The number of the sweep; each has an order of its own.")
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        Some(sizing.input("matches")? / 2)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let matches = context.input::<Matches>("matches")?;
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let before = context.optional::<Field>("field")?;
        let views = pyramid.levels.get(matches.level).ok_or_else(|| no_level(matches.level, &pyramid))?;
        for (direction, matched) in matches.directions.iter().enumerate() {
            let view = &views[direction.min(views.len() - 1)];
            if matched.pixels.iter().any(|&pixel| !view.holds(pixel)) {
                return Err(NodeError::Failed(
                    "the matches lie outside the exemplar; expected the pyramid that they were searched in"
                        .into(),
                ));
            }
        }
        let fits = |field: &Field| field.sources.len() == views.len();
        if !before.as_deref().is_none_or(fits) {
            return Err(NodeError::Failed("the voxels are of another exemplar than the pyramid".into()));
        }
        let settings = SolveSettings {
            solver: if context.text("solver")? == "mean" { Solver::Mean } else { Solver::Discrete },
            gamma: context.float("gamma")?,
            weights: WeightSettings {
                position: context.float("position")?,
                smoothing: context.int("smoothing")? as i32,
                color: context.float("color")?,
            },
            seed: context.int("seed")? as u64,
            sweep: context.int("sweep")? as u32,
        };
        let theta = control_map(context, "theta", matches.level)?;
        let field = solve(&matches, views, before.as_deref(), theta.as_ref(), &settings, context)?;
        context.set("field", field);
        Ok(())
    }
}
