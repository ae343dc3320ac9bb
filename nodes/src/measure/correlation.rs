//! Autocorrelation of luminance: how structures follow each other.

use rayon::prelude::*;

use super::views::{Pixels, luminance};

/// The autocorrelation of pictures for all lags up to `reach` pixels along both axes, −1 to 1; the lag (0, 0) is 1.
#[derive(Clone, Debug)]
pub(super) struct Correlation {
    reach: usize,
    /// For each lag (dx from −reach to reach, dy from 0 to reach), dx fastest.
    values: Vec<f64>,
}

impl Correlation {
    /// The mean autocorrelation of pictures of one size, each larger than `reach` pixels.
    pub fn of(pictures: &[Pixels], reach: usize) -> Self {
        let levels: Vec<Vec<f32>> = pictures
            .iter()
            .map(|picture| picture.data.iter().map(|&pixel| luminance(pixel) as f32).collect())
            .collect();
        let count = levels.iter().map(Vec::len).sum::<usize>().max(1) as f64;
        let sum = |f: fn(f64) -> f64| levels.iter().flatten().map(|&v| f(f64::from(v))).sum::<f64>();
        let mean = sum(|v| v) / count;
        let variance = (sum(|v| v * v) / count - mean * mean).max(1e-9);
        let centred: Vec<Vec<f32>> =
            levels.iter().map(|level| level.iter().map(|v| v - mean as f32).collect()).collect();
        let side = 2 * reach + 1;
        let lags: Vec<(i64, usize)> =
            (0..side * (reach + 1)).map(|i| ((i % side) as i64 - reach as i64, i / side)).collect();
        let value = |&(dx, dy): &(i64, usize)| {
            let (mut sum, mut n) = (0.0, 0usize);
            for (picture, level) in pictures.iter().zip(&centred) {
                let (w, h) = (picture.width, picture.height);
                let shift = dx.unsigned_abs() as usize;
                let (from, to) = if dx < 0 { (shift, 0) } else { (0, shift) };
                for y in 0..h - dy {
                    let a = &level[y * w + from..][..w - shift];
                    let b = &level[(y + dy) * w + to..][..w - shift];
                    sum += a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
                }
                n += (w - shift) * (h - dy);
            }
            sum / n.max(1) as f64 / variance
        };
        Self { reach, values: lags.par_iter().map(value).collect() }
    }

    fn at(&self, dx: i64, dy: i64) -> f64 {
        // The autocorrelation is the same for opposite lags.
        let (dx, dy) = if dy < 0 { (-dx, -dy) } else { (dx, dy) };
        self.values[dy as usize * (2 * self.reach + 1) + (dx + self.reach as i64) as usize]
    }

    /// The same of the transposed pictures.
    pub fn transposed(&self) -> Self {
        Self { reach: self.reach, values: self.lags().map(|(dx, dy)| self.at(dy, dx)).collect() }
    }

    /// The root mean square difference over all lags.
    pub fn distance(&self, other: &Self) -> f64 {
        curve_distance(&self.values, &other.values)
    }

    fn lags(&self) -> impl Iterator<Item = (i64, i64)> {
        let reach = self.reach as i64;
        (0..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| (dx, dy)))
    }

    /// The most by which this exceeds another at a lag of at least `least` pixels along an axis.
    pub fn excess(&self, other: &Self, least: i64) -> f64 {
        let far = self.lags().filter(|&(dx, dy)| dx.abs().max(dy) >= least);
        far.map(|(dx, dy)| self.at(dx, dy) - other.at(dx, dy)).fold(0.0, f64::max)
    }

    /// The mean over all directions, for lags of 0, 1, … pixels (to the nearest).
    pub fn radial(&self) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.reach + 1];
        for (dx, dy) in self.lags() {
            let length = libm::round(libm::sqrt((dx * dx + dy * dy) as f64)) as usize;
            if let Some((sum, count)) = sums.get_mut(length) {
                *sum += self.at(dx, dy);
                *count += 1.0;
            }
        }
        sums.into_iter().map(|(sum, count)| sum / f64::max(count, 1.0)).collect()
    }

    /// The same with the mean over all directions in place of each.
    pub fn isotropic(&self) -> Self {
        let radial = self.radial();
        let level = |(dx, dy): (i64, i64)| {
            let length = libm::sqrt((dx * dx + dy * dy) as f64);
            let (low, part) = (length as usize, length - libm::floor(length));
            let near = |i: usize| radial.get(i).or(radial.last()).copied().unwrap_or(0.0);
            near(low) * (1.0 - part) + near(low + 1) * part
        };
        Self { reach: self.reach, values: self.lags().map(level).collect() }
    }
}

/// The root mean square difference of curves.
pub(super) fn curve_distance(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    libm::sqrt(squares / a.len().min(b.len()).max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stripes(period: usize, slope: usize) -> Pixels {
        let data = (0..32 * 32)
            .map(|i| [if (i % 32 + slope * (i / 32)).is_multiple_of(period) { 255 } else { 0 }; 3]);
        Pixels { width: 32, height: 32, data: data.collect() }
    }

    #[test]
    fn stripes_repeat_after_their_period_and_are_turned_by_transposing() {
        let upright = Correlation::of(&[stripes(4, 0)], 8);
        assert!(upright.at(4, 0) > 0.9 && upright.at(2, 0) < 0.0 && upright.at(0, 3) > 0.9);
        assert!(upright.transposed().at(0, 4) > 0.9 && upright.transposed().at(0, 2) < 0.0);
        // Stripes that lean go through (1, -1) one way and not the other.
        let leaning = Correlation::of(&[stripes(8, 1)], 8);
        assert!(leaning.at(-3, 3) > 0.9 && leaning.at(3, 3) < 0.1);
        assert_eq!(upright.distance(&upright), 0.0);
        assert!(upright.distance(&leaning) > 0.2);
        assert!(leaning.excess(&upright, 3) > 0.9);
        // Half of all directions along the stripes, half across: the rings of 4 mix both.
        let radial = upright.radial();
        assert!((radial[0] - 1.0).abs() < 0.05 && radial.len() == 9 && radial[4] > radial[2]);
        assert!((upright.isotropic().at(0, 4) - radial[4]).abs() < 1e-12);
        assert!((upright.isotropic().at(4, 0) - upright.isotropic().at(0, 4)).abs() < 1e-12);
    }
}
