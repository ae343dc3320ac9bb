//! Projections and distances in integers: the two operations that every search is made of.

use crate::lazy::Isa;

/// The coefficients of a window: `samples` four channels a pixel, `weights` and `bias` of a
/// [`super::PatchBasis`].
#[inline(always)]
pub fn project<const D: usize>(samples: &[i16], weights: &[i16], bias: &[i32], wide: bool) -> [i16; D] {
    #[cfg(target_arch = "x86_64")]
    if wide {
        // SAFETY: `wide` says that the processor has AVX2.
        return unsafe { x86::project::<D>(samples, weights, bias) };
    }
    let _ = wide;
    let mut sums = [0i32; D];
    sums.copy_from_slice(&bias[..D]);
    for (pair, weights) in samples.chunks_exact(2).zip(weights.chunks_exact(2 * D)) {
        for (sum, weight) in sums.iter_mut().zip(weights.chunks_exact(2)) {
            *sum += i32::from(pair[0]) * i32::from(weight[0]) + i32::from(pair[1]) * i32::from(weight[1]);
        }
    }
    sums.map(|sum| (sum >> 10).clamp(-8192, 8191) as i16)
}

/// The squared distance of two windows' coefficients.
#[inline(always)]
pub fn distance<const D: usize>(a: &[i16; D], b: &[i16], wide: bool) -> u32 {
    #[cfg(target_arch = "x86_64")]
    if wide {
        // SAFETY: `wide` says that the processor has AVX2.
        return unsafe { x86::distance::<D>(a, b) };
    }
    let _ = wide;
    let mut sum = 0u32;
    for (x, y) in a.iter().zip(b) {
        let difference = i32::from(*x) - i32::from(*y);
        sum = sum.wrapping_add((difference * difference) as u32);
    }
    sum
}

/// The number of the candidate of which `(squared distance + 1) · weight` is least, the first among equals. Candidates are indices
/// into `table` and `weights`, in whole fours: sums of four need little shuffling. None without candidates.
///
/// # Panics
/// If a candidate is not in `table` and `weights`.
#[inline(always)]
pub fn nearest_of<const D: usize>(
    query: &[i16; D],
    table: &[[i16; D]],
    weights: &[u32],
    candidates: &[[u16; 4]],
    wide: bool,
) -> Option<u16> {
    let pixels = table.len().min(weights.len());
    let (table, weights) = (&table[..pixels], &weights[..pixels]);
    #[cfg(target_arch = "x86_64")]
    if wide {
        // SAFETY: `wide` says that the processor has AVX2.
        let best = unsafe { x86::nearest_of::<D>(query, table, weights, candidates) };
        return candidates.as_flattened().get(best).copied();
    }
    let mut best = (u64::MAX, None);
    for &candidate in candidates.as_flattened() {
        let at = usize::from(candidate);
        let cost = (u64::from(distance::<D>(query, &table[at], wide)) + 1) * u64::from(weights[at]);
        if cost < best.0 {
            best = (cost, Some(candidate));
        }
    }
    best.1
}

