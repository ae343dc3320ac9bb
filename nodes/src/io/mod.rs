//! Reading and writing pictures and volumes.

mod decode_exr;
mod decode_image;
mod decode_npy;
mod decode_nrrd;
mod decode_tiff;
mod encoding;
mod error;
mod export;
mod png_rows;
mod raw_array;
mod read_image;
mod read_volume;
#[cfg(test)]
mod tests;
mod write_atlas;
mod write_curves;
mod write_image;
mod write_list;
mod write_npy;
mod write_nrrd;
mod write_report;
mod write_slices;
mod write_tiff;

pub use decode_image::decode_image;
pub use decode_npy::decode_npy;
pub use decode_nrrd::decode_nrrd;
pub use encoding::Encoding;
pub use error::{ReadError, ReadLimits};
pub use raw_array::{Integers, VolumeOptions};
pub use read_image::ReadImage;
pub use read_volume::ReadVolume;
pub use write_atlas::{atlas_grid, write_atlas};
pub use write_curves::{curves_csv, curves_json, escape, plot_svg};
pub use write_image::{write_image_exr, write_image_png};
pub use write_npy::write_npy;
pub use write_nrrd::{NrrdEncoding, write_nrrd};
pub use write_report::{range_text, report_csv, report_json, report_text, short_number};
pub use write_tiff::write_tiff;

use breccia_engine::{Exporter, Node};

use crate::data::Volume;

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![Box::new(ReadImage), Box::new(ReadVolume)]
}

/// The exporters of this family.
pub fn exporters() -> Vec<Exporter> {
    let volumes = [
        write_npy::EXPORTER,
        write_nrrd::EXPORTER,
        write_tiff::EXPORTER,
        write_slices::EXPORTER,
        write_atlas::EXPORTER,
    ];
    [
        write_image::EXPORTERS,
        write_report::EXPORTERS,
        write_curves::EXPORTERS,
        write_list::EXPORTERS,
        &volumes,
    ]
    .concat()
}

/// Decodes an NPY or NRRD volume; the format is told by the content.
///
/// # Errors
/// See [`ReadError`].
pub fn decode_volume(bytes: &[u8], options: &VolumeOptions) -> Result<Volume, ReadError> {
    if bytes.is_empty() {
        Err(ReadError::Empty)
    } else if bytes.starts_with(b"\x93NUMPY") {
        decode_npy(bytes, options)
    } else if bytes.starts_with(b"NRRD000") {
        decode_nrrd(bytes, options)
    } else {
        Err(ReadError::unknown("an NPY or NRRD volume", bytes))
    }
}
