//! The operations of a correction in AVX2 and AVX-512 with VNNI.

use std::arch::x86_64::*;

use super::basis::{Basis, Descriptor};
use super::candidates::{Strip, Triple};
use super::color::{OneColor, first_least};
use super::isa::{DU, DV, Edges, Operations};
use super::kernel::{AROUND, Row};
use super::pyramid::{N, Pixel};
use super::tables::{Record, ViewTables};

/// Where a set has an instruction of its own for sums of products of bytes.
trait Dot: Copy {
    /// In each of the eight 32-bit lanes the sum of the squares of four 7-bit numbers.
    ///
    /// # Safety
    /// The processor must have the instruction set.
    unsafe fn squares(a: __m256i) -> __m256i;

    /// [`Operations::project`].
    ///
    /// # Safety
    /// As there.
    unsafe fn project<const NARROW: bool>(
        basis: &Basis,
        window: &[u32],
        at: [usize; 4],
        offsets: &[i32; N * N],
    ) -> [Descriptor; 4];
}

#[derive(Clone, Copy)]
pub(super) struct Avx2;

#[derive(Clone, Copy)]
pub(super) struct Avx512;

impl Dot for Avx2 {
    #[inline(always)]
    unsafe fn squares(a: __m256i) -> __m256i {
        // SAFETY: callers have AVX2. Two squares of 7 bits fit 16.
        unsafe { _mm256_madd_epi16(_mm256_maddubs_epi16(a, a), _mm256_set1_epi16(1)) }
    }

    #[inline(always)]
    unsafe fn project<const NARROW: bool>(
        basis: &Basis,
        window: &[u32],
        at: [usize; 4],
        offsets: &[i32; N * N],
    ) -> [Descriptor; 4] {
        // SAFETY: the window's bounds are the caller's promise, the loads stay inside the basis. Weights are at
        // most 63, so a pair of products is at most 2 · 255 · 63 < 2^15 and does not saturate.
        unsafe {
            let ones = _mm256_set1_epi16(1);
            let mut low = [_mm256_loadu_si256(basis.bias.as_ptr().cast()); 4];
            let mut high = [_mm256_loadu_si256(basis.bias.as_ptr().add(8).cast()); 4];
            for (weights, &offset) in basis.weights.iter().zip(offsets) {
                let weights: *const __m256i = weights.as_ptr().cast();
                let (first, second) = (_mm256_loadu_si256(weights), _mm256_loadu_si256(weights.add(1)));
                for i in 0..4 {
                    let texel = *window.get_unchecked(at[i].wrapping_add_signed(offset as isize));
                    let texel = _mm256_set1_epi32(texel as i32);
                    let a = _mm256_madd_epi16(_mm256_maddubs_epi16(texel, first), ones);
                    low[i] = _mm256_add_epi32(low[i], a);
                    if !NARROW {
                        let b = _mm256_madd_epi16(_mm256_maddubs_epi16(texel, second), ones);
                        high[i] = _mm256_add_epi32(high[i], b);
                    }
                }
            }
            let shift = _mm_cvtsi32_si128(basis.shift as i32);
            let mut out = [[0; 16]; 4];
            for i in 0..4 {
                let words =
                    _mm256_packs_epi32(_mm256_sra_epi32(low[i], shift), _mm256_sra_epi32(high[i], shift));
                store(_mm256_permute4x64_epi64::<0b11_01_10_00>(words), &mut out[i]);
            }
            out
        }
    }
}

impl Dot for Avx512 {
    #[inline(always)]
    unsafe fn squares(a: __m256i) -> __m256i {
        // SAFETY: callers have AVX-512 with VNNI.
        unsafe { _mm256_dpbusd_epi32(_mm256_setzero_si256(), a, a) }
    }

