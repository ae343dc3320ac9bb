//! Filtered look-ups in texture maps.

use crate::data::{Image, Samples, linear_to_srgb, srgb_to_linear};

/// What the bytes of a map mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Colours in sRGB encoding.
    Srgb,
    /// Plain fractions.
    Linear,
}

/// A map with ever smaller copies of itself.
pub(super) struct Texture {
    levels: Vec<Level>,
    decode: [f32; 256],
}

struct Level {
    width: usize,
    height: usize,
    data: Vec<[u8; 3]>,
}

impl Texture {
    /// The map and its copies, each half as wide and high, averaged in linear light.
    pub fn new(image: &Image, encoding: Encoding) -> Self {
        let decode = std::array::from_fn(|byte| match encoding {
            Encoding::Srgb => srgb_to_linear(byte as u8),
            Encoding::Linear => byte as f32 / 255.0,
        });
        let encode: Vec<u8> = match encoding {
            Encoding::Srgb => (0..=8191).map(|i| linear_to_srgb(i as f32 / 8191.0)).collect(),
            Encoding::Linear => (0..=8191).map(|i| (i as f32 / 8191.0 * 255.0 + 0.5) as u8).collect(),
        };
        let (width, height) = (image.width(), image.height());
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let data = pixels.map(|(x, y)| texel(image, x, y, encoding)).collect();
        let mut levels = vec![Level { width: width as usize, height: height as usize, data }];
        while let Some(last) = levels.last()
            && (last.width > 1 || last.height > 1)
        {
            let half = last.halved(&decode, &encode);
            levels.push(half);
        }
        Self { levels, decode }
    }

    /// The size of the map in texels.
    pub fn size(&self) -> [f64; 2] {
        self.levels.first().map_or([1.0; 2], |level| [level.width as f64, level.height as f64])
    }

    /// The map at a place, interpolated between texels and between the two levels around `lod` (0 is the
    /// map itself, 1 half its size). Places outside 0 to 1 repeat the map.
    pub fn sample(&self, [u, v]: [f64; 2], lod: f64) -> [f64; 3] {
        let last = self.levels.len().saturating_sub(1);
        let lod = if lod.is_finite() { lod.clamp(0.0, last as f64) } else { 0.0 };
        let (low, blend) = (lod as usize, lod.fract());
        let fine = self.bilinear(low, u, v);
        if blend == 0.0 {
            return fine;
        }
        let coarse = self.bilinear((low + 1).min(last), u, v);
        std::array::from_fn(|c| fine[c] + blend * (coarse[c] - fine[c]))
    }

    fn bilinear(&self, level: usize, u: f64, v: f64) -> [f64; 3] {
        let Some(level) = self.levels.get(level) else { return [0.0; 3] };
        let axis = |t: f64, n: usize| {
            let t = if t.is_finite() { (t - t.floor()) * n as f64 - 0.5 } else { 0.0 };
            let low = t.floor();
            (
                (low as i64).rem_euclid(n as i64) as usize,
                (low as i64 + 1).rem_euclid(n as i64) as usize,
                t - low,
            )
        };
        let ((x0, x1, fx), (y0, y1, fy)) = (axis(u, level.width), axis(v, level.height));
        let get = |x: usize, y: usize| {
            level.data[y * level.width + x].map(|c| f64::from(self.decode[usize::from(c)]))
        };
        let (a, b, c, d) = (get(x0, y0), get(x1, y0), get(x0, y1), get(x1, y1));
        std::array::from_fn(|i| {
            (a[i] * (1.0 - fx) + b[i] * fx) * (1.0 - fy) + (c[i] * (1.0 - fx) + d[i] * fx) * fy
        })
    }
}

fn texel(image: &Image, x: u32, y: u32, encoding: Encoding) -> [u8; 3] {
    if encoding == Encoding::Srgb {
        return image.rgb8(x, y);
    }
    let byte = |c: usize| match image.samples() {
        Samples::U8(_) | Samples::F32(_) => (image.get(x, y, c) * 255.0 + 0.5).clamp(0.0, 255.0) as u8,
        Samples::U32(_) => image.get(x, y, c).clamp(0.0, 255.0) as u8,
    };
    if image.channels() < 3 { [byte(0); 3] } else { [byte(0), byte(1), byte(2)] }
}

impl Level {
    fn halved(&self, decode: &[f32; 256], encode: &[u8]) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut data = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let xs = [2 * x, (2 * x + 1).min(self.width - 1)];
                let ys = [2 * y, (2 * y + 1).min(self.height - 1)];
                data.push(std::array::from_fn(|c| {
                    let get = |x: usize, y: usize| decode[usize::from(self.data[y * self.width + x][c])];
                    let mean =
                        (get(xs[0], ys[0]) + get(xs[1], ys[0]) + get(xs[0], ys[1]) + get(xs[1], ys[1])) / 4.0;
                    encode[((mean * 8191.0 + 0.5) as usize).min(8191)]
                }));
            }
        }
        Self { width, height, data }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texel_centres_are_the_texels_and_places_repeat() {
        let image = Image::from_fn(4, 2, |x, y| [(x * 60) as u8, (y * 200) as u8, 7]);
        let texture = Texture::new(&image, Encoding::Linear);
        for (x, y) in (0..2).flat_map(|y| (0..4).map(move |x| (x, y))) {
            let place = [(f64::from(x) + 0.5) / 4.0 - 3.0, (f64::from(y) + 0.5) / 2.0 + 2.0];
            let expected = image.rgb8(x, y).map(|c| f64::from(c) / 255.0);
            let found = texture.sample(place, 0.0);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {expected:?}");
        }
    }

    #[test]
    fn the_coarsest_level_is_the_mean_in_linear_light() {
        let image = Image::from_fn(8, 8, |x, y| [if (x + y) % 2 == 0 { 255u8 } else { 0 }; 3]);
        let found = Texture::new(&image, Encoding::Srgb).sample([0.3, 0.9], 99.0);
        assert!((found[0] - 0.5).abs() < 0.005, "{found:?}");
    }
}
