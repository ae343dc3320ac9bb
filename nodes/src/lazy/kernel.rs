//! The correction of the voxels of one brick (Dong et al. 2008, section 5.1, Correction).
//!
//! Each direction is matched by its own 2D descriptors: the 2D candidates of the neighbours give the best pixel a
//! direction, then triples are compared: those kept at the three best pixels, and the triple of the three. The cost
//! of a triple is, over its directions, the descriptor distance (raised by κ where the pixel continues no
//! neighbour) plus the pixel's usage weight, plus λ times the crossbar error. Ties go to the triple tried first.

use super::candidates::SET;
use super::isa::{DU, DV, Isa, Operations, Portable};
use super::pyramid::{N, Pixel, RADIUS};
use super::schedule::ColorRule;
use super::similarity::SET as SIMILAR;
use super::tables::{LevelTables, ViewTables};

/// Voxels along a window's edge: a brick and two voxels on each side.
pub(super) const SIDE: usize = 12;
const STRIDE: [i32; 3] = [1, SIDE as i32, (SIDE * SIDE) as i32];

/// The state around a brick before a sub-pass.
pub(super) struct Window {
    /// Colours and feature, little-endian RGBF.
    pub color: [u32; SIDE * SIDE * SIDE],
    /// The pixel in each direction's exemplar.
    pub pixels: [[Pixel; SIDE * SIDE * SIDE]; 3],
}

impl Default for Window {
    fn default() -> Self {
        Self { color: [0; 1728], pixels: [[0; 1728]; 3] }
    }
}

/// The weights of a cost, in 256ths.
#[derive(Clone, Copy)]
pub(super) struct Weights {
    pub similar: usize,
    pub triples: usize,
    /// 256 (1 + κ).
    pub incoherent: i32,
    /// 256 λ.
    pub crossbar: u64,
}

/// The result for one voxel.
pub(super) struct Corrected {
    pub pixels: [Pixel; 3],
    pub cost: i32,
}

/// Offsets in a window to the pixels of a neighbourhood of a direction, row by row.
const fn offsets(direction: usize) -> [i32; N * N] {
    let (u, v) = (STRIDE[(direction + 1) % 3], STRIDE[(direction + 2) % 3]);
    let mut out = [0; N * N];
    let mut k = 0;
    while k < N * N {
        out[k] = (k as i32 % 5 - RADIUS) * u + (k as i32 / 5 - RADIUS) * v;
        k += 1;
    }
    out
}

const OFFSETS: [[i32; N * N]; 3] = [offsets(0), offsets(1), offsets(2)];

