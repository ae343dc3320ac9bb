//! Halving and area-averaging of exemplar maps, in integers.

use crate::data::{Image, Samples};

/// A picture of `channels` a pixel at half the size (rounded down, at least 1): the mean of 2 × 2 pixels.
pub fn halve(pixels: &[u8], width: usize, height: usize, channels: usize) -> (Vec<u8>, usize, usize) {
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let mut out = Vec::with_capacity(w * h * channels);
    for y in 0..h {
        for x in 0..w {
            for c in 0..channels {
                let at = |dx: usize, dy: usize| {
                    let (x, y) = ((2 * x + dx).min(width - 1), (2 * y + dy).min(height - 1));
                    u32::from(pixels[(y * width + x) * channels + c])
                };
                out.push(((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) / 4) as u8);
            }
        }
    }
    (out, w, h)
}

/// A picture shrunk to `width` × `height` by area averaging. Sample type and channels are kept.
pub(crate) fn shrink(image: &Image, width: u32, height: u32) -> Image {
    if (image.width(), image.height()) == (width, height) {
        return image.clone();
    }
    let channels = image.channels();
    let spans = |from: u32, to: u32| -> Vec<Vec<(u32, f64)>> {
        let ratio = f64::from(from) / f64::from(to);
        let span = |i: u32| {
            let (a, b) = (f64::from(i) * ratio, f64::from(i + 1) * ratio);
            let last = (libm::ceil(b) as u32).min(from);
            (a as u32..last).map(|s| (s, (b.min(f64::from(s + 1)) - a.max(f64::from(s))).max(0.0))).collect()
        };
        (0..to).map(span).collect()
    };
    let (columns, rows) = (spans(image.width(), width), spans(image.height(), height));
    let mut values = Vec::with_capacity((width * height) as usize * channels);
    for row in &rows {
        for column in &columns {
            for c in 0..channels {
                let (mut sum, mut weight) = (0.0, 0.0);
                for &(y, wy) in row {
                    for &(x, wx) in column {
                        sum += f64::from(image.get(x, y, c)) * wx * wy;
                        weight += wx * wy;
                    }
                }
                values.push(sum / weight.max(1e-12));
            }
        }
    }
    let samples = match image.samples() {
        Samples::U8(_) => Samples::U8(values.iter().map(|v| (v * 255.0 + 0.5) as u8).collect()),
        _ => Samples::F32(values.iter().map(|&v| v as f32).collect()),
    };
    Image::new(width, height, channels, samples).unwrap_or_else(|_| image.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shrinking_keeps_the_mean() {
        let image = Image::from_fn(30, 21, |x, y| [(x * 7 + y * 3) as u8]);
        let small = shrink(&image, 10, 7);
        let mean = |i: &Image| (0..i.pixels()).map(|k| i.samples().get(k)).sum::<f32>() / i.pixels() as f32;
        assert!((mean(&image) - mean(&small)).abs() < 0.01);
    }
}
