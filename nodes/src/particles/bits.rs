//! Voxel shapes as rows of bits, and a grid that knows which of its voxels are taken.

use serde::{Deserialize, Serialize};

/// A set of voxels in a box around a centre, one bit each, rows along x in words of 64.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bits {
    /// The first voxel of the box, from the centre.
    pub low: [i32; 3],
    /// The edges of the box in voxels.
    pub size: [u32; 3],
    rows: Vec<u64>,
}

impl Bits {
    /// The voxels of a box (from `low`, of `size`) for which `inside` holds.
    pub fn from_fn(low: [i32; 3], size: [u32; 3], mut inside: impl FnMut([i32; 3]) -> bool) -> Self {
        let words = size[0].div_ceil(64) as usize;
        let mut rows = vec![0u64; words * (size[1] * size[2]) as usize];
        let mut at = 0;
        for z in 0..size[2] as i32 {
            for y in 0..size[1] as i32 {
                for x in 0..size[0] as i32 {
                    if inside([low[0] + x, low[1] + y, low[2] + z]) {
                        rows[at + x as usize / 64] |= 1 << (x % 64);
                    }
                }
                at += words;
            }
        }
        Self { low, size, rows }
    }

    fn words(&self) -> usize {
        self.size[0].div_ceil(64) as usize
    }

    /// Whether the bits are as many as the box needs; for what comes from a file.
    pub fn is_whole(&self) -> bool {
        let rows = self.size[1] as u64 * u64::from(self.size[2]);
        rows.checked_mul(self.words() as u64) == Some(self.rows.len() as u64)
            && (0..3).all(|a| self.low[a].unsigned_abs() < 1 << 16 && self.size[a] < 1 << 16)
    }

    /// Whether a voxel, given from the centre, is in the set.
    #[inline]
    pub fn holds(&self, voxel: [i32; 3]) -> bool {
        let at: [i32; 3] = std::array::from_fn(|a| voxel[a] - self.low[a]);
        let inside = (0..3).all(|a| at[a] >= 0 && (at[a] as u32) < self.size[a]);
        let [x, y, z] = at.map(|c| c as usize);
        inside && self.rows[(z * self.size[1] as usize + y) * self.words() + x / 64] >> (x % 64) & 1 == 1
    }

    /// Voxels in the set.
    pub fn count(&self) -> u64 {
        self.rows.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// The voxels, from the centre, x fastest.
    pub fn voxels(&self) -> impl Iterator<Item = [i32; 3]> + '_ {
        let words = self.words();
        self.rows.iter().enumerate().flat_map(move |(i, &word)| {
            let (row, first) = (i / words, i % words * 64);
            let [y, z] = [row % self.size[1] as usize, row / self.size[1] as usize];
            let mut left = word;
            std::iter::from_fn(move || {
                (left != 0).then(|| {
                    let x = first + left.trailing_zeros() as usize;
                    left &= left - 1;
                    [self.low[0] + x as i32, self.low[1] + y as i32, self.low[2] + z as i32]
                })
            })
        })
    }

    /// Bytes held.
    pub fn byte_size(&self) -> u64 {
        8 * self.rows.len() as u64 + 48
    }

    /// The set grown by all voxels no further than `gap` from it.
    pub fn grown(&self, gap: f64) -> Self {
        let reach = gap as i32;
        if reach == 0 {
            return self.clone();
        }
        let ball: Vec<[i32; 3]> = (-reach..=reach)
            .flat_map(|z| (-reach..=reach).flat_map(move |y| (-reach..=reach).map(move |x| [x, y, z])))
            .filter(|d| f64::from(d.iter().map(|c| c * c).sum::<i32>()) <= gap * gap)
            .collect();
        let low = self.low.map(|c| c - reach);
        let size = self.size.map(|n| n + 2 * reach as u32);
        let mut grown = Self::from_fn(low, size, |_| false);
        let words = grown.words();
        for voxel in self.voxels() {
            for d in &ball {
                let at: [usize; 3] = std::array::from_fn(|a| (voxel[a] + d[a] - low[a]) as usize);
                grown.rows[(at[2] * size[1] as usize + at[1]) * words + at[0] / 64] |= 1 << (at[0] % 64);
            }
        }
        grown
    }
}

/// Which voxels of a domain are taken.
pub struct Occupancy {
    size: [i64; 3],
    wrap: bool,
    words: usize,
    rows: Vec<u64>,
}

impl Occupancy {
    /// An empty domain, around its ends if `wrap`; else voxels beyond it are never taken.
    pub fn new(size: [u32; 3], wrap: bool) -> Self {
        let words = size[0].div_ceil(64) as usize;
        let rows = vec![0; words * size[1] as usize * size[2] as usize];
        Self { size: size.map(i64::from), wrap, words, rows }
    }

    fn row(&self, y: i64, z: i64) -> Option<usize> {
        let (y, z) =
            if self.wrap { (y.rem_euclid(self.size[1]), z.rem_euclid(self.size[2])) } else { (y, z) };
        let inside = (0..self.size[1]).contains(&y) && (0..self.size[2]).contains(&z);
        inside.then(|| (z * self.size[1] + y) as usize * self.words)
    }