/// Whether an instruction set has AVX2.
pub(crate) fn is_wide(isa: Isa) -> bool {
    isa != Isa::Portable
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    /// # Safety
    /// The processor must have AVX2. `D` is a multiple of 8.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub unsafe fn project<const D: usize>(samples: &[i16], weights: &[i16], bias: &[i32]) -> [i16; D] {
        let mut sums = [_mm256_setzero_si256(); 8];
        let blocks = D / 8;
        for (sum, bias) in sums[..blocks].iter_mut().zip(bias.chunks_exact(8)) {
            // SAFETY: a chunk is 32 bytes.
            *sum = unsafe { _mm256_loadu_si256(bias.as_ptr().cast()) };
        }
        for (pair, weights) in samples.chunks_exact(2).zip(weights.chunks_exact(2 * D)) {
            let pair = _mm256_set1_epi32(i32::from(pair[0] as u16) | i32::from(pair[1]) << 16);
            for (sum, weights) in sums[..blocks].iter_mut().zip(weights.chunks_exact(16)) {
                // SAFETY: a chunk is 32 bytes.
                let weights = unsafe { _mm256_loadu_si256(weights.as_ptr().cast()) };
                *sum = _mm256_add_epi32(*sum, _mm256_madd_epi16(weights, pair));
            }
        }
        let mut out = [0i16; D];
        for (sum, out) in sums[..blocks].iter().zip(out.chunks_exact_mut(8)) {
            let sum = _mm256_srai_epi32::<10>(*sum);
            let sum =
                _mm256_max_epi32(_mm256_min_epi32(sum, _mm256_set1_epi32(8191)), _mm256_set1_epi32(-8192));
            let packed = _mm_packs_epi32(_mm256_castsi256_si128(sum), _mm256_extracti128_si256::<1>(sum));
            // SAFETY: a chunk is 16 bytes.
            unsafe { _mm_storeu_si128(out.as_mut_ptr().cast(), packed) };
        }
        out
    }

    /// # Safety
    /// The processor must have AVX2. `D` is a multiple of 8, and `b` has as many entries.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub unsafe fn distance<const D: usize>(a: &[i16; D], b: &[i16]) -> u32 {
        let b = &b[..D];
        let mut sum = _mm256_setzero_si256();
        let (a16, b16) = (a.chunks_exact(16), b.chunks_exact(16));
        let (a8, b8) = (a16.remainder(), b16.remainder());
        for (a, b) in a16.zip(b16) {
            // SAFETY: chunks are 32 bytes.
            let difference = unsafe {
                _mm256_sub_epi16(_mm256_loadu_si256(a.as_ptr().cast()), _mm256_loadu_si256(b.as_ptr().cast()))
            };
            sum = _mm256_add_epi32(sum, _mm256_madd_epi16(difference, difference));
        }
        let mut half = _mm_add_epi32(_mm256_castsi256_si128(sum), _mm256_extracti128_si256::<1>(sum));
        if a8.len() == 8 {
            // SAFETY: the remainders are 16 bytes.
            let difference = unsafe {
                _mm_sub_epi16(_mm_loadu_si128(a8.as_ptr().cast()), _mm_loadu_si128(b8.as_ptr().cast()))
            };
            half = _mm_add_epi32(half, _mm_madd_epi16(difference, difference));
        }
        let pair = _mm_add_epi32(half, _mm_shuffle_epi32::<0b00_00_11_10>(half));
        let one = _mm_add_epi32(pair, _mm_shuffle_epi32::<0b01>(pair));
        _mm_cvtsi128_si32(one) as u32
    }

    /// The number of the candidate whose weighted distance is least, the first among equals; `usize::MAX` without candidates.
    ///
    /// # Safety
    /// The processor must have AVX2. `D` is a multiple of 8.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub unsafe fn nearest_of<const D: usize>(
        query: &[i16; D],
        table: &[[i16; D]],
        weights: &[u32],
        candidates: &[[u16; 4]],
    ) -> usize {
        let mut best = Best::new();
        for four in candidates {
            let mut sums = [_mm256_setzero_si256(); 4];
            let mut weight = [0u64; 4];
            for i in 0..4 {
                let at = usize::from(four[i]);
                weight[i] = u64::from(weights[at]);
                let (a16, b16) = (query.chunks_exact(16), table[at].chunks_exact(16));
                let (a8, b8) = (a16.remainder(), b16.remainder());
                for (a, b) in a16.zip(b16) {
                    // SAFETY: chunks are 32 bytes.
                    let (a, b) = unsafe {
                        (_mm256_loadu_si256(a.as_ptr().cast()), _mm256_loadu_si256(b.as_ptr().cast()))
                    };
                    let difference = _mm256_sub_epi16(a, b);
                    sums[i] = _mm256_add_epi32(sums[i], _mm256_madd_epi16(difference, difference));
                }
                if a8.len() == 8 {
                    // SAFETY: the remainders are 16 bytes.
                    let (a, b) =
                        unsafe { (_mm_loadu_si128(a8.as_ptr().cast()), _mm_loadu_si128(b8.as_ptr().cast())) };
                    let difference = _mm_sub_epi16(a, b);
                    let squares = _mm256_zextsi128_si256(_mm_madd_epi16(difference, difference));
                    sums[i] = _mm256_add_epi32(sums[i], squares);
                }
            }
            let [a, b, c, d] = sums;
            let sums = _mm256_hadd_epi32(_mm256_hadd_epi32(a, b), _mm256_hadd_epi32(c, d));
            let sums = _mm_add_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256::<1>(sums));
            let [a, b, c, d] = weight.map(|weight| weight as i64);
            best.add(_mm256_cvtepu32_epi64(sums), _mm256_set_epi64x(d, c, b, a));
        }
        let (cost, number) = best.least(4);
        if cost == u64::MAX { usize::MAX } else { number }
    }

    /// Of each of four lanes the least cost, and how many came before it.
    #[derive(Clone, Copy)]
    struct Best {
        cost: __m256i,
        number: __m256i,
        next: __m256i,
    }

    impl Best {
        #[inline]
        #[target_feature(enable = "avx2")]
        fn new() -> Self {
            let cost = _mm256_set1_epi64x(i64::MAX);
            Self { cost, number: _mm256_setzero_si256(), next: _mm256_setzero_si256() }
        }

        /// The next four, 32 bits in 64 each.
        #[inline]
        #[target_feature(enable = "avx2")]
        fn add(&mut self, distance: __m256i, weight: __m256i) {
            let cost = _mm256_add_epi64(_mm256_mul_epu32(distance, weight), weight);
            let better = _mm256_cmpgt_epi64(self.cost, cost);
            self.cost = _mm256_blendv_epi8(self.cost, cost, better);
            self.number = _mm256_blendv_epi8(self.number, self.next, better);
            self.next = _mm256_add_epi64(self.next, _mm256_set1_epi64x(1));
        }

        /// The least of all lanes and its place, if what came in at once lies `stride` apart; the first among equals.
        #[inline]
        #[target_feature(enable = "avx2")]
        fn least(self, stride: usize) -> (u64, usize) {
            let (mut cost, mut number) = ([0u64; 4], [0u64; 4]);
            // SAFETY: the arrays are 32 bytes.
            unsafe {
                _mm256_storeu_si256(cost.as_mut_ptr().cast(), self.cost);
                _mm256_storeu_si256(number.as_mut_ptr().cast(), self.number);
            }
            let mut best = (u64::MAX, usize::MAX);
            for lane in 0..4 {
                let place = number[lane] as usize * stride + lane * stride / 4;
                if cost[lane] < i64::MAX as u64 {
                    best = best.min((cost[lane], place));
                }
            }
            best
        }
    }

    /// The number of the vector whose weighted distance is least, the first among equals.
    ///
    /// # Safety
    /// The processor must have AVX2; `weights` has eight entries for each block of `entries`.
    #[target_feature(enable = "avx2")]
    pub unsafe fn nearest(entries: &[i16], dims: usize, query: &[i16], weights: &[u32]) -> usize {
        let mut pairs = [_mm256_setzero_si256(); 32];
        for (pair, query) in pairs.iter_mut().zip(query.chunks_exact(2)) {
            *pair = _mm256_set1_epi32(i32::from(query[0] as u16) | i32::from(query[1]) << 16);
        }
        // Those of even places, and those of odd ones.
        let mut best = [Best::new(), Best::new()];
        let low = _mm256_set1_epi64x(0xffff_ffff);
        for (block, weights) in entries.chunks_exact(dims * 8).zip(weights.chunks_exact(8)) {
            let mut sums = _mm256_setzero_si256();
            for (entries, pair) in block.chunks_exact(16).zip(&pairs) {
                // SAFETY: a pair of eight windows is 32 bytes.
                let entries = unsafe { _mm256_loadu_si256(entries.as_ptr().cast()) };
                let difference = _mm256_sub_epi16(entries, *pair);
                sums = _mm256_add_epi32(sums, _mm256_madd_epi16(difference, difference));
            }
            // SAFETY: a chunk is 32 bytes.
            let weights = unsafe { _mm256_loadu_si256(weights.as_ptr().cast()) };
            best[0].add(_mm256_and_si256(sums, low), _mm256_and_si256(weights, low));
            best[1].add(_mm256_srli_epi64::<32>(sums), _mm256_srli_epi64::<32>(weights));
        }
        let [even, odd] = best.map(|best| best.least(8));
        if (odd.0, odd.1.saturating_add(1)) < even { odd.1.saturating_add(1) } else { even.1 }
    }

    /// # Safety
    /// The processor must have AVX2; `out` has eight entries for each block of `entries`.
    #[target_feature(enable = "avx2")]
    pub unsafe fn distances(entries: &[i16], dims: usize, query: &[i16], out: &mut [u32]) {
        let mut pairs = [_mm256_setzero_si256(); 32];
        for (pair, query) in pairs.iter_mut().zip(query.chunks_exact(2)) {
            *pair = _mm256_set1_epi32(i32::from(query[0] as u16) | i32::from(query[1]) << 16);
        }
        for (block, out) in entries.chunks_exact(dims * 8).zip(out.chunks_exact_mut(8)) {
            let mut sums = _mm256_setzero_si256();
            for (entries, pair) in block.chunks_exact(16).zip(&pairs) {
                // SAFETY: a pair of eight windows is 32 bytes.
                let entries = unsafe { _mm256_loadu_si256(entries.as_ptr().cast()) };
                let difference = _mm256_sub_epi16(entries, *pair);
                sums = _mm256_add_epi32(sums, _mm256_madd_epi16(difference, difference));
            }
            // SAFETY: a chunk is 32 bytes.
            unsafe { _mm256_storeu_si256(out.as_mut_ptr().cast(), sums) };
        }
    }
}

