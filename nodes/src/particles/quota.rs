//! How many particles of each size a packing should have, from the sizes of cross-sections.

use super::particle::{NOTHING, ParticleSet};
use super::section::Sections;

/// Classes of particles by volume, and bins of cross-sections by area.
const CLASSES: usize = 8;
const BINS: usize = 12;

/// Which particles are still wanted.
///
/// A plane meets a particle with a probability that grows with its height, and mostly not through its middle. So the densities
/// of the classes are found by unfolding (as Jagnow, Dorsey & Rushmeier 2004 do for one shape): the slices of the particles
/// themselves tell how many cross-sections of each area a particle of each class gives; the densities that explain the
/// picture's cross-sections best follow by expectation maximisation (Richardson 1972, Lucy 1974), which keeps them positive.
/// Without such shares small particles, which fit everywhere, would fill a packing.
pub(super) struct Quota {
    /// The class of each particle.
    class: Vec<usize>,
    /// The share of each class, how many the domain should have of it, and how many have been placed.
    share: [f64; CLASSES],
    limit: [f64; CLASSES],
    placed: [u32; CLASSES],
    total: u32,
    slack: f64,
}

impl Quota {
    /// The shares of a set's particles in a domain of `voxels`; each class may exceed its share of those that have been placed by the
    /// fraction `slack`. Infinite slack: no shares and no limits.
    pub fn new(set: &ParticleSet, voxels: f64, slack: f64) -> Self {
        let class = classes(set);
        let density = densities(set, &class);
        let sum: f64 = density.iter().sum();
        let limited = slack.is_finite() && sum > 0.0;
        Self {
            class,
            share: density.map(|d| if limited { d / sum } else { 1.0 }),
            limit: density.map(|d| if limited { d * voxels } else { f64::INFINITY }),
            placed: [0; CLASSES],
            total: 0,
            slack,
        }
    }

    /// Whether a particle's class has not had its share yet.
    pub fn wants(&self, particle: u32) -> bool {
        let class = self.class[particle as usize];
        f64::from(self.placed[class]) <= self.share[class] * (1.0 + self.slack) * f64::from(self.total) + 2.0
    }

    /// Which of the particles placed are to stay: of each class no more than its limit, those whose second number is lowest.
    pub fn stays(&self, placed: &[(u32, u32)]) -> Vec<bool> {
        let mut stays = vec![true; placed.len()];
        for (class, limit) in self.limit.iter().enumerate() {
            let of_class = |&i: &usize| self.class[placed[i].0 as usize] == class;
            let mut members: Vec<usize> = (0..placed.len()).filter(of_class).collect();
            members.sort_by_key(|&i| (placed[i].1, i));
            let most = libm::ceil(limit.min(1e9)).max(1.0) as usize;
            members.iter().skip(most).for_each(|&i| stays[i] = false);
        }
        stays
    }

    /// Counts a particle that was placed.
    pub fn count(&mut self, particle: u32) {
        self.placed[self.class[particle as usize]] += 1;
        self.total += 1;
    }
}

/// The class of each particle: equal numbers in each, by volume.
fn classes(set: &ParticleSet) -> Vec<usize> {
    let mut order: Vec<usize> = (0..set.particles.len()).collect();
    order.sort_by_key(|&i| (set.particles[i].volume, i));
    let mut class = vec![0; order.len()];
    for (rank, &i) in order.iter().enumerate() {
        class[i] = rank * CLASSES / order.len();
    }
    class
}

/// Particles of each class in a voxel.
fn densities(set: &ParticleSet, class: &[usize]) -> [f64; CLASSES] {
    let least = set.views.iter().flat_map(|v| &v.sections).map(|s| s.area).min().unwrap_or(1);
    let mut areas: Vec<u32> = set.views.iter().flat_map(|v| &v.sections).map(|s| s.area).collect();
    areas.sort_unstable();
    // Borders at which equal numbers of cross-sections lie.
    let borders: Vec<u32> = (1..BINS).map(|k| areas[k * areas.len() / BINS]).collect();
    let bin = |area: u32| borders.iter().filter(|&&border| area >= border).count();
    let mut wanted = [0.0; BINS];
    for view in &set.views {
        let pixels = view.mask.len() as f64 * set.views.len() as f64;
        for section in &view.sections {
            wanted[bin(section.area)] += stands_for(view, section.size) / pixels;
        }
    }
    // Cross-sections of each area that a particle of each class gives per voxel of height, mean of the three directions.
    let mut gives = [[0.0; BINS]; CLASSES];
    let mut count = [0.0; CLASSES];
    for (particle, &class) in set.particles.iter().zip(class) {
        count[class] += 1.0;
        let [w, h, d] = particle.size.map(|n| n as usize);
        let mut slices = [vec![0u32; w], vec![0; h], vec![0; d]];
        for (i, _) in particle.source.iter().enumerate().filter(|(_, source)| **source != NOTHING) {
            slices[0][i % w] += 1;
            slices[1][i / w % h] += 1;
            slices[2][i / w / h] += 1;
        }
        for area in slices.into_iter().flatten().filter(|&area| area >= least) {
            gives[class][bin(area)] += 1.0 / 3.0;
        }
    }
    for (gives, count) in gives.iter_mut().zip(count) {
        gives.iter_mut().for_each(|g| *g /= f64::max(count, 1.0));
    }
    let mut density = [0.0; CLASSES];
    for (k, density) in density.iter_mut().enumerate() {
        *density = if count[k] > 0.0 { 1.0 } else { 0.0 };
    }
    for _ in 0..200 {
        let explained: Vec<f64> = (0..BINS)
            .map(|b| (0..CLASSES).map(|k| gives[k][b] * density[k]).sum::<f64>().max(1e-12))
            .collect();
        for (k, density) in density.iter_mut().enumerate() {
            let all: f64 = gives[k].iter().sum();
            let part: f64 = (0..BINS).map(|b| gives[k][b] * wanted[b] / explained[b]).sum();
            *density *= if all > 0.0 { part / all } else { 0.0 };
        }
    }
    density
}

/// How many cross-sections of its size one within a picture stands for, since its border cuts large ones more often (Miles 1974).
pub(super) fn stands_for(view: &Sections, size: [u32; 2]) -> f64 {
    if view.view.tileable {
        return 1.0;
    }
    let seen = |size: u32, edge: u32| (1.0 - f64::from(size) / f64::from(edge)).max(0.05);
    1.0 / (seen(size[0], view.view.width) * seen(size[1], view.view.height))
}
