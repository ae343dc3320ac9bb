//! Control maps θ(p) and φ(p): what shall appear more often (Chen & Wang 2010, section 4.4.3).

use crate::data::Image;
use crate::lazy::{LevelView, Pyramid};

/// For every view and pixel of a level how often it shall appear, relative to the average.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlMap {
    views: Vec<Vec<f64>>,
}

/// A picture that cannot control anything.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ControlMapError {
    /// All of it is zero.
    #[error(
        "a control map of {width} × {height} pixels that is black everywhere; expected brighter pixels for what shall appear"
    )]
    Zero {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// It holds something that is no number.
    #[error("a control map with a sample that is no finite number from 0 up, at pixel ({x}, {y})")]
    NotFinite {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
}

impl ControlMap {
    /// A map for the views of a level from a picture, scaled to their size: its first channel, 0 to 1, says how often a pixel
    /// shall appear compared to others. With several views each takes the same picture.
    ///
    /// # Errors
    /// If the picture is black, or holds negative or infinite samples.
    pub fn new(image: &Image, pyramid: &Pyramid, level: usize) -> Result<Self, ControlMapError> {
        let (width, height) = (image.width(), image.height());
        let mut sum = 0.0;
        for y in 0..height {
            for x in 0..width {
                let sample = image.get(x, y, 0);
                if !(sample.is_finite() && sample >= 0.0) {
                    return Err(ControlMapError::NotFinite { x, y });
                }
                sum += f64::from(sample);
            }
        }
        if sum <= 0.0 {
            return Err(ControlMapError::Zero { width, height });
        }
        let views = pyramid.levels.get(level).into_iter().flatten();
        Ok(Self { views: views.map(|view| scaled(image, view)).collect() })
    }

    /// The share of a pixel, 1 on the average.
    pub fn at(&self, view: usize, pixel: usize) -> f64 {
        self.views.get(view).and_then(|view| view.get(pixel)).copied().unwrap_or(1.0)
    }
}

/// The mean of the picture over each pixel of the view, over the mean of all.
fn scaled(image: &Image, view: &LevelView) -> Vec<f64> {
    let range = |i: i32, n: i32, of: u32| {
        let from = (i as u64 * u64::from(of) / n as u64) as u32;
        let to = ((i as u64 + 1) * u64::from(of)).div_ceil(n as u64) as u32;
        from..to.max(from + 1).min(of)
    };
    let mut out = Vec::with_capacity((view.width * view.height) as usize);
    for y in 0..view.height {
        for x in 0..view.width {
            let (mut sum, mut count) = (0.0, 0.0);
            for v in range(y, view.height, image.height()) {
                for u in range(x, view.width, image.width()) {
                    sum += f64::from(image.get(u, v, 0));
                    count += 1.0;
                }
            }
            out.push(sum / f64::max(count, 1.0));
        }
    }
    let mean = out.iter().sum::<f64>() / out.len().max(1) as f64;
    out.iter_mut().for_each(|share| *share /= mean);
    out
}
