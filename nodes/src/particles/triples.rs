//! Which cross-sections belong together: triples, one of each view, that agree along the lines where they cross
//! (Du et al. 2013, section 3.1).
//!
//! With P cross-sections a view there are P³ triples of A³ alignments each. The error of a triple is a sum over its three pairs,
//! and there are only 3 P² A² aligned pairs, so all of these are computed first. A triple whose three pairs, each at the best
//! of its own alignments, exceed the threshold already is passed over; the others take A³ additions. The threshold is a
//! fraction of the largest error, which is found on a sample of triples if there are many.

use rayon::prelude::*;

use super::axes::{coordinate, views_with};
use super::section::{Section, Sections, pixel_index};
use crate::control::{Cancelled, Control, check};
use crate::exemplar::View;
use crate::lazy::random::hash;

/// How triples are selected.
#[derive(Clone, Copy, Debug)]
pub struct TripleSettings {
    /// Triples whose error exceeds this fraction of the largest that occurs are rejected (the paper's 20 %).
    pub threshold: f64,
    /// Triples kept at most.
    pub most: usize,
    /// Cross-sections of a view that are considered at most; of more, this many are drawn.
    pub sections: usize,
    /// Positions tried for the centre along each axis of a cross-section, 1 to 5.
    pub alignments: usize,
    /// Seed of the draws.
    pub seed: u64,
}

impl Default for TripleSettings {
    fn default() -> Self {
        Self { threshold: 0.2, most: 160, sections: 160, alignments: 3, seed: 1 }
    }
}

/// Three cross-sections, one of each view, with the pixels that lie on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple {
    /// The sections of the views normal to x, y and z.
    pub sections: [u32; 3],
    /// The pixel of each that is the particle's centre.
    pub centers: [[i32; 2]; 3],
    /// The sum over the three lines of the mean colour difference, 0 to 3.
    pub error: f32,
}

/// Why there are no triples.
#[derive(Clone, Debug, thiserror::Error)]
pub enum TripleError {
    /// The computation was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// All were rejected.
    #[error(
        "no three cross-sections fit together: the best triple has an error of {best:.3}, {percent:.1} % of the largest \
         ({largest:.3}), the threshold is {threshold:.1} %; raise `threshold`, or use views that show particles of one shape"
    )]
    Rejected {
        /// The least error found.
        best: f64,
        /// The same in percent of the largest.
        percent: f64,
        /// The largest error.
        largest: f64,
        /// The threshold in percent.
        threshold: f64,
    },
}

impl From<Cancelled> for TripleError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// What was tried and found.
#[derive(Clone, Debug, Default)]
pub struct TripleCounts {
    /// Triples that were within the threshold.
    pub accepted: u64,
    /// Triples in all.
    pub possible: u64,
    /// The largest error.
    pub largest: f64,
}

const DRAW: u32 = 101;
const SAMPLE: u32 = 102;
/// Triples looked at to find the largest error.
const SAMPLES: u64 = 20_000;
/// Centres of a section at most, and the stride of their tables.
const CENTRES: usize = 25;
/// Errors are kept in this fraction of one.
const SCALE: f64 = 65_535.0;

/// The error of a triple, its sections, and their centres, by position in the lists of candidates.
type Scored = (u32, [usize; 3], [usize; 3]);

