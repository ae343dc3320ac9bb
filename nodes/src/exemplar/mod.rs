//! Exemplars: aligned maps that guide a synthesis or are carried along.

mod exemplar;
mod feature;
mod make;
mod resize;
mod views;

pub use exemplar::{Exemplar, ExemplarError, MAX_SIDE, View};
pub use feature::{Feature, otsu_mask, signed_distance};
pub use make::{MakeSettings, make_exemplar};
pub use resize::halve;

use breccia_engine::Node;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![Box::new(make::MakeExemplar), Box::new(views::CombineViews)]
}
