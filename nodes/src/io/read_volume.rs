//! The node `io.read_volume`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, ParamKind, ParamValue};

use super::{Integers, VolumeOptions, decode_volume};
use crate::data::Volume;

const DOCS: &str = "\
Reads a dense box of voxels from NPY (shape Z, Y, X or Z, Y, X, C) or NRRD (attached data, raw or gzip); the content \
tells the format, not the name. The file holds one map. 8-bit samples are kept as stored, 16-bit ones are divided by \
65,535, wider integers and truth values are labels, floats must be finite. NRRD keeps spacing and origin; NPY has \
none. At most 4 GiB in memory.";

/// Reads a volume.
pub struct ReadVolume;

impl Node for ReadVolume {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new("io.read_volume", 1, "Reads a box of voxels from a file", DOCS)
            .memory_only()
            .file("path", &["npy", "nrrd"], "The volume.")
            .choice(
                "integers",
                &[
                    ("auto", "8 bits are kept, unsigned 16 bits are fractions, all others are labels"),
                    ("labels", "all integers are labels"),
                ],
                "What integer samples mean.",
            )
            .param(
                "map",
                ParamKind::Text,
                ParamValue::Text(String::new()),
                "",
                "The map's name. Empty: `label` for labels, `color` for three or four channels, otherwise `value`.",
            )
            .output("volume", Volume::TYPE, "The volume, with one map.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let bytes = context.file("path")?;
        let options = VolumeOptions {
            integers: Integers::from_name(context.text("integers")?).unwrap_or_default(),
            map: context.text("map")?.to_owned(),
            ..VolumeOptions::default()
        };
        let volume = decode_volume(&bytes, &options).map_err(|error| {
            NodeError::input(format_args!("{}: {error}", context.text("path").unwrap_or_default()))
        })?;
        context.set("volume", volume);
        Ok(())
    }
}