/// The coefficients of many windows in blocks of eight, pairs of coefficients side by side, so that one multiplication serves
/// eight windows and sums need no shuffling.
pub struct PatchTable {
    /// `[block][pair][window][coefficient of the pair]`.
    entries: Vec<i16>,
    dims: usize,
    len: usize,
}

impl PatchTable {
    /// A table of vectors of `dims` (a multiple of 2) coefficients.
    pub fn new<'a>(vectors: impl ExactSizeIterator<Item = &'a [i16]>, dims: usize) -> Self {
        let len = vectors.len();
        let padded = len.div_ceil(8) * 8;
        let mut entries = vec![0; padded * dims];
        for (i, vector) in vectors.enumerate() {
            // The last vector fills the last block, and so is never nearer than itself.
            for i in i..if i + 1 == len { padded } else { i + 1 } {
                let block = i / 8 * dims * 8;
                for (d, &value) in vector.iter().enumerate().take(dims) {
                    entries[block + d / 2 * 16 + i % 8 * 2 + d % 2] = value;
                }
            }
        }
        Self { entries, dims, len }
    }

    /// Weights for [`PatchTable::nearest`]: as many as the table has places, the last repeated.
    pub fn pad(&self, weights: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut out: Vec<u32> = weights.take(self.len).collect();
        out.resize(self.len.div_ceil(8) * 8, out.last().copied().unwrap_or(1));
        out
    }

    /// The vector of which `(squared distance + 1) · weight` is least, the first among equals; `weights` come from
    /// [`PatchTable::pad`] and are at most 2²⁴.
    pub fn nearest(&self, query: &[i16], weights: &[u32], isa: Isa) -> usize {
        #[cfg(target_arch = "x86_64")]
        if is_wide(isa) {
            // SAFETY: the instruction set has AVX2; missing weights only shorten the search.
            return unsafe { x86::nearest(&self.entries, self.dims, query, weights) }.min(self.len);
        }
        let mut distances = Vec::new();
        self.distances(query, &mut distances, isa);
        let costs = distances.iter().zip(weights).map(|(&d, &w)| (u64::from(d) + 1) * u64::from(w));
        costs.enumerate().map(|(i, cost)| (cost, i)).min().map_or(self.len, |best| best.1)
    }

    /// Squared distances of `query` to every vector; `out` gets as many entries, and up to seven more for padding.
    pub fn distances(&self, query: &[i16], out: &mut Vec<u32>, isa: Isa) {
        self.distances_within(0, self.len.div_ceil(8), query, out, isa);
    }

    /// The same of `count` blocks of eight vectors from `first`, or as many as there are.
    pub(super) fn distances_within(
        &self,
        first: usize,
        count: usize,
        query: &[i16],
        out: &mut Vec<u32>,
        isa: Isa,
    ) {
        let entries = self.entries.get(first * self.dims * 8..).unwrap_or(&[]);
        let entries = &entries[..entries.len().min(count * self.dims * 8)];
        out.clear();
        out.resize(entries.len() / self.dims, 0);
        #[cfg(target_arch = "x86_64")]
        if is_wide(isa) {
            // SAFETY: the instruction set has AVX2, and `out` the right length.
            unsafe { x86::distances(entries, self.dims, query, out) };
            return;
        }
        let _ = isa;
        for (block, out) in entries.chunks_exact(self.dims * 8).zip(out.chunks_exact_mut(8)) {
            for (pair, query) in block.chunks_exact(16).zip(query.chunks_exact(2)) {
                for (entry, out) in pair.chunks_exact(2).zip(out.iter_mut()) {
                    let difference = |i: usize| i32::from(entry[i]) - i32::from(query[i]);
                    let sum = difference(0) * difference(0) + difference(1) * difference(1);
                    *out = out.wrapping_add(sum as u32);
                }
            }
        }
    }

    /// Vectors in the table.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lazy::available_instruction_sets;

    fn vectors(count: usize, dims: usize) -> Vec<i16> {
        let value = |i: usize| ((i as u32).wrapping_mul(2_654_435_761) >> 19) as i16 - 4096;
        (0..count * dims).map(value).collect()
    }

    #[test]
    fn every_instruction_set_gives_the_same() {
        let all = vectors(43, 24);
        let table = PatchTable::new(all.chunks_exact(24), 24);
        let query: &[i16; 24] = all[24..48].try_into().unwrap();
        let expected: Vec<u32> = all.chunks_exact(24).map(|v| distance(query, v, false)).collect();
        assert_eq!(expected[1], 0);
        let samples: Vec<i16> = (0..100).map(|i| (i * 37 % 256) as i16).collect();
        let (weights, bias) = (vectors(100, 24), vec![12_345; 24]);
        let plain = project::<24>(&samples, &weights, &bias, false);
        for isa in available_instruction_sets() {
            let mut found = Vec::new();
            table.distances(query, &mut found, isa);
            assert_eq!(found[..43], expected, "{isa:?}");
            let wide = is_wide(isa);
            assert!(
                all.chunks_exact(24).zip(&expected).all(|(v, &e)| distance(query, v, wide) == e),
                "{isa:?}"
            );
            assert_eq!(project::<24>(&samples, &weights, &bias, wide), plain, "{isa:?}");
            // One weight for all but a few; the first of equal vectors is taken.
            for heavy in [0, 3, 1 << 20] {
                let weigh = |i: usize| if i % 5 == 1 { 256 + heavy } else { 256 };
                let weights = table.pad((0..43).map(|i| weigh(i) as u32));
                let cost = |i: &usize| (u64::from(expected[*i]) + 1) * weigh(*i) as u64;
                let least = (0..43).min_by_key(cost).unwrap();
                assert_eq!(table.nearest(query, &weights, isa), least, "{isa:?}");
                let some = [[40, 7, 9, 9], [40, 3, 12, 9]];
                let (rows, weights) = (all.as_chunks::<24>().0, &weights[..43]);
                let least = some.as_flattened().iter().min_by_key(|&&i: &&u16| cost(&usize::from(i)));
                let found = nearest_of(query, rows, weights, &some, wide);
                assert_eq!(found.as_ref(), least, "{isa:?}");
                assert_eq!(nearest_of(query, rows, weights, &[], wide), None);
            }
            let both: Vec<&[i16]> = all.chunks_exact(24).chain(all.chunks_exact(24)).collect();
            let twice = PatchTable::new(both.into_iter(), 24);
            assert_eq!(twice.nearest(query, &twice.pad((0..86).map(|_| 7)), isa), 1, "{isa:?}");
        }
    }
}
