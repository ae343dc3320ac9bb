//! `search.basis`: principal components of neighbourhoods.

use breccia_engine::{Context, Node, NodeError, NodeSpec, Sizing};

use super::basis::{BasisError, Keep, MOST, PatchBasis, patch_basis};
use super::window::Window;
use crate::lazy::Pyramid;

pub(super) struct BasisNode;

impl Node for BasisNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "search.basis",
            1,
            "Principal components of an exemplar's neighbourhoods",
            "Takes every square neighbourhood of one level of the exemplar, all four channels (three of colour, one of \
             feature), and finds the directions along which they differ most. Searching then compares a \
             few coefficients instead of hundreds of samples. Each view has a basis of its own. An exemplar whose \
             neighbourhoods differ in fewer ways than asked for gets a basis of fewer components.",
        )
        .paper("Chen & Wang 2010, section 4.3; subspace iteration: Golub & Van Loan, section 8.2")
        .input("pyramid", "pyramid", "The exemplar's levels.")
        .output("basis", "patch_basis", "The neighbourhood and its basis, a quantised one.")
        .int("level", 0..=15, 0, "count", "The level; 0 is the finest.")
        .int("size", 1..=32, 8, "pixels", "Edge of the square neighbourhood, even or odd; no larger than the level.")
        .int(
            "dims",
            1..=MOST as i64,
            16,
            "count",
            "The most components kept; searching is quickest with a multiple of 16.",
        )
        .float("variance", 0.0..=1.0, 1.0, "1", "No more components than explain this share of the variance.")
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        let size = sizing.int("size")?.unsigned_abs();
        Some(size * size * 4 * sizing.int("dims")?.unsigned_abs() * 2)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let window = Window { size: context.int("size")? as i32 };
        let keep = Keep { dims: context.int("dims")? as usize, variance: context.float("variance")? };
        let basis: Result<PatchBasis, BasisError> =
            patch_basis(&pyramid, context.int("level")? as usize, window, keep, context);
        let basis = basis.map_err(|error| match error {
            BasisError::Cancelled => NodeError::Cancelled,
            other => NodeError::input(other),
        })?;
        context.set("basis", basis);
        Ok(())
    }
}
