//! The coherence iterations that thin out candidate triples (Dong et al. 2008, section 4.2).

use rayon::prelude::*;

use super::candidates::{CandidateSettings, SET, Triple, ViewCandidates};
use super::pyramid::{LevelView, Pixel};
use super::similarity::apart;
use crate::control::{Cancelled, Control, check};

const UNIT: [(i32, i32); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];

/// Keeps the triples that continue those of neighbouring pixels in both other exemplars, iteration by iteration,
/// and cuts the sets to `keep`. Where none continues, the best by crossbar error stay.
///
/// The test alone lets nearly every triple pass while sets are large, so each iteration also halves the sets, by
/// crossbar error weighed with the number of neighbours that continue the triple.
pub(super) fn refine(
    view: &LevelView,
    others: [&LevelView; 2],
    mut sets: Vec<Vec<Triple>>,
    settings: &CandidateSettings,
    control: &dyn Control,
) -> Result<ViewCandidates, Cancelled> {
    let keep = settings.keep.clamp(1, SET);
    let mean =
        |sets: &[Vec<Triple>]| (sets.iter().map(Vec::len).sum::<usize>() * 1000 / sets.len().max(1)) as u32;
    let mut survivors = vec![mean(&sets)];
    for _ in 0..settings.iterations {
        let largest = sets.iter().map(Vec::len).max().unwrap_or(0);
        if largest <= keep {
            break;
        }
        let target = (largest / 2).max(keep);
        sets = iterate(view, others, &sets, target, control)?;
        survivors.push(mean(&sets));
    }
    let mut result = ViewCandidates { triples: Vec::new(), counts: Vec::new(), survivors };
    for set in &sets {
        let chosen = diverse(others, set, keep);
        result.counts.push(chosen.len() as u8);
        result.triples.push(std::array::from_fn(|k| chosen[k.min(chosen.len() - 1)]));
    }
    Ok(result)
}

/// One iteration: the test and the cut to `target` triples a pixel.
fn iterate(
    view: &LevelView,
    others: [&LevelView; 2],
    sets: &[Vec<Triple>],
    target: usize,
    control: &dyn Control,
) -> Result<Vec<Vec<Triple>>, Cancelled> {
    let rows: Vec<Vec<Vec<Triple>>> = (0..view.height)
        .into_par_iter()
        .map(|y| {
            let mut marks = others.map(|other| vec![0u8; other.texels.len()]);
            (0..view.width)
                .map(|x| {
                    check(control)?;
                    let set = &sets[view.index(view.pixel(x, y))];
                    let neighbours =
                        UNIT.map(|(dx, dy)| &sets[view.index(view.shifted(view.pixel(x, y), dx, dy))][..]);
                    mark(&mut marks, others, neighbours, true);
                    let around = |k: usize, pixel: Pixel| {
                        let bits =
                            UNIT.map(|(dx, dy)| marks[k][others[k].index(others[k].shifted(pixel, dx, dy))]);
                        bits.into_iter().fold(0, |all, b| all | b).count_ones()
                    };
                    let mut ranked: Vec<(u64, usize, bool)> = set
                        .iter()
                        .enumerate()
                        .map(|(i, triple)| {
                            let (a, b) = (around(0, triple.next), around(1, triple.last));
                            // From the crossbar error itself down to two thirds of it with all neighbours continuing.
                            let weighed = u64::from(triple.crossbar) * 16 / u64::from(16 + a + b);
                            (weighed, i, a > 0 && b > 0)
                        })
                        .collect();
                    mark(&mut marks, others, neighbours, false);
                    if ranked.iter().any(|r| r.2) {
                        ranked.retain(|r| r.2);
                    }
                    ranked.sort_unstable();
                    Ok(ranked.into_iter().take(target).map(|(_, i, _)| set[i]).collect())
                })
                .collect()
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(rows.concat())
}

/// Sets bit `i` of every pixel that a triple of neighbour `i` uses, or clears all of them.
fn mark(marks: &mut [Vec<u8>; 2], others: [&LevelView; 2], neighbours: [&[Triple]; 4], set: bool) {
    for (i, triples) in neighbours.into_iter().enumerate() {
        for triple in triples {
            for (k, pixel) in [triple.next, triple.last].into_iter().enumerate() {
                let at = others[k].index(pixel);
                marks[k][at] = if set { marks[k][at] | 1 << i } else { 0 };
            }
        }
    }
}

/// The first `keep` triples that differ from those before by more than a pixel in either exemplar, filled up
/// with the others.
fn diverse(others: [&LevelView; 2], set: &[Triple], keep: usize) -> Vec<Triple> {
    let near = |k: usize, a: Pixel, b: Pixel| apart(others[k], a, b) <= 1;
    let (mut chosen, mut rest): (Vec<Triple>, Vec<Triple>) = (Vec::new(), Vec::new());
    for &triple in set {
        let twin = chosen.iter().any(|c| near(0, c.next, triple.next) && near(1, c.last, triple.last));
        if twin { rest.push(triple) } else { chosen.push(triple) }
    }
    chosen.extend(rest);
    chosen.truncate(keep);
    chosen
}
