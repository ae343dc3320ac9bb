//! The optimisation phase: colours from matches (Chen & Wang 2010, section 4.2).
//!
//! It is the processor's unless the caller allows answers that differ in rounding ([`Control::gpu_for_floats`]). Weights span too
//! many orders of magnitude for small integers (γ = 0.8, distances to 2³², histogram weights to 10⁻¹⁴), so they are floats, summed
//! in one order. A compute device may contract a product and a sum to one operation and divide less exactly, hence round
//! otherwise; where two texels are about equally near to the mean, another one may be chosen, and the sweeps after that go another
//! way. Such an answer needs a cache key of its own.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::control_map::ControlMap;
use super::field::Field;
use super::matches::{CODES, DirectionMatches, Matches, decode};
use super::phases::{Around, PHASES, PORTION, Phases};
use super::solve_device;
use super::weights::{Usage, WeightSettings};
use crate::control::{Cancelled, Control, Stopped, check, on_device_in_floats};
use crate::lazy::{Isa, LevelView, Pixel, available_instruction_sets};
use crate::search::{Window, is_wide};

/// What becomes a voxel's colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// The texel nearest to the weighted mean, among those that overlap at the voxel (Han et al. 2006).
    Discrete,
    /// The weighted mean itself (Kopf et al. 2007).
    Mean,
}

/// How colours are solved for.
#[derive(Clone, Debug, PartialEq)]
pub struct SolveSettings {
    /// What becomes a voxel's colour.
    pub solver: Solver,
    /// The exponent γ of the energy: a match at distance r weighs r^(γ − 2).
    pub gamma: f64,
    /// How texels that are used too often are held back.
    pub weights: WeightSettings,
    /// The order of updates.
    pub seed: u64,
    /// The number of the sweep; each has an order of its own.
    pub sweep: u32,
}

const PURPOSE: u32 = 0x501e_e002;

/// A texel of a view that has a margin on all sides, so that windows never leave it.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Texel {
    color: [u8; 4],
    weight: f32,
}

/// A view with a margin of a window's size.
pub(super) struct Padded {
    /// Texels along a row.
    pub pitch: usize,
    /// Texels before the view's first, along rows and columns.
    pub margin: i32,
    pub texels: Vec<Texel>,
    /// The pixels of the view that they are.
    pub sources: Vec<Pixel>,
}

impl Padded {
    fn new(view: &LevelView, margin: i32) -> Self {
        let pitch = view.width + 2 * margin;
        let mut padded = Self { pitch: pitch as usize, margin, texels: Vec::new(), sources: Vec::new() };
        for y in -margin..view.height + margin {
            for x in -margin..view.width + margin {
                let (x, y) = if view.tileable {
                    (x.rem_euclid(view.width), y.rem_euclid(view.height))
                } else {
                    (x.clamp(0, view.width - 1), y.clamp(0, view.height - 1))
                };
                padded.texels.push(Texel { color: view.texel(x, y), weight: 1.0 });
                padded.sources.push((x | y << 8) as Pixel);
            }
        }
        padded
    }

    fn weigh(&mut self, view: &LevelView, weights: &[f32]) {
        for (texel, &source) in self.texels.iter_mut().zip(&self.sources) {
            texel.weight = weights[view.index(source)];
        }
    }
}

/// Colours from matches: the weighted mean of all texels that overlap at a voxel (equation 2), or the texel nearest to it.
/// `before` is the field that the matches were made from; its histograms are the ones to start with.
///
/// Where [`Control::gpu_for_floats`] offers a compute device it is used. It gives the same bits each time, and differs from the
/// processor as rounding does: where histograms do not count, after one sweep less than 1 % of the voxels choose another texel, and
/// less than 1 % of the channels of a mean differ by more than one step of 255. Strong histograms amplify what differs: one voxel
/// that chooses otherwise changes the weights of the phases after it, and their voxels may go another way, as with another seed;
/// texels are held back as much as before.
///
/// # Errors
/// [`Stopped`].
pub fn solve(
    matches: &Matches,
    views: &[LevelView],
    before: Option<&Field>,
    theta: Option<&ControlMap>,
    settings: &SolveSettings,
    control: &dyn Control,
) -> Result<Field, Stopped> {
    let sweep = || Sweep::new(matches, views, before, theta, settings);
    let on_device = on_device_in_floats(control, |gpu| solve_device::run(gpu, sweep(), control))?;
    if let Some(field) = on_device {
        return Ok(field);
    }
    let isa = available_instruction_sets().last().copied().unwrap_or(Isa::Portable);
    Ok(solve_with(isa, matches, views, before, theta, settings, control)?)
}

