//! What patches find in an exemplar: how far, and where.

use rayon::prelude::*;

use super::patches::{NUMBERS, Patch, PatchSet};
use super::random::Random;
use super::views::Pixels;
use crate::control::{Cancelled, Control, check};

/// The most patches kept of half an exemplar; larger exemplars are sampled on a coarser grid.
const MOST_PATCHES: usize = 16_384;

/// The patches of opposite quadrants: top left with bottom right, and the other two. No patch crosses.
pub(super) fn halves(truth: &Pixels) -> [PatchSet; 2] {
    let (w, h) = (truth.width, truth.height);
    let (x, y) = (w / 2, h / 2);
    let mut stride = 1;
    while (w / stride) * (h / stride) / 2 > MOST_PATCHES {
        stride += 1;
    }
    let cell = stride.max(2);
    [
        PatchSet::new(truth, &[[0, 0, x, y], [x, y, w - x, h - y]], stride, cell),
        PatchSet::new(truth, &[[x, 0, w - x, y], [0, y, x, h - y]], stride, cell),
    ]
}

/// What patches found in sets of patches.
#[derive(Clone, Default)]
pub(super) struct Matches {
    /// Sum of squared distances.
    squares: i64,
    /// How many distances.
    pub count: usize,
    /// Cells hit, once for each hit: the set in the upper half, the cell in the lower.
    cells: Vec<u64>,
}

impl Matches {
    /// Each of `patches` in the nearest of `sets`, each with the number that it is known by.
    pub fn within(
        sets: &[(usize, &PatchSet)],
        patches: &[Patch],
        control: &dyn Control,
    ) -> Result<Self, Cancelled> {
        let nearest = |patch: &Patch| {
            let found = sets.iter().map(|&(number, set)| {
                let (square, cell) = set.nearest(patch);
                (square, (number as u64) << 32 | u64::from(cell))
            });
            found.min().unwrap_or((0, 0))
        };
        let found = patches
            .par_chunks(16)
            .map(|patches| {
                check(control)?;
                Ok(patches.iter().map(nearest).collect::<Vec<_>>())
            })
            .collect::<Result<Vec<_>, Cancelled>>()?
            .concat();
        let squares = found.iter().map(|&(square, _)| i64::from(square)).sum();
        Ok(Self { squares, count: found.len(), cells: found.into_iter().map(|(_, cell)| cell).collect() })
    }

    /// Takes the matches of another in.
    pub fn add(&mut self, other: &Self) {
        self.squares += other.squares;
        self.count += other.count;
        self.cells.extend(&other.cells);
    }

    /// The root mean square difference of a patch's number, in grey levels.
    pub fn rms(&self) -> f64 {
        (self.squares as f64 / (self.count.max(1) * NUMBERS) as f64).sqrt()
    }

    /// The share of hits of each cell that was hit, in the order of cells.
    fn shares(&self) -> Vec<f64> {
        let mut cells = self.cells.clone();
        cells.sort_unstable();
        cells.chunk_by(|a, b| a == b).map(|hits| hits.len() as f64 / self.count.max(1) as f64).collect()
    }

    /// How many different cells that many hits reach on average.
    pub fn variety(&self, draws: usize) -> f64 {
        self.shares().into_iter().map(|p| 1.0 - libm::pow(1.0 - p, draws as f64)).sum()
    }

    /// The entropy of the cells hit, in nats.
    pub fn entropy(&self) -> f64 {
        self.shares().into_iter().map(|p| -p * libm::log(p)).sum()
    }
}

/// Patches of a set, drawn with replacement.
pub(super) fn draw(set: &PatchSet, count: usize, key: [u64; 2], random: Random) -> Vec<Patch> {
    (0..count).map(|i| *set.get(random.below(set.len(), [key[0], key[1], i as u64]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variety_and_entropy_count_the_places_that_are_hit() {
        let hits = |cells: &[u64]| Matches { squares: 0, count: cells.len(), cells: cells.to_vec() };
        let even = hits(&(0..100).map(|i| i % 8).collect::<Vec<_>>());
        assert!((libm::exp(even.entropy()) - 8.0).abs() < 0.1 && even.variety(1000) > 7.99);
        let one = hits(&[5; 100]);
        assert!(one.entropy() == 0.0 && one.variety(1000) == 1.0);
        let skewed = hits(&[[1; 50].as_slice(), &[2; 25], &[3; 25]].concat());
        assert!((skewed.entropy() - 1.5 * std::f64::consts::LN_2).abs() < 1e-12);
    }
}