    /// Whether a voxel is taken.
    pub fn holds(&self, [x, y, z]: [i32; 3]) -> bool {
        let x = if self.wrap { i64::from(x).rem_euclid(self.size[0]) } else { i64::from(x) };
        let inside = (0..self.size[0]).contains(&x);
        let row = self.row(y.into(), z.into()).filter(|_| inside);
        row.is_some_and(|row| self.rows[row + x as usize / 64] >> (x % 64) & 1 == 1)
    }

    /// Calls `f` with each word of the domain that a run of up to 64 bits from `x` on touches, and the bits in its place. Stops
    /// when `f` says `false`.
    #[inline]
    fn each(&self, row: usize, mut x: i64, mut bits: u64, f: &mut impl FnMut(usize, u64) -> bool) -> bool {
        if self.wrap {
            x = x.rem_euclid(self.size[0]);
        } else if x < 0 {
            bits = if x <= -64 { 0 } else { bits >> -x };
            x = 0;
        }
        while bits != 0 && x < self.size[0] {
            let (word, shift) = ((x / 64) as usize, x % 64);
            let room = (64 - shift).min(self.size[0] - x);
            let here = if room == 64 { bits } else { bits & ((1 << room) - 1) };
            if here != 0 && !f(row + word, here << shift) {
                return false;
            }
            bits = if room == 64 { 0 } else { bits >> room };
            x += room;
            if x == self.size[0] && self.wrap {
                x = 0;
            }
        }
        true
    }

    fn visit(&self, bits: &Bits, center: [i32; 3], mut f: impl FnMut(usize, u64) -> bool) -> bool {
        let words = bits.words();
        let mut at = 0;
        let from: [i64; 3] = std::array::from_fn(|a| i64::from(center[a]) + i64::from(bits.low[a]));
        for z in 0..i64::from(bits.size[2]) {
            for y in 0..i64::from(bits.size[1]) {
                if let Some(row) = self.row(from[1] + y, from[2] + z) {
                    for word in 0..words {
                        let set = bits.rows[at + word];
                        if set != 0 && !self.each(row, from[0] + 64 * word as i64, set, &mut f) {
                            return false;
                        }
                    }
                }
                at += words;
            }
        }
        true
    }

    /// Whether at most `most` voxels of a set around a centre are taken.
    pub fn fits(&self, bits: &Bits, center: [i32; 3], most: u64) -> bool {
        let mut overlap = 0;
        self.visit(bits, center, |word, set| {
            overlap += u64::from((self.rows[word] & set).count_ones());
            overlap <= most
        })
    }

    /// Takes the voxels of a set around a centre; returns how many were free.
    pub fn take(&mut self, bits: &Bits, center: [i32; 3]) -> u64 {
        let mut changes = Vec::new();
        self.visit(bits, center, |word, set| {
            changes.push((word, set));
            true
        });
        let mut new = 0;
        for (word, set) in changes {
            new += u64::from((set & !self.rows[word]).count_ones());
            self.rows[word] |= set;
        }
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_grid_counts_as_voxel_by_voxel(
            size in (1u32..150, 1u32..12, 1u32..12), wrap: bool,
            spots in proptest::collection::vec((-90i32..200, -12i32..24, -12i32..24, 1u32..130), 1..6),
        ) {
            let size = [size.0, size.1, size.2];
            let mut grid = Occupancy::new(size, wrap);
            let mut plain = std::collections::BTreeSet::new();
            for (x, y, z, width) in spots {
                let bits = Bits::from_fn([-2, -1, -1], [width, 3, 2], |v| (v[0] * 5 + v[1] * 3 + v[2]) % 4 != 0);
                let place = |v: [i32; 3]| {
                    let at = [v[0] + x, v[1] + y, v[2] + z];
                    let wrapped: [i32; 3] = std::array::from_fn(|a| at[a].rem_euclid(size[a] as i32));
                    if wrap { Some(wrapped) } else { (wrapped == at).then_some(at) }
                };
                // Around a small domain a shape may meet itself.
                let distinct: std::collections::BTreeSet<_> = bits.voxels().filter_map(place).collect();
                let taken = bits.voxels().filter_map(place).filter(|v| plain.contains(v)).count() as u64;
                prop_assert!(grid.fits(&bits, [x, y, z], taken));
                prop_assert!(taken == 0 || !grid.fits(&bits, [x, y, z], taken - 1));
                let new = distinct.iter().filter(|v| !plain.contains(*v)).count() as u64;
                prop_assert_eq!(grid.take(&bits, [x, y, z]), new);
                plain.extend(distinct);
                for v in &plain {
                    prop_assert!(grid.holds(*v));
                }
            }
        }
    }

    #[test]
    fn growing_adds_what_is_near() {
        let bits = Bits::from_fn([0; 3], [1; 3], |_| true);
        assert_eq!((bits.grown(0.5).count(), bits.grown(1.0).count(), bits.grown(2.0).count()), (1, 7, 33));
    }
}