/// The triples of least error that together use as many different cross-sections as they can: by rounds, in each of which no
/// cross-section is used more than once more than in the round before.
///
/// # Errors
/// [`TripleError`].
pub fn find_triples(
    views: [&Sections; 3],
    settings: &TripleSettings,
    control: &dyn Control,
) -> Result<(Vec<Triple>, TripleCounts), TripleError> {
    let chosen: [Vec<Candidate>; 3] = std::array::from_fn(|v| candidates(views[v], v, settings));
    let counts = chosen.each_ref().map(Vec::len);
    let pairs: Vec<Pairs> = (0..3)
        .map(|axis| {
            let [a, b] = views_with(axis);
            control.progress(0.1 * axis as f32);
            Pairs::new(&chosen[a], coordinate(a, axis), &chosen[b], coordinate(b, axis), control)
        })
        .collect::<Result<_, Cancelled>>()?;
    let [px, py, pz] = counts.map(|n| n as u64);
    let possible = px * py * pz;
    let sampled = possible.min(SAMPLES);
    let largest = (0..sampled)
        .into_par_iter()
        .map(|i| {
            let at = if sampled == possible {
                i
            } else {
                let draw = |k: i32| u64::from(hash(settings.seed, SAMPLE, [i as i32, k, 0]));
                (draw(0) << 32 | draw(1)) % possible
            };
            best_alignment(&pairs, [at / (py * pz), at / pz % py, at % pz].map(|i| i as usize), u32::MAX)
                .map_or(0, |(error, _)| error)
        })
        .max()
        .unwrap_or(0);
    let limit = (f64::from(largest) * settings.threshold) as u32;

    /// What one section of the first view found: triples, and the least error of all.
    type Found = (Vec<Scored>, u64);
    let found: Vec<Found> = (0..counts[0])
        .into_par_iter()
        .map(|x| {
            check(control)?;
            let mut accepted = Vec::new();
            let mut count = 0;
            // The best few of each pair of sections, so that all sections have their chance.
            let mut by_z: Vec<Vec<Scored>> = vec![Vec::new(); counts[2]];
            for y in 0..counts[1] {
                let mut by_y = Vec::new();
                let first = pairs[2].least(x, y);
                if first > limit {
                    continue;
                }
                for (z, by_z) in by_z.iter_mut().enumerate() {
                    if first + pairs[1].least(x, z) + pairs[0].least(y, z) > limit {
                        continue;
                    }
                    if let Some((error, centers)) = best_alignment(&pairs, [x, y, z], limit) {
                        count += 1;
                        keep_best(&mut by_y, (error, [x, y, z], centers));
                        keep_best(by_z, (error, [x, y, z], centers));
                    }
                }
                accepted.append(&mut by_y);
            }
            accepted.extend(by_z.into_iter().flatten());
            Ok((accepted, count))
        })
        .collect::<Result<_, Cancelled>>()?;
    control.progress(0.9);
    let accepted: u64 = found.iter().map(|(_, count)| count).sum();
    let mut all: Vec<_> = found.into_iter().flat_map(|(triples, _)| triples).collect();
    all.sort_unstable();
    all.dedup();
    if all.is_empty() {
        let best = least_error(&pairs, counts, control)?;
        return Err(TripleError::Rejected {
            best: f64::from(best) / SCALE,
            percent: 100.0 * f64::from(best) / f64::from(largest.max(1)),
            largest: f64::from(largest) / SCALE,
            threshold: 100.0 * settings.threshold,
        });
    }
    let triples = spread(&all, counts, settings.most).into_iter().map(|i| {
        let (error, sections, centers) = all[i];
        Triple {
            sections: std::array::from_fn(|v| chosen[v][sections[v]].section),
            centers: std::array::from_fn(|v| chosen[v][sections[v]].centers[centers[v]]),
            error: (f64::from(error) / SCALE) as f32,
        }
    });
    Ok((triples.collect(), TripleCounts { accepted, possible, largest: f64::from(largest) / SCALE }))
}

/// Keeps the three of least error.
fn keep_best(best: &mut Vec<Scored>, new: Scored) {
    best.push(new);
    best.sort_unstable();
    best.truncate(3);
}

/// Indices of up to `most` triples of a sorted list, by rounds in which every section is used at most once more.
fn spread(all: &[Scored], counts: [usize; 3], most: usize) -> Vec<usize> {
    let mut uses = counts.map(|n| vec![0usize; n]);
    let mut taken = vec![false; all.len()];
    let mut order = Vec::new();
    for round in 1.. {
        let before = order.len();
        for (i, (_, sections, _)) in all.iter().enumerate() {
            if order.len() < most && !taken[i] && (0..3).all(|v| uses[v][sections[v]] < round) {
                taken[i] = true;
                order.push(i);
                (0..3).for_each(|v| uses[v][sections[v]] += 1);
            }
        }
        if order.len() >= most.min(all.len()) || order.len() == before && taken.iter().all(|&t| t) {
            break;
        }
    }
    order.sort_unstable();
    order
}

