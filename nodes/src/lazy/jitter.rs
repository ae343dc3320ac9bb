//! Jitter: a continuous random distortion of what synthesis starts from (Dong et al. 2008, section 5.1):
//! `J[v] = V[v + Σ A_i d_i exp(−|v − c_i|² / 2σ_i²)]`.
//!
//! The paper scatters about 200 Gaussians over its volume. Here they are scattered over the whole lattice, a few
//! in every cell of 4³ voxels by a hash, so that unbounded solids have them everywhere.

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::domain::Domain;
use super::initial::Initial;
use super::random::{hash, mix, unit};

const CENTRE: u32 = 16;
const CELL: i32 = 4;
/// Gaussians end here, in units of σ.
const REACH: f64 = 3.0;

/// The controls of the distortion, in voxels of the start level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jitter {
    /// Largest displacement by one Gaussian of the smallest σ, as a fraction of 16 voxels (the paper's volume
    /// at a start level of 16³).
    pub amount: f64,
    /// Smallest σ in voxels.
    pub sigma_min: f64,
    /// Largest σ in voxels; displacement falls with growing σ as its square root.
    pub sigma_max: f64,
    /// Gaussians in a cell of 4³ voxels.
    pub density: f64,
}

struct Gaussian {
    centre: [f64; 3],
    push: [f64; 3],
    inverse: f64,
    reach: f64,
}

impl Jitter {
    /// The Gaussian `index` of a cell. Only basic operations and `libm`, so the same on every machine.
    fn gaussian(&self, seed: u64, cell: [i32; 3], id: [i32; 3], index: u32) -> Gaussian {
        let mut state = mix(hash(seed, CENTRE, id), index);
        let mut next = || {
            state = mix(state, 0x5bd1_e995);
            unit(state)
        };
        let centre: [f64; 3] = std::array::from_fn(|i| f64::from(cell[i] * CELL) + next() * f64::from(CELL));
        let sigma = self.sigma_min + (self.sigma_max - self.sigma_min).max(0.0) * next();
        // A direction from the cube of random vectors is close enough to uniform for a random warp.
        let raw: [f64; 3] = std::array::from_fn(|_| next() - 0.5);
        let length = libm::sqrt(raw.iter().map(|c| c * c).sum::<f64>()).max(1e-6);
        let size = 16.0 * self.amount * (0.33 + 0.67 * next()) * libm::sqrt(self.sigma_min / sigma);
        Gaussian {
            centre,
            push: raw.map(|c| c / length * size),
            inverse: 1.0 / (2.0 * sigma * sigma),
            reach: REACH * sigma,
        }
    }

    /// The displacements of the voxels of a brick, in whole voxels.
    pub(super) fn displacements(&self, seed: u64, domain: &Domain, brick: [i32; 3]) -> Vec<[i32; 3]> {
        let mut sums = vec![[0.0f64; 3]; 512];
        let base = brick.map(|b| b * 8);
        let reach = libm::ceil(REACH * self.sigma_max) as i32;
        let cells = |axis: usize| {
            let first = (base[axis] - reach).div_euclid(CELL);
            first..=(base[axis] + 7 + reach).div_euclid(CELL)
        };
        let whole = libm::floor(self.density) as u32;
        for cz in cells(2) {
            for cy in cells(1) {
                for cx in cells(0) {
                    let cell = [cx, cy, cz];
                    let id = std::array::from_fn(|i| match domain.period {
                        Some(period) => cell[i].rem_euclid((period[i] + CELL - 1) / CELL),
                        None => cell[i],
                    });
                    // A fractional density is met on average.
                    let extra = unit(hash(seed, CENTRE + 1, id)) < self.density - f64::from(whole);
                    for index in 0..whole + u32::from(extra) {
                        add(&self.gaussian(seed, cell, id, index), base, &mut sums);
                    }
                }
            }
        }
        sums.into_iter().map(|sum| sum.map(|d| libm::round(d) as i32)).collect()
    }
}

/// Adds one Gaussian to the voxels of a brick that it reaches.
fn add(gaussian: &Gaussian, base: [i32; 3], sums: &mut [[f64; 3]]) {
    let range = |axis: usize| {
        let c = gaussian.centre[axis] - 0.5 - f64::from(base[axis]);
        let first = libm::ceil(c - gaussian.reach).max(0.0) as i32;
        first..=(libm::floor(c + gaussian.reach).min(7.0) as i32)
    };
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                let local = [x, y, z];
                let square: f64 = (0..3)
                    .map(|i| {
                        let d = f64::from(base[i] + local[i]) + 0.5 - gaussian.centre[i];
                        d * d
                    })
                    .sum();
                if square <= gaussian.reach * gaussian.reach {
                    let weight = libm::exp(-square * gaussian.inverse);
                    let sum = &mut sums[(x + 8 * y + 64 * z) as usize];
                    (0..3).for_each(|i| sum[i] += gaussian.push[i] * weight);
                }
            }
        }
    }
}

pub(super) struct JitterNode;

impl Node for JitterNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "lazy.jitter",
            1,
            "Distorts what synthesis starts from, for variety",
            "A sum of random Gaussian displacements, strongest at the smallest scale: synthesis repairs the small \
             distortions, which brings variety, and keeps the large ones, which break up repetition. Its random numbers \
             come from the seed of the synthesis.",
        )
        .paper("Dong et al. 2008, section 5.1, Jitter")
        .memory_only()
        .input("initial", "initial", "What synthesis starts from.")
        .output("initial", "initial", "The same, distorted.")
        .float("amount", 0.0..=1.0, 0.1, "× 16 voxels", "Largest displacement by one Gaussian (the paper: 0.1 to 0.3).")
        .float("sigma_min", 0.1..=8.0, 0.3, "start-level voxels", "Smallest width of a Gaussian.")
        .float("sigma_max", 0.1..=8.0, 1.2, "start-level voxels", "Largest width of a Gaussian.")
        .float("density", 0.0..=16.0, 3.0, "per 4³ voxels", "Gaussians in a cell of 4³ start-level voxels (the paper: about 3).")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let mut initial = (*context.input::<Initial>("initial")?).clone();
        let sigma_min = context.float("sigma_min")?;
        initial.jitter = Some(Jitter {
            amount: context.float("amount")?,
            sigma_min,
            sigma_max: context.float("sigma_max")?.max(sigma_min),
            density: context.float("density")?,
        });
        context.set("initial", initial);
        Ok(())
    }
}
