//! The correction of the voxels of one brick (Dong et al. 2008, section 5.1, Correction).
//!
//! Each direction is matched by its own 2D descriptors: the 2D candidates of the neighbours give the best pixel a
//! direction, then triples are compared: those kept at the three best pixels, and the triple of the three. The cost
//! of a triple is, over its directions, the descriptor distance (raised by κ where the pixel continues no
//! neighbour) plus the pixel's usage weight, plus λ times the crossbar error. Ties go to the triple tried first.
//!
//! The voxels of one layer go through each step together. What a step writes is read a whole layer later, when it
//! has long left the processor's store buffer, and the candidates of all voxels make one list, so that no loop
//! has a length which the processor cannot foresee.

use super::candidates::{SET, Triple};
use super::color::{OneColor, mean};
use super::field::Brick;
use super::isa::{Isa, Operations, Portable};
use super::pyramid::{N, Pixel, RADIUS};
use super::similarity::SET as SIMILAR;
use super::tables::{LevelTables, ViewTables};

/// Voxels along a window's edge: a brick and two voxels on each side.
pub(super) const SIDE: usize = 12;
const STRIDE: [i32; 3] = [1, SIDE as i32, (SIDE * SIDE) as i32];
/// Voxels of a brick's layer.
const LAYER: usize = 64;
/// Pixels that continue a neighbour.
pub(super) const AROUND: usize = 9;

/// The state around a brick before a sub-pass.
pub(super) struct Window {
    /// Colours and feature, little-endian RGBF.
    pub color: [u32; SIDE * SIDE * SIDE],
    /// The pixel in each direction's exemplar.
    pub pixels: [[Pixel; SIDE * SIDE * SIDE]; 3],
}

/// A window, and what the steps of a layer's correction hand on.
pub(super) struct Workspace {
    pub window: Window,
    layer: Layer,
}

impl Default for Workspace {
    fn default() -> Self {
        let direction = Direction {
            descriptors: [[0; 16]; LAYER],
            continuing: [[0; 16]; LAYER],
            best: [0; LAYER],
            best_cost: [0; LAYER],
        };
        Self {
            window: Window { color: [0; 1728], pixels: [[0; 1728]; 3] },
            layer: Layer {
                voxels: [0; LAYER],
                at: [0; LAYER],
                count: 0,
                directions: [direction; 3],
                list: [0; LIST],
                owners: [0; GROUPS],
                row: Row { index: [[0; 8]; AROUND], advance: [[0; 8]; AROUND] },
                costs: [[0; 4]; LAYER],
                tags: [[0; 4]; LAYER],
            },
        }
    }
}

/// Groups of four candidates of a layer at most, and what is written beyond them.
const GROUPS: usize = LAYER * AROUND * SIMILAR / 4 + 16;
const LIST: usize = 4 * GROUPS;

/// The voxels of a layer that are corrected, each in its own slot.
struct Layer {
    /// Index in the layer.
    voxels: [u8; LAYER],
    /// Index in the window.
    at: [u16; LAYER],
    count: usize,
    directions: [Direction; 3],
    /// The 2D candidates in groups of four.
    list: [Pixel; LIST],
    /// The slot that a group belongs to.
    owners: [u8; GROUPS],
    row: Row,
    /// Every fourth candidate shares a lane, and each lane keeps its best.
    costs: [[i32; 4]; LAYER],
    /// The groups that the costs come from.
    tags: [[i32; 4]; LAYER],
}

/// What one direction knows of the voxels.
#[derive(Clone, Copy)]
struct Direction {
    descriptors: [[u8; 16]; LAYER],
    /// The nine pixels that continue a neighbour, filled up with the last.
    continuing: [[Pixel; 16]; LAYER],
    best: [Pixel; LAYER],
    best_cost: [i32; LAYER],
}

