//! Pictures as PNG and OpenEXR files.

use std::io::{self, Seek, Write};

use breccia_engine::{Data, Exporter, Sink, Value};
use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use exr::meta::attribute::LineOrder;
use exr::meta::header::LayerAttributes;
use exr::prelude::{Blocks, Compression, SmallVec};

use super::export::{Pixels, invalid, typed};
use super::png_rows::{PngHeader, write_png};
use crate::data::{Image, Samples, srgb_to_linear};

/// Exporters of pictures.
pub(super) const EXPORTERS: &[Exporter] = &[
    Exporter {
        ty: Image::TYPE,
        extensions: &["png"],
        docs: "8-bit samples as stored; float colours encoded to 8-bit sRGB; other floats as 16-bit fractions",
        write: |value, sink| write_file(value, sink, write_image_png),
    },
    Exporter {
        ty: Image::TYPE,
        extensions: &["exr"],
        docs: "32-bit floats; 8-bit colours decoded from sRGB to linear",
        write: |value, sink| write_file(value, sink, write_image_exr),
    },
];

fn write_file(
    value: &Value,
    sink: &mut Sink,
    write: fn(&Image, &mut io::BufWriter<std::fs::File>) -> io::Result<()>,
) -> io::Result<()> {
    let image = typed::<Image>(value)?;
    let mut out = sink.main()?;
    write(&image, &mut out)?;
    out.flush()
}

/// Writes a PNG: 8-bit samples as stored, linear float colours (three or four channels) encoded to 8-bit sRGB, one or
/// two channels of floats as 16-bit fractions, labels with 16 bits. Floats outside of 0 to 1 are clamped.
///
/// # Errors
/// If a label needs more than 16 bits, or from `out`.
pub fn write_image_png(image: &Image, out: &mut impl Write) -> io::Result<()> {
    let pixels = Pixels::of_image(image)?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    let (channels, bits) = (pixels.channels, pixels.bits());
    let header = PngHeader { width, height, channels, bits, description: None };
    write_png(out, header, |y, row| pixels.push(y * width * channels..(y + 1) * width * channels, row))
}

/// Writes an OpenEXR file of one layer with channels `Y`, `Y` `A`, `R` `G` `B` or `R` `G` `B` `A`: floats as they are,
/// 8-bit colours decoded from sRGB to linear (alpha and one or two channels divided by 255), labels as
/// unsigned integers.
///
/// # Errors
/// From `out`.
pub fn write_image_exr(image: &Image, out: &mut (impl Write + Seek)) -> io::Result<()> {
    let names = [&["Y"][..], &["Y", "A"], &["R", "G", "B"], &["R", "G", "B", "A"]];
    let channels = image.channels();
    let names = names.get(channels.saturating_sub(1)).copied().unwrap_or_default();
    let planes =
        names.iter().enumerate().map(|(c, &name)| AnyChannel::new(name, plane(image.samples(), c, channels)));
    let planes: SmallVec<[AnyChannel<FlatSamples>; 4]> = planes.collect();
    // One order of rows whatever the threads do, so that equal pictures give equal files.
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (image.width() as usize, image.height() as usize);
    let layer = Layer::new(size, LayerAttributes::default(), encoding, AnyChannels::sort(planes));
    exr::image::Image::from_layer(layer).write().to_buffered(out).map_err(|error| match error {
        exr::error::Error::Io(error) => error,
        error => invalid(error.to_string()),
    })
}

/// Channel `c` of interleaved samples.
fn plane(samples: &Samples, c: usize, channels: usize) -> FlatSamples {
    let is_color = channels >= 3 && c < 3;
    let decode = |&byte: &u8| if is_color { srgb_to_linear(byte) } else { f32::from(byte) / 255.0 };
    match samples {
        Samples::U8(v) => FlatSamples::F32(v.iter().skip(c).step_by(channels).map(decode).collect()),
        Samples::F32(v) => FlatSamples::F32(v.iter().skip(c).step_by(channels).copied().collect()),
        Samples::U32(v) => FlatSamples::U32(v.iter().skip(c).step_by(channels).copied().collect()),
    }
}
