//! Volumes from NRRD files with attached data.

use std::io::Read;

use super::raw_array::{Layout, Scalar};
use super::{ReadError, VolumeOptions};
use crate::data::Volume;

const FORMAT: &str = "NRRD";

/// Decodes an NRRD file of three axes (X, Y, Z), or four of which one is the channel.
///
/// Encodings raw and gzip, integers of 8 to 64 bits and floats of 32 and 64 bits, either byte order. The channel axis is
/// the one whose kind is no domain or whose space direction is `none`; failing both, the first if it has at
/// most four entries. The spacing is the length of each space direction, or `spacings`; the origin is the space
/// origin in voxels, rounded. Directions that are not along the axes lose their rotation.
///
/// # Errors
/// See [`ReadError`]. The size is checked against the limits before samples are decoded.
pub fn decode_nrrd(bytes: &[u8], options: &VolumeOptions) -> Result<Volume, ReadError> {
    if bytes.is_empty() {
        return Err(ReadError::Empty);
    }
    if !bytes.starts_with(b"NRRD000") {
        return Err(ReadError::unknown("an NRRD volume", bytes));
    }
    let (header, data) = Header::parse(bytes)?;
    let layout = header.layout()?;
    let count = layout.check(&options.limits)?;
    let expected = count.saturating_mul(layout.scalar.bytes());
    let mut volume = match header.require("encoding")?.to_ascii_lowercase().as_str() {
        "raw" => layout.decode(data, options)?,
        "gzip" | "gz" => {
            let mut inflated = Vec::new();
            // Never more than the header promises, whatever the stream would give.
            flate2::read::MultiGzDecoder::new(data)
                .take(expected as u64)
                .read_to_end(&mut inflated)
                .map_err(|error| ReadError::damaged(FORMAT, format!("the gzip stream: {error}")))?;
            layout.decode(&inflated, options)?
        }
        other => {
            let found = format!("encoding {other:?}; raw or gzip is expected");
            return Err(ReadError::unsupported(FORMAT, found));
        }
    };
    let channel_axis = layout.order.iter().position(|&axis| axis == 3).filter(|_| header.sizes.len() == 4);
    header.place(&mut volume, channel_axis)?;
    Ok(volume)
}

struct Header {
    fields: Vec<(String, String)>,
    sizes: Vec<usize>,
}

impl Header {
    /// Splits the lines before the first empty one from the data behind it.
    fn parse(bytes: &[u8]) -> Result<(Self, &[u8]), ReadError> {
        let mut fields: Vec<(String, String)> = Vec::new();
        let mut rest = bytes;
        let mut first = true;
        loop {
            let end = rest.iter().position(|&byte| byte == b'\n');
            let end = end.ok_or_else(|| ReadError::damaged(FORMAT, "the header has no end"))?;
            let (line, after) = rest.split_at(end);
            rest = after.get(1..).unwrap_or_default();
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            if line.is_empty() {
                break;
            }
            // Texts may be in any encoding; those that matter are ASCII.
            let line = String::from_utf8_lossy(line);
            if std::mem::take(&mut first) || line.starts_with('#') || line.contains(":=") {
                continue;
            }
            let (key, value) = line.split_once(':').ok_or_else(|| {
                ReadError::damaged(FORMAT, format!("the header line {line:?} has no colon"))
            })?;
            fields.push((key.trim().to_ascii_lowercase(), value.trim().to_owned()));
        }
        let mut header = Self { fields, sizes: Vec::new() };
        for key in ["data file", "datafile"] {
            if let Some(file) = header.field(key) {
                let found = format!("its samples are in another file, {file:?}; attached ones are expected");
                return Err(ReadError::unsupported(FORMAT, found));
            }
        }
        for key in ["line skip", "lineskip", "byte skip", "byteskip"] {
            if header.field(key).is_some_and(|skip| skip != "0") {
                return Err(ReadError::unsupported(FORMAT, format!("`{key}` is not 0")));
            }
        }
        header.sizes = header.sizes()?;
        Ok((header, rest))
    }

    fn field(&self, key: &str) -> Option<&str> {
        self.fields.iter().find(|(k, _)| k == key).map(|(_, value)| value.as_str())
    }

    fn require(&self, key: &str) -> Result<&str, ReadError> {
        self.field(key).ok_or_else(|| ReadError::damaged(FORMAT, format!("the header lacks `{key}`")))
    }

    fn sizes(&self) -> Result<Vec<usize>, ReadError> {
        let (dimension, text) = (self.require("dimension")?, self.require("sizes")?);
        let sizes: Result<Vec<usize>, _> = text.split_ascii_whitespace().map(str::parse).collect();
        match sizes {
            Ok(sizes) if dimension.parse() == Ok(sizes.len()) => Ok(sizes),
            _ => {
                let found = format!("`dimension` is {dimension:?}, `sizes` are {text:?}");
                Err(ReadError::damaged(FORMAT, found))
            }
        }
    }

