//! How strong the variation of a picture is, coarse and fine together and fine alone, and how sharp.

use super::views::{Pixels, luminance};

/// Sums from which standard deviations are made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Spread {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Spread {
    fn push(&mut self, value: f64) {
        self.count += 1.0;
        self.sum += value;
        self.squares += value * value;
    }

    fn mean(&self) -> f64 {
        self.sum / self.count.max(1.0)
    }

    /// The standard deviation.
    fn deviation(&self) -> f64 {
        let n = self.count.max(1.0);
        let mean = self.sum / n;
        (self.squares / n - mean * mean).max(0.0).sqrt()
    }
}

/// How luminance varies in pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Variation {
    all: Spread,
    fine: Spread,
    /// Squared steps to the right and down.
    steps: Spread,
}

/// A grey level's fraction added to both sides of ratios, so that small deviations divide too.
const FLOOR: f64 = 0.25;

impl Variation {
    /// That of some pictures together.
    pub fn of<'a>(pictures: impl IntoIterator<Item = &'a Pixels>) -> Self {
        let mut variation = Self::default();
        pictures.into_iter().for_each(|picture| variation.add(picture));
        variation
    }

    /// Adds a picture: its luminances, what remains of them after the mean of each pixel's 3 × 3 surroundings is taken away
    /// (border pixels are left out there), and the steps between neighbours.
    pub fn add(&mut self, picture: &Pixels) {
        let grey: Vec<f64> = picture.data.iter().map(|&rgb| luminance(rgb)).collect();
        grey.iter().for_each(|&value| self.all.push(value));
        let (w, h) = (picture.width, picture.height);
        for y in 1..h.saturating_sub(1) {
            for x in 1..w.saturating_sub(1) {
                let rows =
                    [y - 1, y, y + 1].map(|y| grey[y * w + x - 1] + grey[y * w + x] + grey[y * w + x + 1]);
                self.fine.push(grey[y * w + x] - (rows[0] + rows[1] + rows[2]) / 9.0);
            }
        }
        for y in 0..h.saturating_sub(1) {
            for x in 0..w.saturating_sub(1) {
                let here = grey[y * w + x];
                let (right, down) = (grey[y * w + x + 1] - here, grey[(y + 1) * w + x] - here);
                self.steps.push(right * right + down * down);
            }
        }
    }

    /// The root mean square gradient over the deviation, a reciprocal length.
    fn sharpness(&self) -> f64 {
        (libm::sqrt(self.steps.mean()) + FLOOR) / (self.all.deviation() + FLOOR)
    }

    /// Deviation, deviation of the fine detail, and sharpness, over those of another.
    pub fn ratios(&self, other: &Self) -> [f64; 3] {
        let ratio = |a: Spread, b: Spread| (a.deviation() + FLOOR) / (b.deviation() + FLOOR);
        let sharpness = self.sharpness() / other.sharpness();
        [ratio(self.all, other.all), ratio(self.fine, other.fine), sharpness]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(value: impl Fn(usize, usize) -> u8) -> (f64, f64, f64) {
        let data = (0..64 * 64).map(|i| [value(i % 64, i / 64); 3]).collect();
        let variation = Variation::of(&[Pixels { width: 64, height: 64, data }]);
        (variation.all.deviation(), variation.fine.deviation(), variation.sharpness())
    }

    #[test]
    fn a_ramp_has_contrast_but_nothing_fine_and_a_checkerboard_has_both() {
        let (all, fine, sharpness) = measured(|x, _| 4 * x as u8);
        assert!((all - 73.9).abs() < 0.1 && fine < 1e-6, "{all} {fine}");
        assert!((sharpness - 4.25 / 74.15).abs() < 1e-3, "{sharpness}");
        let (all, fine, sharpness) = measured(|x, y| if (x + y) % 2 == 0 { 200 } else { 100 });
        // The 3 × 3 mean of a checkerboard is 100 · 5/9 away from the other colour.
        assert!((all - 50.0).abs() < 1e-6 && (fine - 100.0 * 4.0 / 9.0).abs() < 1e-6, "{all} {fine}");
        assert!((sharpness - 2.0 * libm::sqrt(2.0)).abs() < 0.01, "{sharpness}");
        // Sharpness does not depend on contrast.
        let faint = measured(|x, y| if (x + y) % 2 == 0 { 150 } else { 100 }).2;
        assert!((faint - sharpness).abs() < 0.02, "{faint}");
    }
}