    #[inline(always)]
    unsafe fn project<const NARROW: bool>(
        basis: &Basis,
        window: &[u32],
        at: [usize; 4],
        offsets: &[i32; N * N],
    ) -> [Descriptor; 4] {
        // SAFETY: as for AVX2; a pixel's weights are 64 bytes.
        unsafe {
            if NARROW {
                return project_narrow_avx512(basis, window, at, offsets);
            }
            let mut sums = [_mm512_loadu_si512(basis.bias.as_ptr().cast()); 4];
            for (weights, &offset) in basis.weights.iter().zip(offsets) {
                let weights = _mm512_loadu_si512(weights.as_ptr().cast());
                for i in 0..4 {
                    let texel = *window.get_unchecked(at[i].wrapping_add_signed(offset as isize));
                    sums[i] = _mm512_dpbusd_epi32(sums[i], _mm512_set1_epi32(texel as i32), weights);
                }
            }
            let shift = _mm_cvtsi32_si128(basis.shift as i32);
            let mut out = [[0; 16]; 4];
            for i in 0..4 {
                store(_mm512_cvtsepi32_epi16(_mm512_sra_epi32(sums[i], shift)), &mut out[i]);
            }
            out
        }
    }
}

/// [`Dot::project`] with half the lanes.
#[inline(always)]
unsafe fn project_narrow_avx512(
    basis: &Basis,
    window: &[u32],
    at: [usize; 4],
    offsets: &[i32; N * N],
) -> [Descriptor; 4] {
    // SAFETY: as for all components.
    unsafe {
        let bias = _mm256_loadu_si256(basis.bias.as_ptr().cast());
        let mut sums = [bias; 4];
        for (weights, &offset) in basis.weights.iter().zip(offsets) {
            let weights = _mm256_loadu_si256(weights.as_ptr().cast());
            for i in 0..4 {
                let texel = *window.get_unchecked(at[i].wrapping_add_signed(offset as isize));
                sums[i] = _mm256_dpbusd_epi32(sums[i], _mm256_set1_epi32(texel as i32), weights);
            }
        }
        let shift = _mm_cvtsi32_si128(basis.shift as i32);
        let mut out = [[0; 16]; 4];
        for i in 0..4 {
            let words = _mm256_packs_epi32(_mm256_sra_epi32(sums[i], shift), _mm256_setzero_si256());
            store(_mm256_permute4x64_epi64::<0b11_01_10_00>(words), &mut out[i]);
        }
        out
    }
}

/// Clamps 16 words to 0 … 127 and packs them to bytes.
#[inline(always)]
unsafe fn store(words: __m256i, out: &mut Descriptor) {
    // SAFETY: callers have AVX2.
    unsafe {
        let bytes = _mm_packus_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256::<1>(words));
        _mm_storeu_si128(out.as_mut_ptr().cast(), _mm_min_epu8(bytes, _mm_set1_epi8(127)));
    }
}

/// Sizes of the differences of a descriptor, twice, to two others, which fit 7 bits as the entries do.
#[inline(always)]
unsafe fn sizes(query: __m256i, first: *const Record, second: *const Record) -> __m256i {
    // SAFETY: callers have AVX2 and the addresses of records.
    unsafe {
        let first = _mm_loadu_si128((*first).descriptor.as_ptr().cast());
        let second = _mm_loadu_si128((*second).descriptor.as_ptr().cast());
        _mm256_abs_epi8(_mm256_sub_epi8(query, _mm256_set_m128i(second, first)))
    }
}

/// A narrow descriptor and the usage weight.
#[inline(always)]
unsafe fn last_half(record: *const Record) -> __m128i {
    // SAFETY: the caller's promise; a record has 32 bytes.
    unsafe { _mm_loadu_si128(record.byte_add(8).cast()) }
}

/// The first and third number of both registers.
#[inline(always)]
unsafe fn even(a: __m128i, b: __m128i) -> __m128i {
    // SAFETY: SSE2 is always there on x86-64.
    unsafe { _mm_castps_si128(_mm_shuffle_ps::<0b10_00_10_00>(_mm_castsi128_ps(a), _mm_castsi128_ps(b))) }
}

/// Where a list equals word `K` of each four of another register.
#[inline(always)]
unsafe fn same<const K: i8>(list: __m256i, words: __m256i) -> __m256i {
    // SAFETY: callers have AVX2.
    unsafe {
        let order = _mm256_set1_epi16(i16::from(2 * K + 1) << 8 | i16::from(2 * K));
        _mm256_cmpeq_epi16(list, _mm256_shuffle_epi8(words, order))
    }
}

