//! The canvas: nodes and links of one graph, drawn anew every frame from the document. What the user does to it comes out as
//! [`Action`](crate::action::Action)s; nothing is changed here but where the canvas looks.

mod geometry;
mod gesture;
mod legend;
mod links;
mod minimap;
mod node;
mod touch;
mod view;

pub use geometry::{Geometry, HEADER, ROW, WIDTH, size_of};
pub use node::{bytes, seconds};
pub use view::{Canvas, Sight};
