//! A 2D picture: colour, mask, or any other map.

use breccia_engine::{Data, Digest};

use super::{Reader, Samples, Writer};

/// A picture of `width` × `height` pixels, rows from top to bottom, channels interleaved.
///
/// Colours are kept in sRGB encoding as they come from 8-bit files; `f32` colours are linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    channels: usize,
    samples: Samples,
}

/// A picture's numbers do not fit together.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{width} × {height} pixels of {channels} channels need {expected} samples, found {found}")]
pub struct ImageError {
    width: u32,
    height: u32,
    channels: usize,
    expected: u64,
    found: usize,
}

impl Image {
    /// A picture from its samples.
    ///
    /// # Errors
    /// If there are no pixels, not 1 to 4 channels, or another number of samples than the size needs.
    pub fn new(width: u32, height: u32, channels: usize, samples: Samples) -> Result<Self, ImageError> {
        let expected = u64::from(width) * u64::from(height) * channels as u64;
        if expected == 0 || channels > 4 || samples.len() as u64 != expected {
            return Err(ImageError { width, height, channels, expected, found: samples.len() });
        }
        Ok(Self { width, height, channels, samples })
    }

    /// A picture made pixel by pixel.
    pub fn from_fn<const C: usize>(
        width: u32,
        height: u32,
        mut pixel: impl FnMut(u32, u32) -> [u8; C],
    ) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        let mut samples = Vec::with_capacity(width as usize * height as usize * C);
        for y in 0..height {
            for x in 0..width {
                samples.extend_from_slice(&pixel(x, y));
            }
        }
        Self { width, height, channels: C, samples: Samples::U8(samples) }
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Samples a pixel, 1 to 4: grey, grey and alpha, RGB, RGBA.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// All samples.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Pixels in all.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The pixel as sRGB bytes; grey is repeated, alpha dropped, linear floats are encoded.
    pub fn rgb8(&self, x: u32, y: u32) -> [u8; 3] {
        let at = (y as usize * self.width as usize + x as usize) * self.channels;
        let get = |c: usize| match &self.samples {
            Samples::F32(v) => linear_to_srgb(v[at + c]),
            other => other.get_u8(at + c),
        };
        if self.channels < 3 { [get(0); 3] } else { [get(0), get(1), get(2)] }
    }

    /// Channel `c` of a pixel as stored, u8 divided by 255.
    pub fn get(&self, x: u32, y: u32, c: usize) -> f32 {
        self.samples.get((y as usize * self.width as usize + x as usize) * self.channels + c)
    }
}

/// Encodes a linear value 0 to 1 as an sRGB byte (IEC 61966-2-1).
pub fn linear_to_srgb(linear: f32) -> u8 {
    let l = f64::from(linear.clamp(0.0, 1.0));
    let s = if l <= 0.003_130_8 { 12.92 * l } else { 1.055 * libm::pow(l, 1.0 / 2.4) - 0.055 };
    (s * 255.0 + 0.5) as u8
}

/// Decodes an sRGB byte to a linear value 0 to 1 (IEC 61966-2-1).
pub fn srgb_to_linear(byte: u8) -> f32 {
    let s = f64::from(byte) / 255.0;
    (if s <= 0.040_45 { s / 12.92 } else { libm::pow((s + 0.055) / 1.055, 2.4) }) as f32
}

impl Data for Image {
    const TYPE: &'static str = "image";
    const DOCS: &'static str = "A picture of one to four channels, 8-bit or float.";

    fn byte_size(&self) -> u64 {
        self.samples.byte_size()
    }

    fn summary(&self) -> String {
        let kind = ["", "grey", "grey+alpha", "RGB", "RGBA"][self.channels.min(4)];
        let float = if matches!(self.samples, Samples::F32(_)) { " float" } else { "" };
        format!("{} × {} {kind}{float}", self.width, self.height)
    }

    fn digest(&self) -> Digest {
        let mut hasher = blake3::Hasher::new();
        for n in [self.width, self.height, self.channels as u32, self.samples.ty() as u32] {
            hasher.update(&n.to_le_bytes());
        }
        hasher.update(self.samples.bytes());
        hasher.finalize().into()
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.u64(self.width.into()).u64(self.height.into()).u64(self.channels as u64);
        self.samples.write(&mut out);
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let (width, height, channels) = (reader.u32()?, reader.u32()?, reader.usize()?);
        let samples = Samples::read(&mut reader)?;
        reader.end()?;
        Self::new(width, height, channels, samples).map_err(|error| error.to_string())
    }
}