pub(super) fn solve_with(
    isa: Isa,
    matches: &Matches,
    views: &[LevelView],
    before: Option<&Field>,
    theta: Option<&ControlMap>,
    settings: &SolveSettings,
    control: &dyn Control,
) -> Result<Field, Cancelled> {
    let mut sweep = Sweep::new(matches, views, before, theta, settings);
    let around = Around::new(matches.size);
    let in_bricks = [0, 1, 2].map(|direction| {
        let matched = &matches.directions[direction];
        if matched.pixels.is_empty() { Vec::new() } else { around.arrange(|i| packed(matched, i)) }
    });
    let mut solved: Vec<Solved> = Vec::new();
    for (p, voxels) in sweep.phases().iter().enumerate() {
        check(control)?;
        control.progress(p as f32 / PHASES as f32);
        sweep.weigh();
        let job = Job {
            window: matches.window,
            matches: &in_bricks,
            tables: &sweep.tables,
            distance_weights: &sweep.distance_weights,
            around: &around,
            isa,
            solver: settings.solver,
        };
        solved.clear();
        solved.resize(voxels.len(), Solved::default());
        solved.par_chunks_mut(PORTION).zip(voxels.par_chunks(PORTION)).try_for_each(|(solved, voxels)| {
            check(control)?;
            solve_voxels(&job, voxels, solved);
            Ok(())
        })?;
        sweep.keep(voxels, &solved);
    }
    Ok(sweep.field)
}

/// A match in one word: the pixel, and the code of its distance above.
pub(super) fn packed(matched: &DirectionMatches, voxel: usize) -> u32 {
    u32::from(matched.pixels[voxel]) | u32::from(matched.codes[voxel]) << 16
}

/// A sweep over all voxels, whoever solves for them: the weights of texels and what has been solved so far.
pub(super) struct Sweep<'a> {
    pub matches: &'a Matches,
    views: &'a [LevelView],
    before: Option<&'a Field>,
    theta: Option<&'a ControlMap>,
    pub settings: &'a SolveSettings,
    usage: Usage,
    /// The texels of each view.
    pub tables: Vec<Padded>,
    /// For each code of a distance the weight of a match.
    pub distance_weights: [f32; CODES],
    /// What has been solved.
    pub field: Field,
}

impl<'a> Sweep<'a> {
    /// Before the first phase.
    fn new(
        matches: &'a Matches,
        views: &'a [LevelView],
        before: Option<&'a Field>,
        theta: Option<&'a ControlMap>,
        settings: &'a SolveSettings,
    ) -> Self {
        let voxels = matches.size.iter().product();
        let before = before.filter(|field| field.size == matches.size && field.sources.len() == views.len());
        let mut usage = Usage::new(views);
        if let Some(before) = before {
            for (i, &color) in before.colors.iter().enumerate() {
                let view = before.view_of(i);
                usage.add(views, view, before.sources[view][i], color);
            }
        }
        let field = Field {
            size: matches.size,
            level: matches.level,
            colors: vec![[0; 4]; voxels],
            sources: views.iter().map(|_| vec![0; voxels]).collect(),
            chosen: if views.len() > 1 { vec![0; voxels] } else { Vec::new() },
            index: index_histogram(matches, views),
        };
        let tables = views.iter().map(|view| Padded::new(view, matches.window.size)).collect();
        let distance_weights = distance_weights(settings.gamma);
        Self { matches, views, before, theta, settings, usage, tables, distance_weights, field }
    }

    /// The order of updates.
    pub fn phases(&self) -> Phases {
        Phases::new(self.matches.size, self.settings.seed, PURPOSE, self.settings.sweep)
    }

    /// Weighs texels by what is in use now, for the next phase.
    pub fn weigh(&mut self) {
        for (v, table) in self.tables.iter_mut().enumerate() {
            table.weigh(
                &self.views[v],
                &self.usage.weights(self.views, v, self.theta, &self.settings.weights),
            );
        }
    }

