//! Volumes from NumPy's array files (NPY, versions 1 to 3).

use super::raw_array::{Layout, Scalar};
use super::{ReadError, VolumeOptions};
use crate::data::Volume;

const FORMAT: &str = "NPY";
const MAGIC: &[u8] = b"\x93NUMPY";

/// Decodes an array of shape (Z, Y, X) or (Z, Y, X, C) in C or Fortran order.
///
/// Number types: truth values, signed and unsigned integers of 8 to 64 bits, floats of 16 to 64 bits, of either
/// byte order. Such files have no spacing or origin; the volume gets 1 and 0.
///
/// # Errors
/// See [`ReadError`]. The size is checked against the limits before samples are decoded.
pub fn decode_npy(bytes: &[u8], options: &VolumeOptions) -> Result<Volume, ReadError> {
    if bytes.is_empty() {
        return Err(ReadError::Empty);
    }
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| ReadError::unknown("an NPY array", bytes))?;
    let cut = || ReadError::damaged(FORMAT, "the header ends too early");
    let (major, rest) = match rest {
        [major, _minor, rest @ ..] => (*major, rest),
        _ => return Err(cut()),
    };
    let (length, rest) = match (major, rest) {
        (1, [a, b, rest @ ..]) => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        (2 | 3, [a, b, c, d, rest @ ..]) => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        (1..=3, _) => return Err(cut()),
        _ => return Err(ReadError::unsupported(FORMAT, format!("version {major}; 1 to 3 are expected"))),
    };
    let (header, data) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = parse_header(header).map_err(|reason| ReadError::damaged(FORMAT, reason))?;

    let (big_endian, scalar) = scalar(&header.descr).ok_or_else(|| {
        let found =
            format!("number type {:?}; b1, u1 to u8, i1 to i8 and f2 to f8 are expected", header.descr);
        ReadError::unsupported(FORMAT, found)
    })?;
    let (size, channels) = match *header.shape {
        [z, y, x] => ([x, y, z], 1),
        [z, y, x, c] => ([x, y, z], c),
        _ => {
            let found = format!("shape {:?}; (Z, Y, X) or (Z, Y, X, C) is expected", header.shape);
            return Err(ReadError::unsupported(FORMAT, found));
        }
    };
    let order = if header.fortran_order { [2, 1, 0, 3] } else { [3, 0, 1, 2] };
    Layout { format: FORMAT, scalar, big_endian, size, channels, order }.decode(data, options)
}

/// Byte order and number type of a type string such as `<f4`.
fn scalar(descr: &str) -> Option<(bool, Scalar)> {
    let (big_endian, kind) = match descr.strip_prefix(['<', '|']) {
        Some(kind) => (false, kind),
        None => (true, descr.strip_prefix('>')?),
    };
    let scalar = match kind {
        "b1" => Scalar::Bool,
        "u1" => Scalar::U8,
        "u2" => Scalar::U16,
        "u4" => Scalar::U32,
        "u8" => Scalar::U64,
        "i1" => Scalar::I8,
        "i2" => Scalar::I16,
        "i4" => Scalar::I32,
        "i8" => Scalar::I64,
        "f2" => Scalar::F16,
        "f4" => Scalar::F32,
        "f8" => Scalar::F64,
        _ => return None,
    };
    Some((big_endian, scalar))
}

struct Header {
    descr: String,
    fortran_order: bool,
    shape: Vec<usize>,
}

/// Parses the header, a Python dictionary of three entries in any order.
fn parse_header(bytes: &[u8]) -> Result<Header, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "the header is not text".to_owned())?;
    let mut rest = text.trim_start();
    take(&mut rest, "{")?;
    let (mut descr, mut fortran_order, mut shape) = (None, None, None);
    while !rest.starts_with('}') {
        let key = string(&mut rest)?;
        take(&mut rest, ":")?;
        match key {
            "descr" if rest.starts_with('[') => {
                return Err("records of several fields are not read".to_owned());
            }
            "descr" => descr = Some(string(&mut rest)?.to_owned()),
            "fortran_order" if take(&mut rest, "True").is_ok() => fortran_order = Some(true),
            "fortran_order" => {
                take(&mut rest, "False")?;
                fortran_order = Some(false);
            }
            "shape" => shape = Some(tuple(&mut rest)?),
            _ => return Err(format!("the header has an unknown entry {key:?}")),
        }
        if take(&mut rest, ",").is_err() {
            break;
        }
    }
    take(&mut rest, "}")?;
    Ok(Header {
        descr: descr.ok_or("the header lacks `descr`")?,
        fortran_order: fortran_order.ok_or("the header lacks `fortran_order`")?,
        shape: shape.ok_or("the header lacks `shape`")?,
    })
}

fn take(rest: &mut &str, token: &str) -> Result<(), String> {
    let found = || rest.chars().take(12).collect::<String>();
    *rest = rest
        .strip_prefix(token)
        .ok_or_else(|| format!("the header has {:?} where `{token}` is expected", found()))?
        .trim_start();
    Ok(())
}

fn string<'a>(rest: &mut &'a str) -> Result<&'a str, String> {
    let quote = if rest.starts_with('"') { "\"" } else { "'" };
    let inner = rest.strip_prefix(quote).ok_or("the header lacks a quoted text where one is expected")?;
    let (text, after) = inner.split_once(quote).ok_or("a quoted text in the header has no end")?;
    *rest = after.trim_start();
    Ok(text)
}

fn tuple(rest: &mut &str) -> Result<Vec<usize>, String> {
    take(rest, "(")?;
    let mut numbers = Vec::new();
    while !rest.starts_with(')') {
        let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        let (digits, after) = rest.split_at(end);
        let number =
            digits.parse().map_err(|_| format!("the shape has {digits:?} where a length is expected"))?;
        numbers.push(number);
        // Python 2 wrote long numbers with an `L`.
        *rest = after.strip_prefix('L').unwrap_or(after).trim_start();
        if take(rest, ",").is_err() {
            break;
        }
    }
    take(rest, ")")?;
    Ok(numbers)
}
