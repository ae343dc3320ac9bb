//! `lazy.synthesis`: the lazily synthesised solid.

use std::sync::Arc;

use breccia_engine::{Context, Data, Digest, Node, NodeError, NodeSpec, ParamKind};

use super::candidates::Candidates;
use super::descriptors::Descriptors;
use super::initial::Initial;
use super::list;
use super::pyramid::Pyramid;
use super::schedule::{ColorRule, Schedule, Settings};
use super::similarity::Similarity;
use super::solid::LazySolid;
use super::tables::Tables;
use super::usage::Usage;
use crate::data::SolidValue;
use crate::exemplar::Exemplar;

/// The parameters that a synthesis and the balance of its usage share.
pub(super) fn cost_params(spec: NodeSpec) -> NodeSpec {
    let ints = |min, max| ParamKind::Ints { min_len: 1, max_len: 8, min, max };
    let defaults = Settings::default();
    spec.param(
        "passes",
        ints(0, 16),
        list(&defaults.passes),
        "count",
        "Correction passes, finest level first; the last entry serves all coarser levels.",
    )
    .choice("schedule", SCHEDULES, "Division of a pass into sub-passes at the finest level.")
    .choice("coarse_schedule", SCHEDULES, "Division of a pass into sub-passes at the coarser levels.")
    .param(
        "similar",
        ints(1, 4),
        list(&defaults.similar),
        "count",
        "2D candidates a pixel, finest level first.",
    )
    .param(
        "triples",
        ints(0, 12),
        list(&defaults.triples),
        "count",
        "3D candidates a pixel, finest level first.",
    )
    .float(
        "coherence",
        0.0..=8.0,
        defaults.coherence,
        "1",
        "Raises the distance of pixels that continue none of their neighbours by this fraction (κ).",
    )
    .float(
        "crossbar",
        0.0..=15.0,
        defaults.crossbar,
        "1",
        "Weight of a triple's crossbar error against the neighbourhood distances (λ).",
    )
    .choice(
        "color",
        &[
            ("nearest", "Of the three colours the one nearest to their mean, which keeps contrast."),
            ("mean", "The mean of the three colours, as in the paper."),
        ],
        "How the three colours of a voxel become one.",
    )
}

const SCHEDULES: &[(&str, &str)] = &[
    ("jacobi", "All voxels at once: the shortest chain of dependencies."),
    ("parity", "Two sub-passes: even, then odd coordinate sums."),
    ("octants", "The paper's eight sub-passes (of which complementary ones run together)."),
];
fn schedule(name: &str) -> Schedule {
    match name {
        "parity" => Schedule::Parity,
        "octants" => Schedule::Octants,
        _ => Schedule::Jacobi,
    }
}

/// Reads the shared parameters.
pub(super) fn read_cost(context: &Context<'_>) -> Result<Settings, NodeError> {
    Ok(Settings {
        seed: 0,
        period: None,
        passes: context.ints("passes")?,
        schedule: vec![schedule(context.text("schedule")?), schedule(context.text("coarse_schedule")?)],
        similar: context.ints("similar")?,
        triples: context.ints("triples")?,
        coherence: context.float("coherence")?,
        crossbar: context.float("crossbar")?,
        color: if context.text("color")? == "mean" { ColorRule::Mean } else { ColorRule::Nearest },
    })
}

pub(super) struct SynthesisNode;

impl Node for SynthesisNode {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "lazy.synthesis",
            3,
            "A solid synthesised on demand",
            "Nothing is computed here: the solid computes the voxels that are asked for, and those they depend on, \
             when they are asked for. For a seed every voxel has one colour, whatever else is asked for, in whatever \
             order, on whatever machine.",
        )
        .paper("Dong et al. 2008, section 5")
        .memory_only()
        .input("exemplar", "exemplar", "The exemplar, whose maps are looked up.")
        .input("pyramid", "pyramid", "Its pyramid.")
        .input("descriptors", "descriptors", "Its descriptors.")
        .input("similarity", "similarity", "Its 2D candidates.")
        .input("candidates", "candidates", "Its 3D candidates.")
        .input("initial", "initial", "What synthesis starts from.")
        .optional("usage", "usage", "Usage weights against collapse.")
        .optional(
            "taken",
            SolidValue::TYPE,
            "White where another solid has the voxels, such as particles: these are never computed. Needs one level and an \
             exemplar from `particles.matrix`.",
        )
        .output("solid", "solid", "The solid.")
        .int("seed", 0..=i64::MAX, 1, "count", "Seed of every random choice.")
        .param(
            "period",
            ParamKind::Ints { min_len: 0, max_len: 3, min: 8, max: 65536 },
            list(&[]),
            "voxels",
            "Period along x, y, z, or one number for all three; empty for an unbounded solid.",
        );
        cost_params(spec)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let exemplar = context.input::<Exemplar>("exemplar")?;
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let descriptors = context.input::<Descriptors>("descriptors")?;
        let similarity = context.input::<Similarity>("similarity")?;
        let candidates = context.input::<Candidates>("candidates")?;
        let initial = context.input::<Initial>("initial")?;
        let usage = context.optional::<Usage>("usage")?;
        let mut settings = read_cost(context)?;
        settings.seed = context.int("seed")? as u64;
        settings.period = match context.ints("period")?[..] {
            [] => None,
            [n] => Some([n as u32; 3]),
            [x, y, z] => Some([x as u32, y as u32, z as u32]),
            _ => return Err(NodeError::failed("`period` takes no, one or three numbers, found two")),
        };
        let mut hasher = blake3::Hasher::new();
        for digest in [
            exemplar.digest(),
            pyramid.digest(),
            descriptors.digest(),
            similarity.digest(),
            candidates.digest(),
        ] {
            hasher.update(&digest.0);
        }
        usage.iter().for_each(|usage| {
            hasher.update(&usage.digest().0);
        });
        let tables =
            Tables::new(&exemplar, &pyramid, &descriptors, &similarity, &candidates, usage.as_deref())
                .map_err(NodeError::failed)?;
        let digest = Digest::from(hasher.finalize());
        let mut solid = LazySolid::new(Arc::new(tables), (*initial).clone(), settings, digest);
        if let Some(taken) = context.optional::<SolidValue>("taken")? {
            solid = solid.with_taken(Arc::clone(&taken.0)).map_err(NodeError::failed)?;
        }
        context.set("solid", SolidValue(Arc::new(solid)));
        Ok(())
    }
}