/// The columns and rows one step back from eight pixels.
#[inline(always)]
unsafe fn step_back(pixels: __m128i, du: i16, dv: i16, edges: &Edges) -> (__m128i, __m128i) {
    // SAFETY: SSE4.1 comes with AVX2.
    unsafe {
        let mut x = _mm_sub_epi16(_mm_and_si128(pixels, _mm_set1_epi16(255)), _mm_set1_epi16(du));
        let mut y = _mm_sub_epi16(_mm_srli_epi16::<8>(pixels), _mm_set1_epi16(dv));
        if let Some([w, h]) = edges.around {
            // One step at most beyond an edge: add the size below 0, subtract it above the last.
            let (wide, high) = (_mm_set1_epi16(w), _mm_set1_epi16(h));
            let below = _mm_and_si128(wide, _mm_srai_epi16::<15>(x));
            let above = _mm_and_si128(wide, _mm_cmpgt_epi16(x, _mm_set1_epi16(w - 1)));
            x = _mm_sub_epi16(_mm_add_epi16(x, below), above);
            let below = _mm_and_si128(high, _mm_srai_epi16::<15>(y));
            let above = _mm_and_si128(high, _mm_cmpgt_epi16(y, _mm_set1_epi16(h - 1)));
            y = _mm_sub_epi16(_mm_add_epi16(y, below), above);
        } else {
            let [x0, x1, y0, y1] = edges.bounds;
            x = _mm_min_epi16(_mm_max_epi16(x, _mm_set1_epi16(x0)), _mm_set1_epi16(x1));
            y = _mm_min_epi16(_mm_max_epi16(y, _mm_set1_epi16(y0)), _mm_set1_epi16(y1));
        }
        (x, y)
    }
}

/// Rows to columns.
#[inline(always)]
unsafe fn transpose(rows: [__m128i; 8]) -> [__m128i; 8] {
    // SAFETY: SSE2 is always there on x86-64.
    unsafe {
        let [a, b, c, d, e, f, g, h] = rows;
        let (ab0, ab1) = (_mm_unpacklo_epi16(a, b), _mm_unpackhi_epi16(a, b));
        let (cd0, cd1) = (_mm_unpacklo_epi16(c, d), _mm_unpackhi_epi16(c, d));
        let (ef0, ef1) = (_mm_unpacklo_epi16(e, f), _mm_unpackhi_epi16(e, f));
        let (gh0, gh1) = (_mm_unpacklo_epi16(g, h), _mm_unpackhi_epi16(g, h));
        let (ad0, ad1) = (_mm_unpacklo_epi32(ab0, cd0), _mm_unpackhi_epi32(ab0, cd0));
        let (ad2, ad3) = (_mm_unpacklo_epi32(ab1, cd1), _mm_unpackhi_epi32(ab1, cd1));
        let (eh0, eh1) = (_mm_unpacklo_epi32(ef0, gh0), _mm_unpackhi_epi32(ef0, gh0));
        let (eh2, eh3) = (_mm_unpacklo_epi32(ef1, gh1), _mm_unpackhi_epi32(ef1, gh1));
        [
            _mm_unpacklo_epi64(ad0, eh0),
            _mm_unpackhi_epi64(ad0, eh0),
            _mm_unpacklo_epi64(ad1, eh1),
            _mm_unpackhi_epi64(ad1, eh1),
            _mm_unpacklo_epi64(ad2, eh2),
            _mm_unpackhi_epi64(ad2, eh2),
            _mm_unpacklo_epi64(ad3, eh3),
            _mm_unpackhi_epi64(ad3, eh3),
        ]
    }
}

// SAFETY: callers have the instruction sets.
unsafe impl<D: Dot> Operations for D {
    type Four = __m128i;

    #[inline(always)]
    unsafe fn project<const NARROW: bool>(
        basis: &Basis,
        window: &[u32],
        at: [usize; 4],
        offsets: &[i32; N * N],
    ) -> [Descriptor; 4] {
        // SAFETY: the caller's promise.
        unsafe { <D as Dot>::project::<NARROW>(basis, window, at, offsets) }
    }

