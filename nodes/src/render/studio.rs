//! The surroundings of a picture: background, encoding of pixels, rows in parallel.

use rayon::prelude::*;

use super::error::{RenderError, check_picture};
use crate::control::{Cancelled, Control, check};
use crate::data::{Image, Samples, linear_to_srgb};

/// What lies behind the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// Light grey, darker towards the corners.
    Neutral,
    /// White.
    White,
    /// Black.
    Black,
    /// Nothing: the picture gets an alpha channel, shadows are translucent black.
    Transparent,
}

impl Background {
    /// Names and docs, as a choice parameter takes them.
    pub const CHOICES: &'static [(&'static str, &'static str)] = &[
        ("neutral", "Light grey, darker towards the corners."),
        ("white", "White."),
        ("black", "Black."),
        ("transparent", "An alpha channel; shadows are translucent black."),
    ];

    /// The background of that name; neutral for any other.
    pub fn named(name: &str) -> Self {
        match name {
            "white" => Self::White,
            "black" => Self::Black,
            "transparent" => Self::Transparent,
            _ => Self::Neutral,
        }
    }

    /// The linear grey at a place, given as fractions of width and height.
    fn grey(self, x: f64, y: f64) -> f64 {
        match self {
            Self::Neutral => {
                let (dx, dy) = (x - 0.5, y - 0.45);
                (0.84 - 0.42 * (dx * dx + dy * dy)).max(0.3)
            }
            Self::White => 1.0,
            Self::Black | Self::Transparent => 0.0,
        }
    }
}

/// Light that reaches the eye through a place of the picture.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    /// Linear colour of the object, times its coverage.
    pub color: [f64; 3],
    /// Coverage by the object, 0 to 1.
    pub object: f64,
    /// Coverage by shadow on the ground, 0 to 1; the object excludes it.
    pub shadow: f64,
}

impl std::ops::AddAssign for Seen {
    fn add_assign(&mut self, other: Self) {
        self.color.iter_mut().zip(other.color).for_each(|(a, b)| *a += b);
        self.object += other.object;
        self.shadow += other.shadow;
    }
}

/// Composes a picture pixel by pixel over a background, rows in parallel.
pub(super) fn compose(
    size: [u32; 2],
    background: Background,
    control: &dyn Control,
    seen: impl Fn(u32, u32) -> Seen + Sync,
) -> Result<Image, RenderError> {
    check_picture(size)?;
    let [width, height] = size;
    let channels = if background == Background::Transparent { 4 } else { 3 };
    let mut samples = vec![0u8; width as usize * height as usize * channels];
    let rows = samples.par_chunks_mut(width as usize * channels).enumerate();
    let drawn: Result<(), Cancelled> = rows.try_for_each(|(y, row)| {
        check(control)?;
        for (x, pixel) in row.chunks_exact_mut(channels).enumerate() {
            let place = [(x as f64 + 0.5) / f64::from(width), (y as f64 + 0.5) / f64::from(height)];
            encode(seen(x as u32, y as u32), background.grey(place[0], place[1]), pixel);
        }
        Ok(())
    });
    drawn?;
    Image::new(width, height, channels, Samples::U8(samples)).map_err(|_| RenderError::Size(width, height))
}

fn encode(seen: Seen, grey: f64, pixel: &mut [u8]) {
    let object = seen.object.clamp(0.0, 1.0);
    let shadow = seen.shadow.clamp(0.0, 1.0 - object);
    if let [r, g, b, a] = pixel {
        let alpha = object + shadow;
        let color = seen.color.map(|c| if alpha > 0.0 { c / alpha } else { 0.0 });
        [*r, *g, *b] = color.map(|c| linear_to_srgb(c as f32));
        *a = (alpha * 255.0 + 0.5) as u8;
    } else {
        let behind = grey * (1.0 - object - shadow);
        let encoded = seen.color.map(|c| linear_to_srgb((c + behind) as f32));
        pixel.copy_from_slice(&encoded);
    }
}
