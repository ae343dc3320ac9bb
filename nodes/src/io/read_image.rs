//! The node `io.read_image`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::decode_image::IMAGE_EXTENSIONS;
use super::{Encoding, ReadLimits, decode_image};
use crate::data::Image;

const DOCS: &str = "\
Reads PNG, JPEG, TIFF, BMP, WebP and OpenEXR; the content tells the format, not the name. Grey, grey + alpha, \
RGB and RGBA stay one to four channels, palettes are expanded, an orientation noted by a camera is applied.

8-bit samples are kept as stored (colours in sRGB encoding). 16-bit samples become floats as `encoding` says. \
Float samples are taken as they are and must be finite; float colours are linear. At most 16,384 pixels a side and 512 MiB \
in memory.";

/// Reads a picture.
pub struct ReadImage;

impl Node for ReadImage {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new("io.read_image", 1, "Reads a picture from a file", DOCS)
            .memory_only()
            .file("path", IMAGE_EXTENSIONS, "The picture.")
            .choice(
                "encoding",
                &[
                    ("auto", "three or four channels are `color`, one or two are `data`"),
                    ("color", "16-bit samples are sRGB colours and are decoded to linear floats"),
                    ("data", "16-bit samples are divided by 65,535, as height and roughness maps need"),
                ],
                "What 16-bit integer samples mean. 8-bit and float samples are the same under every choice.",
            )
            .output("image", Image::TYPE, "The picture.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let bytes = context.file("path")?;
        let encoding = Encoding::from_name(context.text("encoding")?).unwrap_or_default();
        let image = decode_image(&bytes, encoding, &ReadLimits::default()).map_err(|error| {
            NodeError::input(format_args!("{}: {error}", context.text("path").unwrap_or_default()))
        })?;
        context.set("image", image);
        Ok(())
    }
}
