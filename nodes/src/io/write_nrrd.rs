//! Volumes as NRRD files.

use std::io::{self, Write};

use breccia_engine::{Data, Exporter, Sink, Value};
use flate2::Compression;
use flate2::write::GzEncoder;

use super::export::{named_maps, typed};
use super::write_npy::write_little_endian;
use crate::data::{Map, Samples, Volume};

/// Exporter of volumes.
pub(super) const EXPORTER: Exporter = Exporter {
    ty: Volume::TYPE,
    extensions: &["nrrd"],
    docs: "NRRD with spacing and origin, raw, in uint8, uint32 or float; further maps as NAME.MAP.nrrd",
    write: write_files,
};

fn write_files(value: &Value, sink: &mut Sink) -> io::Result<()> {
    let volume = typed::<Volume>(value)?;
    for (i, (name, map)) in named_maps(&volume)?.into_iter().enumerate() {
        let sibling = format!("{}.{name}.nrrd", sink.stem());
        let mut out = if i == 0 { sink.main()? } else { sink.file(&sibling)? };
        write_nrrd(&volume, map, NrrdEncoding::Raw, &mut out)?;
        out.flush()?;
    }
    Ok(())
}

/// How the samples of an NRRD file are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NrrdEncoding {
    /// As they are.
    Raw,
    /// Compressed.
    Gzip,
}

/// Writes one map of a volume as an NRRD file: axes channel (left out where there is one), X, Y, Z; the spacing along
/// the diagonal of the space directions, and origin times spacing as the space origin. The map's name is kept
/// under the key `map`.
///
/// # Errors
/// From `out`.
pub fn write_nrrd(
    volume: &Volume,
    map: &Map,
    encoding: NrrdEncoding,
    out: &mut impl Write,
) -> io::Result<()> {
    let [x, y, z] = volume.size;
    let [sx, sy, sz] = volume.spacing;
    let [ox, oy, oz]: [f64; 3] =
        std::array::from_fn(|i| f64::from(volume.origin[i]) * f64::from(volume.spacing[i]));
    let (ty, endian) = match map.samples {
        Samples::U8(_) => ("uint8", ""),
        Samples::U32(_) => ("uint32", "endian: little\n"),
        Samples::F32(_) => ("float", "endian: little\n"),
    };
    let (dimension, channel_size, none, kind) = match map.channels {
        1 => (3, String::new(), "", ""),
        3 if map.name == "color" => (4, "3 ".to_owned(), "none ", "RGB-color "),
        4 if map.name == "color" => (4, "4 ".to_owned(), "none ", "RGBA-color "),
        c @ 2..=4 => (4, format!("{c} "), "none ", ["2-vector ", "3-vector ", "4-vector "][c - 2]),
        c => (4, format!("{c} "), "none ", "vector "),
    };
    let name: String = map.name.chars().filter(|c| !c.is_control()).collect();
    let packed = if encoding == NrrdEncoding::Gzip { "gzip" } else { "raw" };
    write!(
        out,
        "NRRD0005\ntype: {ty}\ndimension: {dimension}\nspace dimension: 3\nsizes: {channel_size}{x} {y} {z}\n\
         space directions: {none}({sx},0,0) (0,{sy},0) (0,0,{sz})\nspace origin: ({ox},{oy},{oz})\n\
         kinds: {kind}domain domain domain\n{endian}encoding: {packed}\nmap:={name}\n\n"
    )?;
    match encoding {
        NrrdEncoding::Raw => write_little_endian(&map.samples, out),
        NrrdEncoding::Gzip => {
            let mut packer = GzEncoder::new(out, Compression::fast());
            write_little_endian(&map.samples, &mut packer)?;
            packer.finish()?;
            Ok(())
        }
    }
}
