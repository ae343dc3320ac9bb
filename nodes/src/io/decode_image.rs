//! Pictures from the bytes of PNG, JPEG, TIFF, BMP, WebP and OpenEXR files.

use std::io::Cursor;

use image::error::ImageError as CodecError;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use super::decode_exr::decode_exr;
use super::decode_tiff::decode_float_tiff;
use super::{Encoding, ReadError, ReadLimits};
use crate::data::{Image, Samples};

/// Extensions of the picture formats that are read.
pub const IMAGE_EXTENSIONS: &[&str] = &["png", "jpg", "jpeg", "tif", "tiff", "bmp", "webp", "exr"];

const EXPECTED: &str = "a PNG, JPEG, TIFF, BMP, WebP or OpenEXR picture";

/// Decodes a picture; the format is told by the content, not by the name.
///
/// Grey, grey + alpha, RGB and RGBA stay one to four channels; palettes are expanded and CMYK is converted to RGB.
/// 8-bit samples are kept as stored, 16-bit ones become `f32` as `encoding` says, floats stay as they are
/// and must be finite. An orientation noted in EXIF data is applied. Colour profiles and gamma notes are
/// ignored: integer colours count as sRGB.
///
/// # Errors
/// See [`ReadError`]. The size is checked against `limits` before samples are decoded.
pub fn decode_image(bytes: &[u8], encoding: Encoding, limits: &ReadLimits) -> Result<Image, ReadError> {
    if bytes.is_empty() {
        return Err(ReadError::Empty);
    }
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return fenced("OpenEXR", || decode_exr(bytes, limits));
    }
    let (format, name) = match image::guess_format(bytes) {
        Ok(ImageFormat::Png) => (ImageFormat::Png, "PNG"),
        Ok(ImageFormat::Jpeg) => (ImageFormat::Jpeg, "JPEG"),
        Ok(ImageFormat::Tiff) => (ImageFormat::Tiff, "TIFF"),
        Ok(ImageFormat::Bmp) => (ImageFormat::Bmp, "BMP"),
        Ok(ImageFormat::WebP) => (ImageFormat::WebP, "WebP"),
        _ => return Err(ReadError::unknown(EXPECTED, bytes)),
    };
    if format == ImageFormat::Tiff
        && let Some(image) = fenced(name, || decode_float_tiff(bytes, limits))?
    {
        return Ok(image);
    }
    if format == ImageFormat::Jpeg && !jpeg_has_end(bytes) {
        // The decoder fills what is missing with grey.
        return Err(ReadError::damaged(name, "the end-of-image marker is missing"));
    }
    if format == ImageFormat::Png
        && let Some(length) = png_palette(bytes).filter(|length| !length.is_multiple_of(3))
    {
        // The decoder takes it for whole colours, and panics.
        return Err(ReadError::damaged(name, format!("the palette has {length} bytes, not three a colour")));
    }
    fenced(name, || decode_raster(bytes, format, name, encoding, limits))
}

/// Keeps a decoder's panic on damaged bytes from ending the program. Panics that are known are prevented before.
fn fenced<T>(format: &'static str, decode: impl FnOnce() -> Result<T, ReadError>) -> Result<T, ReadError> {
    // Nothing outlives the closure but its result, so that no broken state can be seen.
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err(ReadError::damaged(format, "the decoder failed")))
}

