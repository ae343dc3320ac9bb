//! Arrays of any number type and memory order, as array files hold them, turned into samples.

use super::{ReadError, ReadLimits};
use crate::data::{Map, Samples, Volume};

/// How a volume's file is understood.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct VolumeOptions {
    /// How large it may be.
    pub limits: ReadLimits,
    /// What integers mean.
    pub integers: Integers,
    /// The name of the map; empty for `label` where samples are labels, `color` where there are three or
    /// four channels, and `value` otherwise.
    pub map: String,
}

/// What the integers of an array mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integers {
    /// 8 bits are kept, unsigned 16 bits are divided by 65,535, all others and truth values are labels.
    #[default]
    Auto,
    /// All integers and truth values are labels.
    Labels,
}

impl Integers {
    /// The meaning of that name: `auto` or `labels`.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "auto" => Some(Self::Auto),
            "labels" => Some(Self::Labels),
            _ => None,
        }
    }
}

/// A number type of an array file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    Bool,
    U8,
    U16,
    U32,
    U64,
    I8,
    I16,
    I32,
    I64,
    F16,
    F32,
    F64,
}

impl Scalar {
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Bool | Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The integer in `raw`, little-endian and of the right length.
    fn integer(self, raw: [u8; 8]) -> i128 {
        let bits = u64::from_le_bytes(raw);
        match self {
            Self::Bool => i128::from(bits != 0),
            Self::I8 => i128::from(bits as i8),
            Self::I16 => i128::from(bits as i16),
            Self::I32 => i128::from(bits as i32),
            Self::I64 => i128::from(bits as i64),
            _ => i128::from(bits),
        }
    }

    /// The float in `raw`, little-endian and of the right length.
    fn float(self, raw: [u8; 8]) -> f64 {
        let bits = u64::from_le_bytes(raw);
        match self {
            Self::F16 => exr::prelude::f16::from_bits(bits as u16).to_f64(),
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
            _ => self.integer(raw) as f64,
        }
    }
}

/// What an array's header says.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// The file format, for errors.
    pub(super) format: &'static str,
    pub(super) scalar: Scalar,
    pub(super) big_endian: bool,
    /// Along x, y and z.
    pub(super) size: [usize; 3],
    pub(super) channels: usize,
    /// The axes from the fastest to the slowest: 0 to 2 for x to z, 3 for the channel.
    pub(super) order: [usize; 4],
}

impl Layout {
    /// Samples in all, if they fit the limits.
    ///
    /// # Errors
    /// [`ReadError::Damaged`] without any sample, [`ReadError::TooLarge`].
    pub(super) fn check(&self, limits: &ReadLimits) -> Result<usize, ReadError> {
        let [x, y, z] = self.size;
        let what = format!(
            "a volume of {x} × {y} × {z} voxels with {} channels of {:?}",
            self.channels, self.scalar
        );
        let factors = [x, y, z, self.channels];
        if factors.contains(&0) {
            return Err(ReadError::damaged(self.format, format!("{what} holds no samples")));
        }
        let kept = if self.scalar == Scalar::U8 { 1 } else { self.scalar.bytes().max(4) };
        let count = factors.iter().try_fold(1usize, |n, &m| n.checked_mul(m));
        let bytes = count.and_then(|n| n.checked_mul(kept)).map_or(u64::MAX, |n| n as u64);
        match count {
            Some(count) if bytes <= limits.volume_bytes => Ok(count),
            _ => Err(ReadError::TooLarge { what, bytes, limit: limits.volume_bytes }),
        }
    }

    /// Turns the array's bytes into a volume of one map at the origin with spacing 1.
    ///
    /// # Errors
    /// If bytes are missing, a float is not finite in `f32`, or a label is no number of 32 bits.
    pub(super) fn decode(&self, data: &[u8], options: &VolumeOptions) -> Result<Volume, ReadError> {
        let count = self.check(&options.limits)?;
        let expected = count.saturating_mul(self.scalar.bytes());
        let data = data.get(..expected).ok_or_else(|| {
            ReadError::damaged(
                self.format,
                format!("expected {expected} bytes of samples, found {}", data.len()),
            )
        })?;
        let labels = match self.scalar {
            Scalar::F16 | Scalar::F32 | Scalar::F64 => false,
            Scalar::U8 | Scalar::U16 => options.integers == Integers::Labels,
            _ => true,
        };
        let samples = match self.scalar {
            _ if labels => {
                Samples::U32(self.gather(data, "a label from 0 to 4,294,967,295 is expected", |raw| {
                    u32::try_from(self.scalar.integer(raw)).map_err(|_| self.scalar.integer(raw).to_string())
                })?)
            }
            Scalar::U8 if self.order == [3, 0, 1, 2] => Samples::U8(data.to_vec()),
            Scalar::U8 => Samples::U8(self.gather(data, "", |raw| Ok(raw[0]))?),
            Scalar::U16 => Samples::F32(
                self.gather(data, "", |raw| Ok(f32::from(u16::from_le_bytes([raw[0], raw[1]])) / 65_535.0))?,
            ),
            _ => Samples::F32(self.gather(data, "every sample must be a finite 32-bit float", |raw| {
                let value = self.scalar.float(raw);
                if (value as f32).is_finite() { Ok(value as f32) } else { Err(value.to_string()) }
            })?),
        };
        let name = match options.map.as_str() {
            "" if labels => "label",
            "" if self.channels == 3 || self.channels == 4 => "color",
            "" => "value",
            name => name,
        };
        let maps = vec![Map { name: name.to_owned(), channels: self.channels, samples }];
        Ok(Volume { size: self.size, origin: [0; 3], spacing: [1.0; 3], maps })
    }

    /// Reads every sample in the order Z, Y, X, channel. An error of `convert` is the value it cannot take.
    fn gather<T>(
        &self,
        data: &[u8],
        expected: &'static str,
        convert: impl Fn([u8; 8]) -> Result<T, String>,
    ) -> Result<Vec<T>, ReadError> {
        let width = self.scalar.bytes();
        let lengths = [self.size[0], self.size[1], self.size[2], self.channels];
        let mut strides = [0; 4];
        let mut stride = width;
        for axis in self.order {
            strides[axis] = stride;
            stride = stride.saturating_mul(lengths[axis]);
        }
        let mut samples = Vec::with_capacity(data.len() / width);
        for z in 0..lengths[2] {
            for y in 0..lengths[1] {
                for x in 0..lengths[0] {
                    for c in 0..lengths[3] {
                        let at = x * strides[0] + y * strides[1] + z * strides[2] + c * strides[3];
                        let mut raw = [0; 8];
                        if let Some(bytes) = data.get(at..at + width) {
                            raw[..width].copy_from_slice(bytes);
                        }
                        if self.big_endian {
                            raw[..width].reverse();
                        }
                        samples.push(convert(raw).map_err(|value| ReadError::BadSample {
                            place: format!("x {x}, y {y}, z {z}, channel {c}"),
                            value,
                            expected,
                        })?);
                    }
                }
            }
        }
        Ok(samples)
    }
}
