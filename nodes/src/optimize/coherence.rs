//! The nearest neighbourhood of voxels, by k-coherence or by comparing with all (Chen & Wang 2010, section
//! 4.3).

use super::matches::code;
use super::phases::Around;
use super::search::Method;
use crate::lazy::{Isa, LevelView, Pixel};
use crate::search::{PatchTable, Patches, SimilarSets, distance, is_wide, nearest_of, project};

/// What all voxels of a direction share.
#[derive(Clone, Copy)]
pub(super) struct Direction<'a> {
    pub direction: usize,
    /// For each view the voxels, in the order of `around`.
    pub voxels: &'a [Vec<Voxel>],
    pub patches: &'a Patches,
    pub reach: i32,
    pub isa: Isa,
    pub around: &'a Around,
    pub candidates: &'a Candidates,
    /// How much farther each pixel counts, in units of 1/256: the index histogram.
    pub weights: &'a [u32],
    /// The same for the centres of an exhaustive search.
    pub centre_weights: &'a [u32],
}

/// What a search reads of a voxel, in one word.
#[derive(Clone, Copy, Default)]
#[repr(align(8))]
pub(super) struct Voxel {
    pub color: [u8; 4],
    pub source: Pixel,
}

/// What a view proposes.
#[derive(Default)]
pub(super) struct Candidates {
    /// For an exhaustive search the indices of the centres, and their coefficients in blocks.
    pub all: Option<(Vec<u16>, PatchTable)>,
    /// Pixels in a similarity set; 1 without sets.
    k: usize,
    /// For every pixel itself and the others of its similarity set, as indices of pixels, in [`Candidates::stride`] places.
    sets: Vec<u16>,
}

impl Candidates {
    /// Those of a view.
    pub fn new(patches: &Patches, view: usize, sets: Option<&SimilarSets>, method: Method) -> Self {
        let view_of = &patches.views[view];
        let (width, height, tileable) = (view_of.width, view_of.height, view_of.tileable);
        let level = LevelView { width, height, tileable, texels: Vec::new(), barred: Vec::new() };
        let last = (width * height - 1) as usize;
        let index = |&pixel: &Pixel| level.index(pixel).min(last) as u16;
        if method == Method::Exhaustive {
            let centres: Vec<u16> = patches.window().pixels_of(&level).iter().map(index).collect();
            let vectors: Vec<_> = centres.iter().map(|&i| view_of.coefficients(i.into())).collect();
            let table = PatchTable::new(vectors.into_iter(), view_of.dims);
            return Self { all: Some((centres, table)), ..Self::default() };
        }
        let sets_of = sets.and_then(|sets| Some((sets.k.max(1), sets.views.get(view)?)));
        let (k, pixels) = sets_of.map_or((1, &[][..]), |(k, pixels)| (k, pixels));
        let mut known = Self { all: None, k, sets: Vec::new() };
        let stride = known.stride();
        known.sets.resize((last + 1) * stride, 0);
        for at in 0..=last {
            let row = &mut known.sets[at * stride..][..stride];
            row.fill(at as u16);
            let set = pixels.get(at * k..at * k + k).unwrap_or(&[]).iter().map(index);
            let others = set.filter(|&other| usize::from(other) != at);
            row[1..k].iter_mut().zip(others).for_each(|(to, other)| *to = other);
        }
        known
    }

    /// Pixels in a set.
    pub fn members(&self) -> usize {
        self.k
    }

    /// The sets, each in [`Candidates::stride`] places.
    pub fn sets(&self) -> &[u16] {
        &self.sets
    }

    /// Room for a set: whole fours, so that copying them needs no loop.
    pub fn stride(&self) -> usize {
        self.k.next_multiple_of(4)
    }
}

/// A voxel's match: the pixel, and the code of its distance.
pub(super) type Match = (Pixel, u16);

/// Room for the work of a thread, kept from portion to portion.
pub(super) struct Scratch {
    samples: Vec<i16>,
    /// Where the voxels of the window came from.
    sources: Vec<Pixel>,
    /// The pixels that continue these, with [`NEAR`] where their similarity sets are proposed; then each once.
    continued: Vec<u32>,
    candidates: Vec<u16>,
    /// For each pixel the voxel for which it was last met.
    met: Box<[u8; 1 << 16]>,
    epoch: u8,
}

