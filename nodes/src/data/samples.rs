//! Sample arrays and named maps, shared by images, volumes and voxel maps.

use super::{Reader, Writer};

/// The number type of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleType {
    /// 0 to 255.
    U8,
    /// Labels.
    U32,
    /// Any finite number; colours and fractions are 0 to 1.
    F32,
}

/// An array of samples of one type.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 0 to 255.
    U8(Vec<u8>),
    /// Labels.
    U32(Vec<u32>),
    /// Any finite number; colours and fractions are 0 to 1.
    F32(Vec<f32>),
}

impl SampleType {
    /// Bytes of a sample.
    pub fn byte_size(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U32 | Self::F32 => 4,
        }
    }
}

impl Samples {
    /// `len` zeros.
    pub fn zeros(ty: SampleType, len: usize) -> Self {
        match ty {
            SampleType::U8 => Self::U8(vec![0; len]),
            SampleType::U32 => Self::U32(vec![0; len]),
            SampleType::F32 => Self::F32(vec![0.0; len]),
        }
    }

    /// The number type.
    pub fn ty(&self) -> SampleType {
        match self {
            Self::U8(_) => SampleType::U8,
            Self::U32(_) => SampleType::U32,
            Self::F32(_) => SampleType::F32,
        }
    }

    /// How many samples.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(v) => v.len(),
            Self::U32(v) => v.len(),
            Self::F32(v) => v.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes held.
    pub fn byte_size(&self) -> u64 {
        self.bytes().len() as u64
    }

    /// The samples' bytes in the machine's order.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::U8(v) => v,
            Self::U32(v) => bytemuck::cast_slice(v),
            Self::F32(v) => bytemuck::cast_slice(v),
        }
    }

    /// The samples' bytes in the machine's order.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        match self {
            Self::U8(v) => v,
            Self::U32(v) => bytemuck::cast_slice_mut(v),
            Self::F32(v) => bytemuck::cast_slice_mut(v),
        }
    }

    /// Sample `i` as a fraction: u8 divided by 255, others as they are.
    pub fn get(&self, i: usize) -> f32 {
        match self {
            Self::U8(v) => f32::from(v[i]) / 255.0,
            Self::U32(v) => v[i] as f32,
            Self::F32(v) => v[i],
        }
    }

    /// Sample `i` as a byte: fractions times 255, rounded and clamped.
    pub fn get_u8(&self, i: usize) -> u8 {
        match self {
            Self::U8(v) => v[i],
            Self::U32(v) => v[i].min(255) as u8,
            Self::F32(v) => (v[i] * 255.0 + 0.5).clamp(0.0, 255.0) as u8,
        }
    }

    /// Copies `count` samples from `from[from_at..]` to `self[at..]`; both must be of one type.
    pub fn copy_from(&mut self, at: usize, from: &Self, from_at: usize, count: usize) {
        match (self, from) {
            (Self::U8(a), Self::U8(b)) => a[at..at + count].copy_from_slice(&b[from_at..from_at + count]),
            (Self::U32(a), Self::U32(b)) => a[at..at + count].copy_from_slice(&b[from_at..from_at + count]),
            (Self::F32(a), Self::F32(b)) => a[at..at + count].copy_from_slice(&b[from_at..from_at + count]),
            (a, b) => debug_assert!(false, "{:?} samples copied to {:?}", b.ty(), a.ty()),
        }
    }

    /// Appends the disk cache's form.
    pub fn write(&self, out: &mut Writer) {
        let tag = match self {
            Self::U8(_) => 0,
            Self::U32(_) => 1,
            Self::F32(_) => 2,
        };
        out.u64(tag).bytes(self.bytes());
    }

    /// Reads the disk cache's form.
    ///
    /// # Errors
    /// If the data is damaged.
    pub fn read(reader: &mut Reader<'_>) -> Result<Self, String> {
        match reader.u64()? {
            0 => Ok(Self::U8(reader.array()?)),
            1 => Ok(Self::U32(reader.array()?)),
            2 => Ok(Self::F32(reader.array()?)),
            tag => Err(format!("unknown sample type {tag}")),
        }
    }
}

/// What a map holds, without its samples.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct MapInfo {
    /// `color`, `normal`, `roughness`, `metallic`, `height`, `label`, `source`, or any other name.
    pub name: String,
    /// Samples a voxel or pixel.
    pub channels: usize,
    /// The number type.
    pub ty: SampleType,
}

/// A named array of samples, `channels` a voxel or pixel, interleaved.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// As in [`MapInfo::name`].
    pub name: String,
    /// Samples a voxel or pixel.
    pub channels: usize,
    /// The samples.
    pub samples: Samples,
}

impl Map {
    /// A map of zeros for `count` voxels or pixels.
    pub fn zeros(info: &MapInfo, count: usize) -> Self {
        Self {
            name: info.name.clone(),
            channels: info.channels,
            samples: Samples::zeros(info.ty, count * info.channels),
        }
    }

    /// What the map holds.
    pub fn info(&self) -> MapInfo {
        MapInfo { name: self.name.clone(), channels: self.channels, ty: self.samples.ty() }
    }

    /// Appends the disk cache's form.
    pub fn write(&self, out: &mut Writer) {
        out.text(&self.name).u64(self.channels as u64);
        self.samples.write(out);
    }

    /// Reads the disk cache's form.
    ///
    /// # Errors
    /// If the data is damaged.
    pub fn read(reader: &mut Reader<'_>) -> Result<Self, String> {
        Ok(Self { name: reader.text()?, channels: reader.usize()?, samples: Samples::read(reader)? })
    }
}
