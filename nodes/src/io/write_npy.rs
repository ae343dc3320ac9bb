//! Volumes as NumPy array files.

use std::io::{self, Write};

use breccia_engine::{Data, Exporter, Sink, Value};

use super::export::{named_maps, typed};
use crate::data::{Map, Samples, Volume};

/// Exporter of volumes.
pub(super) const EXPORTER: Exporter = Exporter {
    ty: Volume::TYPE,
    extensions: &["npy"],
    docs: "NumPy array of shape Z, Y, X, C (Z, Y, X for one channel) in u1, u4 or f4; further maps as NAME.MAP.npy",
    write: write_files,
};

fn write_files(value: &Value, sink: &mut Sink) -> io::Result<()> {
    let volume = typed::<Volume>(value)?;
    for (i, (name, map)) in named_maps(&volume)?.into_iter().enumerate() {
        let sibling = format!("{}.{name}.npy", sink.stem());
        let mut out = if i == 0 { sink.main()? } else { sink.file(&sibling)? };
        write_npy(volume.size, map, &mut out)?;
        out.flush()?;
    }
    Ok(())
}

/// Writes one map of a volume of `size` voxels along x, y and z as an NPY file of version 1, little-endian, in C order:
/// shape (Z, Y, X, C), or (Z, Y, X) for one channel.
///
/// # Errors
/// From `out`.
pub fn write_npy(size: [usize; 3], map: &Map, out: &mut impl Write) -> io::Result<()> {
    let [x, y, z] = size;
    let shape = match map.channels {
        1 => format!("({z}, {y}, {x})"),
        c => format!("({z}, {y}, {x}, {c})"),
    };
    let descr = match map.samples {
        Samples::U8(_) => "|u1",
        Samples::U32(_) => "<u4",
        Samples::F32(_) => "<f4",
    };
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    // Magic, version and length take 10 bytes; samples start at a multiple of 64, after a line break.
    let padding = (10 + header.len() + 1).next_multiple_of(64) - (10 + header.len() + 1);
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(header.len() as u16).to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    write_little_endian(&map.samples, out)
}

/// Writes samples in little-endian order.
pub(super) fn write_little_endian(samples: &Samples, out: &mut impl Write) -> io::Result<()> {
    match samples {
        _ if cfg!(target_endian = "little") => out.write_all(samples.bytes()),
        Samples::U8(v) => out.write_all(v),
        Samples::U32(v) => v.iter().try_for_each(|v| out.write_all(&v.to_le_bytes())),
        Samples::F32(v) => v.iter().try_for_each(|v| out.write_all(&v.to_le_bytes())),
    }
}
