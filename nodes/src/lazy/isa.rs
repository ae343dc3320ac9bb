//! The operations that decide the speed of a correction, for each instruction set. All of them are exact
//! integer arithmetic, so every set gives the same bits.

use super::basis::{Basis, DIMS, Descriptor};
use super::candidates::{Strip, Triple};
use super::color::OneColor;
use super::kernel::{AROUND, Row};
use super::pyramid::{N, Pixel};
use super::tables::ViewTables;

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
        if has!("avx2") && has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt") {
            sets.push(Isa::Avx2);
            if has!("avx512f") && has!("avx512bw") && has!("avx512vl") && has!("avx512vnni") {
                sets.push(Isa::Avx512);
            }
        }
    }
    sets
}

/// The operations; `NARROW` says that no descriptor has more than eight components. Pixels come in fours, packed into 64 bits, the first lowest; costs in fours of 32 bits.
///
/// # Safety
/// The processor must have the instruction set; indices of a window plus the offsets must lie in it; pixels must
/// be pixels of the view that the tables belong to.
pub(super) unsafe trait Operations: Copy {
    /// Four costs or tags.
    type Four: Copy;

    /// [`Basis::project`] of four neighbourhoods gathered from a window.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn project<const NARROW: bool>(
        basis: &Basis,
        window: &[u32],
        at: [usize; 4],
        offsets: &[i32; N * N],
    ) -> [Descriptor; 4];

    /// For each of eight voxels along x, from `at` on, the pixels that continue its nine neighbours, at the edges
    /// as the view says, filled up with the last; and what `row` holds of them, each first of its kind adding
    /// `similar` candidates.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn continue_row(
        pixels: &[Pixel],
        at: usize,
        offsets: &[i32; AROUND],
        tables: &ViewTables,
        similar: usize,
        row: &mut Row,
        continuing: &mut [[Pixel; 16]; 8],
    );

    /// The costs of four pixels: the distance of their descriptors, times `incoherent` / 256 where they are none of
    /// `continuing`, plus their usage weights.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn costs<const NARROW: bool>(
        tables: &ViewTables,
        descriptor: &Descriptor,
        continuing: &[Pixel; 16],
        pixels: u64,
        incoherent: i32,
    ) -> Self::Four;

    /// For each direction the pixels of two triples of each other direction's set, as their next and their last.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn pairs(sets: [&[Triple; 2]; 3]) -> [u64; 3];

    /// The costs of two triples of each direction: `own`, the costs of the pixels of [`Operations::pairs`], and the
    /// crossbar errors times `factor` / 2^24. The first two are the largest number.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn sums(
        sets: [&[Triple; 2]; 3],
        factor: u32,
        own: [i32; 3],
        costs: [Self::Four; 3],
    ) -> [Self::Four; 2];

    /// Four numbers.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn load(numbers: &[i32; 4]) -> Self::Four;

    /// One number, four times.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn all(number: i32) -> Self::Four;

    /// Four times the numbers, plus others.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn scale(numbers: Self::Four, plus: [i32; 4]) -> Self::Four;

    /// The first and third of costs, and the largest number in place of the others.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn only_even(costs: Self::Four) -> Self::Four;

    /// The least of four costs and its tag, the smallest of equals.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn least(costs: Self::Four, tags: Self::Four) -> (i32, u32);

    /// Replaces costs and their tags where the new costs are less.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn keep_less(costs: &mut [i32; 4], tags: &mut [i32; 4], new: Self::Four, new_tags: Self::Four);

    /// The squared difference of two strips.
    ///
    /// # Safety
    /// See the trait.
    unsafe fn strips(a: &Strip, b: &Strip) -> i32;

    /// [`OneColor::nearest`].
    ///
    /// # Safety
    /// See the trait.
    unsafe fn nearest_color(colors: [[u8; 4]; 3], color: &OneColor) -> usize;
}

/// What lies beyond the edges of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edges {
    /// Width and height, if the picture continues at the opposite edge.
    pub around: Option<[i16; 2]>,
    /// First and last column, first and last row that can be reached; steps beyond them stay there.
    pub bounds: [i16; 4],
}

/// Steps along the columns' axis to the nine neighbours.
pub(super) const DU: [i16; AROUND] = [-1, 0, 1, -1, 0, 1, -1, 0, 1];
/// Steps along the rows' axis.
pub(super) const DV: [i16; AROUND] = [-1, -1, -1, 0, 0, 0, 1, 1, 1];

#[derive(Clone, Copy)]
pub(super) struct Portable;

#[inline(always)]
fn unpack(pixels: u64) -> [Pixel; 4] {
    [0, 16, 32, 48].map(|shift| (pixels >> shift) as Pixel)
}

#[inline(always)]
fn pack(pixels: [Pixel; 4]) -> u64 {
    (0..4).fold(0, |all, k| all | u64::from(pixels[k]) << (16 * k))
}

// SAFETY: only safe operations.
unsafe impl Operations for Portable {
    type Four = [i32; 4];

