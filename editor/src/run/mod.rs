//! Running what is edited: what can run, in the background, and what is known of every node.

mod bakes;
mod board;
mod budget;
mod check;
mod draft;
mod runner;
mod thumbnail;

pub use bakes::{Bake, Bakes, Fit};
pub use board::{Board, NodeStatus, Phase};
pub use budget::MemoryBudget;
pub use check::{Checked, check};
pub use draft::draft;
pub use runner::{Item, Lane, Outcome, Runner, Update};
pub use thumbnail::{Thumbnail, thumbnail};

/// The name of a node in a run without the numbers of iterations: `zone[3]/node` is `zone/node`.
pub fn general(path: &str) -> String {
    let mut out = String::with_capacity(path.len());
    let mut inside = false;
    for c in path.chars() {
        match c {
            '[' => inside = true,
            ']' if inside => inside = false,
            c if !inside => out.push(c),
            _ => {}
        }
    }
    out
}
