//! Brute-force nearest neighbours over byte vectors: exact, and quick enough that no tree is needed.

/// Byte vectors in blocks of eight, pairs of entries side by side, so that one multiplication serves eight of
/// them and sums need no shuffling.
pub(super) struct Table {
    /// `[block][pair][vector][entry of the pair]`.
    entries: Vec<i16>,
    pairs: usize,
    len: usize,
}

/// Vectors in a block.
const LANES: usize = 8;

impl Table {
    /// The first `dims` (an even number) entries of each vector.
    pub fn new<const D: usize>(vectors: impl ExactSizeIterator<Item = [u8; D]>, dims: usize) -> Self {
        let (len, pairs) = (vectors.len(), dims.min(D) / 2);
        let mut entries = vec![0; len.div_ceil(LANES) * pairs * 2 * LANES];
        for (i, vector) in vectors.enumerate() {
            let block = i / LANES * pairs * 2 * LANES;
            for d in 0..pairs * 2 {
                entries[block + d / 2 * 2 * LANES + i % LANES * 2 + d % 2] = i16::from(vector[d]);
            }
        }
        Self { entries, pairs, len }
    }

    /// Squared distances of `query` to every vector.
    pub fn distances(&self, query: &[u8], out: &mut Vec<u32>) {
        out.clear();
        out.resize(self.len.div_ceil(LANES) * LANES, 0);
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2.
            unsafe { self.distances_avx2(query, out) };
            out.truncate(self.len);
            return;
        }
        self.distances_portable(query, out);
        out.truncate(self.len);
    }

    fn distances_portable(&self, query: &[u8], out: &mut [u32]) {
        let blocks = self.entries.chunks_exact(self.pairs * 2 * LANES);
        for (block, out) in blocks.zip(out.chunks_exact_mut(LANES)) {
            for (pair, query) in block.chunks_exact(2 * LANES).zip(query.chunks_exact(2)) {
                for (entry, out) in pair.chunks_exact(2).zip(out.iter_mut()) {
                    let difference = |i: usize| i32::from(entry[i]) - i32::from(query[i]);
                    *out += (difference(0) * difference(0) + difference(1) * difference(1)) as u32;
                }
            }
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn distances_avx2(&self, query: &[u8], out: &mut [u32]) {
        use std::arch::x86_64::*;
        let mut pairs = [_mm256_setzero_si256(); 16];
        let count = self.pairs.min(pairs.len());
        for (pair, query) in pairs.iter_mut().zip(query.chunks_exact(2)).take(count) {
            *pair = _mm256_set1_epi32(i32::from(query[0]) | i32::from(query[1]) << 16);
        }
        let blocks = self.entries.chunks_exact(self.pairs * 2 * LANES);
        for (block, out) in blocks.zip(out.chunks_exact_mut(LANES)) {
            let mut sums = _mm256_setzero_si256();
            for (entries, pair) in block.chunks_exact(2 * LANES).zip(&pairs[..count]) {
                // SAFETY: a pair of eight vectors is 32 bytes.
                let entries = unsafe { _mm256_loadu_si256(entries.as_ptr().cast()) };
                let difference = _mm256_sub_epi16(entries, *pair);
                sums = _mm256_add_epi32(sums, _mm256_madd_epi16(difference, difference));
            }
            // SAFETY: eight sums are 32 bytes.
            unsafe { _mm256_storeu_si256(out.as_mut_ptr().cast(), sums) };
        }
    }
}

/// The `count` smallest distances with their indices, in ascending order; ties go to the lower index.
pub(super) fn smallest(distances: &[u32], count: usize) -> Vec<(u32, u32)> {
    let mut kept: Vec<u64> = Vec::with_capacity(2 * count + 1);
    let mut bound = u64::MAX;
    for (i, &distance) in distances.iter().enumerate() {
        let key = u64::from(distance) << 32 | i as u64;
        if key < bound {
            kept.push(key);
            if kept.len() > 2 * count {
                kept.select_nth_unstable(count);
                kept.truncate(count);
                bound = kept.iter().copied().max().unwrap_or(u64::MAX);
            }
        }
    }
    kept.sort_unstable();
    kept.truncate(count);
    kept.into_iter().map(|key| ((key >> 32) as u32, key as u32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_equal_their_definition() {
        let vectors: Vec<[u8; 20]> =
            (0..37u32).map(|i| std::array::from_fn(|d| (i * 97 + d as u32 * 31 + i * i) as u8)).collect();
        let table = Table::new(vectors.iter().copied(), 20);
        let expected: Vec<u32> = vectors
            .iter()
            .map(|v| v.iter().zip(&vectors[5]).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum())
            .collect();
        let mut found = Vec::new();
        table.distances(&vectors[5], &mut found);
        assert_eq!(found, expected);
        let mut portable = vec![0; 40];
        table.distances_portable(&vectors[5], &mut portable);
        assert_eq!(portable[..37], expected);
    }

    #[test]
    fn smallest_equals_a_full_sort() {
        let distances: Vec<u32> = (0..5000u32).map(|i| i.wrapping_mul(2654435761) % 700).collect();
        let mut expected: Vec<(u32, u32)> = distances.iter().zip(0..).map(|(&d, i)| (d, i)).collect();
        expected.sort_unstable();
        assert_eq!(smallest(&distances, 65), expected[..65]);
        assert_eq!(smallest(&distances[..3], 65).len(), 3);
    }
}
