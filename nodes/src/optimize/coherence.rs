//! The nearest neighbourhood of voxels, by k-coherence or by comparing with all (Chen & Wang 2010, section
//! 4.3).

use super::field::Field;
use super::matches::code;
use super::phases::Around;
use super::search::Method;
use crate::lazy::{Isa, Pixel};
use crate::search::{PatchTable, Patches, SimilarSets, distance, is_wide, project};

/// What all voxels of a direction share.
pub(super) struct Direction<'a> {
    pub direction: usize,
    pub field: &'a Field,
    pub patches: &'a Patches,
    pub sets: Option<&'a SimilarSets>,
    pub method: Method,
    pub reach: i32,
    pub isa: Isa,
    pub around: &'a Around,
    /// For an exhaustive search the centres, and their coefficients in blocks.
    pub all: Option<&'a (Vec<Pixel>, PatchTable)>,
    /// How much farther each pixel counts, in units of 1/256: the index histogram.
    pub weights: &'a [u32],
}

/// A voxel's match: the pixel, and the code of its distance.
pub(super) type Match = (Pixel, u16);

/// Finds the matches of some voxels.
pub(super) fn match_voxels(search: &Direction<'_>, voxels: &[u32], out: &mut [Match]) {
    macro_rules! dims {
        ($($d:literal)*) => {
            match search.patches.basis.dims {
                $($d => enter::<$d>(search, voxels, out),)*
                // No basis has another number of components.
                _ => {}
            }
        };
    }
    dims!(8 16 24 32 40 48 56 64);
}

fn enter<const D: usize>(search: &Direction<'_>, voxels: &[u32], out: &mut [Match]) {
    #[cfg(target_arch = "x86_64")]
    if is_wide(search.isa) {
        // SAFETY: `isa` comes from `available_instruction_sets`.
        return unsafe { matches_avx2::<D>(search, voxels, out) };
    }
    matches::<D>(search, voxels, out, false);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn matches_avx2<const D: usize>(search: &Direction<'_>, voxels: &[u32], out: &mut [Match]) {
    matches::<D>(search, voxels, out, true);
}

/// Entries of the table of candidates seen, which saves most of the repeated ones.
const SEEN: usize = 512;

/// Adds a candidate to the list unless it is there already. Without a branch, since nobody could foretell it.
#[inline(always)]
fn propose(
    candidates: &mut [Pixel],
    count: &mut usize,
    seen: &mut [u32; SEEN],
    epoch: u32,
    candidate: Pixel,
) {
    let slot = &mut seen[(u32::from(candidate).wrapping_mul(40_503) >> 5) as usize % SEEN];
    let tag = epoch | u32::from(candidate);
    let new = *slot != tag;
    *slot = tag;
    candidates[*count] = candidate;
    *count += usize::from(new);
}

// Written with plain loops: a closure would be compiled without the instruction set and not inlined.
#[inline(always)]
fn matches<const D: usize>(search: &Direction<'_>, voxels: &[u32], out: &mut [Match], wide: bool) {
    let Direction { field, patches, .. } = search;
    let view = patches.view(search.direction);
    let (table, basis) = (&patches.views[view], &patches.basis);
    let (weights, bias) = (&basis.weights[view][..], &basis.bias[view][..]);
    let sources = &field.sources[view.min(field.sources.len() - 1)][..];
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
    let (columns_wide, rows_high) = ((right - left) as u32, (bottom - top) as u32);
    let k = search.sets.map_or(1, |sets| sets.k);
    let sets: &[Pixel] = search.sets.map_or(&[], |sets| &sets.views[view]);
    let mut samples = vec![0i16; window.pixels() * 4];
    let mut seen = [0u32; SEEN];
    let mut candidates: Vec<Pixel> = vec![0; window.pixels() * k + 1];
    let mut distances = Vec::new();
    for (i, (&voxel, out)) in voxels.iter().zip(out).enumerate() {
        let voxel = voxel as usize;
        let (own, columns, rows) = search.around.plane(voxel, search.direction, before, size);
        let mut to = samples.chunks_exact_mut(4);
        for &row in rows {
            for &column in columns {
                let color = field.colors[(own + row + column) as usize];
                if let Some([r, g, b, feature]) = to.next() {
                    *r = i16::from(color[0]);
                    *g = i16::from(color[1]);
                    *b = i16::from(color[2]);
                    *feature = i16::from(color[3]);
                }
            }
        }
        let query: [i16; D] = project::<D>(&samples, weights, bias, wide);
        let (mut best, mut cost, mut nearest) = (0 as Pixel, u64::MAX, 0u32);
        if let (Method::Exhaustive, Some((centres, all))) = (search.method, search.all) {
            all.distances(&query, &mut distances, search.isa);
            for (i, centre) in centres.iter().enumerate() {
                let at = usize::from(centre >> 8) * table.width as usize + usize::from(centre & 255);
                let weighted = (u64::from(distances[i]) + 1) * u64::from(search.weights[at]);
                if weighted < cost {
                    (best, cost, nearest) = (*centre, weighted, distances[i]);
                }
            }
        } else {
            let epoch = (i as u32 + 1) << 16;
            let mut count = 0;
            for (r, &row) in rows.iter().enumerate() {
                let across = r as i32 - before;
                for (c, &place) in columns.iter().enumerate() {
                    let along = c as i32 - before;
                    let source = sources[(own + row + place) as usize];
                    let mut column = i32::from(source & 255) - along;
                    let mut line = i32::from(source >> 8) - across;
                    if table.tileable {
                        column = column.rem_euclid(table.width);
                        line = line.rem_euclid(table.height);
                    } else if (column - left) as u32 > columns_wide || (line - top) as u32 > rows_high {
                        continue;
                    }
                    let at = (line * table.width + column) as usize;
                    let near = along.abs() <= search.reach && across.abs() <= search.reach;
                    if near && !sets.is_empty() {
                        for &candidate in &sets[at * k..at * k + k] {
                            propose(&mut candidates, &mut count, &mut seen, epoch, candidate);
                        }
                    } else {
                        propose(&mut candidates, &mut count, &mut seen, epoch, (column | line << 8) as Pixel);
                    }
                }
            }
            for &candidate in &candidates[..count] {
                let at = usize::from(candidate >> 8) * table.width as usize + usize::from(candidate & 255);
                let found = distance::<D>(&query, &table.table[at * D..at * D + D], wide);
                let weighted = (u64::from(found) + 1) * u64::from(search.weights[at]);
                if weighted < cost {
                    (best, cost, nearest) = (candidate, weighted, found);
                }
            }
            if cost == u64::MAX {
                // Every source lies so near to an edge that no window fits: the centre nearest to the voxel's own.
                let source = sources[voxel];
                let column = i32::from(source & 255).clamp(left, right);
                let line = i32::from(source >> 8).clamp(top, bottom);
                best = (column | line << 8) as Pixel;
                let at = (line * table.width + column) as usize;
                nearest = distance::<D>(&query, &table.table[at * D..at * D + D], wide);
            }
        }
        *out = (best, code(nearest));
    }
}
