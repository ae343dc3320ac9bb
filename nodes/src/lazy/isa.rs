//! The operations that decide the speed of a correction, for each instruction set. All of them are exact
//! integer arithmetic, so every set gives the same bits.

use super::basis::{Basis, DIMS, Descriptor};
use super::pyramid::{N, Pixel};

/// An instruction set to run a correction with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isa {
    /// Whatever the target offers at compile time.
    Portable,
    /// AVX2.
    Avx2,
    /// AVX-512 with VNNI.
    Avx512,
}

/// The instruction sets that this machine has, slowest first.
pub fn available() -> Vec<Isa> {
    let mut sets = vec![Isa::Portable];
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        if has!("avx2") {
            sets.push(Isa::Avx2);
        }
        if has!("avx512f") && has!("avx512bw") && has!("avx512vl") && has!("avx512vnni") && has!("avx2") {
            sets.push(Isa::Avx512);
        }
    }
    sets
}

/// The operations. `at` is the centre's index in the window, `offsets` lead from it to the 25 pixels.
///
/// # Safety
/// The processor must have the instruction set; `at + offset` must lie in the window.
pub(super) unsafe trait Operations: Copy {
    /// [`Basis::project`] of a neighbourhood gathered from a window.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn project(basis: &Basis, window: &[u32], at: usize, offsets: &[i32; N * N]) -> Descriptor;

    /// The squared distances of `a` to `others[0..2]`, and of `b` to `others[2..4]`.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn distances(a: &Descriptor, b: &Descriptor, others: [&Descriptor; 4]) -> [i32; 4];

    /// The places of a pixel in a list, as bits, two a place.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn places(list: &[Pixel; 16], pixel: Pixel) -> u32;

    /// The pixels one step back from each of sixteen, at the edges as `edges` says.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn step_back(pixels: &[Pixel; 16], edges: &Edges) -> [Pixel; 16];
}

/// What lies beyond the edges of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edges {
    /// Width and height, if the picture continues at the opposite edge.
    pub around: Option<[i16; 2]>,
    /// First and last column, first and last row that can be reached; steps beyond them stay there.
    pub bounds: [i16; 4],
}

/// Steps along the columns' axis to the nine neighbours; the rest fills a vector.
pub(super) const DU: [i16; 16] = [-1, 0, 1, -1, 0, 1, -1, 0, 1, 0, 0, 0, 0, 0, 0, 0];
/// Steps along the rows' axis.
pub(super) const DV: [i16; 16] = [-1, -1, -1, 0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0];

#[derive(Clone, Copy)]
pub(super) struct Portable;

// SAFETY: only safe operations.
unsafe impl Operations for Portable {
    #[inline(always)]
    unsafe fn project(basis: &Basis, window: &[u32], at: usize, offsets: &[i32; N * N]) -> Descriptor {
        basis.project(&offsets.map(|offset| window[at.wrapping_add_signed(offset as isize)].to_le_bytes()))
    }

    #[inline(always)]
    unsafe fn distances(a: &Descriptor, b: &Descriptor, others: [&Descriptor; 4]) -> [i32; 4] {
        let mut sums = [0; 4];
        for (i, (sum, other)) in sums.iter_mut().zip(others).enumerate() {
            let query = if i < 2 { a } else { b };
            for d in 0..DIMS {
                let difference = i16::from(query[d]) - i16::from(other[d]);
                *sum += i32::from(difference) * i32::from(difference);
            }
        }
        sums
    }

    #[inline(always)]
    unsafe fn places(list: &[Pixel; 16], pixel: Pixel) -> u32 {
        list.iter().enumerate().fold(0, |bits, (k, &p)| if p == pixel { bits | 3 << (2 * k) } else { bits })
    }