    #[inline(always)]
    unsafe fn project<const NARROW: bool>(
        basis: &Basis,
        window: &[u32],
        at: [usize; 4],
        offsets: &[i32; N * N],
    ) -> [Descriptor; 4] {
        at.map(|at| {
            basis
                .project(&offsets.map(|offset| window[at.wrapping_add_signed(offset as isize)].to_le_bytes()))
        })
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
        let Edges { around, bounds: [x0, x1, y0, y1] } = tables.edges;
        for (i, continuing) in continuing.iter_mut().enumerate() {
            for k in 0..AROUND {
                let pixel = pixels[(at + i).wrapping_add_signed(offsets[k] as isize)];
                let (x, y) = ((pixel & 255) as i16 - DU[k], (pixel >> 8) as i16 - DV[k]);
                let (x, y) = match around {
                    Some([w, h]) => (x.rem_euclid(w), y.rem_euclid(h)),
                    None => (x.clamp(x0, x1), y.clamp(y0, y1)),
                };
                let pixel = (x | y << 8) as Pixel;
                let repeated = continuing[..k].contains(&pixel);
                continuing[k] = pixel;
                row.index[k][i] = tables.view.index(pixel) as u16;
                row.advance[k][i] = if repeated { 0 } else { similar as u16 };
            }
            let last = continuing[AROUND - 1];
            continuing[AROUND..].fill(last);
        }
    }

    #[inline(always)]
    unsafe fn costs<const NARROW: bool>(
        tables: &ViewTables,
        descriptor: &Descriptor,
        continuing: &[Pixel; 16],
        pixels: u64,
        incoherent: i32,
    ) -> [i32; 4] {
        unpack(pixels).map(|pixel| {
            let record = &tables.records[tables.view.index(pixel)];
            let mut distance = 0;
            for (a, b) in descriptor.iter().zip(&record.descriptor[if NARROW { DIMS / 2 } else { 0 }..]) {
                let difference = i16::from(*a) - i16::from(*b);
                distance += i32::from(difference) * i32::from(difference);
            }
            let coherent = continuing.iter().fold(false, |any, &p| any | (p == pixel));
            ((distance * if coherent { 256 } else { incoherent }) >> 8) + record.usage
        })
    }

    #[inline(always)]
    unsafe fn pairs(sets: [&[Triple; 2]; 3]) -> [u64; 3] {
        std::array::from_fn(|d| {
            let (next_of, last_of) = (sets[(d + 2) % 3], sets[(d + 1) % 3]);
            pack([next_of[0].next, next_of[1].next, last_of[0].last, last_of[1].last])
        })
    }

    #[inline(always)]
    unsafe fn sums(
        sets: [&[Triple; 2]; 3],
        factor: u32,
        own: [i32; 3],
        costs: [[i32; 4]; 3],
    ) -> [[i32; 4]; 2] {
        let sum = |e: usize, k: usize| {
            let crossbar = (u64::from(sets[e][k].crossbar) * u64::from(factor)) >> 24;
            own[e] + crossbar as i32 + costs[(e + 1) % 3][k] + costs[(e + 2) % 3][2 + k]
        };
        [[i32::MAX, i32::MAX, sum(0, 0), sum(0, 1)], [sum(1, 0), sum(1, 1), sum(2, 0), sum(2, 1)]]
    }

    #[inline(always)]
    unsafe fn load(numbers: &[i32; 4]) -> [i32; 4] {
        *numbers
    }

    #[inline(always)]
    unsafe fn all(number: i32) -> [i32; 4] {
        [number; 4]
    }

    #[inline(always)]
    unsafe fn scale(numbers: [i32; 4], plus: [i32; 4]) -> [i32; 4] {
        std::array::from_fn(|k| 4 * numbers[k] + plus[k])
    }

    #[inline(always)]
    unsafe fn only_even(costs: [i32; 4]) -> [i32; 4] {
        [costs[0], i32::MAX, costs[2], i32::MAX]
    }

    #[inline(always)]
    unsafe fn least(costs: [i32; 4], tags: [i32; 4]) -> (i32, u32) {
        let key = |k: usize| (costs[k], tags[k] as u32);
        key(0).min(key(1)).min(key(2).min(key(3)))
    }

    #[inline(always)]
    unsafe fn keep_less(costs: &mut [i32; 4], tags: &mut [i32; 4], new: [i32; 4], new_tags: [i32; 4]) {
        for k in 0..4 {
            if new[k] < costs[k] {
                (costs[k], tags[k]) = (new[k], new_tags[k]);
            }
        }
    }

    #[inline(always)]
    unsafe fn strips(a: &Strip, b: &Strip) -> i32 {
        let square = |(a, b): (&u8, &u8)| {
            let difference = i32::from(i16::from(*a) - i16::from(*b));
            difference * difference
        };
        a.iter().zip(b).map(square).sum()
    }

    #[inline(always)]
    unsafe fn nearest_color(colors: [[u8; 4]; 3], color: &OneColor) -> usize {
        color.nearest(colors)
    }
}