    fn layout(&self) -> Result<Layout, ReadError> {
        let name = self.require("type")?;
        let scalar = scalar(name).ok_or_else(|| {
            let found = format!("type {name:?}; integers of 8 to 64 bits, float or double are expected");
            ReadError::unsupported(FORMAT, found)
        })?;
        let big_endian = match self.field("endian").map(str::to_ascii_lowercase).as_deref() {
            Some("big") => true,
            Some("little") => false,
            None if scalar.bytes() == 1 => false,
            found => {
                let found = found.unwrap_or("missing");
                return Err(ReadError::damaged(
                    FORMAT,
                    format!("`endian` is {found}; little or big is expected"),
                ));
            }
        };
        let (size, channels, order) = match *self.sizes {
            [x, y, z] => ([x, y, z], 1, [3, 0, 1, 2]),
            [a, b, c, d] => match self.channel_axis()? {
                0 => ([b, c, d], a, [3, 0, 1, 2]),
                1 => ([a, c, d], b, [0, 3, 1, 2]),
                2 => ([a, b, d], c, [0, 1, 3, 2]),
                _ => ([a, b, c], d, [0, 1, 2, 3]),
            },
            _ => {
                let found = format!("{} axes; X, Y, Z or channel, X, Y, Z are expected", self.sizes.len());
                return Err(ReadError::unsupported(FORMAT, found));
            }
        };
        Ok(Layout { format: FORMAT, scalar, big_endian, size, channels, order })
    }

    /// Which of four axes is the channel.
    fn channel_axis(&self) -> Result<usize, ReadError> {
        let is_domain = |kind: &str| matches!(kind, "domain" | "space" | "time" | "???" | "none");
        let kinds = self.field("kinds").unwrap_or_default().to_ascii_lowercase();
        if let Some(axis) = kinds.split_ascii_whitespace().position(|kind| !is_domain(kind)) {
            return Ok(axis);
        }
        if let Some(axis) = self.directions()?.iter().position(Option::is_none) {
            return Ok(axis);
        }
        match self.sizes.first() {
            Some(1..=4) => Ok(0),
            _ => Err(ReadError::unsupported(FORMAT, "four axes, none of which is known as the channel")),
        }
    }

    /// The space directions, one an axis.
    fn directions(&self) -> Result<Vec<Option<Vec<f64>>>, ReadError> {
        let Some(text) = self.field("space directions") else { return Ok(Vec::new()) };
        let wrong = || ReadError::damaged(FORMAT, format!("`space directions` are {text:?}"));
        let mut rest = text.trim();
        let mut directions = Vec::new();
        while !rest.is_empty() {
            if let Some(after) = rest.strip_prefix("none") {
                directions.push(None);
                rest = after.trim_start();
            } else {
                let (inner, after) =
                    rest.strip_prefix('(').and_then(|r| r.split_once(')')).ok_or_else(wrong)?;
                directions.push(Some(numbers(inner).ok_or_else(wrong)?));
                rest = after.trim_start();
            }
        }
        Ok(directions)
    }

    /// Sets spacing and origin.
    fn place(&self, volume: &mut Volume, channel_axis: Option<usize>) -> Result<(), ReadError> {
        let mut spacings: Vec<f64> = Vec::new();
        if let Some(text) = self.field("spacings") {
            let wrong = || ReadError::damaged(FORMAT, format!("`spacings` are {text:?}"));
            let parsed = text.split_ascii_whitespace().map(str::parse).collect::<Result<_, _>>();
            spacings = parsed.map_err(|_| wrong())?;
        }
        let directions = self.directions()?;
        if !directions.is_empty() {
            let length = |d: &Option<Vec<f64>>| {
                d.as_ref().map_or(1.0, |d| d.iter().map(|c| c * c).sum::<f64>().sqrt())
            };
            spacings = directions.iter().map(length).collect();
        }
        let spatial = (0..self.sizes.len()).filter(|&axis| Some(axis) != channel_axis);
        for (spacing, axis) in volume.spacing.iter_mut().zip(spatial) {
            let found = spacings.get(axis).map_or(1.0, |&s| s as f32);
            if found.is_finite() && found > 0.0 {
                *spacing = found;
            }
        }
        if let Some(text) = self.field("space origin") {
            let inner = text.trim().strip_prefix('(').and_then(|t| t.strip_suffix(')')).and_then(numbers);
            let origin =
                inner.ok_or_else(|| ReadError::damaged(FORMAT, format!("`space origin` is {text:?}")))?;
            for ((to, from), spacing) in volume.origin.iter_mut().zip(origin).zip(volume.spacing) {
                *to = (from / f64::from(spacing)).round() as i32;
            }
        }
        Ok(())
    }
}

fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|number| number.trim().parse().ok()).collect()
}

fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Scalar::U8,
        "signed char" | "int8" | "int8_t" => Scalar::I8,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Scalar::U16,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Scalar::I16,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Scalar::U32,
        "int" | "signed int" | "int32" | "int32_t" => Scalar::I32,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Scalar::U64,
        "longlong" | "long long" | "long long int" | "signed long long" | "int64" | "int64_t" => Scalar::I64,
        "float" => Scalar::F32,
        "double" => Scalar::F64,
        _ => return None,
    })
}