    #[inline(always)]
    unsafe fn step_back(pixels: &[Pixel; 16], edges: &Edges) -> [Pixel; 16] {
        let [x0, x1, y0, y1] = edges.bounds;
        std::array::from_fn(|k| {
            let (x, y) = ((pixels[k] & 255) as i16 - DU[k], (pixels[k] >> 8) as i16 - DV[k]);
            let (x, y) = match edges.around {
                Some([w, h]) => (x.rem_euclid(w), y.rem_euclid(h)),
                None => (x.clamp(x0, x1), y.clamp(y0, y1)),
            };
            (x | y << 8) as Pixel
        })
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use x86::{Avx2, Avx512};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::{Basis, DU, DV, Descriptor, Edges, N, Operations, Pixel};

    /// Sizes of the differences of two descriptors to two others, which fit 7 bits as the entries do.
    #[inline(always)]
    unsafe fn sizes(query: __m256i, first: &Descriptor, second: &Descriptor) -> __m256i {
        // SAFETY: descriptors are 16 bytes; callers have AVX2.
        unsafe {
            let first = _mm_loadu_si128(first.as_ptr().cast());
            let second = _mm_loadu_si128(second.as_ptr().cast());
            _mm256_abs_epi8(_mm256_sub_epi8(query, _mm256_set_m128i(second, first)))
        }
    }

    /// A descriptor in both halves of a register.
    #[inline(always)]
    unsafe fn twice(descriptor: &Descriptor) -> __m256i {
        // SAFETY: as above.
        unsafe { _mm256_broadcastsi128_si256(_mm_loadu_si128(descriptor.as_ptr().cast())) }
    }

    /// The sums of the four quarters of two registers.
    #[inline(always)]
    unsafe fn sum_halves(a: __m256i, b: __m256i) -> [i32; 4] {
        // SAFETY: as above.
        unsafe {
            let pairs = _mm256_hadd_epi32(a, b);
            let sums = _mm256_hadd_epi32(pairs, pairs);
            let low = _mm_cvtsi128_si64(_mm256_castsi256_si128(sums));
            let high = _mm_cvtsi128_si64(_mm256_extracti128_si256::<1>(sums));
            [low as i32, high as i32, (low >> 32) as i32, (high >> 32) as i32]
        }
    }

    /// [`Operations::step_back`] in one register.
    #[inline(always)]
    unsafe fn step_back_256(pixels: &[Pixel; 16], edges: &Edges) -> [Pixel; 16] {
        // SAFETY: as above.
        unsafe {
            let pixels = _mm256_loadu_si256(pixels.as_ptr().cast());
            let du = _mm256_loadu_si256(DU.as_ptr().cast());
            let dv = _mm256_loadu_si256(DV.as_ptr().cast());
            let mut x = _mm256_sub_epi16(_mm256_and_si256(pixels, _mm256_set1_epi16(255)), du);
            let mut y = _mm256_sub_epi16(_mm256_srli_epi16::<8>(pixels), dv);
            if let Some([w, h]) = edges.around {
                // One step at most beyond an edge: add the size below 0, subtract it above the last.
                let (w, h) = (_mm256_set1_epi16(w), _mm256_set1_epi16(h));
                let one = _mm256_set1_epi16(1);
                let low = _mm256_and_si256(w, _mm256_srai_epi16::<15>(x));
                let high = _mm256_and_si256(w, _mm256_cmpgt_epi16(x, _mm256_sub_epi16(w, one)));
                x = _mm256_sub_epi16(_mm256_add_epi16(x, low), high);
                let low = _mm256_and_si256(h, _mm256_srai_epi16::<15>(y));
                let high = _mm256_and_si256(h, _mm256_cmpgt_epi16(y, _mm256_sub_epi16(h, one)));
                y = _mm256_sub_epi16(_mm256_add_epi16(y, low), high);
            } else {
                let [x0, x1, y0, y1] = edges.bounds;
                x = _mm256_min_epi16(_mm256_max_epi16(x, _mm256_set1_epi16(x0)), _mm256_set1_epi16(x1));
                y = _mm256_min_epi16(_mm256_max_epi16(y, _mm256_set1_epi16(y0)), _mm256_set1_epi16(y1));
            }
            let mut out = [0; 16];
            _mm256_storeu_si256(out.as_mut_ptr().cast(), _mm256_or_si256(x, _mm256_slli_epi16::<8>(y)));
            out
        }
    }

    #[derive(Clone, Copy)]
    pub(in super::super) struct Avx2;

    // SAFETY: callers have AVX2.
    unsafe impl Operations for Avx2 {
        #[inline(always)]
        unsafe fn project(basis: &Basis, window: &[u32], at: usize, offsets: &[i32; N * N]) -> Descriptor {
            // SAFETY: the window's bounds are the caller's promise, the loads stay inside the basis. Weights are
            // at most 63, so a pair of products is at most 2 · 255 · 63 < 2^15 and does not saturate.
            unsafe {
                let ones = _mm256_set1_epi16(1);
                let mut low = _mm256_loadu_si256(basis.bias.as_ptr().cast());
                let mut high = _mm256_loadu_si256(basis.bias.as_ptr().add(8).cast());
                for (weights, &offset) in basis.weights.iter().zip(offsets) {
                    let texel = *window.get_unchecked(at.wrapping_add_signed(offset as isize));
                    let texel = _mm256_set1_epi32(texel as i32);
                    let weights: *const __m256i = weights.as_ptr().cast();
                    let a = _mm256_maddubs_epi16(texel, _mm256_loadu_si256(weights));
                    let b = _mm256_maddubs_epi16(texel, _mm256_loadu_si256(weights.add(1)));
                    low = _mm256_add_epi32(low, _mm256_madd_epi16(a, ones));
                    high = _mm256_add_epi32(high, _mm256_madd_epi16(b, ones));
                }
                let shift = _mm_cvtsi32_si128(basis.shift as i32);
                let packed = _mm256_packs_epi32(_mm256_sra_epi32(low, shift), _mm256_sra_epi32(high, shift));
                let packed = _mm256_permute4x64_epi64::<0b11_01_10_00>(packed);
                finish(_mm256_castsi256_si128(packed), _mm256_extracti128_si256::<1>(packed))
            }
        }

        #[inline(always)]
        unsafe fn distances(a: &Descriptor, b: &Descriptor, others: [&Descriptor; 4]) -> [i32; 4] {
            // SAFETY: as the trait. Two squares of 7 bits fit i16.
            unsafe {
                let ones = _mm256_set1_epi16(1);
                let a = sizes(twice(a), others[0], others[1]);
                let b = sizes(twice(b), others[2], others[3]);
                let a = _mm256_madd_epi16(_mm256_maddubs_epi16(a, a), ones);
                sum_halves(a, _mm256_madd_epi16(_mm256_maddubs_epi16(b, b), ones))
            }
        }

        #[inline(always)]
        unsafe fn places(list: &[Pixel; 16], pixel: Pixel) -> u32 {
            // SAFETY: as the trait.
            unsafe {
                let list = _mm256_loadu_si256(list.as_ptr().cast());
                _mm256_movemask_epi8(_mm256_cmpeq_epi16(list, _mm256_set1_epi16(pixel as i16))) as u32
            }
        }

        #[inline(always)]
        unsafe fn step_back(pixels: &[Pixel; 16], edges: &Edges) -> [Pixel; 16] {
            // SAFETY: as the trait.
            unsafe { step_back_256(pixels, edges) }
        }
    }

    /// Clamps 16 words to 0 … 127 and packs them to bytes.
    #[inline(always)]
    unsafe fn finish(low: __m128i, high: __m128i) -> Descriptor {
        // SAFETY: SSE2 is always there on x86-64.
        unsafe {
            let bytes = _mm_min_epu8(_mm_packus_epi16(low, high), _mm_set1_epi8(127));
            let mut out = [0; 16];
            _mm_storeu_si128(out.as_mut_ptr().cast(), bytes);
            out
        }
    }

    #[derive(Clone, Copy)]
    pub(in super::super) struct Avx512;

    // SAFETY: callers have AVX-512 F, BW, VL and VNNI.
    unsafe impl Operations for Avx512 {
        #[inline(always)]
        unsafe fn project(basis: &Basis, window: &[u32], at: usize, offsets: &[i32; N * N]) -> Descriptor {
            // SAFETY: as for AVX2; a pixel's weights are 64 bytes.
            unsafe {
                let mut even = _mm512_loadu_si512(basis.bias.as_ptr().cast());
                let mut odd = _mm512_setzero_si512();
                let weights: *const __m512i = basis.weights.as_ptr().cast();
                // Two sums, so that one product need not wait for the other. No closures: they would be compiled
                // without the instruction set.
                let mut k = 0;
                while k < N * N {
                    let texel = *window.get_unchecked(at.wrapping_add_signed(offsets[k] as isize));
                    let texel = _mm512_set1_epi32(texel as i32);
                    even = _mm512_dpbusd_epi32(even, texel, _mm512_loadu_si512(weights.add(k)));
                    k += 1;
                    if k < N * N {
                        let texel = *window.get_unchecked(at.wrapping_add_signed(offsets[k] as isize));
                        let texel = _mm512_set1_epi32(texel as i32);
                        odd = _mm512_dpbusd_epi32(odd, texel, _mm512_loadu_si512(weights.add(k)));
                        k += 1;
                    }
                }
                let sums =
                    _mm512_sra_epi32(_mm512_add_epi32(even, odd), _mm_cvtsi32_si128(basis.shift as i32));
                let words = _mm512_cvtsepi32_epi16(sums);
                finish(_mm256_castsi256_si128(words), _mm256_extracti128_si256::<1>(words))
            }
        }

        #[inline(always)]
        unsafe fn distances(a: &Descriptor, b: &Descriptor, others: [&Descriptor; 4]) -> [i32; 4] {
            // SAFETY: as the trait.
            unsafe {
                let zero = _mm256_setzero_si256();
                let a = sizes(twice(a), others[0], others[1]);
                let b = sizes(twice(b), others[2], others[3]);
                sum_halves(_mm256_dpbusd_epi32(zero, a, a), _mm256_dpbusd_epi32(zero, b, b))
            }
        }

        #[inline(always)]
        unsafe fn places(list: &[Pixel; 16], pixel: Pixel) -> u32 {
            // SAFETY: as the trait.
            unsafe {
                let list = _mm256_loadu_si256(list.as_ptr().cast());
                _mm256_movemask_epi8(_mm256_cmpeq_epi16(list, _mm256_set1_epi16(pixel as i16))) as u32
            }
        }

        #[inline(always)]
        unsafe fn step_back(pixels: &[Pixel; 16], edges: &Edges) -> [Pixel; 16] {
            // SAFETY: as the trait.
            unsafe { step_back_256(pixels, edges) }
        }
    }
}