impl Scratch {
    pub fn new() -> Self {
        Self {
            samples: Vec::new(),
            sources: Vec::new(),
            continued: Vec::new(),
            candidates: Vec::new(),
            met: Box::new([0; 1 << 16]),
            epoch: 0,
        }
    }
}

/// Marks a pixel near the centre of the window, whose similarity set is proposed.
const NEAR: u32 = 1 << 16;
/// Marks a pixel where no window fits.
const OUTSIDE: u32 = 1 << 17;

/// Finds the matches of some voxels in one direction.
pub(super) fn match_voxels(
    search: &Direction<'_>,
    voxels: &[u32],
    out: &mut [[Match; 3]],
    scratch: &mut Scratch,
) {
    macro_rules! dims {
        ($($d:literal)*) => {
            match search.patches.basis.dims {
                $($d => enter::<$d>(search, voxels, out, scratch),)*
                // No basis has another number of components.
                _ => {}
            }
        };
    }
    dims!(8 16 24 32 40 48 56 64);
}

fn enter<const D: usize>(
    search: &Direction<'_>,
    voxels: &[u32],
    out: &mut [[Match; 3]],
    scratch: &mut Scratch,
) {
    #[cfg(target_arch = "x86_64")]
    if is_wide(search.isa) {
        // SAFETY: `isa` comes from `available_instruction_sets`.
        return unsafe { matches_avx2::<D>(search, voxels, out, scratch) };
    }
    matches::<D>(search, voxels, out, scratch, false);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn matches_avx2<const D: usize>(
    search: &Direction<'_>,
    voxels: &[u32],
    out: &mut [[Match; 3]],
    scratch: &mut Scratch,
) {
    matches::<D>(search, voxels, out, scratch, true);
}

// Written with plain loops: a closure would be compiled without the instruction set and not inlined.
#[inline(always)]
fn matches<const D: usize>(
    search: &Direction<'_>,
    voxels: &[u32],
    out: &mut [[Match; 3]],
    scratch: &mut Scratch,
    wide: bool,
) {
    let Direction { patches, candidates: known, .. } = *search;
    let view = patches.view(search.direction);
    let (table, basis) = (&patches.views[view], &patches.basis);
    let (weights, bias) = (&basis.weights[view][..], &basis.bias[view][..]);
    let voxels_of = &search.voxels[view.min(search.voxels.len() - 1)][..];
    let (k, stride, sets) = (known.k, known.stride(), &known.sets[..]);
    let coefficients = table.table.as_chunks::<D>().0;
    let window = patches.window();
    let (before, size) = (window.before(), window.size);
    let [(left, right), (top, bottom)] = if table.tileable {
        [(0, table.width - 1), (0, table.height - 1)]
    } else {
        [
            (window.before(), table.width - 1 - window.after()),
            (window.before(), table.height - 1 - window.after()),
        ]
    };
    let (width, height) = (table.width, table.height);
    let last = (width * height - 1) as u32;
    let (columns_wide, rows_high) = ((right - left) as u32, (bottom - top) as u32);
    // How far each voxel of the window is from its centre, and whether that is near.
    let mut steps: Vec<(i32, i32, u32)> = Vec::with_capacity(window.pixels());
    for (along, across) in window.offsets() {
        let near = along.abs() <= search.reach && across.abs() <= search.reach;
        steps.push((along, across, if near { NEAR } else { 0 }));
    }
    let Scratch { samples, sources: found, continued, candidates, met, epoch } = scratch;
    samples.resize(window.pixels() * 4, 0);
    found.resize(window.pixels(), 0);
    continued.resize(window.pixels(), 0);
    candidates.resize(window.pixels() * k + stride, 0);
    for (&voxel, out) in voxels.iter().zip(out) {
        let voxel = voxel as usize;
        let (own, columns, rows) = search.around.plane(voxel, search.direction, before, size);
        let row_of = samples.chunks_exact_mut(4 * size as usize).zip(found.chunks_exact_mut(size as usize));
        for (&row, (samples, found)) in rows.iter().zip(row_of) {
            for (&column, (to, found)) in columns.iter().zip(samples.chunks_exact_mut(4).zip(found)) {
                let at = (own + row + column) as usize;
                let Voxel { color, source } = voxels_of[at];
                for channel in 0..4 {
                    to[channel] = i16::from(color[channel]);
                }
                *found = source;
            }
        }
        let query: [i16; D] = project::<D>(samples, weights, bias, wide);
        if let Some((centres, all)) = &known.all {
            let i = all.nearest(&query, search.centre_weights, search.isa);
            let at = usize::from(centres.get(i).copied().unwrap_or(0));
            let nearest = distance::<D>(&query, &coefficients[at], wide);
            out[search.direction] = (pixel(at, width), code(nearest));
            continue;
        }
        for ((to, &source), &(along, across, near)) in continued.iter_mut().zip(&*found).zip(&steps) {
            let mut column = i32::from(source & 255) - along;
            let mut line = i32::from(source >> 8) - across;
            let mut mark = near;
            if table.tileable {
                // No window is larger than the view.
                column += if column < 0 { width } else { 0 };
                column -= if column >= width { width } else { 0 };
                line += if line < 0 { height } else { 0 };
                line -= if line >= height { height } else { 0 };
            } else if (column - left) as u32 > columns_wide || (line - top) as u32 > rows_high {
                mark = OUTSIDE;
            }
            *to = ((line * width + column) as u32).min(last) | mark;
        }
        // Every pixel once, without a branch, since nobody could foretell it. What is met as near is greater than what is met
        // elsewhere, whose set is still to be proposed. Members of several sets are compared again, which costs less than to
        // find out.
        *epoch += 1;
        if *epoch == 128 {
            met[..=last as usize].fill(0);
            *epoch = 1;
        }
        let mut count = 0;
        for i in 0..continued.len() {
            let place = continued[i];
            let now = if place >= OUTSIDE { 0 } else { 2 * *epoch + u8::from(place >= NEAR) };
            let met = &mut met[usize::from(place as u16)];
            continued[count] = place;
            count += usize::from(*met < now);
            *met = now.max(*met);
        }
        let places = &continued[..count];
        let mut count = 0;
        for &place in places {
            let at = usize::from(place as u16);
            let from = &sets[at * stride..][..stride];
            let to = &mut candidates[count..][..stride];
            // Copies of known length are a move or two.
            match (from.first_chunk::<8>(), to.first_chunk_mut::<8>()) {
                (Some(first), Some(head)) => {
                    *head = *first;
                    if stride > 8 {
                        to[8..].copy_from_slice(&from[8..]);
                    }
                }
                _ => {
                    if let (Some(first), Some(head)) = (from.first_chunk::<4>(), to.first_chunk_mut::<4>()) {
                        *head = *first;
                    }
                }
            }
            count += if place >= NEAR { k } else { 1 };
        }
        if count == 0 {
            // Every source lies so near to an edge that no window fits: the centre nearest to the voxel's own.
            let source = voxels_of[search.around.own(voxel)].source;
            let column = i32::from(source & 255).clamp(left, right);
            let line = i32::from(source >> 8).clamp(top, bottom);
            candidates[0] = (line * width + column) as u16;
            count = 1;
        }
        let filled = count.next_multiple_of(4);
        for i in count..filled {
            candidates[i] = candidates[0];
        }
        let fours = candidates[..filled].as_chunks::<4>().0;
        let best = nearest_of::<D>(&query, coefficients, search.weights, fours, wide).unwrap_or(0);
        let nearest = distance::<D>(&query, &coefficients[usize::from(best)], wide);
        out[search.direction] = (pixel(best.into(), width), code(nearest));
    }
}

/// The pixel with an index.
#[inline(always)]
fn pixel(index: usize, width: i32) -> Pixel {
    let (column, row) = (index as u32 % width as u32, index as u32 / width as u32);
    (column | row << 8) as Pixel
}
