//! How strong the variation of a picture is, coarse and fine together and fine alone.

use super::views::{Pixels, luminance};

/// Sums from which standard deviations are made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Spread {
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

    /// The standard deviation.
    pub fn deviation(&self) -> f64 {
        let n = self.count.max(1.0);
        let mean = self.sum / n;
        (self.squares / n - mean * mean).max(0.0).sqrt()
    }
}

/// Adds the luminances of a picture to `all`, and what remains of them after the mean of each pixel's 3 × 3
/// surroundings is taken away to `fine` (border pixels are left out there).
pub(super) fn gather(picture: &Pixels, all: &mut Spread, fine: &mut Spread) {
    let grey: Vec<f64> = picture.data.iter().map(|&rgb| luminance(rgb)).collect();
    grey.iter().for_each(|&value| all.push(value));
    let (w, h) = (picture.width, picture.height);
    for y in 1..h.saturating_sub(1) {
        for x in 1..w.saturating_sub(1) {
            let rows = [y - 1, y, y + 1].map(|y| grey[y * w + x - 1] + grey[y * w + x] + grey[y * w + x + 1]);
            fine.push(grey[y * w + x] - (rows[0] + rows[1] + rows[2]) / 9.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(value: impl Fn(usize, usize) -> u8) -> (f64, f64) {
        let data = (0..64 * 64).map(|i| [value(i % 64, i / 64); 3]).collect();
        let (mut all, mut fine) = (Spread::default(), Spread::default());
        gather(&Pixels { width: 64, height: 64, data }, &mut all, &mut fine);
        (all.deviation(), fine.deviation())
    }

    #[test]
    fn a_ramp_has_contrast_but_nothing_fine_and_a_checkerboard_has_both() {
        let (all, fine) = measured(|x, _| 4 * x as u8);
        assert!((all - 73.9).abs() < 0.1 && fine < 1e-6, "{all} {fine}");
        let (all, fine) = measured(|x, y| if (x + y) % 2 == 0 { 200 } else { 100 });
        // The 3 × 3 mean of a checkerboard is 100 · 5/9 away from the other colour.
        assert!((all - 50.0).abs() < 1e-6 && (fine - 100.0 * 4.0 / 9.0).abs() < 1e-6, "{all} {fine}");
    }
}
