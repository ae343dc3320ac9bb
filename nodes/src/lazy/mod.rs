//! Lazy solid synthesis (Dong, Lefebvre, Tong & Drettakis, "Lazy Solid Texture Synthesis", 2008), in integer
//! arithmetic, so that every machine, thread count and order of requests gives the same bits.
//!
//! Data flows one way: [`Pyramid`] → [`Descriptors`] → [`Similarity`]; [`Pyramid`] → [`Candidates`] →
//! [`Initial`] (slab, then jitter); all of them → [`Usage`] and finally [`LazySolid`].
//!
//! Directions are numbered x = 0, y = 1, z = 2, and taken cyclically: the exemplar of direction `e` has its
//! columns along axis `e + 1` and its rows along axis `e + 2`. So the rows of one exemplar run along the columns
//! of the next, the three share one rule, and a single exemplar needs one set of candidates.

mod basis;
mod candidates;
mod coherence;
mod color;
mod dependency;
mod descriptors;
mod device;
mod domain;
mod field;
mod initial;
mod isa;
mod jitter;
mod kernel;
mod nearest;
#[cfg(test)]
mod oracle;
mod pyramid;
mod pyramid_node;
pub(crate) mod random;
mod schedule;
mod similarity;
mod slab;
mod solid;
mod statistics;
mod synthesis_node;
mod tables;
mod taken;
#[cfg(test)]
mod tests;
mod usage;
mod usage_node;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use basis::eigen;
pub use basis::{Basis, DIMS, Descriptor, LevelBases};
pub use candidates::{CandidateSettings, Candidates, SET as CANDIDATES, Triple, make_candidates};
pub use dependency::{Dependency, dependency};
pub use descriptors::{Descriptors, LevelDescriptors, make_descriptors};
pub use domain::Domain;
pub use initial::Initial;
pub use isa::{Isa, available as available_instruction_sets};
pub use jitter::Jitter;
pub use pyramid::{LEAST_SIDE, LevelView, N, Pixel, Pyramid};
pub use schedule::{ColorRule, Schedule, Settings};
pub(crate) use similarity::apart;
pub use similarity::{Similarity, similarity_sets};
pub use slab::make_slab;
pub use solid::{LazySolid, TakenError};
pub use statistics::candidate_statistics;
pub use tables::Tables;
pub use usage::{Usage, UsageSettings, balance_usage};

use breccia_engine::{Node, ParamValue, TypeInfo};

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![
        Box::new(pyramid_node::PyramidNode),
        Box::new(descriptors::DescriptorsNode),
        Box::new(similarity::SimilarityNode),
        Box::new(candidates::CandidatesNode),
        Box::new(statistics::StatisticsNode),
        Box::new(slab::SlabNode),
        Box::new(jitter::JitterNode),
        Box::new(usage_node::UsageNode),
        Box::new(synthesis_node::SynthesisNode),
    ]
}

/// The socket types of this family.
pub fn types() -> Vec<TypeInfo> {
    vec![
        TypeInfo::of::<Pyramid>(),
        TypeInfo::of::<Descriptors>(),
        TypeInfo::of::<Similarity>(),
        TypeInfo::of::<Candidates>(),
        TypeInfo::of::<Initial>(),
        TypeInfo::of::<Usage>(),
    ]
}

/// The entry of a per-level list (finest first) for a level; the last entry serves all coarser levels.
fn per_level(values: &[i64], level: usize) -> i64 {
    values.get(level).or(values.last()).copied().unwrap_or(1)
}

/// A list parameter's value.
fn list(values: &[i64]) -> ParamValue {
    ParamValue::List(values.iter().map(|&v| ParamValue::Int(v)).collect())
}
