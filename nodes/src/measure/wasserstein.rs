//! The sliced Wasserstein distance of patches over a Laplacian pyramid (Rabin et al. 2011; Karras et al. 2018).

use rayon::prelude::*;

use super::laplacian::{Level, laplacian};
use super::patches::EDGE;
use super::random::Random;
use super::views::Pixels;
use areas::Areas;

/// Random directions.
const DIRECTIONS: usize = 64;
/// Numbers of a patch.
const NUMBERS: usize = EDGE * EDGE * 3;
/// The shortest edge of the coarsest level.
const COARSEST: usize = 8;
/// The most levels.
const MOST: usize = 5;

/// A patch's numbers over their spread in the exemplar.
pub(super) type Vector = [f32; NUMBERS];

/// How many levels pictures have whose shortest edge is this.
pub(super) fn levels(shortest: usize) -> usize {
    (1..MOST).take_while(|level| shortest >> level >= COARSEST).count() + 1
}

/// The Laplacian pyramids of pictures.
pub(super) fn pyramids(pictures: &[Pixels], levels: usize) -> Vec<Vec<Level>> {
    pictures.par_iter().map(|picture| laplacian(picture, levels)).collect()
}

/// Parts of levels to take patches from.
pub(super) mod areas {
    use super::Level;
    use crate::measure::views::PAIRS;

    /// Levels, each with an area: x, y, width and height.
    pub type Areas<'a> = Vec<(&'a Level, [usize; 4])>;

    /// The whole of one level of pyramids.
    pub fn whole(pyramids: &[Vec<Level>], level: usize) -> Areas<'_> {
        let levels = pyramids.iter().filter_map(|pyramid| pyramid.get(level));
        levels.map(|level| (level, [0, 0, level.width, level.height])).collect()
    }

    /// The quadrants of a level in two halves, in all three ways.
    pub fn splits(level: &Level) -> [[Areas<'_>; 2]; 3] {
        let (w, h) = (level.width / 2, level.height / 2);
        let quadrant = |i: usize| (level, [i % 2 * w, i / 2 * h, w, h]);
        PAIRS.map(|split| split.map(|half| half.map(quadrant).to_vec()))
    }
}

/// The spread of each channel about its mean over the exemplar's level, at least half a grey level.
pub(super) fn scales<'a>(levels: impl IntoIterator<Item = &'a Level>) -> [[f32; 2]; 3] {
    let (mut n, mut sums, mut squares) = (0.0, [0.0f64; 3], [0.0f64; 3]);
    for pixel in levels.into_iter().flat_map(|level| &level.data) {
        n += 1.0;
        for c in 0..3 {
            sums[c] += f64::from(pixel[c]);
            squares[c] += f64::from(pixel[c]) * f64::from(pixel[c]);
        }
    }
    let n = f64::max(n, 1.0);
    std::array::from_fn(|c| {
        let mean = sums[c] / n;
        let deviation = libm::sqrt((squares[c] / n - mean * mean).max(0.0));
        [mean as f32, deviation.max(0.5) as f32]
    })
}

/// `count` patches from random places of random areas, normalised; `transposed` swaps rows and columns.
pub(super) fn vectors(
    areas: &Areas<'_>,
    scales: &[[f32; 2]; 3],
    transposed: bool,
    count: usize,
    (random, key): (Random, u64),
) -> Vec<Vector> {
    let areas: Vec<_> = areas.iter().filter(|(_, [.., w, h])| *w >= EDGE && *h >= EDGE).collect();
    if areas.is_empty() {
        return Vec::new();
    }
    let pick = |i: usize| {
        let number = |n, k| random.below(n, [60 + key, i as u64, k]);
        let &(level, [x, y, w, h]) = areas[number(areas.len(), 0)];
        let (x, y) = (x + number(w + 1 - EDGE, 1), y + number(h + 1 - EDGE, 2));
        std::array::from_fn(|k| {
            let (at, c) = (k / 3, k % 3);
            let (i, j) = if transposed { (at / EDGE, at % EDGE) } else { (at % EDGE, at / EDGE) };
            let [mean, deviation] = scales[c];
            (level.get(x + i, y + j)[c] - mean) / deviation
        })
    };
    (0..count).map(pick).collect()
}

/// The mean over random unit directions of the Wasserstein distance W₁ of the projections, `mean |aᵢ − bᵢ|` of both in
/// order. As many vectors on both sides; 0 for none.
pub(super) fn sliced(a: &[Vector], b: &[Vector], random: Random) -> f64 {
    let n = a.len().min(b.len());
    let along = |d: usize| {
        let direction: [f64; NUMBERS] = std::array::from_fn(|k| random.normal([70, d as u64, k as u64]));
        let length = libm::sqrt(direction.iter().map(|v| v * v).sum());
        let project = |set: &[Vector]| {
            let dot = |v: &Vector| v.iter().zip(&direction).map(|(v, d)| f64::from(*v) * d).sum::<f64>();
            let mut values: Vec<f64> = set.iter().take(n).map(|v| dot(v) / length).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        project(a).iter().zip(project(b)).map(|(a, b)| (a - b).abs()).sum::<f64>() / n.max(1) as f64
    };
    let distances: Vec<f64> = (0..DIRECTIONS).into_par_iter().map(along).collect();
    distances.iter().sum::<f64>() / DIRECTIONS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_costs_its_length_along_each_direction() {
        let random = Random(1);
        let cloud: Vec<Vector> =
            (0..200).map(|i| std::array::from_fn(|k| random.normal([1, i, k as u64]) as f32)).collect();
        let shifted: Vec<Vector> = cloud.iter().rev().map(|v| v.map(|x| x + 1.0)).collect();
        assert_eq!(sliced(&cloud, &cloud.iter().rev().copied().collect::<Vec<_>>(), random), 0.0);
        // The shift (1, …, 1) along a random direction has a normal distribution: the mean of |N(0, 1)| is √(2/π).
        let distance = sliced(&cloud, &shifted, random);
        assert!((distance - libm::sqrt(2.0 / std::f64::consts::PI)).abs() < 0.2, "{distance}");
        assert_eq!(sliced(&[], &cloud, random), 0.0);
    }

    #[test]
    fn levels_end_at_eight_pixels() {
        assert_eq!([9, 16, 31, 32, 64, 4096].map(levels), [1, 2, 2, 3, 4, 5]);
    }
}
