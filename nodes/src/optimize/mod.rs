//! Texture optimisation with position and index histograms (Chen & Wang, "High quality solid texture synthesis using
//! position and index histogram matching", 2010), from stages that can be wired in other ways.
//!
//! A [`Field`] holds the colours of a box of voxels and where in the exemplar each came from; [`Matches`] hold for each
//! voxel and direction the exemplar's neighbourhood nearest to the one around it. [`search`](search::search)
//! makes matches from a field, [`solve`](solve::solve) a field from matches, in turn; [`start`](start::start) makes the first
//! field of a level. Directions and exemplars are oriented as in [`crate::lazy`]: cyclically.
//!
//! Voxels are updated in 64 phases, by a hash of their place. Histograms stand still within a phase and are
//! brought up to date, as integers, between phases. So they are seldom out of date, and the result does not
//! depend on the number of threads.

mod coherence;
mod constrain_node;
mod control_map;
mod device;
mod field;
mod histogram;
mod matches;
mod phases;
mod search;
mod search_node;
mod solid;
mod solid_node;
mod solve;
mod solve_device;
mod solve_node;
mod start;
mod start_node;
#[cfg(test)]
mod tests;
mod weights;

pub use control_map::{ControlMap, ControlMapError};
pub use field::{Field, level_size};
pub use histogram::{Histogram, histogram_image};
pub use matches::{DirectionMatches, Matches};
pub use search::{Method, SearchSettings, search};
pub use solid::{SolidSettings, field_volume};
pub use solve::{SolveSettings, Solver, solve};
pub use start::{start, upsample};
pub use weights::WeightSettings;

use breccia_engine::{Node, TypeInfo};

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![
        Box::new(start_node::StartNode),
        Box::new(search_node::SearchNode),
        Box::new(solve_node::SolveNode),
        Box::new(constrain_node::ConstrainNode),
        Box::new(solid_node::SolidNode),
        Box::new(histogram::HistogramNode),
    ]
}

/// The socket types of this family.
pub fn types() -> Vec<TypeInfo> {
    vec![TypeInfo::of::<Field>(), TypeInfo::of::<Matches>()]
}
