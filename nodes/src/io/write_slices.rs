//! Volumes as a folder of PNG slices.

use std::io::{self, Write};

use breccia_engine::{Data, Exporter, Sink, Value};
use serde_json::json;

use super::export::{Pixels, json_number, named_maps, typed};
use super::png_rows::{PngHeader, write_png};
use crate::data::Volume;

/// Exporter of volumes.
///
/// Slice `z` of a map is `MAP_ZZZZ.png` (at least four digits), rows along y from top to bottom, columns along x. Bytes are
/// kept, float `color` is encoded to 8-bit sRGB, other floats are scaled to 8 bits, labels take 16 bits.
/// `volume.json` tells `size` and `origin` in voxels and `spacing` along x, y and z, and of each map its `name`,
/// `channels`, `bits`, the pattern of its `files`, and for scaled floats the `range` of values from 0 to 255.
pub(super) const EXPORTER: Exporter = Exporter {
    ty: Volume::TYPE,
    extensions: &["/"],
    docs: "folder of PNG slices MAP_0000.png along z, and volume.json with size, spacing, origin and maps",
    write: write_folder,
};

fn write_folder(value: &Value, sink: &mut Sink) -> io::Result<()> {
    let volume = typed::<Volume>(value)?;
    let [width, height, depth] = volume.size;
    let digits = depth.saturating_sub(1).to_string().len().max(4);
    let mut maps = Vec::new();
    for (name, map) in named_maps(&volume)? {
        let pixels = Pixels::of_map(map)?;
        let (channels, bits) = (pixels.channels, pixels.bits());
        for z in 0..depth {
            let mut out = sink.file(&format!("{name}_{z:0digits$}.png"))?;
            let header = PngHeader { width, height, channels, bits, description: None };
            write_png(&mut out, header, |y, row| {
                let at = volume.index(0, y, z) * channels;
                pixels.push(at..at + width * channels, row);
            })?;
            out.flush()?;
        }
        let files = format!("{name}_%0{digits}d.png");
        let mut entry = json!({ "name": map.name, "channels": channels, "bits": bits, "files": files });
        if let (Some((lo, hi)), Some(entry)) = (pixels.range(), entry.as_object_mut()) {
            entry.insert("range".to_owned(), json!([json_number(lo), json_number(hi)]));
        }
        maps.push(entry);
    }
    let spacing = volume.spacing.map(json_number);
    let about = json!({ "size": volume.size, "spacing": spacing, "origin": volume.origin, "maps": maps });
    let mut out = sink.file("volume.json")?;
    serde_json::to_writer_pretty(&mut out, &about)?;
    out.write_all(b"\n")?;
    out.flush()
}