fn decode_raster(
    bytes: &[u8],
    format: ImageFormat,
    name: &'static str,
    encoding: Encoding,
    limits: &ReadLimits,
) -> Result<Image, ReadError> {
    let wrap = |error: CodecError| match error {
        CodecError::Unsupported(error) => ReadError::unsupported(name, error),
        error => ReadError::damaged(name, error),
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut allocation = image::Limits::default();
    // Twice: decoders may hold a second buffer while they convert.
    allocation.max_alloc = Some(limits.picture_bytes.saturating_mul(2));
    reader.limits(allocation);
    let mut decoder = reader.into_decoder().map_err(wrap)?;

    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    let channels = usize::from(color.channel_count());
    let sample_bytes = if color.bytes_per_pixel() == color.channel_count() { 1 } else { 4 };
    limits.check_picture(width.into(), height.into(), channels as u64 * sample_bytes)?;
    if width == 0 || height == 0 {
        return Err(ReadError::damaged(name, format!("the picture has {width} × {height} pixels")));
    }

    let orientation = decoder.orientation().map_err(wrap)?;
    let mut picture = DynamicImage::from_decoder(decoder).map_err(wrap)?;
    picture.apply_orientation(orientation);
    let (width, height) = (picture.width(), picture.height());
    let samples = match picture {
        DynamicImage::ImageLuma8(p) => Samples::U8(p.into_raw()),
        DynamicImage::ImageLumaA8(p) => Samples::U8(p.into_raw()),
        DynamicImage::ImageRgb8(p) => Samples::U8(p.into_raw()),
        DynamicImage::ImageRgba8(p) => Samples::U8(p.into_raw()),
        DynamicImage::ImageLuma16(p) => Samples::F32(encoding.decode16(&p, channels)),
        DynamicImage::ImageLumaA16(p) => Samples::F32(encoding.decode16(&p, channels)),
        DynamicImage::ImageRgb16(p) => Samples::F32(encoding.decode16(&p, channels)),
        DynamicImage::ImageRgba16(p) => Samples::F32(encoding.decode16(&p, channels)),
        DynamicImage::ImageRgb32F(p) => Samples::F32(p.into_raw()),
        DynamicImage::ImageRgba32F(p) => Samples::F32(p.into_raw()),
        other => return Err(ReadError::unsupported(name, format!("samples of type {:?}", other.color()))),
    };
    finite(Image::new(width, height, channels, samples).map_err(|error| ReadError::damaged(name, error))?)
}

/// The picture, if all its samples are finite.
pub(super) fn finite(image: Image) -> Result<Image, ReadError> {
    let Samples::F32(samples) = image.samples() else { return Ok(image) };
    let Some(i) = samples.iter().position(|v| !v.is_finite()) else { return Ok(image) };
    let (channels, width) = (image.channels(), image.width() as usize);
    let (pixel, c) = (i / channels, i % channels);
    Err(ReadError::BadSample {
        place: format!("x {}, y {}, channel {c}", pixel % width, pixel / width),
        value: samples.get(i).map_or_else(String::new, f32::to_string),
        expected: "every sample must be finite",
    })
}

/// The length in bytes of a PNG file's palette.
fn png_palette(bytes: &[u8]) -> Option<u32> {
    let mut at = 8usize;
    loop {
        let (length, rest) = bytes.get(at..)?.split_first_chunk::<4>()?;
        let length = u32::from_be_bytes(*length);
        match rest.get(..4)? {
            b"PLTE" => return Some(length),
            b"IDAT" => return None,
            // Length, type and checksum take 12 bytes.
            _ => at = at.checked_add(length as usize)?.checked_add(12)?,
        }
    }
}

/// Whether a JPEG stream has its end-of-image marker, segment by segment (payloads may hold thumbnails with
/// markers of their own).
fn jpeg_has_end(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some(&[marker, code]) = bytes.get(at..at + 2) {
        if marker != 0xff {
            // Entropy-coded data, or padding.
            at += 1;
            continue;
        }
        match code {
            0xd9 => return true,
            // A fill byte; the next may be the marker's code.
            0xff => at += 1,
            // An escaped data byte and the markers without a payload.
            0x00 | 0x01 | 0xd0..=0xd8 => at += 2,
            _ => {
                let Some(&[high, low]) = bytes.get(at + 2..at + 4) else { return false };
                at += 2 + usize::from(u16::from_be_bytes([high, low]));
            }
        }
    }
    false
}