/// The nine pixels that continue a neighbour of eight voxels along x.
pub(super) struct Row {
    /// Their indices.
    pub index: [[u16; 8]; AROUND],
    /// The number of candidates that each adds: none where an earlier one is the same pixel.
    pub advance: [[u16; 8]; AROUND],
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

/// What a correction of a level works with.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub level: &'a LevelTables,
    pub weights: Weights,
    pub color: OneColor,
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

/// The offsets of the nine nearest of them.
const fn nearest(direction: usize) -> [i32; AROUND] {
    let mut out = [0; AROUND];
    let mut k = 0;
    while k < AROUND {
        out[k] = OFFSETS[direction][(k / 3 + 1) * 5 + k % 3 + 1];
        k += 1;
    }
    out
}

const NEAREST: [[i32; AROUND]; 3] = [nearest(0), nearest(1), nearest(2)];

/// Corrects the voxels of `mask` (bits x + 8 y of word z) of the brick amid the workspace's window, and returns the
/// sum of their costs.
pub(super) fn correct(
    isa: Isa,
    job: Job<'_>,
    workspace: &mut Workspace,
    mask: &[u64; 8],
    brick: &mut Brick,
) -> i64 {
    match isa {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `isa` comes from `isa::available`.
        Isa::Avx512 => unsafe { correct_avx512(job, workspace, mask, brick) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        Isa::Avx2 => unsafe { correct_avx2(job, workspace, mask, brick) },
        // SAFETY: the portable operations need nothing.
        _ => unsafe { correct_with::<Portable>(job, workspace, mask, brick) },
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn correct_avx2(job: Job<'_>, workspace: &mut Workspace, mask: &[u64; 8], brick: &mut Brick) -> i64 {
    // SAFETY: the caller's promise.
    unsafe { correct_with::<super::x86::Avx2>(job, workspace, mask, brick) }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vnni")]
unsafe fn correct_avx512(job: Job<'_>, workspace: &mut Workspace, mask: &[u64; 8], brick: &mut Brick) -> i64 {
    // SAFETY: the caller's promise.
    unsafe { correct_with::<super::x86::Avx512>(job, workspace, mask, brick) }
}

#[inline(always)]
unsafe fn correct_with<O: Operations>(
    job: Job<'_>,
    workspace: &mut Workspace,
    mask: &[u64; 8],
    brick: &mut Brick,
) -> i64 {
    // SAFETY: the caller's promise.
    unsafe {
        match job.level.narrow {
            true => correct_layers::<O, true>(job, workspace, mask, brick),
            false => correct_layers::<O, false>(job, workspace, mask, brick),
        }
    }
}

// Whatever an instruction set runs is inlined into its function, without closures: those would be compiled
// without the instruction set.
#[inline(always)]
unsafe fn correct_layers<O: Operations, const NARROW: bool>(
    job: Job<'_>,
    workspace: &mut Workspace,
    mask: &[u64; 8],
    brick: &mut Brick,
) -> i64 {
    let Workspace { window, layer } = workspace;
    let mut cost = 0;
    for (z, &word) in mask.iter().enumerate() {
        if word == 0 {
            continue;
        }
        layer.choose(z, word);
        // SAFETY: the caller's promise; every slot's neighbourhood lies in the window, and the pixels in tables
        // and window are those of the views, as `Tables::new` and `Field` see to.
        unsafe {
            for direction in 0..3 {
                let tables = job.level.view(direction);
                layer.project::<O, NARROW>(tables, window, direction);
                let groups =
                    layer.list_candidates::<O>(tables, window, direction, z, word, job.weights.similar);
                layer.search::<O, NARROW>(tables, direction, groups, job.weights);
            }
            cost += layer.search_triples::<O, NARROW>(job, z, brick);
        }
    }
    cost
}

impl Layer {
    /// Gives each voxel of a layer that is to be corrected a slot.
    #[inline(always)]
    fn choose(&mut self, z: usize, word: u64) {
        let mut bits = word;
        self.count = 0;
        while bits != 0 {
            let i = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            self.voxels[self.count] = i as u8;
            self.at[self.count] = window_index(z, i) as u16;
            self.count += 1;
        }
    }

    /// The descriptors of the voxels' neighbourhoods.
    #[inline(always)]
    unsafe fn project<O: Operations, const NARROW: bool>(
        &mut self,
        tables: &ViewTables,
        window: &Window,
        direction: usize,
    ) {
        let mut slot = 0;
        while slot < self.count {
            // The last four may overlap those before, or repeat the last voxel.
            let first = slot.min(self.count.saturating_sub(4));
            let at =
                [first, first + 1, first + 2, first + 3].map(|s| usize::from(self.at[s.min(self.count - 1)]));
            // SAFETY: the caller's promise.
            let descriptors =
                unsafe { O::project::<NARROW>(&tables.basis, &window.color, at, &OFFSETS[direction]) };
            self.directions[direction].descriptors[first..first + 4].copy_from_slice(&descriptors);
            slot += 4;
        }
    }

    /// The pixels that continue a neighbour of each voxel, and its candidates: the similarity sets of those pixels.
    /// Neighbours in one patch all lead to the same pixel, whose set is taken once: without a branch, which
    /// nothing could predict, a repeated one is overwritten by the next. Returns the number of groups of four.
    #[inline(always)]
    unsafe fn list_candidates<O: Operations>(
        &mut self,
        tables: &ViewTables,
        window: &Window,
        direction: usize,
        z: usize,
        word: u64,
        similar: usize,
    ) -> usize {
        let continuing = &mut self.directions[direction].continuing;
        let list = self.list.as_mut_ptr();
        let mut groups = 0;
        let mut slot = 0;
        for y in 0..8 {
            let mut left = word >> (8 * y) & 255;
            if left == 0 {
                continue;
            }
            // SAFETY: the caller's promise; a slot adds at most nine groups, and `GROUPS` leaves room for what is
            // written beyond the last.
            unsafe {
                let (at, pixels) = (window_index(z, 8 * y), &window.pixels[direction]);
                let chosen = left.count_ones() as usize;
                let mut rows = [[0; 16]; 8];
                O::continue_row(pixels, at, &NEAREST[direction], tables, similar, &mut self.row, &mut rows);
                for _ in 0..chosen {
                    let x = left.trailing_zeros() as usize;
                    left &= left - 1;
                    *continuing.get_unchecked_mut(slot) = *rows.get_unchecked(x);
                    let mut to = list.add(4 * groups);
                    let from = to;
                    for k in 0..AROUND {
                        let index = usize::from(*self.row.index[k].get_unchecked(x));
                        // A set begins with the pixel itself. All are copied, whatever their number, in one move.
                        to.cast::<[Pixel; SIMILAR]>()
                            .write_unaligned(tables.records.get_unchecked(index).similar);
                        to = to.add(usize::from(*self.row.advance[k].get_unchecked(x)));
                    }
                    // The first again to fill the last group of four.
                    to.cast::<[Pixel; 4]>().write_unaligned([*from; 4]);
                    let own = (to.offset_from_unsigned(from)).div_ceil(4);
                    let owners = self.owners.as_mut_ptr().add(groups);
                    owners.cast::<[u8; 16]>().write_unaligned([slot as u8; 16]);
                    groups += own;
                    slot += 1;
                }
            }
        }
        groups
    }

    /// The best pixel of one direction among the candidates of each voxel.
    #[inline(always)]
    unsafe fn search<O: Operations, const NARROW: bool>(
        &mut self,
        tables: &ViewTables,
        direction: usize,
        groups: usize,
        weights: Weights,
    ) {
        self.costs[..self.count].fill([i32::MAX; 4]);
        let Direction { descriptors, continuing, best, best_cost } = &mut self.directions[direction];
        for group in 0..groups {
            // SAFETY: the caller's promise; owners are slots.
            unsafe {
                let slot = usize::from(*self.owners.get_unchecked(group));
                let pixels = self.list.as_ptr().add(4 * group).cast::<u64>().read_unaligned();
                let cost = O::costs::<NARROW>(
                    tables,
                    descriptors.get_unchecked(slot),
                    continuing.get_unchecked(slot),
                    pixels,
                    weights.incoherent,
                );
                let (costs, tags) = (self.costs.get_unchecked_mut(slot), self.tags.get_unchecked_mut(slot));
                O::keep_less(costs, tags, cost, O::all(group as i32));
            }
        }
        for slot in 0..self.count {
            // SAFETY: the caller's promise; a tag is a group and a lane a place in it.
            unsafe {
                let tags = O::scale(O::load(self.tags.get_unchecked(slot)), [0, 1, 2, 3]);
                let (cost, place) = O::least(O::load(self.costs.get_unchecked(slot)), tags);
                best[slot] = *self.list.get_unchecked(place as usize);
                best_cost[slot] = cost;
            }
        }
    }

    /// The best triple of each voxel; returns the sum of their costs.
    #[inline(always)]
    unsafe fn search_triples<O: Operations, const NARROW: bool>(
        &mut self,
        job: Job<'_>,
        z: usize,
        brick: &mut Brick,
    ) -> i64 {
        let Job { level, weights, color } = job;
        let views = [level.view(0), level.view(1), level.view(2)];
        let factor = crossbar_factor(level, weights);
        let mut total = 0;
        for slot in 0..self.count {
            let d = &self.directions;
            let bests = [d[0].best[slot], d[1].best[slot], d[2].best[slot]];
            let own = [d[0].best_cost[slot], d[1].best_cost[slot], d[2].best_cost[slot]];
            let index =
                [views[0].view.index(bests[0]), views[1].view.index(bests[1]), views[2].view.index(bests[2])];
            // SAFETY: the caller's promise.
            let crossbar = unsafe {
                O::strips(views[0].columns.get_unchecked(index[0]), views[1].rows.get_unchecked(index[1]))
                    + O::strips(
                        views[1].columns.get_unchecked(index[1]),
                        views[2].rows.get_unchecked(index[2]),
                    )
                    + O::strips(
                        views[2].columns.get_unchecked(index[2]),
                        views[0].rows.get_unchecked(index[0]),
                    )
            };
            let mixed = own[0] + own[1] + own[2] + weigh(crossbar as u32, factor);
            // Tag 0 is the mixed triple, others lead back to a direction and a place in its set.
            let mut costs = [[mixed, i32::MAX, i32::MAX, i32::MAX], [i32::MAX; 4]];
            let mut tags = [[0; 4]; 2];
            let mut first = 0;
            while first < weights.triples {
                // SAFETY: the caller's promise.
                unsafe {
                    let sets = [
                        views[0].triples.get_unchecked(first / 2).get_unchecked(index[0]),
                        views[1].triples.get_unchecked(first / 2).get_unchecked(index[1]),
                        views[2].triples.get_unchecked(first / 2).get_unchecked(index[2]),
                    ];
                    let pixels = O::pairs(sets);
                    // Written out, as an array's `map` takes a closure.
                    let mut found = [O::all(0); 3];
                    for e in 0..3 {
                        found[e] = O::costs::<NARROW>(
                            views[e],
                            d[e].descriptors.get_unchecked(slot),
                            d[e].continuing.get_unchecked(slot),
                            pixels[e],
                            weights.incoherent,
                        );
                    }
                    let [mut a, mut b] = O::sums(sets, factor, own, found);
                    if first + 1 == weights.triples {
                        (a, b) = (O::only_even(a), O::only_even(b));
                    }
                    let [to_a, to_b] = &mut costs;
                    let [tags_a, tags_b] = &mut tags;
                    O::keep_less(to_a, tags_a, a, O::load(&TAGS[first / 2][0]));
                    O::keep_less(to_b, tags_b, b, O::load(&TAGS[first / 2][1]));
                }
                first += 2;
            }
            // SAFETY: the caller's promise.
            let (cost, tag) = unsafe {
                // The tags of the first four are the smaller ones.
                let (mut all, mut all_tags) = (costs[0], tags[0]);
                O::keep_less(&mut all, &mut all_tags, O::load(&costs[1]), O::load(&tags[1]));
                O::least(O::load(&all), O::load(&all_tags))
            };
            total += i64::from(cost);
            let mut pixels = bests;
            let mut at = index;
            if tag > 0 {
                let (e, k) = (((tag - 1) as usize) / SET, ((tag - 1) as usize) % SET);
                let Triple { next, last, .. } = views[e].triples[k / 2][index[e]][k % 2];
                for (e, pixel) in [((e + 1) % 3, next), ((e + 2) % 3, last)] {
                    pixels[e] = pixel;
                    at[e] = views[e].view.index(pixel);
                }
            }
            let voxel = z * LAYER + usize::from(self.voxels[slot]);
            for (of_brick, pixel) in brick.pixels.iter_mut().zip(pixels) {
                of_brick[voxel] = pixel;
            }
            // SAFETY: the caller's promise.
            let colors = unsafe {
                [
                    *views[0].view.texels.get_unchecked(at[0]),
                    *views[1].view.texels.get_unchecked(at[1]),
                    *views[2].view.texels.get_unchecked(at[2]),
                ]
            };
            // SAFETY: the caller's promise.
            let shown = unsafe { O::nearest_color(colors, &color) };
            let color = if color.takes_one() { colors[shown] } else { mean(colors) };
            brick.color[voxel] = u32::from_le_bytes(color);
            brick.shown[voxel] = shown as u8;
        }
        total
    }
}

/// The tags of each two triples of the three directions, in the order of [`Operations::sums`]: 1 + place in the set
/// of twelve + 12 · direction.
const TAGS: [[[i32; 4]; 2]; SET / 2] = {
    let mut tags = [[[0; 4]; 2]; SET / 2];
    let mut k = 0;
    while k < SET / 2 {
        let (tag, set) = (1 + 2 * k as i32, SET as i32);
        tags[k] = [[0, 0, tag, tag + 1], [tag + set, tag + set + 1, tag + 2 * set, tag + 2 * set + 1]];
        k += 1;
    }
    tags
};

/// The index in a window of voxel `i` of a brick's layer `z`.
#[inline(always)]
fn window_index(z: usize, i: usize) -> usize {
    (z + 2) * SIDE * SIDE + (i / 8 + 2) * SIDE + i % 8 + 2
}

/// What a crossbar error is multiplied with for its cost, times 2^24: it turns colours into the units of
/// descriptor distances and weighs them. Errors are at most 3.9 million, so that costs stay below 2^29.
pub(super) fn crossbar_factor(level: &LevelTables, weights: Weights) -> u32 {
    (u64::from(level.scale) * weights.crossbar).min(i32::MAX as u64) as u32
}

#[inline(always)]
fn weigh(crossbar: u32, factor: u32) -> i32 {
    ((u64::from(crossbar) * u64::from(factor)) >> 24) as i32
}
