//! Pictures of textured meshes and solids, made on the CPU without a window.

mod camera;
mod contact_sheet;
mod cube;
mod cutaway;
mod error;
mod ground;
mod light;
mod march;
mod march_device;
mod material;
mod mesh;
mod portrait;
mod raster;
mod shadow;
mod sheet;
mod studio;
mod surface;
mod texture;
mod translucent;
mod translucent_node;
mod vector;

pub use camera::Camera;
pub use contact_sheet::contact_sheet;
pub use cutaway::{CutawaySettings, cutaway};
pub use error::RenderError;
pub use march::Scene;
pub use march_device::{DeviceScene, march_on_device};
pub use portrait::{PortraitSettings, portrait};
pub use studio::Background;
pub use translucent::{Cut, Key, TranslucentSettings, translucent, translucent_scene};

use breccia_engine::Node;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![
        Box::new(cube::Cube),
        Box::new(mesh::Mesh),
        Box::new(sheet::Sheet),
        Box::new(translucent_node::Translucent),
    ]
}
