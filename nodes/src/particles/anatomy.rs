//! Size and shape of single particles.

use super::bits::Bits;
use crate::lazy::eigen;

/// Size and shape of a set of voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anatomy {
    /// Voxels.
    pub volume: f64,
    /// Area of the surface in squares of voxel edges, by Crofton's formula over 13 directions.
    pub surface: f64,
    /// The mean of its voxels' places.
    pub centroid: [f64; 3],
    /// Lengths of the axes of the ellipsoid with the same second moments, longest first.
    pub axes: [f64; 3],
}

impl Anatomy {
    /// The anatomy of a set of voxels; `None` of an empty one.
    pub fn of(bits: &Bits) -> Option<Self> {
        let (mut count, mut sum, mut products) = (0i64, [0i64; 3], [[0i64; 3]; 3]);
        for v in bits.voxels() {
            let v = v.map(i64::from);
            count += 1;
            for a in 0..3 {
                sum[a] += v[a];
                (0..3).for_each(|b| products[a][b] += v[a] * v[b]);
            }
        }
        if count == 0 {
            return None;
        }
        let n = count as f64;
        let centroid = sum.map(|s| s as f64 / n);
        let mut covariance = vec![0.0; 9];
        for a in 0..3 {
            for b in 0..3 {
                covariance[3 * a + b] = products[a][b] as f64 / n - centroid[a] * centroid[b];
            }
            // A voxel is a cube, not a point.
            covariance[4 * a] += 1.0 / 12.0;
        }
        let (values, _) = eigen(covariance, 3);
        let mut values: Vec<f64> = values;
        values.sort_by(|a, b| b.total_cmp(a));
        let axes = std::array::from_fn(|i| 2.0 * libm::sqrt(5.0 * values[i].max(0.0)));
        Some(Self { volume: n, surface: surface(bits), centroid, axes })
    }

    /// The surface of a ball of the same volume against the surface: 1 for a ball, less for all else (Wadell 1932).
    pub fn sphericity(&self) -> f64 {
        let ball = libm::cbrt(std::f64::consts::PI) * libm::pow(6.0 * self.volume, 2.0 / 3.0);
        ball / self.surface.max(1e-9)
    }
}

/// Directions up to their sign, with weights that sum to one (Legland, Kiêu & Devaux 2007).
const DIRECTIONS: [([i32; 3], f64); 13] = [
    ([1, 0, 0], 0.091_555_78),
    ([0, 1, 0], 0.091_555_78),
    ([0, 0, 1], 0.091_555_78),
    ([1, 1, 0], 0.073_961_26),
    ([1, -1, 0], 0.073_961_26),
    ([1, 0, 1], 0.073_961_26),
    ([1, 0, -1], 0.073_961_26),
    ([0, 1, 1], 0.073_961_26),
    ([0, 1, -1], 0.073_961_26),
    ([1, 1, 1], 0.070_391_28),
    ([1, 1, -1], 0.070_391_28),
    ([1, -1, 1], 0.070_391_28),
    ([-1, 1, 1], 0.070_391_28),
];

/// Lines in a direction d are 1 / |d| squares apart and meet the surface where one voxel is inside and the next is not; the mean over
/// directions is half of the surface.
fn surface(bits: &Bits) -> f64 {
    let mut sum = 0.0;
    for (d, weight) in DIRECTIONS {
        let length = libm::sqrt(f64::from(d.iter().map(|c| c * c).sum::<i32>()));
        // Every line leaves the set as often as it enters it.
        let leaving = bits.voxels().filter(|v| !bits.holds(std::array::from_fn(|a| v[a] + d[a]))).count();
        sum += weight * 2.0 * leaving as f64 / length;
    }
    2.0 * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_and_an_ellipsoid_are_measured() {
        let ball = Bits::from_fn([-20; 3], [41; 3], |v| v.iter().map(|c| c * c).sum::<i32>() <= 15 * 15);
        let found = Anatomy::of(&ball).unwrap();
        assert!((found.surface / (4.0 * std::f64::consts::PI * 15.0 * 15.0) - 1.0).abs() < 0.03, "{found:?}");
        assert!((found.sphericity() - 1.0).abs() < 0.03);
        assert!(found.axes.iter().all(|a| (a - 30.0).abs() < 0.7), "{found:?}");
        let long = Bits::from_fn([-30; 3], [61; 3], |[x, y, z]| {
            (f64::from(x) / 24.0).powi(2) + (f64::from(y) / 12.0).powi(2) + (f64::from(z - 3) / 8.0).powi(2)
                <= 1.0
        });
        let found = Anatomy::of(&long).unwrap();
        for (axis, wanted) in found.axes.iter().zip([48.0, 24.0, 16.0]) {
            assert!((axis - wanted).abs() < 0.7, "{found:?}");
        }
        assert!((found.centroid[2] - 3.0).abs() < 1e-9 && found.sphericity() < 0.9);
        assert!(Anatomy::of(&Bits::default()).is_none());
    }
}
