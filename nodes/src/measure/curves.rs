//! The curves behind the measures of likeness.

use super::views::{Pixels, luminance};
use crate::data::{Curves, Plot, Series};

/// Bins of the histogram of luminance.
const BINS: usize = 32;

/// Curves of the slices across the axes, of the oblique cuts, and of the exemplar.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LikenessCurves {
    /// Shares of luminance in 32 bins.
    pub luminance: [Vec<f64>; 3],
    /// Autocorrelation of luminance, the mean over all directions, for lags of 0, 1, … pixels. Slices and exemplar, then cuts.
    pub autocorrelation: [Vec<f64>; 3],
    /// Shares of local orientation in 16 bins over half a turn, slices and exemplar.
    pub orientation: [Vec<f64>; 2],
}

/// The shares of luminance in bins.
pub(super) fn histogram<'a>(pictures: impl IntoIterator<Item = &'a Pixels>) -> Vec<f64> {
    let mut counts = vec![0u64; BINS];
    for &pixel in pictures.into_iter().flat_map(|picture| &picture.data) {
        counts[(luminance(pixel) * BINS as f64 / 256.0) as usize % BINS] += 1;
    }
    let sum = counts.iter().sum::<u64>().max(1) as f64;
    counts.into_iter().map(|count| count as f64 / sum).collect()
}

impl LikenessCurves {
    /// The plots, each with its series.
    pub fn plots(&self) -> Curves {
        const NAMES: [&str; 3] = ["slices", "oblique", "exemplar"];
        let series = |name: &str, values: &[f64], scale: f64, start: f64| Series {
            name: name.to_owned(),
            points: values.iter().enumerate().map(|(i, &v)| [start + scale * i as f64, v]).collect(),
        };
        let all = |values: &[Vec<f64>; 3], scale: f64, start: f64| {
            NAMES.iter().zip(values).map(|(name, values)| series(name, values, scale, start)).collect()
        };
        let wide = 256.0 / BINS as f64;
        let turn = 180.0 / self.orientation[0].len().max(1) as f64;
        let orientation = ["slices", "exemplar"].iter().zip(&self.orientation);
        let mut curves = Curves::new("quality");
        curves.plots = vec![
            Plot::new("luminance", "luminance", "share of pixels", all(&self.luminance, wide, wide / 2.0)),
            Plot::new(
                "autocorrelation",
                "lag in voxels",
                "autocorrelation",
                all(&self.autocorrelation, 1.0, 0.0),
            ),
            Plot::new(
                "orientation",
                "direction of the gradient in degrees",
                "share",
                orientation.map(|(name, values)| series(name, values, turn, 0.0)).collect(),
            ),
        ];
        curves
    }
}
