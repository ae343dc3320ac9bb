//! Volumes as one PNG with all slices side by side.

use std::io::{self, Write};

use breccia_engine::{Data, Exporter, Sink, Value};
use serde_json::json;

use super::export::{Pixels, invalid, json_number, named_maps, typed};
use super::png_rows::{PngHeader, write_png};
use crate::data::{Map, Volume};

/// Exporter of volumes.
pub(super) const EXPORTER: Exporter = Exporter {
    ty: Volume::TYPE,
    extensions: &["png"],
    docs: "slice atlas: a grid of all Z slices, its layout in the PNG's Description; further maps as NAME.MAP.png",
    write: write_files,
};

fn write_files(value: &Value, sink: &mut Sink) -> io::Result<()> {
    let volume = typed::<Volume>(value)?;
    for (i, (name, map)) in named_maps(&volume)?.into_iter().enumerate() {
        let sibling = format!("{}.{name}.png", sink.stem());
        let mut out = if i == 0 { sink.main()? } else { sink.file(&sibling)? };
        write_atlas(&volume, map, &mut out)?;
        out.flush()?;
    }
    Ok(())
}

/// Columns and rows of the grid that holds `size[2]` slices: the shortest longer side, then the fewest empty cells, then
/// the fewest columns.
pub fn atlas_grid(size: [usize; 3]) -> [usize; 2] {
    let [x, y, z] = size;
    let cost = |&columns: &usize| {
        let rows = z.div_ceil(columns);
        (columns.saturating_mul(x).max(rows.saturating_mul(y)), columns.saturating_mul(rows), columns)
    };
    let columns = (1..=z.max(1)).min_by_key(cost).unwrap_or(1);
    [columns, z.div_ceil(columns)]
}

/// Writes one map of a volume as a slice atlas: slice `z` stands in column `z % columns` and row `z / columns` of the grid,
/// counted from the top left, with x to the right and y downwards; cells without a slice are 0.
///
/// A `Description` text chunk holds `columns`, `rows`, `size`, `origin` and `spacing` (along x, y, z), `map`, and for scaled
/// floats the `range` of values from 0 to 255, as JSON. Samples are stored as in a folder of slices.
///
/// # Errors
/// If the map has more than four channels or labels of more than 16 bits, or from `out`.
pub fn write_atlas(volume: &Volume, map: &Map, out: &mut impl Write) -> io::Result<()> {
    let pixels = Pixels::of_map(map)?;
    let [columns, rows] = atlas_grid(volume.size);
    let [x, y, z] = volume.size;
    let too_large =
        || invalid(format!("an atlas of {columns} × {rows} slices of {x} × {y} pixels is too large"));
    let width = columns.checked_mul(x).ok_or_else(too_large)?;
    let height = rows.checked_mul(y).ok_or_else(too_large)?;
    let mut about = json!({
        "columns": columns, "rows": rows, "size": volume.size, "origin": volume.origin,
        "spacing": volume.spacing.map(json_number), "map": map.name,
    });
    if let (Some((lo, hi)), Some(about)) = (pixels.range(), about.as_object_mut()) {
        about.insert("range".to_owned(), json!([json_number(lo), json_number(hi)]));
    }
    let (channels, bits) = (pixels.channels, pixels.bits());
    let header = PngHeader { width, height, channels, bits, description: Some(ascii(&about.to_string())) };
    let row_bytes = width.saturating_mul(channels).saturating_mul(usize::from(bits / 8));
    write_png(out, header, |row, bytes| {
        let first = row / y * columns;
        for slice in first..(first + columns).min(z) {
            let at = volume.index(0, row % y, slice) * channels;
            pixels.push(at..at + x * channels, bytes);
        }
        bytes.resize(row_bytes, 0);
    })
}

/// JSON with every character beyond ASCII escaped: text chunks are Latin-1.
fn ascii(json: &str) -> String {
    let mut text = String::new();
    for c in json.chars() {
        if c.is_ascii() {
            text.push(c);
        } else {
            c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| text += &format!("\\u{unit:04x}"));
        }
    }
    text
}
