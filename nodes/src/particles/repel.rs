//! Repulsion: particles move away from where others crowd (Du et al. 2013, section 3.4).
//!
//! The force on a particle is a sum over its samples r and the samples s of all others. The field E(r) of *all* samples is one convolution of
//! their density with −v / d over the window; what a particle's own samples add to the sum of E over them cancels, since the force of
//! r on s is the opposite of that of s on r. So one convolution serves all particles.

use rayon::prelude::*;

use super::fft::{Complex, times, transform};
use super::packing::{Packing, Placed};
use crate::control::{Cancelled, Control, check};

/// How particles repel each other.
#[derive(Clone, Copy, Debug)]
pub struct RepelSettings {
    /// Iterations (the paper: at most 20).
    pub iterations: usize,
    /// How far a particle moves at most in the first iteration, in voxels.
    pub step: f64,
    /// The limit of each iteration as a fraction of the one before.
    pub decay: f64,
}

impl Default for RepelSettings {
    fn default() -> Self {
        Self { iterations: 20, step: 1.5, decay: 0.85 }
    }
}

/// Samples along the longest edge of the domain.
const GRID: usize = 64;
/// Samples from the middle of the window to its border: 17 in all.
const REACH: i32 = 8;

/// The packing with its particles moved. In a domain that ends, centres stay within.
///
/// # Errors
/// [`Cancelled`].
pub fn repel(
    packing: &Packing,
    settings: &RepelSettings,
    control: &dyn Control,
) -> Result<Packing, Cancelled> {
    let grid = Grid::new(packing);
    let kernel = grid.kernel();
    let mut places: Vec<[f64; 3]> = packing.placed.iter().map(|p| p.center.map(f64::from)).collect();
    let mut limit = settings.step;
    for iteration in 0..settings.iterations {
        check(control)?;
        control.progress(iteration as f32 / settings.iterations as f32);
        let rounded: Vec<[i32; 3]> = places.iter().map(|p| p.map(|c| libm::round(c) as i32)).collect();
        let samples: Vec<Vec<u32>> = packing
            .placed
            .par_iter()
            .zip(&rounded)
            .map(|(placed, &center)| grid.samples(packing, placed, center))
            .collect();
        let field = grid.field(&samples, &kernel);
        check(control)?;
        let forces: Vec<[f64; 3]> = samples
            .par_iter()
            .map(|samples| {
                let mut force = [0.0; 3];
                for &sample in samples {
                    (0..3).for_each(|a| force[a] += field[sample as usize][a]);
                }
                force.map(|f| f / samples.len().max(1) as f64)
            })
            .collect();
        let length = |f: &[f64; 3]| libm::sqrt(f.iter().map(|c| c * c).sum());
        let mean = forces.iter().map(length).sum::<f64>() / forces.len().max(1) as f64;
        for (place, force) in places.iter_mut().zip(&forces) {
            let strength = length(force);
            if strength > 0.0 {
                let step = limit * (strength / mean.max(1e-12)).min(1.0);
                for a in 0..3 {
                    let (moved, n) = (place[a] + force[a] / strength * step, f64::from(packing.size[a]));
                    place[a] = if packing.wrap {
                        moved - n * libm::floor(moved / n)
                    } else {
                        moved.clamp(0.0, n - 1.0)
                    };
                }
            }
        }
        limit *= settings.decay;
    }
    let placed = packing.placed.iter().zip(&places).map(|(placed, place)| {
        let center = std::array::from_fn(|a| {
            let c = libm::round(place[a]) as i32;
            if packing.wrap { c.rem_euclid(packing.size[a] as i32) } else { c }
        });
        Placed { center, ..placed.clone() }
    });
    Ok(Packing { placed: placed.collect(), set: packing.set.clone(), size: packing.size, wrap: packing.wrap })
}

/// The samples of a domain.
struct Grid {
    /// Samples along each axis, with room around a domain that ends; powers of two.
    size: [usize; 3],
    /// Samples within the domain.
    inner: [usize; 3],
    /// Voxels between samples.
    spacing: [f64; 3],
}

