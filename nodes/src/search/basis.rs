//! Principal components of neighbourhoods (Chen & Wang 2010, section 4.3: "reducing the full dimensionality from
//! 192 to about 20 dimensions with … PCA"), quantised so that projecting is integer arithmetic, the same on every
//! machine.

use breccia_engine::{Data, Digest};
use rayon::prelude::*;

use super::window::Window;
use crate::control::{Cancelled, Control, check};
use crate::data::{Reader, Writer};
use crate::lazy::{LevelView, Pyramid, eigen};

/// Components come in blocks of this many; what is left over is zero.
pub const BLOCK: usize = 8;
/// The most components.
pub const MOST: usize = 64;
/// Coefficients are this many times the projection on a unit vector, in grey levels.
pub const SCALE: i32 = 4;
/// Weights are this many binary digits finer than coefficients.
const SHIFT: u32 = 10;

/// How many components are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keep {
    /// At most this many, 1 to 64.
    pub dims: usize,
    /// No more than are needed for this share of the variance, 0 to 1.
    pub variance: f64,
}

/// Why there is no basis.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BasisError {
    /// The window is larger than a view at that level.
    #[error(
        "a neighbourhood of {size} × {size} pixels is larger than the exemplar at level {level}, {width} × {height} pixels; \
         expected a smaller neighbourhood, fewer levels, or a larger exemplar"
    )]
    Window {
        /// Pixels along the window's edge.
        size: i32,
        /// The level, 0 the finest.
        level: usize,
        /// Pixels in a row at that level.
        width: i32,
        /// Rows at that level.
        height: i32,
    },
    /// There is no such level.
    #[error("found level {level}, expected one of the pyramid's {levels} levels, 0 to {}", levels - 1)]
    Level {
        /// The level asked for.
        level: usize,
        /// The levels there are.
        levels: usize,
    },
    /// The computation was cancelled.
    #[error("cancelled")]
    Cancelled,
}

impl From<Cancelled> for BasisError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// A quantised PCA basis for each view of a level: coefficient `d` of a window is
/// `(bias[d] + Σ weight[i][d] · sample[i]) >> 10`.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchBasis {
    /// The pyramid's level, 0 the finest.
    pub level: usize,
    /// The neighbourhood.
    pub window: Window,
    /// Components, a multiple of 8; those beyond what is kept are zero.
    pub dims: usize,
    /// For each view the weights, `[pair of samples][component][sample of the pair]`.
    pub weights: Vec<Vec<i16>>,
    /// For each view and component what is added.
    pub bias: Vec<Vec<i32>>,
    /// For each view the components that are kept.
    pub kept: Vec<usize>,
    /// For each view the share of the variance that they explain.
    pub explained: Vec<f64>,
}

/// The bases of the views of one level.
///
/// # Errors
/// If there is no such level, or the window does not fit into one of its views.
pub fn patch_basis(
    pyramid: &Pyramid,
    level: usize,
    window: Window,
    keep: Keep,
    control: &dyn Control,
) -> Result<PatchBasis, BasisError> {
    let levels = pyramid.levels.len();
    let views = pyramid.levels.get(level).ok_or(BasisError::Level { level, levels })?;
    if let Some(view) = views.iter().find(|view| !window.fits(view)) {
        let (width, height) = (view.width, view.height);
        return Err(BasisError::Window { size: window.size, level, width, height });
    }
    let found =
        views.iter().map(|view| components(view, window, keep, control)).collect::<Result<Vec<_>, _>>()?;
    let dims = found.iter().map(|c| c.vectors.len()).max().unwrap_or(1).max(1).next_multiple_of(BLOCK);
    let mut basis = PatchBasis {
        level,
        window,
        dims,
        weights: Vec::new(),
        bias: Vec::new(),
        kept: found.iter().map(|c| c.vectors.len()).collect(),
        explained: found.iter().map(|c| c.explained).collect(),
    };
    let unit = f64::from(SCALE << SHIFT);
    for components in found {
        let samples = window.pixels() * 4;
        let mut weights = vec![0i16; samples * dims];
        let mut bias = vec![0i32; dims];
        for (d, vector) in components.vectors.iter().enumerate() {
            let mut centre = 0.0;
            for (i, component) in vector.iter().enumerate() {
                let weight = libm::round(component * unit);
                weights[i / 2 * 2 * dims + d * 2 + i % 2] = weight as i16;
                centre += weight * components.mean[i];
            }
            bias[d] = (1 << SHIFT >> 1) - libm::round(centre) as i32;
        }
        basis.weights.push(weights);
        basis.bias.push(bias);
    }
    Ok(basis)
}

