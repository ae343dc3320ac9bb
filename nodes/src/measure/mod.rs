//! Measures of a solid against its exemplar.

mod colors;
mod compare;
mod contrast;
mod correlation;
mod flat;
mod orientation;
mod patches;
mod quality;
mod structure;
mod views;

pub use colors::color_divergence;
pub use compare::{MeasureError, Quality, QualitySettings, measure_quality};
pub use structure::Structure;

use breccia_engine::Node;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![Box::new(quality::MeasureQuality), Box::new(quality::MeasureVolume)]
}
