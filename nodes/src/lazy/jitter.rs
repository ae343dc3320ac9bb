//! Jitter: a continuous random distortion of what synthesis starts from (Dong et al. 2008, section 5.1):
//! `J[v] = V[v + Σ A_i d_i exp(−|v − c_i|² / 2σ_i²)]`.
//!
//! The paper scatters about 200 Gaussians over its volume. Here they are scattered over the whole lattice, a few
//! in every cell of 4³ voxels by a hash, so that unbounded solids have them everywhere.

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::domain::Domain;
use super::initial::Initial;
use super::random::{hash, mix, unit};
use crate::data::BRICK_VOXELS;

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

/// One Gaussian in fixed point, as a brick sees it: what reaches a voxel is summed up in whole numbers, so that every
/// device finds the same displacement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Gaussian {
    /// From the brick's first voxel, in 256ths of a voxel.
    pub centre: [i32; 3],
    /// The largest squared distance that it reaches, in the same units.
    pub reach: i32,
    /// In 1024ths of a voxel, at the centre.
    pub push: [i32; 3],
    /// Leads from a squared distance `d` to a place in [`falling`]: `(d >> shift) * factor >> 16`, the shift in the lowest eight
    /// bits, the factor above them.
    pub shape: u32,
}

/// Places of [`falling`] to one in the exponent.
const FINE: f64 = 256.0;

/// e^−x in 65,536ths, for x from 0 to where Gaussians end.
pub(super) fn falling() -> Vec<u32> {
    let last = (REACH * REACH / 2.0 * FINE) as i32;
    (0..=last).map(|i| libm::round(libm::exp(-(f64::from(i) + 0.5) / FINE) * 65536.0) as u32).collect()
}

impl Gaussian {
    /// The push on the voxel at a position in the brick, in 2^-18 voxels.
    #[inline(always)]
    fn at(&self, local: [i32; 3], falling: &[u32]) -> Option<[i32; 3]> {
        let d: [i32; 3] = std::array::from_fn(|i| local[i] * 256 + 128 - self.centre[i]);
        let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        if square > self.reach {
            return None;
        }
        let place = (((square as u32) >> (self.shape & 255)) * (self.shape >> 8)) >> 16;
        let weight = falling[(place as usize).min(falling.len() - 1)] as i32;
        Some(self.push.map(|push| (push * weight) >> 8))
    }
}

impl Jitter {
    /// The Gaussian `index` of a cell that begins at `first`, from the brick's first voxel. Only basic operations and `libm`, so
    /// the same on every machine.
    fn gaussian(&self, seed: u64, first: [i32; 3], id: [i32; 3], index: u32) -> Gaussian {
        let mut state = mix(hash(seed, CENTRE, id), index);
        let mut next = || {
            state = mix(state, 0x5bd1_e995);
            unit(state)
        };
        let centre = first.map(|c| c * 256 + (next() * f64::from(CELL * 256)) as i32);
        let sigma = self.sigma_min + (self.sigma_max - self.sigma_min).max(0.0) * next();
        // A direction from the cube of random vectors is close enough to uniform for a random warp.
        let raw: [f64; 3] = std::array::from_fn(|_| next() - 0.5);
        let length = libm::sqrt(raw.iter().map(|c| c * c).sum::<f64>()).max(1e-6);
        let size = 16.0 * self.amount * (0.33 + 0.67 * next()) * libm::sqrt(self.sigma_min / sigma);
        let reach = (REACH * REACH * sigma * sigma * 65536.0) as u32;
        // So that the products of `Gaussian::at` stay within 32 bits.
        let shift = (32 - reach.leading_zeros()).saturating_sub(16);
        let factor = libm::round(FINE / 2.0 * f64::from(1u32 << shift) / (sigma * sigma)) as u32;
        Gaussian {
            centre,
            reach: reach as i32,
            push: raw.map(|c| libm::round(c / length * size * 1024.0) as i32),
            shape: shift | factor << 8,
        }
    }

    /// The Gaussians that reach into a brick.
    pub(super) fn gaussians(&self, seed: u64, domain: &Domain, brick: [i32; 3]) -> Vec<Gaussian> {
        let base = brick.map(|b| b.wrapping_mul(8));
        let reach = libm::ceil(REACH * self.sigma_max) as i32;
        let cells = |axis: usize| {
            let first = base[axis].saturating_sub(reach).div_euclid(CELL);
            first..=base[axis].saturating_add(7 + reach).div_euclid(CELL)
        };
        let whole = libm::floor(self.density) as u32;
        let mut found = Vec::new();
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
                    let first = std::array::from_fn(|i| cell[i].wrapping_mul(CELL).wrapping_sub(base[i]));
                    let all = (0..whole + u32::from(extra)).map(|i| self.gaussian(seed, first, id, i));
                    found.extend(all.filter(Gaussian::touches));
                }
            }
        }
        found
    }

    /// The displacements of the voxels of a brick, in whole voxels.
    pub(super) fn displacements(&self, seed: u64, domain: &Domain, brick: [i32; 3]) -> Vec<[i32; 3]> {
        let falling = falling();
        let mut sums = vec![[0i32; 3]; BRICK_VOXELS];
        for gaussian in self.gaussians(seed, domain, brick) {
            let [xs, ys, zs] = gaussian.voxels();
            for z in zs {
                for y in ys.clone() {
                    for x in xs.clone() {
                        let Some(push) = gaussian.at([x, y, z], &falling) else { continue };
                        let sum = &mut sums[(x + 8 * y + 64 * z) as usize];
                        (0..3).for_each(|i| sum[i] = sum[i].wrapping_add(push[i]));
                    }
                }
            }
        }
        sums.into_iter().map(|sum| sum.map(|d| d.wrapping_add(1 << 17) >> 18)).collect()
    }
}

impl Gaussian {
    /// Ranges of a brick's voxels beyond which it does not reach.
    fn voxels(&self) -> [std::ops::RangeInclusive<i32>; 3] {
        let radius = libm::sqrt(f64::from(self.reach)) as i32 + 1;
        self.centre.map(|c| {
            let first = (c - 128 - radius).div_euclid(256);
            first.max(0)..=((c - 128 + radius).div_euclid(256) + 1).min(7)
        })
    }

    fn touches(&self) -> bool {
        self.voxels().iter().all(|range| !range.is_empty())
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