struct Components {
    mean: Vec<f64>,
    vectors: Vec<Vec<f64>>,
    explained: f64,
}

fn components(
    view: &LevelView,
    window: Window,
    keep: Keep,
    control: &dyn Control,
) -> Result<Components, Cancelled> {
    let n = window.pixels() * 4;
    let centres = window.pixels_of(view);
    let count = centres.len() as i64;
    let mut all = Vec::with_capacity(centres.len() * n);
    let mut one = Vec::new();
    for &centre in &centres {
        window.samples(view, centre, &mut one);
        all.extend_from_slice(&one);
    }
    check(control)?;
    let mut sums = vec![0i64; n];
    for samples in all.chunks_exact(n) {
        sums.iter_mut().zip(samples).for_each(|(sum, &s)| *sum += i64::from(s));
    }
    // Integer sums are exact, so the covariance is the same in any order.
    let rows: Vec<Vec<f64>> = (0..n)
        .into_par_iter()
        .map(|i| {
            check(control)?;
            let mut products = vec![0i64; n];
            // 32 bits hold the products of 32,768 windows.
            for part in all.chunks(n * 32_768) {
                let mut row = vec![0u32; n];
                for samples in part.chunks_exact(n) {
                    let s = samples[i] as u32;
                    row.iter_mut().zip(samples).for_each(|(sum, &t)| *sum += s * t as u32);
                }
                products.iter_mut().zip(row).for_each(|(sum, part)| *sum += i64::from(part));
            }
            let products = products.iter().zip(&sums);
            Ok(products.map(|(p, s)| (p * count - sums[i] * s) as f64 / (count * count) as f64).collect())
        })
        .collect::<Result<_, Cancelled>>()?;
    let (values, vectors) = principal(&rows.concat(), n, keep.dims.clamp(1, MOST), control)?;
    let total: f64 = (0..n).map(|i| rows[i][i]).sum();
    let mut kept = 0;
    let mut explained = 0.0;
    while kept < values.len() && values[kept] > 1e-9 && explained < keep.variance * total {
        explained += values[kept];
        kept += 1;
    }
    let share = if total > 0.0 { (explained / total).min(1.0) } else { 1.0 };
    let mean = sums.iter().map(|&s| s as f64 / count as f64).collect();
    Ok(Components { mean, vectors: vectors.into_iter().take(kept).collect(), explained: share })
}

