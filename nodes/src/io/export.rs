//! What all exporters of this family share: checks, file names, and samples as 8- or 16-bit pixels.

use std::io;
use std::ops::Range;
use std::sync::Arc;

use breccia_engine::{Data, Value};

use crate::data::{Image, Map, Samples, Volume, linear_to_srgb};

/// An error of the value, not of the file.
pub(super) fn invalid(message: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, message.into())
}

/// The value as the type that an exporter is registered for.
pub(super) fn typed<T: Data>(value: &Value) -> io::Result<Arc<T>> {
    let message = || invalid(format!("expected a value of type {}, found {}", T::TYPE, value.type_name()));
    value.downcast().ok_or_else(message)
}

/// A volume's maps with the names that their files bear, after checking that all numbers fit together.
pub(super) fn named_maps(volume: &Volume) -> io::Result<Vec<(String, &Map)>> {
    let [x, y, z] = volume.size;
    let mut named: Vec<(String, &Map)> = Vec::new();
    for map in &volume.maps {
        let expected = [x, y, z, map.channels].iter().try_fold(1usize, |n, &m| n.checked_mul(m));
        if expected.is_none_or(|n| n == 0 || n != map.samples.len()) {
            let (c, found) = (map.channels, map.samples.len());
            let name = &map.name;
            return Err(invalid(format!(
                "map `{name}` of {x} × {y} × {z} voxels with {c} channels has {found} samples"
            )));
        }
        let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
        let name: String = map.name.chars().map(|c| if is_plain(c) { c } else { '_' }).collect();
        if let Some((_, other)) = named.iter().find(|(n, _)| *n == name) {
            let (a, b) = (&other.name, &map.name);
            return Err(invalid(format!(
                "maps `{a}` and `{b}` would both be written to files named `{name}`"
            )));
        }
        named.push((name, map));
    }
    if named.is_empty() { Err(invalid("the volume has no maps to write")) } else { Ok(named) }
}

/// A number as JSON writes it, with the digits of the 32-bit float rather than of its 64-bit neighbour.
pub(super) fn json_number(value: f32) -> serde_json::Value {
    value.to_string().parse::<f64>().map_or(serde_json::Value::Null, serde_json::Value::from)
}

/// How samples become the integers of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// 8 bits as stored.
    Bytes,
    /// Linear colours encoded to 8-bit sRGB; alpha times 255.
    Srgb,
    /// `lo` becomes 0, `hi` becomes 255.
    Scaled { lo: f32, hi: f32 },
    /// Fractions times 65,535.
    Fraction16,
    /// 16-bit labels as stored.
    Label16,
}

/// Samples seen as pixels of one to four channels with 8 or 16 bits.
pub(super) struct Pixels<'a> {
    samples: &'a Samples,
    pub(super) channels: usize,
    form: Form,
}

impl<'a> Pixels<'a> {
    /// A picture: bytes as stored, linear colours encoded to sRGB, other floats as 16-bit fractions.
    pub(super) fn of_image(image: &'a Image) -> io::Result<Self> {
        let (samples, channels) = (image.samples(), image.channels());
        let form = match samples {
            Samples::U8(_) => Form::Bytes,
            Samples::F32(_) if channels >= 3 => Form::Srgb,
            Samples::F32(_) => Form::Fraction16,
            Samples::U32(v) => label16(v)?,
        };
        Ok(Self { samples, channels, form })
    }

    /// A volume's map: bytes as stored, `color` encoded to sRGB, other floats scaled to 8 bits.
    pub(super) fn of_map(map: &'a Map) -> io::Result<Self> {
        if !(1..=4).contains(&map.channels) {
            let (name, c) = (&map.name, map.channels);
            return Err(invalid(format!(
                "map `{name}` has {c} channels, a pixel at most 4; npy and nrrd hold it"
            )));
        }
        let form = match &map.samples {
            Samples::U8(_) => Form::Bytes,
            Samples::F32(_) if map.name == "color" && map.channels >= 3 => Form::Srgb,
            Samples::F32(v) => {
                let (lo, hi) = v.iter().fold((0.0f32, 1.0f32), |(lo, hi), &v| (lo.min(v), hi.max(v)));
                Form::Scaled { lo, hi }
            }
            Samples::U32(v) => label16(v)?,
        };
        Ok(Self { samples: &map.samples, channels: map.channels, form })
    }

    /// Bits a sample, 8 or 16.
    pub(super) fn bits(&self) -> u8 {
        if matches!(self.form, Form::Fraction16 | Form::Label16) { 16 } else { 8 }
    }

    /// The values that 0 and the largest integer stand for, where that is not plain from the type.
    pub(super) fn range(&self) -> Option<(f32, f32)> {
        if let Form::Scaled { lo, hi } = self.form { Some((lo, hi)) } else { None }
    }

    /// Appends samples as bytes, most significant first. Samples out of range are clamped.
    pub(super) fn push(&self, range: Range<usize>, out: &mut Vec<u8>) {
        match (self.form, self.samples) {
            (Form::Bytes, Samples::U8(v)) => out.extend_from_slice(v.get(range).unwrap_or_default()),
            (Form::Srgb, Samples::F32(v)) => {
                let c = self.channels;
                let byte = |i: usize, v: f32| {
                    if c == 4 && i % 4 == 3 { scale(v, 0.0, 1.0, 255.0) as u8 } else { linear_to_srgb(v) }
                };
                let start = range.start;
                let samples = v.get(range).unwrap_or_default();
                out.extend(samples.iter().enumerate().map(|(i, &v)| byte(start + i, v)));
            }
            (Form::Scaled { lo, hi }, Samples::F32(v)) => {
                out.extend(v.get(range).unwrap_or_default().iter().map(|&v| scale(v, lo, hi, 255.0) as u8));
            }
            (Form::Fraction16, Samples::F32(v)) => {
                for &v in v.get(range).unwrap_or_default() {
                    out.extend((scale(v, 0.0, 1.0, 65_535.0) as u16).to_be_bytes());
                }
            }
            (_, Samples::U32(v)) => {
                for &v in v.get(range).unwrap_or_default() {
                    out.extend((v.min(65_535) as u16).to_be_bytes());
                }
            }
            (form, samples) => debug_assert!(false, "{:?} samples as {form:?}", samples.ty()),
        }
    }
}

/// The integer nearest to `v` where `lo` is 0 and `hi` is `top`.
fn scale(v: f32, lo: f32, hi: f32, top: f32) -> f32 {
    // Halves first: the difference of two large floats may be infinite.
    let fraction = (v / 2.0 - lo / 2.0) / (hi / 2.0 - lo / 2.0);
    (fraction * top + 0.5).clamp(0.0, top)
}

fn label16(labels: &[u32]) -> io::Result<Form> {
    match labels.iter().find(|&&label| label > 65_535) {
        None => Ok(Form::Label16),
        Some(label) => Err(invalid(format!(
            "label {label} does not fit into the 16 bits of a png; npy, nrrd and tif hold it"
        ))),
    }
}
