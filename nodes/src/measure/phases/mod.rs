//! Statistics of media of two phases.

mod compare;
mod components;
mod euler;
mod grid;
mod lines;
mod node;
mod read;
mod statistics;
#[cfg(test)]
mod tests;
mod threshold;

pub use compare::{PhaseSettings, compare_phases};
pub use components::connectivity;
pub use euler::{Neighbours, euler_number};
pub use grid::Grid;
pub use lines::{Chords, two_point};
pub(super) use node::MeasurePhases;
pub use read::PhaseError;
pub use threshold::otsu;