    /// Takes up what the voxels of a phase become.
    pub fn keep(&mut self, voxels: &[u32], solved: &[Solved]) {
        let Self { views, before, usage, field, .. } = self;
        let count = || {
            for (&voxel, solved) in voxels.iter().zip(solved) {
                let voxel = voxel as usize;
                if let Some(before) = before {
                    let view = before.view_of(voxel);
                    usage.remove(views, view, before.sources[view][voxel], before.colors[voxel]);
                }
                let view = usize::from(solved.chosen);
                usage.add(views, view, solved.sources[view], solved.color);
            }
        };
        let write = || {
            for (&voxel, solved) in voxels.iter().zip(solved) {
                let voxel = voxel as usize;
                field.colors[voxel] = solved.color;
                field.sources.iter_mut().zip(solved.sources).for_each(|(to, source)| to[voxel] = source);
                if let Some(to) = field.chosen.get_mut(voxel) {
                    *to = solved.chosen;
                }
            }
        };
        rayon::join(count, write);
    }
}

/// What a voxel becomes.
#[derive(Clone, Copy, Default)]
pub(super) struct Solved {
    pub color: [u8; 4],
    /// For each view the pixel of the nearest texel.
    pub sources: [Pixel; 3],
    /// The view whose texel is the nearest.
    pub chosen: u8,
}

/// For each code of a distance the weight r^(γ − 2) of a match.
fn distance_weights(gamma: f64) -> [f32; CODES] {
    // A match of no distance must not outweigh all others: one grey level is as near as it gets.
    let least = f64::from(crate::search::SCALE).powi(2);
    std::array::from_fn(|code| libm::pow((decode(code) + least) / least, (gamma - 2.0) / 2.0) as f32)
}

/// How often each pixel is matched.
fn index_histogram(matches: &Matches, views: &[LevelView]) -> Vec<Vec<u32>> {
    let mut index: Vec<Vec<u32>> = views.iter().map(|view| vec![0; view.texels.len()]).collect();
    for (direction, matched) in matches.directions.iter().enumerate() {
        let view = direction.min(views.len() - 1);
        for &pixel in &matched.pixels {
            index[view][views[view].index(pixel)] += 1;
        }
    }
    index
}

struct Job<'a> {
    window: Window,
    /// For each direction the matches, pixel and code in one word, in the order of `around`.
    matches: &'a [Vec<u32>; 3],
    tables: &'a [Padded],
    distance_weights: &'a [f32; CODES],
    around: &'a Around,
    isa: Isa,
    solver: Solver,
}

