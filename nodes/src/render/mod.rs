//! Pictures of textured meshes and solids, made on the CPU without a window.

mod camera;
mod contact_sheet;
mod cube;
mod cutaway;
mod error;
mod sheet;
mod studio;
mod vector;

pub use camera::Camera;
pub use contact_sheet::contact_sheet;
pub use cutaway::{CutawaySettings, cutaway};
pub use error::RenderError;
pub use studio::Background;

use breccia_engine::Node;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![Box::new(cube::Cube), Box::new(sheet::Sheet)]
}
