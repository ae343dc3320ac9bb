//! PCA bases and quantised descriptors of neighbourhoods (Dong et al. 2008, section 6.2: "we reduce the
//! dimensionality … using PCA … and quantize the neighborhoods to 8-bits").
//!
//! A neighbourhood is projected on at most 16 principal components with 7-bit weights, and the result is kept
//! in 7 bits, so that every product fits the integer instructions of all processors and the answer is the
//! same on each. One scale serves all views of a level, so that distances in different views compare.

use super::pyramid::{LevelView, N, Pixel, Pyramid};

/// Largest number of components.
pub const DIMS: usize = 16;
/// Samples in a neighbourhood: 5 × 5 pixels of 4 channels.
const SAMPLES: usize = N * N * 4;

/// The quantised projection of a neighbourhood, each entry 0 to 127.
pub type Descriptor = [u8; DIMS];

/// A quantised PCA basis. A component is `clamp((Σ weight · sample + bias) >> shift, 0, 127)`.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Basis {
    /// For each pixel, component and channel, from −63 to 63.
    pub weights: [[[i8; 4]; DIMS]; N * N],
    /// Added before the shift: centring, rounding and the offset of 64.
    pub bias: [i32; DIMS],
    /// Binary digits dropped.
    pub shift: u32,
}

impl Basis {
    /// Components that are not always zero.
    pub fn dims(&self) -> usize {
        let used = |d: &usize| self.bias[*d] != 0 || self.weights.iter().any(|pixel| pixel[*d] != [0; 4]);
        (0..DIMS).rev().find(used).map_or(0, |d| d + 1)
    }

    /// The descriptor of a neighbourhood, row by row.
    pub fn project(&self, neighbourhood: &[[u8; 4]; N * N]) -> Descriptor {
        let mut sums = self.bias;
        for (pixel, weights) in neighbourhood.iter().zip(&self.weights) {
            for (sum, weight) in sums.iter_mut().zip(weights) {
                for c in 0..4 {
                    *sum += i32::from(pixel[c]) * i32::from(weight[c]);
                }
            }
        }
        sums.map(|sum| (sum >> self.shift).clamp(0, 127) as u8)
    }
}

/// The bases of a level's views, and how descriptor distances compare to colour distances.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelBases {
    /// One basis a view.
    pub bases: Vec<Basis>,
    /// Descriptor distance a squared colour difference of 1, times 65,536.
    pub scale: u32,
}

/// The PCA bases of one level with `dims` components (1 to 16).
pub fn level_bases(pyramid: &Pyramid, level: usize, dims: usize) -> LevelBases {
    let views = &pyramid.levels[level];
    let components: Vec<_> =
        views.iter().map(|view| principal_components(view, dims.clamp(1, DIMS))).collect();
    // The largest projection of any neighbourhood is to use the 7 bits fully.
    let largest = views.iter().zip(&components).map(|(view, pca)| pca.largest(view)).fold(1.0f64, f64::max);
    let scale = 63.0 / largest;
    let bases = components.iter().map(|pca| pca.quantise(scale)).collect();
    LevelBases { bases, scale: ((scale * scale * 65536.0) as u32).max(1) }
}

/// Mean and orthonormal components of a view's neighbourhoods.
struct Components {
    mean: [f64; SAMPLES],
    vectors: Vec<[f64; SAMPLES]>,
}

fn samples(view: &LevelView, pixel: Pixel) -> [u8; SAMPLES] {
    let neighbourhood = view.neighbourhood(pixel);
    std::array::from_fn(|i| neighbourhood[i / 4][i % 4])
}

fn principal_components(view: &LevelView, dims: usize) -> Components {
    let centres = view.centres();
    let count = centres.len() as i64;
    // Integer sums are exact, so the covariance is the same in any order.
    let mut sum = [0i64; SAMPLES];
    let mut products = vec![0i64; SAMPLES * SAMPLES];
    for &pixel in &centres {
        let s = samples(view, pixel).map(i64::from);
        for (i, &one) in s.iter().enumerate() {
            sum[i] += one;
            for (product, &other) in products[i * SAMPLES..][i..SAMPLES].iter_mut().zip(&s[i..]) {
                *product += one * other;
            }
        }
    }
    let mut covariance = vec![0.0; SAMPLES * SAMPLES];
    for i in 0..SAMPLES {
        for j in i..SAMPLES {
            let value = (products[i * SAMPLES + j] * count - sum[i] * sum[j]) as f64 / (count * count) as f64;
            covariance[i * SAMPLES + j] = value;
            covariance[j * SAMPLES + i] = value;
        }
    }
    let (values, vectors) = eigen(covariance, SAMPLES);
    let mut order: Vec<usize> = (0..SAMPLES).collect();
    order.sort_by(|&a, &b| values[b].total_cmp(&values[a]).then(a.cmp(&b)));
    let kept = order.iter().take(dims).filter(|&&k| values[k] > 1e-9);
    Components {
        mean: sum.map(|s| s as f64 / count as f64),
        vectors: kept.map(|&k| std::array::from_fn(|i| vectors[i * SAMPLES + k])).collect(),
    }
}

