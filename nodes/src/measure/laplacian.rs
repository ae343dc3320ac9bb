//! The Laplacian pyramid (Burt & Adelson 1983).

use super::views::Pixels;

/// One level of a pyramid: RGB in grey levels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Level {
    pub width: usize,
    pub height: usize,
    pub data: Vec<[f32; 3]>,
}

impl Level {
    pub fn get(&self, x: usize, y: usize) -> [f32; 3] {
        self.data[y * self.width + x]
    }

    fn from_fn(width: usize, height: usize, pixel: impl Fn(usize, usize) -> [f32; 3]) -> Self {
        let data = (0..width * height).map(|i| pixel(i % width, i / width)).collect();
        Self { width, height, data }
    }

    /// Smoothed by 1 4 6 4 1 both ways (borders repeated), every second pixel.
    fn reduced(&self) -> Self {
        const WEIGHTS: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];
        let near = |at: usize, k: usize, n: usize| (2 * at + k).saturating_sub(2).min(n - 1);
        let mix = |pixel: &dyn Fn(usize) -> [f32; 3]| {
            std::array::from_fn(|c| WEIGHTS.iter().enumerate().fold(0.0, |s, (k, w)| s + w * pixel(k)[c]))
        };
        let (w, h) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let rows = Self::from_fn(w, self.height, |x, y| mix(&|k| self.get(near(x, k, self.width), y)));
        Self::from_fn(w, h, |x, y| mix(&|k| rows.get(x, near(y, k, self.height))))
    }

    /// The inverse of [`Self::reduced`] but for what it lost: between pixels linear, on them smoothed.
    fn expanded(&self, width: usize, height: usize) -> Self {
        let mix = |at: usize, n: usize, pixel: &dyn Fn(usize) -> [f32; 3]| -> [f32; 3] {
            let i = at / 2;
            let (before, here, after) = (pixel(i.saturating_sub(1)), pixel(i), pixel((i + 1).min(n - 1)));
            std::array::from_fn(|c| match at % 2 {
                0 => (before[c] + 6.0 * here[c] + after[c]) / 8.0,
                _ => (here[c] + after[c]) / 2.0,
            })
        };
        let rows = Self::from_fn(width, self.height, |x, y| mix(x, self.width, &|i| self.get(i, y)));
        Self::from_fn(width, height, |x, y| mix(y, self.height, &|i| rows.get(x, i)))
    }
}

/// `levels` levels, finest first; all but the last hold what the next coarser one lacks.
pub(super) fn laplacian(picture: &Pixels, levels: usize) -> Vec<Level> {
    let data = picture.data.iter().map(|rgb| rgb.map(f32::from)).collect();
    let mut level = Level { width: picture.width, height: picture.height, data };
    let mut pyramid = Vec::new();
    for _ in 1..levels {
        let coarser = level.reduced();
        let smooth = coarser.expanded(level.width, level.height);
        for (pixel, smooth) in level.data.iter_mut().zip(&smooth.data) {
            (0..3).for_each(|c| pixel[c] -= smooth[c]);
        }
        pyramid.push(std::mem::replace(&mut level, coarser));
    }
    pyramid.push(level);
    pyramid
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_add_up_to_the_picture_and_part_scales() {
        let picture = |f: fn(usize, usize) -> u8| Pixels {
            width: 33,
            height: 20,
            data: (0..33 * 20).map(|i| [f(i % 33, i / 33); 3]).collect(),
        };
        let random = picture(|x, y| (x * 37 + y * 91 + x * y) as u8);
        let pyramid = laplacian(&random, 3);
        assert_eq!([0, 1, 2].map(|l| (pyramid[l].width, pyramid[l].height)), [(33, 20), (17, 10), (9, 5)]);
        let middle = pyramid[2].expanded(17, 10);
        let middle = Level::from_fn(17, 10, |x, y| {
            std::array::from_fn(|c| middle.get(x, y)[c] + pyramid[1].get(x, y)[c])
        });
        let fine = middle.expanded(33, 20);
        for (x, y) in (0..33 * 20).map(|i| (i % 33, i / 33)) {
            let sum = fine.get(x, y)[1] + pyramid[0].get(x, y)[1];
            assert!((sum - f32::from(random.get(x, y)[1])).abs() < 1e-3);
        }
        let flat = laplacian(&picture(|_, _| 90), 2);
        assert!(flat[0].data.iter().all(|p| p[0].abs() < 1e-3) && (flat[1].data[7][2] - 90.0).abs() < 1e-3);
        let checks = laplacian(&picture(|x, y| ((x + y) % 2 * 200) as u8), 2);
        assert!(checks[0].get(10, 10)[0].abs() > 90.0 && (checks[1].get(5, 5)[0] - 100.0).abs() < 1.0);
    }
}
