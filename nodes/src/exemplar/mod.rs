//! Exemplars: aligned maps that guide a synthesis or are carried along.

mod feature;
mod make;
mod resize;
mod view;
mod views;

pub use feature::{Feature, otsu_mask, signed_distance};
pub(crate) use feature::{feature_channel, luminance};
pub use make::{MakeSettings, make_exemplar};
pub use resize::halve;
pub(crate) use resize::shrink;
pub use view::{Exemplar, ExemplarError, MAX_SIDE, View};
pub(crate) use views::combine;

use breccia_engine::Node;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![Box::new(make::MakeExemplar), Box::new(views::CombineViews)]
}