fn solve_voxels(job: &Job<'_>, voxels: &[u32], out: &mut [Solved]) {
    #[cfg(target_arch = "x86_64")]
    if is_wide(job.isa) {
        // SAFETY: `isa` comes from `available_instruction_sets`.
        return unsafe { solve_avx2(job, voxels, out) };
    }
    solve_any(job, voxels, out);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn solve_avx2(job: &Job<'_>, voxels: &[u32], out: &mut [Solved]) {
    solve_any(job, voxels, out);
}

/// How many texels are compared at once.
const LANES: usize = 8;

// Plain loops: a closure would be compiled without the instruction set and not inlined. Sums are taken in the same order on all
// of them, and nothing contracts a product and a sum, so that all give the same bits.
#[inline(always)]
fn solve_any(job: &Job<'_>, voxels: &[u32], out: &mut [Solved]) {
    let Job { window, matches, tables, distance_weights, .. } = *job;
    // The window around a matched voxel covers this one if that voxel lies within the mirrored window.
    let (before, size) = (window.after(), window.size);
    let directions: Vec<usize> = (0..3).filter(|&d| !matches[d].is_empty()).collect();
    // The texel lies as far after the match's centre as the voxel lies after the matched one.
    let offset = |table: &Padded, i: i32| {
        let (row, column) = (before - i / size + table.margin, before - i % size + table.margin);
        row as u32 * table.pitch as u32 + column as u32
    };
    let offsets: Vec<Vec<u32>> =
        tables.iter().map(|table| (0..size * size).map(|i| offset(table, i)).collect()).collect();
    // The texels that overlap at a voxel, those of each view together, filled with the last so that they come in whole lanes.
    let together = if tables.len() == 1 { directions.len() } else { 1 };
    let each = (window.pixels() * together).next_multiple_of(LANES);
    let mut overlapping = vec![0u32; window.pixels()];
    let mut colors = vec![0u32; each * directions.len() / together];
    let mut indices = colors.clone();
    for (&voxel, out) in voxels.iter().zip(out) {
        let mut sums = [0.0f32; 4];
        let mut total = 0.0f32;
        let mut next = 0;
        for (&direction, number) in directions.iter().zip(1..) {
            let matched = &matches[direction][..];
            let view = direction.min(tables.len() - 1);
            let (table, pitch) = (&tables[view].texels[..], tables[view].pitch as u32);
            let (own, columns, rows) = job.around.plane(voxel as usize, direction, before, size);
            for (&row, to) in rows.iter().zip(overlapping.chunks_exact_mut(size as usize)) {
                for (&column, to) in columns.iter().zip(to) {
                    *to = matched[(own + row + column) as usize];
                }
            }
            let to = colors[next..].iter_mut().zip(&mut indices[next..]);
            for ((&matched, &offset), (color, index)) in overlapping.iter().zip(&offsets[view]).zip(to) {
                *index = (matched >> 8 & 255) * pitch + (matched & 255) + offset;
                let texel = table[*index as usize];
                *color = u32::from_le_bytes(texel.color);
                let weight = distance_weights[(matched >> 16) as usize & (CODES - 1)] * texel.weight;
                for (sum, channel) in sums.iter_mut().zip(texel.color) {
                    *sum += weight * f32::from(channel);
                }
                total += weight;
            }
            next += window.pixels();
            let last = together == 1 || number == directions.len();
            while last && !next.is_multiple_of(each) {
                (colors[next], indices[next]) = (colors[next - 1], indices[next - 1]);
                next += 1;
            }
        }
        let mean = sums.map(|sum| if total > 0.0 { sum / total } else { 0.0 });
        let mut best = [(f32::INFINITY, 0usize); 3];
        for (i, (colors, indices)) in colors.chunks_exact(each).zip(indices.chunks_exact(each)).enumerate() {
            let (gap, place) = nearest_color(colors.as_chunks::<LANES>().0, mean);
            let view = directions[i].min(tables.len() - 1);
            if gap < best[view].0 {
                best[view] = (gap, indices[place] as usize);
            }
        }
        let mut chosen = 0;
        for view in 0..tables.len() {
            out.sources[view] = tables[view].sources[best[view].1];
            if best[view].0 < best[chosen].0 {
                chosen = view;
            }
        }
        out.chosen = chosen as u8;
        out.color = match job.solver {
            Solver::Discrete => tables[chosen].texels[best[chosen].1].color,
            Solver::Mean => mean.map(|m| (m + 0.5) as u8),
        };
    }
}

/// How far the colour nearest to `mean` is from it, squared, and which it is, the first among equals.
#[inline(always)]
fn nearest_color(colors: &[[u32; LANES]], mean: [f32; 4]) -> (f32, usize) {
    let mut least = [f32::INFINITY; LANES];
    // Numbers of blocks, as floats so that both are chosen alike.
    let mut block = [0.0f32; LANES];
    for (number, colors) in colors.iter().enumerate() {
        for lane in 0..LANES {
            let mut squares = [0.0f32; 4];
            for channel in 0..4 {
                let difference = (colors[lane] >> (8 * channel) & 255) as i32 as f32 - mean[channel];
                squares[channel] = difference * difference;
            }
            let gap = (squares[0] + squares[2]) + (squares[1] + squares[3]);
            let nearer = gap < least[lane];
            least[lane] = if nearer { gap } else { least[lane] };
            block[lane] = if nearer { number as f32 } else { block[lane] };
        }
    }
    let mut gap = least[0];
    for other in least {
        gap = if other < gap { other } else { gap };
    }
    let mut place = u32::MAX;
    for lane in 0..LANES {
        let this = block[lane] as u32 * LANES as u32 + lane as u32;
        place = place.min(if least[lane] == gap { this } else { u32::MAX });
    }
    (gap, place as usize)
}