impl Components {
    fn largest(&self, view: &LevelView) -> f64 {
        let project = |vector: &[f64; SAMPLES], s: &[u8; SAMPLES]| {
            (0..SAMPLES).map(|i| vector[i] * (f64::from(s[i]) - self.mean[i])).sum::<f64>().abs()
        };
        let each = view.centres().into_iter().map(|pixel| {
            let s = samples(view, pixel);
            self.vectors.iter().map(|vector| project(vector, &s)).fold(0.0, f64::max)
        });
        each.fold(0.0, f64::max)
    }

    fn quantise(&self, scale: f64) -> Basis {
        let largest = self.vectors.iter().flatten().fold(0.0f64, |a, w| a.max(w.abs())) * scale;
        let mut shift = 0;
        while shift < 20 && largest * f64::from(2u32 << shift) <= 63.0 {
            shift += 1;
        }
        let unit = scale * f64::from(1u32 << shift);
        let mut basis = Basis { weights: [[[0; 4]; DIMS]; N * N], bias: [0; DIMS], shift };
        for (d, vector) in self.vectors.iter().enumerate() {
            let mut centre = 0.0;
            for (i, component) in vector.iter().enumerate() {
                let weight = libm::round(component * unit);
                basis.weights[i / 4][d][i % 4] = weight as i8;
                centre += weight * self.mean[i];
            }
            basis.bias[d] = (64 << shift) + (1 << shift >> 1) - libm::round(centre) as i32;
        }
        basis
    }
}

/// Eigenvalues and eigenvectors (as columns) of a symmetric matrix by cyclic Jacobi rotations (Golub & Van
/// Loan, section 8.5). Only additions, multiplications, divisions and square roots in a fixed order, so the
/// result is the same bits on every machine, which a library with run-time dispatch does not promise.
pub(crate) fn eigen(mut a: Vec<f64>, n: usize) -> (Vec<f64>, Vec<f64>) {
    let mut v = vec![0.0; n * n];
    (0..n).for_each(|i| v[i * n + i] = 1.0);
    for _ in 0..30 {
        let off: f64 =
            (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i * n + j] * a[i * n + j]).sum();
        let diagonal: f64 = (0..n).map(|i| a[i * n + i] * a[i * n + i]).sum();
        if off <= 1e-18 * diagonal {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                let apq = a[p * n + q];
                if apq * apq <= 1e-24 * diagonal {
                    continue;
                }
                let theta = (a[q * n + q] - a[p * n + p]) / (2.0 * apq);
                let sign = if theta < 0.0 { -1.0 } else { 1.0 };
                let t = sign / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for k in 0..n {
                    let (x, y) = (a[k * n + p], a[k * n + q]);
                    a[k * n + p] = c * x - s * y;
                    a[k * n + q] = s * x + c * y;
                }
                for k in 0..n {
                    let (x, y) = (a[p * n + k], a[q * n + k]);
                    a[p * n + k] = c * x - s * y;
                    a[q * n + k] = s * x + c * y;
                    let (x, y) = (v[k * n + p], v[k * n + q]);
                    v[k * n + p] = c * x - s * y;
                    v[k * n + q] = s * x + c * y;
                }
            }
        }
    }
    ((0..n).map(|i| a[i * n + i]).collect(), v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_diagonalise() {
        let n = 7;
        let m: Vec<f64> = (0..n * n)
            .map(|i| ((i / n + 1) * (i % n + 1)) as f64 % 5.0 + ((i / n) + (i % n)) as f64)
            .collect();
        let a: Vec<f64> = (0..n * n).map(|i| m[i] + m[i % n * n + i / n]).collect();
        let (values, vectors) = eigen(a.clone(), n);
        for k in 0..n {
            for i in 0..n {
                let av: f64 = (0..n).map(|j| a[i * n + j] * vectors[j * n + k]).sum();
                assert!((av - values[k] * vectors[i * n + k]).abs() < 1e-8);
            }
        }
    }
}