    #[inline(always)]
    unsafe fn continue_row(
        pixels: &[Pixel],
        at: usize,
        offsets: &[i32; AROUND],
        tables: &ViewTables,
        similar: usize,
        row: &mut Row,
        continuing: &mut [[Pixel; 16]; 8],
    ) {
        // SAFETY: the caller's promise; eight voxels along x lie in the window wherever the first does.
        unsafe {
            let zero = _mm_setzero_si128();
            let (width, similar) = (_mm_set1_epi16(tables.view.width as i16), _mm_set1_epi16(similar as i16));
            let mut found = [zero; AROUND];
            for k in 0..AROUND {
                let from = pixels.as_ptr().add(at.wrapping_add_signed(offsets[k] as isize));
                let (x, y) = step_back(_mm_loadu_si128(from.cast()), DU[k], DV[k], &tables.edges);
                let index = _mm_add_epi16(_mm_mullo_epi16(y, width), x);
                _mm_storeu_si128(row.index[k].as_mut_ptr().cast(), index);
                let pixel = _mm_or_si128(x, _mm_slli_epi16::<8>(y));
                let mut repeated = zero;
                for earlier in found.iter().take(k) {
                    repeated = _mm_or_si128(repeated, _mm_cmpeq_epi16(*earlier, pixel));
                }
                found[k] = pixel;
                let advance = _mm_andnot_si128(repeated, similar);
                _mm_storeu_si128(row.advance[k].as_mut_ptr().cast(), advance);
            }
            let [a, b, c, d, e, f, g, h, last] = found;
            let columns = transpose([a, b, c, d, e, f, g, h]);
            let lasts = transpose([last; 8]);
            for i in 0..8 {
                let to: *mut __m128i = continuing[i].as_mut_ptr().cast();
                _mm_storeu_si128(to, columns[i]);
                _mm_storeu_si128(to.add(1), lasts[i]);
            }
        }
    }

