//! The nearest neighbourhood of every voxel of a row, by k-coherence or by comparing with all (Chen & Wang 2010, section
//! 4.3).

use super::field::Field;
use super::matches::code;
use super::phases::{Columns, Place, place};
use super::search::Method;
use crate::lazy::{Isa, Pixel};
use crate::search::{PatchTable, Patches, SimilarSets, distance, is_wide, project};

/// What all rows of a direction share.
pub(super) struct Direction<'a> {
    pub direction: usize,
    pub field: &'a Field,
    pub patches: &'a Patches,
    pub sets: Option<&'a SimilarSets>,
    pub method: Method,
    pub reach: i32,
    pub isa: Isa,
    pub columns: &'a Columns,
    /// For an exhaustive search the centres, and their coefficients in blocks.
    pub all: Option<&'a (Vec<Pixel>, PatchTable)>,
    /// How much farther each pixel counts, in units of 1/256: the index histogram.
    pub weights: &'a [u32],
}

/// A row's matches.
pub(super) struct RowMatches<'a> {
    pub pixels: &'a mut [Pixel],
    pub codes: &'a mut [u16],
}

/// Finds the matches of the row (y, z).
pub(super) fn match_row(search: &Direction<'_>, y: usize, z: usize, out: &mut RowMatches<'_>) {
    macro_rules! dims {
        ($($d:literal)*) => {
            match search.patches.basis.dims {
                $($d => enter::<$d>(search, y, z, out),)*
                // No basis has another number of components.
                _ => {}
            }
        };
    }
    dims!(8 16 24 32 40 48 56 64);
}

fn enter<const D: usize>(search: &Direction<'_>, y: usize, z: usize, out: &mut RowMatches<'_>) {
    #[cfg(target_arch = "x86_64")]
    if is_wide(search.isa) {
        // SAFETY: `isa` comes from `available_instruction_sets`.
        return unsafe { row_avx2::<D>(search, y, z, out) };
    }
    row::<D>(search, y, z, out, false);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn row_avx2<const D: usize>(search: &Direction<'_>, y: usize, z: usize, out: &mut RowMatches<'_>) {
    row::<D>(search, y, z, out, true);
}

/// Entries of the table of candidates seen, which saves most of the repeated ones.
const SEEN: usize = 512;

// Written with plain loops: a closure would be compiled without the instruction set and not inlined.
#[inline(always)]
fn row<const D: usize>(search: &Direction<'_>, y: usize, z: usize, out: &mut RowMatches<'_>, wide: bool) {
    let Direction { field, patches, .. } = search;
    let view = patches.view(search.direction);
    let (table, basis) = (&patches.views[view], &patches.basis);
    let (weights, bias) = (&basis.weights[view][..], &basis.bias[view][..]);
    let sources = &field.sources[view.min(field.sources.len() - 1)][..];
    let window = patches.window();
    let offsets: Vec<(i32, i32)> = window.offsets().collect();
    let places: Vec<Place> =
        offsets.iter().map(|&(c, r)| place(field.size, search.direction, y, z, c, r)).collect();
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
    let mut distances = Vec::new();
    for x in 0..field.size[0] {
        for (place, to) in places.iter().zip(samples.chunks_exact_mut(4)) {
            let color = field.colors[search.columns.at(*place, x)];
            to[0] = i16::from(color[0]);
            to[1] = i16::from(color[1]);
            to[2] = i16::from(color[2]);
            to[3] = i16::from(color[3]);
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
            let epoch = (x as u32 + 1) << 16;
            for (offset, place) in offsets.iter().zip(&places) {
                let source = sources[search.columns.at(*place, x)];
                let mut column = i32::from(source & 255) - offset.0;
                let mut line = i32::from(source >> 8) - offset.1;
                if table.tileable {
                    column = column.rem_euclid(table.width);
                    line = line.rem_euclid(table.height);
                } else if (column - left) as u32 > columns_wide || (line - top) as u32 > rows_high {
                    continue;
                }
                let at = (line * table.width + column) as usize;
                let near = offset.0.abs() <= search.reach && offset.1.abs() <= search.reach;
                let own = [(column | line << 8) as Pixel];
                let proposed = if near && !sets.is_empty() { &sets[at * k..at * k + k] } else { &own[..] };
                for &candidate in proposed {
                    let slot = &mut seen[(u32::from(candidate).wrapping_mul(40_503) >> 5) as usize % SEEN];
                    let tag = epoch | u32::from(candidate);
                    if *slot == tag {
                        continue;
                    }
                    *slot = tag;
                    let at =
                        usize::from(candidate >> 8) * table.width as usize + usize::from(candidate & 255);
                    let found = distance::<D>(&query, &table.table[at * D..at * D + D], wide);
                    let weighted = (u64::from(found) + 1) * u64::from(search.weights[at]);
                    if weighted < cost {
                        (best, cost, nearest) = (candidate, weighted, found);
                    }
                }
            }
            if cost == u64::MAX {
                // Every source lies so near to an edge that no window fits: the centre nearest to the voxel's own.
                let own = sources[search.columns.at(place(field.size, search.direction, y, z, 0, 0), x)];
                let column = i32::from(own & 255).clamp(left, right);
                let line = i32::from(own >> 8).clamp(top, bottom);
                best = (column | line << 8) as Pixel;
                let at = (line * table.width + column) as usize;
                nearest = distance::<D>(&query, &table.table[at * D..at * D + D], wide);
            }
        }
        out.pixels[x] = best;
        out.codes[x] = code(nearest);
    }
}
