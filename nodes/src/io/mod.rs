//! Reading and writing pictures and volumes.

mod decode_exr;
mod decode_image;
mod decode_tiff;
mod encoding;
mod error;
mod read_image;

pub use decode_image::decode_image;
pub use encoding::Encoding;
pub use error::{ReadError, ReadLimits};
pub use read_image::ReadImage;

use breccia_engine::{Exporter, Node};

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![Box::new(ReadImage)]
}

/// The exporters of this family.
pub fn exporters() -> Vec<Exporter> {
    Vec::new()
}