/// The least error of all triples, for a message.
fn least_error(pairs: &[Pairs], counts: [usize; 3], control: &dyn Control) -> Result<u32, Cancelled> {
    let least: Vec<u32> = (0..counts[0])
        .into_par_iter()
        .map(|x| {
            check(control)?;
            let mut least = u32::MAX;
            for y in 0..counts[1] {
                for z in 0..counts[2] {
                    if pairs[2].least(x, y) + pairs[1].least(x, z) + pairs[0].least(y, z) >= least {
                        continue;
                    }
                    if let Some((error, _)) = best_alignment(pairs, [x, y, z], least.saturating_sub(1)) {
                        least = error;
                    }
                }
            }
            Ok(least)
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(least.into_iter().min().unwrap_or(u32::MAX))
}

/// The alignment of least error of three sections, if that is within `limit`.
fn best_alignment(pairs: &[Pairs], [x, y, z]: [usize; 3], limit: u32) -> Option<(u32, [usize; 3])> {
    let (in_x, in_y, in_z) = (pairs[0].table(y, z), pairs[1].table(x, z), pairs[2].table(x, y));
    let [nx, ny, nz] = [pairs[2].centers[0][x], pairs[2].centers[1][y], pairs[1].centers[1][z]];
    let mut best: Option<(u32, [usize; 3])> = None;
    for i in 0..nx {
        for j in 0..ny {
            let both = u32::from(in_z[i * ny + j]);
            for k in 0..nz {
                let error = both + u32::from(in_y[i * nz + k]) + u32::from(in_x[j * nz + k]);
                if error <= limit && best.is_none_or(|(least, _)| error < least) {
                    best = Some((error, [i, j, k]));
                }
            }
        }
    }
    best
}

/// A section with the centres that are tried.
struct Candidate {
    section: u32,
    centers: Vec<[i32; 2]>,
    /// For each centre, the line along the columns' axis and the line along the rows' axis.
    lines: Vec<[Line; 2]>,
}

/// A line of pixels through a centre.
struct Line {
    /// Pixels from the centre to the first one, negative.
    low: i32,
    /// Colour and whether the pixel belongs to the section.
    pixels: Vec<([u8; 3], bool)>,
}

fn candidates(of: &Sections, v: usize, settings: &TripleSettings) -> Vec<Candidate> {
    let mut chosen: Vec<u32> = (0..of.sections.len() as u32).collect();
    if chosen.len() > settings.sections {
        chosen.sort_by_key(|&i| (hash(settings.seed, DRAW, [i as i32, v as i32, 0]), i));
        chosen.truncate(settings.sections.max(1));
        chosen.sort_unstable();
    }
    chosen
        .into_par_iter()
        .map(|index| {
            let section = &of.sections[index as usize];
            let centers = centers(section, settings.alignments);
            let lines =
                centers.iter().map(|&c| [0, 1].map(|axis| line(&of.view, section, c, axis))).collect();
            Candidate { section: index, centers, lines }
        })
        .collect()
}

/// Pixels that may be the centre of a particle: those on a small grid around the centroid, no further from it than half of the
/// smallest distance from the centroid to the boundary (Fig. 3c).
pub(super) fn centers(section: &Section, alignments: usize) -> Vec<[i32; 2]> {
    let depth = section.depth();
    let width = section.size[0] as i32;
    let depth_at = |[x, y]: [i32; 2]| {
        let inside = section.holds(x, y);
        if inside { depth[((y - section.low[1]) * width + x - section.low[0]) as usize] } else { 0.0 }
    };
    let mut middle = section.centroid.map(|c| libm::roundf(c) as i32);
    if depth_at(middle) <= 1.0 && section.area > 4 {
        // The centroid of a crescent lies outside: its deepest pixel does instead.
        let deepest = section.pixels().max_by(|&a, &b| depth_at(a).total_cmp(&depth_at(b)).then(b.cmp(&a)));
        middle = deepest.unwrap_or(middle);
    }
    let reach = f64::from(depth_at(middle)) / 2.0;
    let side = (alignments.clamp(1, 5) as i32 - 1) / 2;
    let step = if side == 0 { 0.0 } else { (reach / (f64::from(side) * std::f64::consts::SQRT_2)).max(1.0) };
    let mut found = vec![middle];
    for dy in -side..=side {
        for dx in -side..=side {
            let offset = [dx, dy].map(|d| libm::round(f64::from(d) * step) as i32);
            let center = [middle[0] + offset[0], middle[1] + offset[1]];
            let squared = f64::from(offset[0] * offset[0] + offset[1] * offset[1]);
            if squared <= reach * reach && section.holds(center[0], center[1]) && !found.contains(&center) {
                found.push(center);
            }
        }
    }
    found.truncate(CENTRES);
    found
}

fn line(view: &View, section: &Section, center: [i32; 2], axis: usize) -> Line {
    let color = view.carried.first().map(|(_, image)| image);
    let place = |t: i32| if axis == 0 { [center[0] + t, center[1]] } else { [center[0], center[1] + t] };
    let holds = |t: i32| {
        let [x, y] = place(t);
        section.holds(x, y)
    };
    let from = section.low[axis] - center[axis];
    let to = from + section.size[axis] as i32;
    let low = (from..to).find(|&t| holds(t)).unwrap_or(0);
    let high = (from..to).rev().find(|&t| holds(t)).unwrap_or(0);
    let pixels = (low..=high).map(|t| {
        let [x, y] = place(t);
        let i = pixel_index(view, x, y) as u32;
        (color.map_or([0; 3], |image| image.rgb8(i % view.width, i / view.width)), holds(t))
    });
    Line { low, pixels: pixels.collect() }
}

/// The mean difference of two lines that are laid on each other, in units of one over [`SCALE`]: of colours where both belong to their
/// sections, the largest there is where one does.
fn difference(a: &Line, b: &Line) -> u16 {
    let high = |line: &Line| line.low + line.pixels.len() as i32;
    let (mut sum, mut count) = (0u32, 0u32);
    for t in a.low.min(b.low)..high(a).max(high(b)) {
        let at = |line: &Line| {
            usize::try_from(t - line.low)
                .ok()
                .and_then(|i| line.pixels.get(i))
                .copied()
                .filter(|(_, inside)| *inside)
        };
        match (at(a), at(b)) {
            (Some((p, _)), Some((q, _))) => {
                sum += (0..3).map(|c| u32::from(p[c].abs_diff(q[c]))).sum::<u32>();
                count += 1;
            }
            (None, None) => {}
            _ => {
                sum += 3 * 255;
                count += 1;
            }
        }
    }
    (f64::from(sum) / f64::from(count.max(1)) / 765.0 * SCALE) as u16
}

/// The differences of all aligned pairs of sections of two views.
struct Pairs {
    /// For each section of the one and of the other view, the number of its centres.
    centers: [Vec<usize>; 2],
    /// Where the table of a pair begins; its rows are the first section's centres.
    starts: Vec<usize>,
    errors: Vec<u16>,
    least: Vec<u16>,
}

impl Pairs {
    fn new(
        a: &[Candidate],
        axis_a: usize,
        b: &[Candidate],
        axis_b: usize,
        control: &dyn Control,
    ) -> Result<Self, Cancelled> {
        let rows: Vec<Vec<Vec<u16>>> = a
            .par_iter()
            .map(|a| {
                check(control)?;
                let table = |b: &Candidate| {
                    let lines = |l: &[Line; 2]| {
                        b.lines.iter().map(|m| difference(&l[axis_a], &m[axis_b])).collect::<Vec<_>>()
                    };
                    a.lines.iter().flat_map(lines).collect()
                };
                Ok(b.iter().map(table).collect())
            })
            .collect::<Result<_, Cancelled>>()?;
        let (mut starts, mut errors, mut least) = (Vec::new(), Vec::new(), Vec::new());
        for table in rows.into_iter().flatten() {
            starts.push(errors.len());
            least.push(table.iter().copied().min().unwrap_or(u16::MAX));
            errors.extend(table);
        }
        starts.push(errors.len());
        let count = |of: &[Candidate]| of.iter().map(|c| c.centers.len()).collect();
        Ok(Self { centers: [count(a), count(b)], starts, errors, least })
    }

    fn table(&self, a: usize, b: usize) -> &[u16] {
        let pair = a * self.centers[1].len() + b;
        &self.errors[self.starts[pair]..self.starts[pair + 1]]
    }

    fn least(&self, a: usize, b: usize) -> u32 {
        self.least[a * self.centers[1].len() + b].into()
    }
}
