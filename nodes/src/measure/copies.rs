//! How large the pieces are that were copied verbatim.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::random::Random;
use super::views::Pixels;
use crate::control::{Cancelled, Control, check};

/// Where each colour of some pictures is.
pub(super) struct Places<'a> {
    pictures: &'a [Pixels],
    colors: FxHashMap<[u8; 3], Vec<(u32, u32)>>,
}

impl<'a> Places<'a> {
    pub fn of(pictures: &'a [Pixels]) -> Self {
        let mut colors = FxHashMap::<_, Vec<_>>::default();
        for (number, picture) in pictures.iter().enumerate() {
            for (at, &pixel) in picture.data.iter().enumerate() {
                colors.entry(pixel).or_default().push((number as u32, at as u32));
            }
        }
        Self { pictures, colors }
    }

    /// The edge, up to `limit`, of the largest square from (x, y) to the lower right that stands somewhere in the pictures
    /// too, pixel for pixel, unturned or (all of it) transposed. The square from (x, y) of edge `limit` must be inside.
    fn largest(&self, picture: &Pixels, x: usize, y: usize, limit: usize) -> usize {
        let mut best = 0;
        for &(number, at) in self.colors.get(&picture.get(x, y)).into_iter().flatten() {
            let source = &self.pictures[number as usize];
            let (u, v) = (at as usize % source.width, at as usize / source.width);
            let room = limit.min(source.width - u).min(source.height - v);
            for transposed in [false, true] {
                let same = |i: usize, j: usize| {
                    let (a, b) = if transposed { (j, i) } else { (i, j) };
                    picture.get(x + i, y + j) == source.get(u + a, v + b)
                };
                // Only what can beat the best is looked at; its last pixel is the likeliest to differ.
                if room <= best || !same(best, best) {
                    continue;
                }
                let edge = (0..room).find(|&n| !(0..=n).all(|k| same(n, k) && same(k, n)));
                best = best.max(edge.unwrap_or(room));
                if best == limit {
                    return best;
                }
            }
        }
        best
    }
}

/// The mean edge, in pixels, of the largest verbatim squares from `samples` random places in `pictures`.
pub(super) fn mean_copy(
    pictures: &[Pixels],
    places: &Places<'_>,
    limit: usize,
    samples: usize,
    (random, key): (Random, u64),
    control: &dyn Control,
) -> Result<f64, Cancelled> {
    let roomy: Vec<&Pixels> = pictures.iter().filter(|p| p.width.min(p.height) >= limit).collect();
    if roomy.is_empty() {
        return Ok(0.0);
    }
    let edge = |i: usize| {
        check(control)?;
        let number = |n, k| random.below(n, [50 + key, i as u64, k]);
        let picture = roomy[number(roomy.len(), 0)];
        let (x, y) = (number(picture.width - limit + 1, 1), number(picture.height - limit + 1, 2));
        Ok(places.largest(picture, x, y, limit))
    };
    let edges = (0..samples).into_par_iter().map(edge).collect::<Result<Vec<_>, Cancelled>>()?;
    Ok(edges.iter().sum::<usize>() as f64 / samples.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(edge: usize, seed: u64) -> Pixels {
        let number = |i: usize| Random(seed).below(1 << 20, [1, i as u64, 0]);
        let data = (0..edge * edge).map(|i| [number(i) as u8, (number(i) >> 8) as u8, 0]).collect();
        Pixels { width: edge, height: edge, data }
    }

    #[test]
    fn copies_are_as_large_as_their_squares() {
        let source = noise(64, 1);
        let places = Places::of(std::slice::from_ref(&source));
        let mean = |picture: Pixels| mean_copy(&[picture], &places, 16, 400, (Random(1), 0), &()).unwrap();
        assert!(mean(noise(48, 2)) < 0.2);
        // Transposed and shifted as a whole.
        let whole: Vec<_> = (0..48 * 48).map(|i| source.get(5 + i / 48, 3 + i % 48)).collect();
        assert_eq!(mean(Pixels { width: 48, height: 48, data: whole }), 16.0);
        // Squares of 8 from random places: a place within is on average 4.5 from the farther borders' nearer one.
        let at = |i: usize, k| Random(9).below(56, [(i / 48 / 8) as u64, (i % 48 / 8) as u64, k]);
        let squares = |i: usize| source.get(at(i, 0) + i % 48 % 8, at(i, 1) + i / 48 % 8);
        let mean = mean(Pixels { width: 48, height: 48, data: (0..48 * 48).map(squares).collect() });
        // The mean of the smaller of two numbers from 1 to 8 is 51/16.
        assert!((mean - 51.0 / 16.0).abs() < 0.4, "{mean}");
    }

    #[test]
    fn squares_are_found_by_the_definition() {
        let coarse = |edge: usize, seed: u64| {
            let data = noise(edge, seed).data.iter().map(|p| [p[0] / 128 * 9, 0, 0]).collect();
            Pixels { width: edge, height: edge, data }
        };
        let (source, picture) = (coarse(12, 3), coarse(12, 4));
        let places = Places::of(std::slice::from_ref(&source));
        for (x, y) in (0..36).map(|i| (i % 6, i / 6)) {
            let fits = |n: usize, u: usize, v: usize, turned: bool| {
                (0..n * n).map(|k| (k % n, k / n)).all(|(i, j)| {
                    let (a, b) = if turned { (j, i) } else { (i, j) };
                    picture.get(x + i, y + j) == source.get(u + a, v + b)
                })
            };
            let slow = (1..=6).rev().find(|&n| {
                (0..=12 - n).any(|u| (0..=12 - n).any(|v| fits(n, u, v, false) || fits(n, u, v, true)))
            });
            assert_eq!(places.largest(&picture, x, y, 6), slow.unwrap_or(0));
        }
    }
}
