//! Float TIFF pictures, of which the common decoder reads RGB and RGBA only.

use std::io::Cursor;

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::{SampleFormat, Tag};
use tiff::{ColorType, TiffError};

use super::decode_image::finite;
use super::{ReadError, ReadLimits};
use crate::data::{Image, Samples};

/// Decodes the first picture of a TIFF file if its samples are floats of 16, 32 or 64 bits; `None` if they are not.
///
/// # Errors
/// If a float picture is damaged, too large, or has samples that are not finite.
pub(super) fn decode_float_tiff(bytes: &[u8], limits: &ReadLimits) -> Result<Option<Image>, ReadError> {
    let wrap = |error: TiffError| match error {
        TiffError::UnsupportedError(error) => ReadError::unsupported("TIFF", error),
        error => ReadError::damaged("TIFF", error),
    };
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(wrap)?;
    let formats = decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).map_err(wrap)?.unwrap_or_default();
    if formats.is_empty() || formats.iter().any(|&format| format != SampleFormat::IEEEFP.to_u16()) {
        return Ok(None);
    }
    let channels = match decoder.colortype().map_err(wrap)? {
        ColorType::Gray(_) => 1,
        ColorType::GrayA(_) => 2,
        ColorType::RGB(_) => 3,
        ColorType::RGBA(_) => 4,
        ColorType::Multiband { num_samples, .. } if num_samples <= 4 => usize::from(num_samples),
        other => return Err(ReadError::unsupported("TIFF", format!("{other:?} with float samples"))),
    };
    let (width, height) = decoder.dimensions().map_err(wrap)?;
    limits.check_picture(width.into(), height.into(), 4 * channels as u64)?;
    let mut allocation = Limits::default();
    // Doubles are twice as large as what is kept.
    allocation.decoding_buffer_size =
        usize::try_from(limits.picture_bytes.saturating_mul(2)).unwrap_or(usize::MAX);
    allocation.intermediate_buffer_size = allocation.decoding_buffer_size;
    let samples = match decoder.with_limits(allocation).read_image().map_err(wrap)? {
        DecodingResult::F16(v) => v.into_iter().map(f32::from).collect(),
        DecodingResult::F32(v) => v,
        DecodingResult::F64(v) => v.into_iter().map(|v| v as f32).collect(),
        _ => return Err(ReadError::damaged("TIFF", "the sample format contradicts the sample size")),
    };
    let image = Image::new(width, height, channels, Samples::F32(samples));
    finite(image.map_err(|error| ReadError::damaged("TIFF", error))?).map(Some)
}
