//! Which way structures run: histograms of local orientation by the structure tensor (Bigün & Granlund 1987).

use super::views::{Pixels, luminance};

/// Bins over half a turn.
const BINS: usize = 16;

/// How much of the structure runs each way.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Orientations([f64; BINS]);

impl Orientations {
    /// Adds the pixels of a picture. The tensor is the 3 × 3 mean of products of central differences; a pixel counts by
    /// the difference of its eigenvalues, so that what has no direction does not count.
    pub fn add(&mut self, picture: &Pixels) {
        let (w, h) = (picture.width, picture.height);
        let level = |x: usize, y: usize| luminance(picture.get(x, y));
        let products = |x: usize, y: usize| {
            let gx = (level(x + 1, y) - level(x - 1, y)) / 2.0;
            let gy = (level(x, y + 1) - level(x, y - 1)) / 2.0;
            [gx * gx, gy * gy, gx * gy]
        };
        for y in 2..h.saturating_sub(2) {
            for x in 2..w.saturating_sub(2) {
                let mut tensor = [0.0; 3];
                for (dy, dx) in (0..9).map(|k| (k / 3, k % 3)) {
                    let product = products(x + dx - 1, y + dy - 1);
                    tensor.iter_mut().zip(product).for_each(|(sum, p)| *sum += p);
                }
                let [xx, yy, xy] = tensor;
                let (along, across) = (xx - yy, 2.0 * xy);
                // The doubled angle of the gradient, from 0 to 1.
                let turn = libm::atan2(across, along) / (2.0 * std::f64::consts::PI) + 0.5;
                // Bins overlap, so that a direction on the border of two counts for both.
                let place = turn * BINS as f64;
                let (bin, part) = (libm::floor(place), place - libm::floor(place));
                let weight = libm::sqrt(along * along + across * across);
                self.0[bin as usize % BINS] += weight * (1.0 - part);
                self.0[(bin as usize + 1) % BINS] += weight * part;
            }
        }
    }

    /// The same of the transposed pictures.
    pub fn transposed(&self) -> Self {
        // Transposing mirrors the gradient at the diagonal: its doubled angle a becomes half a turn less a.
        Self(std::array::from_fn(|bin| self.0[(BINS + BINS / 2 - bin) % BINS]))
    }

    /// The divergence of another distribution from this one after the turn, in steps of a bin, and the mirroring that make it
    /// smallest: what a picture of unknown rotation can be held to.
    pub fn divergence_turned(&self, found: &Self) -> f64 {
        let versions = [found.clone(), found.transposed()];
        let turned = versions.iter().flat_map(|version| {
            (0..BINS).map(|turn| Self(std::array::from_fn(|bin| version.0[(bin + turn) % BINS])))
        });
        turned.map(|version| self.divergence(&version)).fold(f64::INFINITY, f64::min)
    }

    /// The share of each bin, from gradients along x on.
    pub fn shares(&self) -> Vec<f64> {
        let sum = self.0.iter().sum::<f64>().max(1e-9);
        (0..BINS).map(|bin| self.0[(bin + BINS / 2) % BINS] / sum).collect()
    }

    /// The Kullback-Leibler divergence of another distribution from this one, in nats; 0 is the same.
    pub fn divergence(&self, found: &Self) -> f64 {
        let shares = |of: &Self| {
            let sum: f64 = of.0.iter().sum();
            of.0.map(|v| (v + 1e-3 * sum + 1e-9) / ((1.0 + 1e-3 * BINS as f64) * sum + 1e-9 * BINS as f64))
        };
        let (truth, found) = (shares(self), shares(found));
        truth.iter().zip(found).map(|(p, q)| p * libm::log(p / q)).sum::<f64>().max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waves(along: f64, down: f64) -> Orientations {
        let level = |x: usize, y: usize| 128.0 + 100.0 * libm::sin(along * x as f64 + down * y as f64);
        let data = (0..48 * 48).map(|i| [level(i % 48, i / 48) as u8; 3]).collect();
        let mut orientations = Orientations::default();
        orientations.add(&Pixels { width: 48, height: 48, data });
        orientations
    }

    #[test]
    fn waves_are_told_apart_by_their_direction_alone() {
        let upright = waves(0.5, 0.0);
        assert!(upright.divergence(&upright) < 1e-9);
        assert!(upright.divergence(&waves(0.3, 0.0)) < 0.05);
        assert!(upright.divergence(&waves(0.0, 0.5)) > 2.0);
        assert!(upright.transposed().divergence(&waves(0.0, 0.5)) < 0.05);
        let (falling, rising) = (waves(0.4, 0.4), waves(0.4, -0.4));
        assert!(falling.divergence(&rising) > 2.0 && falling.transposed().divergence(&falling) < 0.05);
        assert!(upright.divergence_turned(&falling) < 0.1);
        assert_eq!(upright.shares().len(), 16);
        assert!(upright.shares()[0] > 0.5);
    }
}
