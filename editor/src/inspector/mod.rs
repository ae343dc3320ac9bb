//! The inspector: what is selected, with every parameter, its help and its state; the graph itself if nothing is.

mod curve;
mod document;
mod help;
mod node;
mod param;
mod widget;

pub use document::document;
pub use node::{Subject, node};
pub use param::Row;