/// The `dims` largest eigenvalues of a symmetric matrix, largest first, and their eigenvectors, by subspace iteration
/// with a Rayleigh-Ritz step (Golub & Van Loan, section 8.2): only additions, multiplications, divisions and square roots in a
/// fixed order. A few more vectors than asked for make the last of them converge.
fn principal(
    a: &[f64],
    n: usize,
    dims: usize,
    control: &dyn Control,
) -> Result<(Vec<f64>, Vec<Vec<f64>>), Cancelled> {
    let m = (dims + 8).min(n);
    // Any start will do that is not orthogonal to what is sought; cosines of the window come close.
    let mut basis: Vec<Vec<f64>> = (0..m)
        .map(|k| {
            (0..n).map(|i| (((i * (2 * k + 3) + k * k) * 7919 % 10_007) as f64) / 10_007.0 - 0.5).collect()
        })
        .collect();
    orthonormalise(&mut basis);
    let mut values = vec![0.0; m];
    for round in 0..60 {
        check(control)?;
        let image: Vec<Vec<f64>> =
            basis.par_iter().map(|vector| a.chunks_exact(n).map(|row| dot(row, vector)).collect()).collect();
        let mut small = vec![0.0; m * m];
        for i in 0..m {
            for j in 0..=i {
                let value = dot(&basis[i], &image[j]);
                (small[i * m + j], small[j * m + i]) = (value, value);
            }
        }
        let (found, rotation) = eigen(small, m);
        let mut order: Vec<usize> = (0..m).collect();
        order.sort_by(|&p, &q| found[q].total_cmp(&found[p]).then(p.cmp(&q)));
        let before = std::mem::replace(&mut values, order.iter().map(|&k| found[k].max(0.0)).collect());
        let turn = |vectors: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let column = |&k: &usize| {
                let mut sum = vec![0.0; n];
                for (j, vector) in vectors.iter().enumerate() {
                    let c = rotation[j * m + k];
                    sum.iter_mut().zip(vector).for_each(|(s, v)| *s += c * v);
                }
                sum
            };
            order.iter().map(column).collect()
        };
        let settled =
            values.iter().zip(&before).take(dims).all(|(new, old)| (new - old).abs() <= 1e-7 * values[0]);
        if settled && round > 3 {
            basis = turn(&basis);
            break;
        }
        basis = turn(&image);
        orthonormalise(&mut basis);
    }
    values.truncate(dims);
    basis.truncate(dims);
    Ok((values, basis))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four sums side by side: the order is fixed, and the processor need not wait for each addition.
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a4.zip(b4) {
        for i in 0..4 {
            sums[i] += x[i] * y[i];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Gram-Schmidt, each vector twice; what vanishes stays zero.
fn orthonormalise(vectors: &mut [Vec<f64>]) {
    for k in 0..vectors.len() {
        let (done, rest) = vectors.split_at_mut(k);
        let vector = &mut rest[0];
        let length = dot(vector, vector).sqrt();
        for _ in 0..2 {
            for other in done.iter() {
                let along = dot(vector, other);
                vector.iter_mut().zip(other).for_each(|(v, o)| *v -= along * o);
            }
        }
        let left = dot(vector, vector).sqrt();
        let scale = if left > 1e-10 * length && left > 0.0 { 1.0 / left } else { 0.0 };
        vector.iter_mut().for_each(|v| *v *= scale);
    }
}

impl Data for PatchBasis {
    const TYPE: &'static str = "patch_basis";
    const DOCS: &'static str = "Principal components of an exemplar's neighbourhoods at one level.";

    fn byte_size(&self) -> u64 {
        self.weights.iter().map(|w| w.len() as u64 * 2).sum()
    }

    fn summary(&self) -> String {
        let size = self.window.size;
        let kept: Vec<_> = self
            .kept
            .iter()
            .zip(&self.explained)
            .map(|(k, e)| format!("{k} components, {:.1} %", e * 100.0))
            .collect();
        format!("level {}, {size} × {size}: {} of the variance", self.level, kept.join("; "))
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.u64(self.level as u64)
            .u64(self.window.size as u64)
            .u64(self.dims as u64)
            .u64(self.weights.len() as u64);
        for view in 0..self.weights.len() {
            out.array(&self.weights[view]).array(&self.bias[view]).u64(self.kept[view] as u64);
            out.array(&[self.explained[view]]);
        }
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let (level, size, dims, views) = (reader.u64()?, reader.u64()?, reader.u64()?, reader.u64()?);
        let window = Window { size: size.min(64) as i32 };
        let dims = dims.min(MOST as u64) as usize;
        let (weights, bias, kept, explained) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut basis = Self { level: level as usize, window, dims, weights, bias, kept, explained };
        for _ in 0..views {
            basis.weights.push(reader.array()?);
            basis.bias.push(reader.array()?);
            basis.kept.push(reader.u64()? as usize);
            basis.explained.extend(reader.array::<f64>()?.first());
            let lengths = (basis.weights.last().map(Vec::len), basis.bias.last().map(Vec::len));
            if lengths != (Some(window.pixels() * 4 * dims), Some(dims)) {
                return Err("weights do not fit the window".to_owned());
            }
        }
        reader.end()?;
        if !dims.is_multiple_of(BLOCK) || dims == 0 || basis.explained.len() != basis.kept.len() {
            return Err("no whole blocks of components".to_owned());
        }
        Ok(basis)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(side: i32, texel: impl Fn(i32, i32) -> [u8; 4]) -> Pyramid {
        let texels = (0..side * side).map(|i| texel(i % side, i / side)).collect();
        Pyramid {
            levels: vec![vec![LevelView {
                width: side,
                height: side,
                tileable: true,
                texels,
                barred: Vec::new(),
            }]],
        }
    }

    fn noise(x: i32, y: i32) -> [u8; 4] {
        let h = (x.wrapping_mul(374_761_393) ^ y.wrapping_mul(668_265_263)).wrapping_mul(1_274_126_177);
        [(h >> 8) as u8, (h >> 16) as u8, (h >> 12) as u8, 0]
    }

    const ALL: Keep = Keep { dims: 64, variance: 1.0 };

    #[test]
    fn distances_survive_when_all_components_are_kept() {
        // A 3 × 3 window of three channels has 27 dimensions.
        let pyramid = view(24, noise);
        let window = Window { size: 3 };
        let basis = patch_basis(&pyramid, 0, window, ALL, &()).unwrap();
        assert_eq!((basis.dims, basis.kept[0]), (32, 27));
        let level = &pyramid.levels[0][0];
        let table = super::super::patches(&pyramid, &basis, &()).unwrap();
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for (p, q) in [(0x0305, 0x0a02), (0x1111, 0x0007), (0x0000, 0x1717)] {
            window.samples(level, p, &mut a);
            window.samples(level, q, &mut b);
            let exact: i64 = a.iter().zip(&b).map(|(x, y)| i64::from(x - y).pow(2)).sum();
            let view = &table.views[0];
            let (u, v) = (view.coefficients(level.index(p)), view.coefficients(level.index(q)));
            let found: i64 = u.iter().zip(v).map(|(x, y)| i64::from(x - y).pow(2)).sum();
            let ratio = found as f64 / (exact * 16) as f64;
            assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
        }
    }

    #[test]
    fn a_rank_deficient_exemplar_keeps_what_there_is() {
        let stripes = view(16, |x, _| if x % 4 < 2 { [200, 100, 50, 0] } else { [20, 30, 40, 0] });
        let basis = patch_basis(&stripes, 0, Window { size: 5 }, ALL, &()).unwrap();
        // A pattern of period 4 that changes along x only has four different windows, so three components at most.
        assert!(basis.kept[0] <= 3 && basis.kept[0] >= 2, "{:?}", basis.kept);
        let constant = view(16, |_, _| [9, 9, 9, 0]);
        assert_eq!(patch_basis(&constant, 0, Window { size: 4 }, ALL, &()).unwrap().kept, [0]);
    }

    #[test]
    fn variance_decides_how_many_are_kept() {
        let pyramid = view(32, |x, y| {
            let n = noise(x, y)[0] / 8;
            [((x * 6) as u8).wrapping_add(n), (y * 6) as u8, n, 0]
        });
        let few =
            patch_basis(&pyramid, 0, Window { size: 4 }, Keep { dims: 64, variance: 0.8 }, &()).unwrap();
        let many =
            patch_basis(&pyramid, 0, Window { size: 4 }, Keep { dims: 64, variance: 0.99 }, &()).unwrap();
        assert!(few.kept[0] < many.kept[0], "{:?} {:?}", few.kept, many.kept);
        assert!(few.explained[0] >= 0.8 && many.explained[0] >= 0.99);
    }

    #[test]
    fn a_window_too_large_is_named() {
        let error = patch_basis(&view(16, noise), 0, Window { size: 17 }, ALL, &()).unwrap_err().to_string();
        assert!(error.contains("17 × 17") && error.contains("16 × 16"), "{error}");
        let error = patch_basis(&view(16, noise), 2, Window { size: 3 }, ALL, &()).unwrap_err().to_string();
        assert!(error.contains("level 2") && error.contains("1 levels"), "{error}");
    }

    #[test]
    fn encoding_reads_back() {
        let basis = patch_basis(&view(16, noise), 0, Window { size: 4 }, ALL, &()).unwrap();
        let bytes = basis.encode().unwrap();
        assert_eq!(PatchBasis::decode(&bytes).unwrap(), basis);
        assert!(PatchBasis::decode(&bytes[..bytes.len() - 3]).is_err());
    }
}
