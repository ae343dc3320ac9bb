//! `lazy.usage`: usage weights against collapse.

use std::sync::Arc;

use breccia_engine::{Context, Node, NodeError, NodeSpec, Sizing};

use super::candidates::Candidates;
use super::descriptors::Descriptors;
use super::initial::Initial;
use super::pyramid::Pyramid;
use super::similarity::Similarity;
use super::synthesis_node::{cost_params, read_cost};
use super::tables::Tables;
use super::usage::{UsageSettings, balance_usage};
use crate::exemplar::Exemplar;

pub(super) struct UsageNode;

impl Node for UsageNode {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "lazy.usage",
            3,
            "Balances how often each exemplar pixel is used",
            "Small test volumes are synthesised with seeds of their own, and pixels used too often become dearer, \
             for good. Without it, structured exemplars tend to collapse to their commonest colour. Its settings \
             should be those of the synthesis that it serves.",
        )
        .paper("the index histogram of Chen & Wang 2010, section 4.4.2, measured beforehand to stay lazy")
        .input("exemplar", "exemplar", "The exemplar.")
        .input("pyramid", "pyramid", "Its pyramid.")
        .input("descriptors", "descriptors", "Its descriptors.")
        .input("similarity", "similarity", "Its 2D candidates.")
        .input("candidates", "candidates", "Its 3D candidates.")
        .input("initial", "initial", "What synthesis starts from.")
        .output("usage", "usage", "The weights.")
        .int("rounds", 0..=16, 3, "count", "Test volumes, one after the other; 0 leaves usage alone.")
        .int("size", 16..=256, 64, "voxels", "Edge of a test volume.")
        .float(
            "rate",
            0.0..=2.0,
            0.3,
            "1",
            "How far a weight moves in a round for each factor of two in use, in thirds of the mean cost.",
        )
        .float(
            "contrast",
            0.0..=1.5,
            0.95,
            "of the exemplar's",
            "The wanted contrast: where the three colours of a voxel disagree, choosing among them costs contrast, and \
             the choice is moved away from the mean colour to restore it. More is crisper and noisier; 0 leaves it as \
             it comes.",
        )
        .draft("size", 2, 32);
        cost_params(spec)
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        // A pixel of the pyramid has four bytes, and so has a weight.
        Some(sizing.input("pyramid")? / 4 * 4)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let exemplar = context.input::<Exemplar>("exemplar")?;
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let tables = Tables::new(
            &exemplar,
            &pyramid,
            &*context.input::<Descriptors>("descriptors")?,
            &*context.input::<Similarity>("similarity")?,
            &*context.input::<Candidates>("candidates")?,
            None,
        )
        .map_err(NodeError::failed)?;
        let initial: Arc<Initial> = context.input("initial")?;
        let usage = UsageSettings {
            rounds: context.int("rounds")? as usize,
            size: context.int("size")? as u32,
            rate: context.float("rate")?,
            contrast: context.float("contrast")?,
        };
        let settings = read_cost(context)?;
        let weights = balance_usage(&pyramid, tables, &initial, &settings, &usage, &*context)?;
        context.set("usage", weights);
        Ok(())
    }
}