impl Grid {
    fn new(packing: &Packing) -> Self {
        let longest = packing.size.iter().copied().max().unwrap_or(1);
        let mut grid = Self { size: [0; 3], inner: [0; 3], spacing: [0.0; 3] };
        for a in 0..3 {
            let wanted = (GRID as f64 * f64::from(packing.size[a]) / f64::from(longest)).max(2.0);
            grid.size[a] = (wanted as usize).next_power_of_two();
            if packing.wrap {
                grid.inner[a] = grid.size[a];
            } else {
                // The window must not reach around the ends.
                grid.size[a] = grid.size[a].max(2 * REACH as usize);
                grid.inner[a] = grid.size[a] - REACH as usize;
            }
            grid.spacing[a] = f64::from(packing.size[a]) / grid.inner[a] as f64;
        }
        grid
    }

    fn index(&self, place: [usize; 3]) -> usize {
        (place[2] * self.size[1] + place[1]) * self.size[0] + place[0]
    }

    /// The samples within a placed particle.
    fn samples(&self, packing: &Packing, placed: &Placed, center: [i32; 3]) -> Vec<u32> {
        let (low, size) = packing.bounds(placed);
        let span = |a: usize| {
            let first = f64::from(center[a] + low[a]) / self.spacing[a];
            let last = (f64::from(center[a] + low[a]) + f64::from(size[a])) / self.spacing[a];
            (libm::floor(first) as i64, libm::ceil(last) as i64)
        };
        let [xs, ys, zs] = [span(0), span(1), span(2)];
        let mut found = Vec::new();
        for z in zs.0..=zs.1 {
            for y in ys.0..=ys.1 {
                for x in xs.0..=xs.1 {
                    let sample = [x, y, z];
                    let voxel: [i32; 3] = std::array::from_fn(|a| {
                        libm::floor((sample[a] as f64 + 0.5) * self.spacing[a]) as i32 - center[a]
                    });
                    let inside = |a: usize| packing.wrap || (0..self.inner[a] as i64).contains(&sample[a]);
                    if packing.holds(placed, voxel) && (0..3).all(inside) {
                        let wrapped =
                            std::array::from_fn(|a| sample[a].rem_euclid(self.inner[a] as i64) as usize);
                        found.push(self.index(wrapped) as u32);
                    }
                }
            }
        }
        found
    }

    /// The transforms of the window's forces: along x and y as the parts of one, along z.
    fn kernel(&self) -> [Vec<Complex>; 2] {
        let count = self.size.iter().product();
        let mut kernels = [vec![[0.0; 2]; count], vec![[0.0; 2]; count]];
        for z in -REACH..=REACH {
            for y in -REACH..=REACH {
                for x in -REACH..=REACH {
                    let offset = [x, y, z];
                    // On a short axis the window would reach around and meet itself.
                    if (0..3).any(|a| 2 * offset[a].unsigned_abs() as usize >= self.size[a])
                        || offset == [0; 3]
                    {
                        continue;
                    }
                    let d: [f64; 3] = std::array::from_fn(|a| f64::from(offset[a]) * self.spacing[a]);
                    let squared: f64 = d.iter().map(|c| c * c).sum();
                    let place = std::array::from_fn(|a| offset[a].rem_euclid(self.size[a] as i32) as usize);
                    // At r = s + offset the force points from s to r: −v / d with v from r to s.
                    let i = self.index(place);
                    kernels[0][i] = [d[0] / squared, d[1] / squared];
                    kernels[1][i] = [d[2] / squared, 0.0];
                }
            }
        }
        kernels.iter_mut().for_each(|kernel| transform(kernel, self.size, false));
        kernels
    }

    /// The force at every sample.
    fn field(&self, samples: &[Vec<u32>], kernel: &[Vec<Complex>; 2]) -> Vec<[f64; 3]> {
        let count: usize = self.size.iter().product();
        let mut density = vec![[0.0; 2]; count];
        samples.iter().flatten().for_each(|&i| density[i as usize][0] += 1.0);
        transform(&mut density, self.size, false);
        let [xy, z] = [0, 1].map(|k: usize| {
            let mut product: Vec<Complex> =
                density.iter().zip(&kernel[k]).map(|(&a, &b)| times(a, b)).collect();
            transform(&mut product, self.size, true);
            product
        });
        let scale = 1.0 / count as f64;
        xy.iter().zip(&z).map(|(xy, z)| [xy[0] * scale, xy[1] * scale, z[0] * scale]).collect()
    }
}