    #[inline(always)]
    unsafe fn costs<const NARROW: bool>(
        tables: &ViewTables,
        descriptor: &Descriptor,
        continuing: &[Pixel; 16],
        pixels: u64,
        incoherent: i32,
    ) -> __m128i {
        // SAFETY: the caller's promise.
        unsafe {
            // The bytes of a pixel as two words, times the bytes to the next record along x and y.
            let step = size_of::<Record>() as i32;
            let steps = _mm_set1_epi32((tables.view.width * step) << 16 | step);
            let at = _mm_madd_epi16(_mm_cvtepu8_epi16(_mm_cvtsi64_si128(pixels as i64)), steps);
            let (low, high) = (_mm_cvtsi128_si64(at) as u64, _mm_extract_epi64::<1>(at) as u64);
            let records = tables.records.as_ptr();
            let at = [
                records.byte_add((low & 0xffff_ffff) as usize),
                records.byte_add((low >> 32) as usize),
                records.byte_add((high & 0xffff_ffff) as usize),
                records.byte_add((high >> 32) as usize),
            ];
            let (distances, usage) = if NARROW {
                let [a, b, c, d] = [last_half(at[0]), last_half(at[1]), last_half(at[2]), last_half(at[3])];
                let query = _mm256_set1_epi64x(descriptor.as_ptr().cast::<i64>().read_unaligned());
                let others = _mm256_set_m128i(_mm_unpacklo_epi64(c, d), _mm_unpacklo_epi64(a, b));
                let squares = D::squares(_mm256_abs_epi8(_mm256_sub_epi8(query, others)));
                let sums = _mm256_add_epi32(squares, _mm256_srli_epi64::<32>(squares));
                (
                    even(_mm256_castsi256_si128(sums), _mm256_extracti128_si256::<1>(sums)),
                    even(_mm_unpackhi_epi64(a, b), _mm_unpackhi_epi64(c, d)),
                )
            } else {
                let query = _mm256_broadcastsi128_si256(_mm_loadu_si128(descriptor.as_ptr().cast()));
                let first = D::squares(sizes(query, at[0], at[1]));
                let second = D::squares(sizes(query, at[2], at[3]));
                let sums = _mm256_hadd_epi32(first, second);
                let sums = _mm256_hadd_epi32(sums, sums);
                (
                    _mm_unpacklo_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256::<1>(sums)),
                    _mm_set_epi32((*at[3]).usage, (*at[2]).usage, (*at[1]).usage, (*at[0]).usage),
                )
            };

            let continuing = _mm256_loadu_si256(continuing.as_ptr().cast());
            let pixels = _mm256_set1_epi64x(pixels as i64);
            let pair = _mm256_packs_epi16(same::<0>(continuing, pixels), same::<1>(continuing, pixels));
            let other = _mm256_packs_epi16(same::<2>(continuing, pixels), same::<3>(continuing, pixels));
            // Pairs of bytes as words: packed once more they stay 0 where both are 0, and only there.
            let all = _mm256_packs_epi16(pair, other);
            let all = _mm_or_si128(_mm256_castsi256_si128(all), _mm256_extracti128_si256::<1>(all));
            let none = _mm_cmpeq_epi32(all, _mm_setzero_si128());
            // distance · incoherent / 256 is the distance and what is beyond it, exactly.
            let more = _mm_srai_epi32::<8>(_mm_mullo_epi32(distances, _mm_set1_epi32(incoherent - 256)));
            _mm_add_epi32(_mm_add_epi32(distances, usage), _mm_and_si128(none, more))
        }
    }

    #[inline(always)]
    unsafe fn pairs(sets: [&[Triple; 2]; 3]) -> [u64; 3] {
        // SAFETY: callers have AVX2; two triples are 16 bytes.
        unsafe {
            // Both next pixels, then both last.
            let order = _mm_setr_epi8(0, 1, 8, 9, 2, 3, 10, 11, -1, -1, -1, -1, -1, -1, -1, -1);
            let mut pixels = [0; 3];
            for e in 0..3 {
                let set = _mm_loadu_si128(sets[e].as_ptr().cast());
                pixels[e] = _mm_cvtsi128_si64(_mm_shuffle_epi8(set, order)) as u64;
            }
            let low = 0xffff_ffff;
            [
                pixels[2] & low | pixels[1] & !low,
                pixels[0] & low | pixels[2] & !low,
                pixels[1] & low | pixels[0] & !low,
            ]
        }
    }

    #[inline(always)]
    unsafe fn sums(sets: [&[Triple; 2]; 3], factor: u32, own: [i32; 3], costs: [__m128i; 3]) -> [__m128i; 2] {
        // SAFETY: as above; a crossbar error is the upper half of a triple.
        unsafe {
            let factor = _mm_set1_epi64x(i64::from(factor));
            let mut crossbars = [_mm_setzero_si128(); 3];
            for e in 0..3 {
                let set = _mm_srli_epi64::<32>(_mm_loadu_si128(sets[e].as_ptr().cast()));
                let weighed = _mm_srli_epi64::<24>(_mm_mul_epu32(set, factor));
                let own = _mm_set1_epi32(own[e]);
                crossbars[e] = _mm_add_epi32(_mm_shuffle_epi32::<0b00_00_10_00>(weighed), own);
            }
            let first = _mm_add_epi32(costs[1], _mm_unpackhi_epi64(costs[2], costs[2]));
            let first = _mm_add_epi32(first, crossbars[0]);
            let nexts = _mm_unpacklo_epi64(costs[2], costs[0]);
            let lasts = _mm_unpackhi_epi64(costs[0], costs[1]);
            let others = _mm_unpacklo_epi64(crossbars[1], crossbars[2]);
            [
                _mm_unpacklo_epi64(_mm_set1_epi32(i32::MAX), first),
                _mm_add_epi32(others, _mm_add_epi32(nexts, lasts)),
            ]
        }
    }

    #[inline(always)]
    unsafe fn load(numbers: &[i32; 4]) -> __m128i {
        // SAFETY: four numbers are 16 bytes.
        unsafe { _mm_loadu_si128(numbers.as_ptr().cast()) }
    }

    #[inline(always)]
    unsafe fn all(number: i32) -> __m128i {
        // SAFETY: callers have AVX2.
        unsafe { _mm_set1_epi32(number) }
    }

    #[inline(always)]
    unsafe fn scale(numbers: __m128i, plus: [i32; 4]) -> __m128i {
        // SAFETY: callers have AVX2.
        unsafe { _mm_add_epi32(_mm_slli_epi32::<2>(numbers), _mm_loadu_si128(plus.as_ptr().cast())) }
    }

    #[inline(always)]
    unsafe fn only_even(costs: __m128i) -> __m128i {
        // SAFETY: callers have AVX2.
        unsafe { _mm_blend_epi16::<0b1100_1100>(costs, _mm_set1_epi32(i32::MAX)) }
    }

    #[inline(always)]
    unsafe fn least(costs: __m128i, tags: __m128i) -> (i32, u32) {
        // SAFETY: callers have AVX2.
        unsafe {
            let least = _mm_min_epi32(costs, _mm_shuffle_epi32::<0b10_11_00_01>(costs));
            let least = _mm_min_epi32(least, _mm_shuffle_epi32::<0b01_00_11_10>(least));
            // All ones in place of the tags of greater costs.
            let greater = _mm_cmpgt_epi32(costs, least);
            let tags = _mm_or_si128(tags, greater);
            let first = _mm_min_epu32(tags, _mm_shuffle_epi32::<0b10_11_00_01>(tags));
            let first = _mm_min_epu32(first, _mm_shuffle_epi32::<0b01_00_11_10>(first));
            (_mm_cvtsi128_si32(least), _mm_cvtsi128_si32(first) as u32)
        }
    }

    #[inline(always)]
    unsafe fn keep_less(costs: &mut [i32; 4], tags: &mut [i32; 4], new: __m128i, new_tags: __m128i) {
        // SAFETY: callers have AVX2.
        unsafe {
            let (to, to_tags): (*mut __m128i, *mut __m128i) =
                (costs.as_mut_ptr().cast(), tags.as_mut_ptr().cast());
            let (old, old_tags) = (_mm_loadu_si128(to), _mm_loadu_si128(to_tags));
            let less = _mm_cmpgt_epi32(old, new);
            _mm_storeu_si128(to, _mm_min_epi32(old, new));
            _mm_storeu_si128(to_tags, _mm_blendv_epi8(old_tags, new_tags, less));
        }
    }

    #[inline(always)]
    unsafe fn strips(a: &Strip, b: &Strip) -> i32 {
        // SAFETY: a strip has 32 bytes, zero after the twentieth.
        unsafe {
            let (a, b): (*const __m128i, *const __m128i) = (a.as_ptr().cast(), b.as_ptr().cast());
            let low = _mm256_sub_epi16(
                _mm256_cvtepu8_epi16(_mm_loadu_si128(a)),
                _mm256_cvtepu8_epi16(_mm_loadu_si128(b)),
            );
            let high = _mm_sub_epi16(
                _mm_cvtepu8_epi16(_mm_loadu_si64(a.add(1).cast())),
                _mm_cvtepu8_epi16(_mm_loadu_si64(b.add(1).cast())),
            );
            let low = _mm256_madd_epi16(low, low);
            let low = _mm_add_epi32(_mm256_castsi256_si128(low), _mm256_extracti128_si256::<1>(low));
            let sums = _mm_add_epi32(low, _mm_madd_epi16(high, high));
            let sums = _mm_add_epi32(sums, _mm_shuffle_epi32::<0b01_00_11_10>(sums));
            let sums = _mm_add_epi32(sums, _mm_shuffle_epi32::<0b10_11_00_01>(sums));
            _mm_cvtsi128_si32(sums)
        }
    }

    #[inline(always)]
    unsafe fn nearest_color(colors: [[u8; 4]; 3], color: &OneColor) -> usize {
        // SAFETY: callers have AVX2. All numbers are at most 3 · 255 · 3 from zero.
        unsafe {
            let [a, b, c] = colors.map(u32::from_le_bytes);
            let packed = _mm_cvtsi64_si128((u64::from(b) << 32 | u64::from(a)) as i64);
            let both = _mm_cvtepu8_epi16(packed);
            let third = _mm_cvtepu8_epi16(_mm_cvtsi32_si128(c as i32));
            let sum = _mm_add_epi16(_mm_add_epi16(both, _mm_unpackhi_epi64(both, both)), third);
            let beyond = _mm_sub_epi16(sum, _mm_loadu_si64(color.middle.as_ptr().cast()));
            // The product's upper half, rounded: (beyond · stretch + 128) / 256.
            let beyond = _mm_mulhrs_epi16(beyond, _mm_set1_epi16(color.stretch << 7));
            let sum = _mm_add_epi16(sum, beyond);
            let sum = _mm_unpacklo_epi64(sum, sum);
            let three = _mm_set1_epi16(3);
            let both = _mm_sub_epi16(_mm_mullo_epi16(both, three), sum);
            let third = _mm_sub_epi16(_mm_mullo_epi16(third, three), sum);
            let third = _mm_move_epi64(third);
            let gaps = _mm_hadd_epi32(_mm_madd_epi16(both, both), _mm_madd_epi16(third, third));
            let gaps = [_mm_cvtsi128_si32(gaps), _mm_extract_epi32::<1>(gaps), _mm_extract_epi32::<2>(gaps)];
            first_least(gaps)
        }
    }
}