/// Corrects the voxels of `mask` (bits x + 8 y of word z) and hands each to `store` with its index in the brick.
pub(super) fn correct(
    isa: Isa,
    level: &LevelTables,
    weights: Weights,
    window: &Window,
    mask: &[u64; 8],
    store: &mut dyn FnMut(usize, Corrected),
) {
    match isa {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `isa` comes from `isa::available`.
        Isa::Avx512 => unsafe { correct_avx512(level, weights, window, mask, store) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        Isa::Avx2 => unsafe { correct_avx2(level, weights, window, mask, store) },
        // SAFETY: the portable operations need nothing.
        _ => unsafe { correct_with::<Portable>(level, weights, window, mask, store) },
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn correct_avx2(
    level: &LevelTables,
    weights: Weights,
    window: &Window,
    mask: &[u64; 8],
    store: &mut dyn FnMut(usize, Corrected),
) {
    // SAFETY: the caller's promise.
    unsafe { correct_with::<super::isa::Avx2>(level, weights, window, mask, store) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vnni")]
unsafe fn correct_avx512(
    level: &LevelTables,
    weights: Weights,
    window: &Window,
    mask: &[u64; 8],
    store: &mut dyn FnMut(usize, Corrected),
) {
    // SAFETY: the caller's promise.
    unsafe { correct_with::<super::isa::Avx512>(level, weights, window, mask, store) }
}

#[inline(always)]
unsafe fn correct_with<O: Operations>(
    level: &LevelTables,
    weights: Weights,
    window: &Window,
    mask: &[u64; 8],
    store: &mut dyn FnMut(usize, Corrected),
) {
    for (z, &word) in mask.iter().enumerate() {
        let mut bits = word;
        while bits != 0 {
            let i = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let at = (z + 2) * 144 + (i / 8 + 2) * 12 + i % 8 + 2;
            // SAFETY: `at` is a voxel of the brick, so its neighbourhood lies in the window.
            store(z * 64 + i, unsafe { correct_voxel::<O>(level, weights, window, at) });
        }
    }
}

/// What one direction knows of a voxel.
#[derive(Clone, Copy)]
struct Direction {
    descriptor: [u8; 16],
    /// The nine pixels that continue a neighbour, filled up with the middle one.
    continuing: [Pixel; 16],
    best: Pixel,
    best_cost: i32,
}

#[inline(always)]
unsafe fn correct_voxel<O: Operations>(
    level: &LevelTables,
    weights: Weights,
    window: &Window,
    at: usize,
) -> Corrected {
    // Written out: a closure would not have the caller's instruction set.
    // SAFETY: the caller's promise.
    let directions = unsafe {
        [
            search_2d::<O>(level.view(0), weights, window, at, 0),
            search_2d::<O>(level.view(1), weights, window, at, 1),
            search_2d::<O>(level.view(2), weights, window, at, 2),
        ]
    };
    let views = [level.view(0), level.view(1), level.view(2)];
    let bests = [directions[0].best, directions[1].best, directions[2].best];
    let mixed = directions[0].best_cost
        + directions[1].best_cost
        + directions[2].best_cost
        + weigh(crossbar(views, bests), level, weights);
    // Order 0 is the mixed triple, others lead back to a direction and a place in its set.
    let mut found = key(mixed, 0, 0);
    for e in 0..3 {
        let (next, last) = ((e + 1) % 3, (e + 2) % 3);
        let set = &views[e].triples[views[e].view.index(directions[e].best)];
        let mut k = 0;
        while k < weights.triples {
            let pair = [set[k], set[(k + 1).min(SET - 1)]];
            let nexts = [views[next].view.index(pair[0].next), views[next].view.index(pair[1].next)];
            let lasts = [views[last].view.index(pair[0].last), views[last].view.index(pair[1].last)];
            // SAFETY: the caller's promise.
            let d = unsafe {
                O::distances(
                    &directions[next].descriptor,
                    &directions[last].descriptor,
                    [
                        &views[next].descriptors[nexts[0]],
                        &views[next].descriptors[nexts[1]],
                        &views[last].descriptors[lasts[0]],
                        &views[last].descriptors[lasts[1]],
                    ],
                )
            };
            for i in 0..2 {
                // SAFETY: the caller's promise.
                let (to_next, to_last) = unsafe {
                    (
                        weigh_distance::<O>(d[i], &directions[next].continuing, pair[i].next, weights),
                        weigh_distance::<O>(d[2 + i], &directions[last].continuing, pair[i].last, weights),
                    )
                };
                let own = directions[e].best_cost + weigh(pair[i].crossbar, level, weights);
                let cost =
                    own + to_next + views[next].usage[nexts[i]] + to_last + views[last].usage[lasts[i]];
                // Beyond the number asked for, the second of a pair is not a candidate.
                let cost = if k + i < weights.triples { cost } else { i32::MAX };
                found = found.min(key(cost, (1 + e * SET + k + i) as u32, 0));
            }
            k += 2;
        }
    }
    let (cost, order) = ((found >> 32) as i32, (found >> 16 & 0xffff) as usize);
    if order == 0 {
        return Corrected { pixels: bests, cost };
    }
    let e = (order - 1) / SET;
    let triple = views[e].triples[views[e].view.index(bests[e])][(order - 1) % SET];
    let mut pixels = bests;
    pixels[(e + 1) % 3] = triple.next;
    pixels[(e + 2) % 3] = triple.last;
    Corrected { pixels, cost }
}

/// A crossbar error in the units of descriptor distances, weighted.
#[inline(always)]
fn weigh(crossbar: u32, level: &LevelTables, weights: Weights) -> i32 {
    // At most 3.9 million · 2^16 · 2^12 before the shift; the cap keeps sums of costs within 31 bits.
    ((u64::from(crossbar) * u64::from(level.scale) * weights.crossbar) >> 24).min(1 << 29) as i32
}

/// The first step: the best pixel of one direction among the 2D candidates of the neighbours.
#[inline(always)]
unsafe fn search_2d<O: Operations>(
    tables: &ViewTables,
    weights: Weights,
    window: &Window,
    at: usize,
    direction: usize,
) -> Direction {
    let (u, v) = (STRIDE[(direction + 1) % 3], STRIDE[(direction + 2) % 3]);
    // SAFETY: the caller's promise.
    let descriptor = unsafe { O::project(&tables.basis, &window.color, at, &OFFSETS[direction]) };
    let mut pixels = [window.pixels[direction][at]; 16];
    for k in 0..9 {
        let offset = DU[k] as i32 * u + DV[k] as i32 * v;
        // SAFETY: the caller's promise.
        pixels[k] =
            unsafe { *window.pixels[direction].get_unchecked(at.wrapping_add_signed(offset as isize)) };
    }
    // SAFETY: the caller's promise, here and below.
    let continuing = unsafe { O::step_back(&pixels, &tables.edges) };
    // The candidates in order. Neighbours in one patch all lead to the same pixel, which is taken once: without a
    // branch, which nothing could predict, a repeated one is overwritten by the next.
    let mut list = [0; 44];
    let mut n = 0;
    for k in 0..9 {
        let pixel = continuing[k];
        // SAFETY: the caller's promise.
        let first = unsafe { O::places(&continuing, pixel) }.trailing_zeros() == 2 * k as u32;
        // A set begins with the pixel itself. All four are copied, whatever their number, in one move.
        list[n..n + SIMILAR].copy_from_slice(&tables.similar[tables.view.index(pixel)]);
        n += if first { weights.similar } else { 0 };
    }
    // The first again to fill the last group of four.
    let fill = list[0];
    list[n..n + 4].fill(fill);
    // The smallest of cost, order and pixel in one number.
    let mut best = u64::MAX;
    let mut k = 0;
    while k < n {
        let group = [list[k], list[k + 1], list[k + 2], list[k + 3]];
        let at = [
            tables.view.index(group[0]),
            tables.view.index(group[1]),
            tables.view.index(group[2]),
            tables.view.index(group[3]),
        ];
        let table = &tables.descriptors;
        // SAFETY: the caller's promise.
        let d = unsafe {
            O::distances(
                &descriptor,
                &descriptor,
                [&table[at[0]], &table[at[1]], &table[at[2]], &table[at[3]]],
            )
        };
        for i in 0..4 {
            // SAFETY: the caller's promise.
            let cost =
                unsafe { weigh_distance::<O>(d[i], &continuing, group[i], weights) } + tables.usage[at[i]];
            best = best.min(key(cost, (k + i) as u32, group[i]));
        }
        k += 4;
    }
    Direction { descriptor, continuing, best: best as Pixel, best_cost: (best >> 32) as i32 }
}

/// A distance, raised where the pixel continues no neighbour.
#[inline(always)]
unsafe fn weigh_distance<O: Operations>(
    distance: i32,
    continuing: &[Pixel; 16],
    pixel: Pixel,
    weights: Weights,
) -> i32 {
    // SAFETY: the caller's promise.
    let factor = if unsafe { O::places(continuing, pixel) } != 0 { 256 } else { weights.incoherent };
    (distance * factor) >> 8
}

/// Cost, then order, then pixel. Costs are sums of squares and weights, never negative.
#[inline(always)]
fn key(cost: i32, order: u32, pixel: Pixel) -> u64 {
    (cost as u64) << 32 | u64::from(order) << 16 | u64::from(pixel)
}

/// The squared colour differences along the three lines where the neighbourhoods of a triple meet.
#[inline(always)]
fn crossbar(views: [&ViewTables; 3], pixels: [Pixel; 3]) -> u32 {
    let mut sum = 0i32;
    for e in 0..3 {
        let next = (e + 1) % 3;
        let a = &views[e].columns[views[e].view.index(pixels[e])];
        let b = &views[next].rows[views[next].view.index(pixels[next])];
        for (a, b) in a.iter().zip(b) {
            let difference = i32::from(i16::from(*a) - i16::from(*b));
            sum += difference * difference;
        }
    }
    sum as u32
}

/// One colour of three, and which: the mean has no direction of its own and gives 0.
#[inline(always)]
pub(super) fn one_color(rule: ColorRule, colors: [[u8; 4]; 3]) -> ([u8; 4], usize) {
    let sum: [i32; 4] = std::array::from_fn(|c| colors.iter().map(|color| i32::from(color[c])).sum());
    let apart = |color: [u8; 4]| -> i32 { (0..4).map(|c| (3 * i32::from(color[c]) - sum[c]).pow(2)).sum() };
    let gaps = colors.map(apart);
    let nearest = if gaps[1] < gaps[0] { 1 } else { 0 };
    let nearest = if gaps[2] < gaps[nearest] { 2 } else { nearest };
    match rule {
        ColorRule::Nearest => (colors[nearest], nearest),
        ColorRule::Mean => (sum.map(|s| ((s + 1) / 3) as u8), nearest),
    }
}
