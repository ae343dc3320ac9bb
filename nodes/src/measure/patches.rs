//! Square patches of pixels, and the exact nearest neighbour of a patch among those of an exemplar.

use super::views::Pixels;

/// Pixels along a patch's edge.
pub(super) const EDGE: usize = 5;

/// Numbers a patch: red, green, blue of each pixel.
pub(super) const NUMBERS: usize = EDGE * EDGE * 3;

/// A patch's numbers, padded with zeros to whole vectors of 8.
pub(super) type Patch = [i16; 80];

/// A patch from its pixels in rows.
pub(super) fn patch(mut pixel: impl FnMut(usize, usize) -> [u8; 3]) -> Patch {
    let mut patch = [0; 80];
    for (at, to) in patch.chunks_exact_mut(3).enumerate().take(EDGE * EDGE) {
        let rgb = pixel(at % EDGE, at / EDGE);
        to.iter_mut().zip(rgb).for_each(|(to, c)| *to = i16::from(c));
    }
    patch
}

/// The sum of squared differences.
fn distance(a: &Patch, b: &Patch) -> i32 {
    // 80 squares of at most 255² stay far below 2³¹; wrapping operations let the compiler use vectors.
    a.iter().zip(b).fold(0i32, |sum, (a, b)| {
        let d = i32::from(a.wrapping_sub(*b));
        sum.wrapping_add(d.wrapping_mul(d))
    })
}

/// A coarse form of a patch whose squared distances are at most 12 times those of the patches.
///
/// The columns and the rows fall into groups of 2, 1 and 2, which makes 9 blocks of 12, 6 and 3 numbers. By
/// Cauchy and Schwarz a block's squared difference of sums is at most its size times its squared
/// distance; sums of the blocks of 6 count twice therefore, those of 3 four times.
type Coarse = [i16; 16];

/// How much larger squared distances of the coarse forms may be.
const COARSE_FACTOR: i64 = 12;

fn coarse(patch: &Patch) -> Coarse {
    let group = |i: usize| [0, 0, 1, 2, 2][i];
    let mut blocks = [[0i16; 3]; 3];
    for (at, rgb) in patch.chunks_exact(3).enumerate().take(EDGE * EDGE) {
        blocks[group(at / EDGE)][group(at % EDGE)] += rgb.iter().sum::<i16>();
    }
    let [[a, b, c], [d, e, f], [g, h, i]] = blocks;
    [a, c, g, i, b, b, d, d, f, f, h, h, 2 * e, 0, 0, 0]
}

/// The sum of squared differences of coarse forms.
fn coarse_distance(a: &Coarse, b: &Coarse) -> i32 {
    // 16 squares of at most 3060² stay below 2³¹.
    a.iter().zip(b).fold(0i32, |sum, (a, b)| {
        let d = i32::from(a.wrapping_sub(*b));
        sum.wrapping_add(d.wrapping_mul(d))
    })
}

/// The sum of all numbers.
fn total(patch: &Patch) -> i32 {
    patch.iter().map(|&n| i32::from(n)).sum()
}

/// Patches of an exemplar, each with the cell of the picture that it belongs to.
#[derive(Default)]
pub(super) struct PatchSet {
    /// Total of all numbers, by which the entries are sorted.
    totals: Vec<i32>,
    coarse: Vec<Coarse>,
    patches: Vec<Patch>,
    cells: Vec<u32>,
}

impl PatchSet {
    /// Every patch of `picture` that lies within one of `areas` (x, y, width, height), `stride` pixels
    /// apart; cells are squares of `cell` pixels.
    pub fn new(picture: &Pixels, areas: &[[usize; 4]], stride: usize, cell: usize) -> Self {
        let mut entries = Vec::new();
        for &[x0, y0, width, height] in areas {
            for y in (y0..(y0 + height + 1).saturating_sub(EDGE)).step_by(stride) {
                for x in (x0..(x0 + width + 1).saturating_sub(EDGE)).step_by(stride) {
                    let patch = patch(|i, j| picture.get(x + i, y + j));
                    let id = (y / cell) * picture.width.div_ceil(cell) + x / cell;
                    entries.push((total(&patch), id as u32, patch));
                }
            }
        }
        Self::sorted(entries)
    }

    /// Any patches, without cells.
    pub fn of(patches: Vec<Patch>) -> Self {
        Self::sorted(patches.into_iter().map(|patch| (total(&patch), 0, patch)).collect())
    }

    /// From totals, cells and patches.
    fn sorted(mut entries: Vec<(i32, u32, Patch)>) -> Self {
        entries.sort_by_key(|&(total, ..)| total);
        let mut set = Self::default();
        for (total, cell, patch) in entries {
            set.totals.push(total);
            set.coarse.push(coarse(&patch));
            set.patches.push(patch);
            set.cells.push(cell);
        }
        set
    }

    /// How many different cells the patches belong to.
    pub fn cell_count(&self) -> usize {
        let mut cells = self.cells.clone();
        cells.sort_unstable();
        cells.dedup();
        cells.len()
    }

    /// How many patches.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    /// Patch `i`, in no order that matters.
    pub fn get(&self, i: usize) -> &Patch {
        &self.patches[i]
    }

    /// The squared distance to the nearest patch and its cell; of equally near patches the one of the
    /// smallest cell. The set must not be empty.
    ///
    /// Exact: entries are visited outwards from the query's own total, and since the squared difference
    /// of totals is at most 75 times the squared distance, all others are farther once that bound is passed.
    pub fn nearest(&self, query: &Patch) -> (i32, u32) {
        let (total, rough) = (total(query), coarse(query));
        let start = self.totals.partition_point(|&t| t < total);
        let (mut low, mut high) = (start, start);
        let mut best = (i32::MAX, u32::MAX);
        loop {
            let below = low.checked_sub(1).map(|i| total - self.totals[i]);
            let above = self.totals.get(high).map(|t| t - total);
            let (at, gap) = match (below, above) {
                (Some(b), Some(a)) if b <= a => (low - 1, b),
                (Some(b), None) => (low - 1, b),
                (_, Some(a)) => (high, a),
                (None, None) => return best,
            };
            if i64::from(gap) * i64::from(gap) > NUMBERS as i64 * i64::from(best.0) {
                return best;
            }
            if at < low {
                low -= 1;
            } else {
                high += 1;
            }
            let bound = COARSE_FACTOR * i64::from(best.0);
            if i64::from(coarse_distance(&rough, &self.coarse[at])) <= bound {
                best = best.min((distance(query, &self.patches[at]), self.cells[at]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_patch_is_that_of_an_exhaustive_search() {
        let mut state = 7u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8 & 0xf0
        };
        let data = (0..40 * 30).map(|_| [next(), next(), next()]).collect();
        let picture = Pixels { width: 40, height: 30, data };
        let set = PatchSet::new(&picture, &[[0, 0, 20, 15], [20, 15, 20, 15]], 1, 2);
        assert_eq!(set.len(), 2 * 16 * 11);
        for _ in 0..50 {
            let mut query = patch(|_, _| [next(), next(), next()]);
            if next() > 128 {
                query = *set.get(usize::from(next()));
            }
            let all = (0..set.len()).map(|i| (distance(&query, set.get(i)), set.cells[i]));
            assert_eq!(Some(set.nearest(&query)), all.min());
        }
    }
}
