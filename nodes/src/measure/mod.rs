//! Measures of a solid against its exemplar.

mod colors;
mod compare;
mod contrast;
mod copies;
mod correlation;
mod curves;
mod cuts;
mod cuts_node;
mod flat;
mod laplacian;
mod likeness;
mod matches;
mod nearest;
mod orientation;
mod patches;
mod phases;
mod quality;
mod random;
mod structure;
mod table;
mod views;
mod wasserstein;

pub use colors::color_divergence;
pub use compare::{MeasureError, QualitySettings, measure_quality, measure_views};
pub use curves::LikenessCurves;
pub use likeness::{Likeness, Quality};
pub use phases::{
    Chords, Grid, Neighbours, PhaseError, PhaseSettings, compare_phases, connectivity, euler_number, otsu,
    two_point,
};
pub use table::quality_report;

use breccia_engine::Node;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![
        Box::new(quality::MeasureQuality),
        Box::new(quality::MeasureVolume),
        Box::new(phases::MeasurePhases),
        Box::new(cuts_node::MeasureCuts),
    ]
}
