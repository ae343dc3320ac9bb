//! The two operations that decide the speed of a correction, for each instruction set. All of them are exact
//! integer arithmetic, so every set gives the same bits.

use super::basis::{Basis, DIMS, Descriptor};
use super::pyramid::N;

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

    /// The squared distance of two descriptors.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn distance(a: &Descriptor, b: &Descriptor) -> i32;
}

#[derive(Clone, Copy)]
pub(super) struct Portable;

// SAFETY: only safe operations.
unsafe impl Operations for Portable {
    #[inline(always)]
    unsafe fn project(basis: &Basis, window: &[u32], at: usize, offsets: &[i32; N * N]) -> Descriptor {
        basis.project(&offsets.map(|offset| window[at.wrapping_add_signed(offset as isize)].to_le_bytes()))
    }

    #[inline(always)]
    unsafe fn distance(a: &Descriptor, b: &Descriptor) -> i32 {
        let mut sum = 0;
        for d in 0..DIMS {
            let difference = i16::from(a[d]) - i16::from(b[d]);
            sum += i32::from(difference) * i32::from(difference);
        }
        sum
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use x86::{Avx2, Avx512};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::{Basis, Descriptor, N, Operations};

    /// Squared distance in one 128-bit register: entries are 7 bits, so their differences fit i8 and the sum of
    /// two squares fits i16.
    #[inline(always)]
    unsafe fn distance_128(a: &Descriptor, b: &Descriptor) -> i32 {
        // SAFETY: descriptors are 16 bytes; callers have SSSE3, which AVX2 implies.
        unsafe {
            let a = _mm_loadu_si128(a.as_ptr().cast());
            let b = _mm_loadu_si128(b.as_ptr().cast());
            let size = _mm_abs_epi8(_mm_sub_epi8(a, b));
            let pairs = _mm_maddubs_epi16(size, size);
            let sums = _mm_madd_epi16(pairs, _mm_set1_epi16(1));
            let sums = _mm_add_epi32(sums, _mm_shuffle_epi32::<0b01_00_11_10>(sums));
            let sums = _mm_add_epi32(sums, _mm_shuffle_epi32::<0b10_11_00_01>(sums));
            _mm_cvtsi128_si32(sums)
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
        unsafe fn distance(a: &Descriptor, b: &Descriptor) -> i32 {
            // SAFETY: as the trait.
            unsafe { distance_128(a, b) }
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
        unsafe fn distance(a: &Descriptor, b: &Descriptor) -> i32 {
            // SAFETY: as the trait.
            unsafe { distance_128(a, b) }
        }
    }
}
