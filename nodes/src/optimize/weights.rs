//! Weights of texels in the solver: what is used too often counts less (Chen & Wang 2010, equation 4; Kopf et al. 2007,
//! equation 3).

use super::control_map::ControlMap;
use crate::lazy::{LevelView, Pixel};

/// How texels that are used too often are held back.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightSettings {
    /// Strength of position histogram matching: the weight is divided by `1 + position · max(0, H/θ − 1)`.
    pub position: f64,
    /// Pixels around each over which the position histogram is averaged first.
    pub smoothing: i32,
    /// Strength of colour histogram matching: the weight is divided by `1 + color · Σ max(0, H_s − H_e)`, shares of 16 bins for each
    /// of three channels.
    pub color: f64,
}

/// Bins of a channel.
const BINS: usize = 16;

/// What has been used so far, counted in integers.
pub(super) struct Usage {
    /// For each view and pixel.
    positions: Vec<Vec<u32>>,
    /// For each channel and bin.
    colors: [[u32; BINS]; 3],
    /// The exemplar's shares of the same bins.
    wanted: [[f64; BINS]; 3],
    /// Voxels counted.
    voxels: u64,
}

impl Usage {
    pub fn new(views: &[LevelView]) -> Self {
        let mut counts = [[0u64; BINS]; 3];
        let mut texels = 0u64;
        for texel in views.iter().flat_map(|view| &view.texels) {
            (0..3).for_each(|c| counts[c][usize::from(texel[c]) * BINS / 256] += 1);
            texels += 1;
        }
        Self {
            positions: views.iter().map(|view| vec![0; view.texels.len()]).collect(),
            colors: [[0; BINS]; 3],
            wanted: counts.map(|bins| bins.map(|n| n as f64 / texels.max(1) as f64)),
            voxels: 0,
        }
    }

    /// Counts a voxel.
    pub fn add(&mut self, views: &[LevelView], view: usize, source: Pixel, color: [u8; 4]) {
        self.positions[view][views[view].index(source)] += 1;
        (0..3).for_each(|c| self.colors[c][usize::from(color[c]) * BINS / 256] += 1);
        self.voxels += 1;
    }

    /// Takes back what [`Usage::add`] counted.
    pub fn remove(&mut self, views: &[LevelView], view: usize, source: Pixel, color: [u8; 4]) {
        self.positions[view][views[view].index(source)] -= 1;
        (0..3).for_each(|c| self.colors[c][usize::from(color[c]) * BINS / 256] -= 1);
        self.voxels -= 1;
    }

    /// The weight of every texel of a view.
    pub fn weights(
        &self,
        views: &[LevelView],
        view: usize,
        theta: Option<&ControlMap>,
        settings: &WeightSettings,
    ) -> Vec<f32> {
        let level = &views[view];
        if self.voxels == 0 {
            return vec![1.0; level.texels.len()];
        }
        let of_view: u64 = self.positions[view].iter().map(|&n| u64::from(n)).sum();
        let even = of_view as f64 / level.texels.len() as f64;
        let smooth = smoothed(&self.positions[view], level, settings.smoothing);
        let voxels = self.voxels as f64;
        let excess: [[f64; BINS]; 3] = std::array::from_fn(|c| {
            std::array::from_fn(|b| (f64::from(self.colors[c][b]) / voxels - self.wanted[c][b]).max(0.0))
        });
        let each = level.texels.iter().zip(smooth).enumerate();
        each.map(|(i, (texel, h))| {
            let wanted = even * theta.map_or(1.0, |theta| theta.at(view, i));
            let over = if even > 0.0 { (h / wanted - 1.0).max(0.0) } else { 0.0 };
            let color: f64 = (0..3).map(|c| excess[c][usize::from(texel[c]) * BINS / 256]).sum();
            (1.0 / ((1.0 + settings.position * over.min(1e12)) * (1.0 + settings.color * color))) as f32
        })
        .collect()
    }
}

/// The mean of a histogram over the square of `radius` pixels around each pixel.
fn smoothed(counts: &[u32], view: &LevelView, radius: i32) -> Vec<f64> {
    let (w, h) = (view.width, view.height);
    let at = |i: i32, n: i32| if view.tileable { i.rem_euclid(n) } else { i.clamp(0, n - 1) };
    let mut rows = vec![0u64; counts.len()];
    for y in 0..h {
        let row = &counts[(y * w) as usize..][..w as usize];
        let mut sum: u64 = (-radius..=radius).map(|d| u64::from(row[at(d, w) as usize])).sum();
        for x in 0..w {
            rows[(y * w + x) as usize] = sum;
            sum += u64::from(row[at(x + radius + 1, w) as usize]);
            sum -= u64::from(row[at(x - radius, w) as usize]);
        }
    }
    let mut out = vec![0.0; counts.len()];
    let area = f64::from((2 * radius + 1).pow(2));
    for x in 0..w {
        let column = |y: i32| rows[(at(y, h) * w + x) as usize];
        let mut sum: u64 = (-radius..=radius).map(column).sum();
        for y in 0..h {
            out[(y * w + x) as usize] = sum as f64 / area;
            sum += column(y + radius + 1);
            sum -= column(y - radius);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_is_the_mean_of_a_square() {
        for tileable in [false, true] {
            let view =
                LevelView { width: 7, height: 5, tileable, texels: vec![[0; 4]; 35], barred: Vec::new() };
            let counts: Vec<u32> = (0..35).map(|i| i * i % 23).collect();
            for radius in 0..3 {
                let found = smoothed(&counts, &view, radius);
                for (i, found) in found.iter().enumerate() {
                    let (x, y) = (i as i32 % 7, i as i32 / 7);
                    let mut sum = 0;
                    for v in y - radius..=y + radius {
                        for u in x - radius..=x + radius {
                            let (u, v) = if tileable {
                                (u.rem_euclid(7), v.rem_euclid(5))
                            } else {
                                (u.clamp(0, 6), v.clamp(0, 4))
                            };
                            sum += counts[(v * 7 + u) as usize];
                        }
                    }
                    assert_eq!(*found, f64::from(sum) / f64::from((2 * radius + 1).pow(2)));
                }
            }
        }
    }
}
