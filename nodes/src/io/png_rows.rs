//! PNG files written row by row.

use std::io::{self, Write};

use png::{BitDepth, ColorType, Compression, Encoder, EncodingError};

use super::export::invalid;

/// A PNG file's header.
pub(super) struct PngHeader {
    pub(super) width: usize,
    pub(super) height: usize,
    /// 1 to 4.
    pub(super) channels: usize,
    /// 8 or 16.
    pub(super) bits: u8,
    /// The text of a `Description` chunk.
    pub(super) description: Option<String>,
}

/// Writes a picture; `row` appends the bytes of one row.
pub(super) fn write_png(
    out: &mut impl Write,
    header: PngHeader,
    mut row: impl FnMut(usize, &mut Vec<u8>),
) -> io::Result<()> {
    let side = |n: usize| {
        let message =
            || invalid(format!("a png has at most 2,147,483,647 pixels a side, the picture has {n}"));
        u32::try_from(n).ok().filter(|&n| i32::try_from(n).is_ok()).ok_or_else(message)
    };
    let mut encoder = Encoder::new(out, side(header.width)?, side(header.height)?);
    encoder.set_color(match header.channels {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    });
    encoder.set_depth(if header.bits == 16 { BitDepth::Sixteen } else { BitDepth::Eight });
    encoder.set_compression(Compression::Fast);
    if let Some(text) = header.description {
        encoder.add_text_chunk("Description".to_owned(), text).map_err(to_io)?;
    }
    let mut writer = encoder.write_header().map_err(to_io)?;
    let mut stream = writer.stream_writer().map_err(to_io)?;
    let mut bytes = Vec::new();
    for y in 0..header.height {
        bytes.clear();
        row(y, &mut bytes);
        stream.write_all(&bytes)?;
    }
    stream.finish().map_err(to_io)?;
    writer.finish().map_err(to_io)
}

fn to_io(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        error => invalid(error.to_string()),
    }
}
