//! What integer samples mean: colours in sRGB encoding, or data that must stay proportional.

/// How the integer samples of a picture are understood. Float samples are taken as they are in every case.
///
/// 8-bit samples are kept as stored: a consumer that wants colour decodes them from sRGB, one that wants
/// data divides them by 255. 16-bit samples become `f32`, and `f32` colours are linear by convention, so
/// that there the question must be answered on reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// Three or four channels are colour, one or two are data, as height and roughness maps are stored.
    #[default]
    Auto,
    /// 16-bit samples are colours in sRGB encoding (IEC 61966-2-1) and are decoded to linear `f32`; alpha stays
    /// proportional.
    Color,
    /// 16-bit samples are divided by 65,535.
    Data,
}

impl Encoding {
    /// The encoding of that name: `auto`, `color` or `data`.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "auto" => Some(Self::Auto),
            "color" => Some(Self::Color),
            "data" => Some(Self::Data),
            _ => None,
        }
    }

    /// Turns interleaved 16-bit samples into `f32`.
    pub(super) fn decode16(self, samples: &[u16], channels: usize) -> Vec<f32> {
        let fraction = |v: u16| f32::from(v) / 65_535.0;
        let is_color = match self {
            Self::Auto => channels >= 3,
            Self::Color => true,
            Self::Data => false,
        };
        if !is_color {
            return samples.iter().map(|&v| fraction(v)).collect();
        }
        // A table costs 65,536 powers, a picture many more.
        let table: Vec<f32> = (0..=u16::MAX).map(|v| srgb_decode(f64::from(v) / 65_535.0)).collect();
        let has_alpha = channels.is_multiple_of(2);
        let sample = |(i, &v): (usize, &u16)| {
            if has_alpha && i % channels == channels - 1 { fraction(v) } else { table[usize::from(v)] }
        };
        samples.iter().enumerate().map(sample).collect()
    }
}

/// Decodes an sRGB value 0 to 1 to a linear one (IEC 61966-2-1).
fn srgb_decode(s: f64) -> f32 {
    (if s <= 0.040_45 { s / 12.92 } else { libm::pow((s + 0.055) / 1.055, 2.4) }) as f32
}
