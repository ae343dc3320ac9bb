//! The search phase (Chen & Wang 2010, section 4.3) with index histogram matching (section 4.4.2).

use rayon::prelude::*;

use super::coherence::{Candidates, Direction, Match, Scratch, Voxel, match_voxels};
use super::control_map::ControlMap;
use super::device::Job;
use super::field::Field;
use super::matches::{DirectionMatches, Matches};
use super::phases::{Around, PHASES, PORTION, Phases};
use crate::control::{Cancelled, Control, Stopped, check, on_device};
use crate::lazy::{Isa, Pixel, available_instruction_sets};
use crate::search::{Patches, SimilarSets};

/// Which neighbourhoods are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Those that continue a voxel of the window, and for the voxels near its centre their similarity sets.
    Coherent,
    /// All.
    Exhaustive,
}

/// How matches are searched.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchSettings {
    /// Which neighbourhoods are compared.
    pub method: Method,
    /// Voxels from the centre of the window whose similarity sets are proposed, whole; others propose only what continues them.
    pub reach: i32,
    /// How strongly neighbourhoods that are matched too often are avoided: 0 is not at all.
    pub index: f64,
    /// Which directions are matched.
    pub directions: [bool; 3],
    /// The order of updates.
    pub seed: u64,
    /// The number of the sweep; each has an order of its own.
    pub sweep: u32,
}

pub(super) const PURPOSE: u32 = 0x5ea7_c401;

/// For each voxel and direction the nearest neighbourhood of the exemplar. The distance is multiplied by
/// `1 + index · max(0, H/φ − 1)` (equations 5 and 6, with H relative to the even share φ, so that one strength suits all sizes).
/// A compute device finds the same.
///
/// # Errors
/// [`Stopped`].
pub fn search(
    field: &Field,
    patches: &Patches,
    sets: Option<&SimilarSets>,
    phi: Option<&ControlMap>,
    settings: &SearchSettings,
    control: &dyn Control,
) -> Result<Matches, Stopped> {
    let job = Job { field, patches, sets, phi, settings };
    if job.fits()
        && let Some(matches) = on_device(control, |gpu| job.run(gpu, control))?
    {
        return Ok(matches);
    }
    let isa = available_instruction_sets().last().copied().unwrap_or(Isa::Portable);
    Ok(search_with(isa, field, patches, sets, phi, settings, control)?)
}

pub(super) fn search_with(
    isa: Isa,
    field: &Field,
    patches: &Patches,
    sets: Option<&SimilarSets>,
    phi: Option<&ControlMap>,
    settings: &SearchSettings,
    control: &dyn Control,
) -> Result<Matches, Cancelled> {
    let voxels = field.voxels();
    let around = Around::new(field.size);
    let phases = Phases::new(field.size, settings.seed, PURPOSE, settings.sweep);
    let in_bricks: Vec<Vec<Voxel>> = field
        .sources
        .iter()
        .map(|sources| around.arrange(|i| Voxel { color: field.colors[i], source: sources[i] }))
        .collect();
    let candidates: Vec<Candidates> =
        (0..patches.views.len()).map(|view| Candidates::new(patches, view, sets, settings.method)).collect();
    let mut directions = <[DirectionMatches; 3]>::default();
    for (direction, wanted) in directions.iter_mut().zip(settings.directions) {
        let count = if wanted { voxels } else { 0 };
        *direction = DirectionMatches { pixels: vec![0; count], codes: vec![0; count] };
    }
    let mut usage = IndexUsage::new(field, patches, settings);
    let mut found: Vec<[Match; 3]> = Vec::new();
    for (p, voxels) in phases.iter().enumerate() {
        check(control)?;
        control.progress(p as f32 / PHASES as f32);
        let weights = usage.weights(phi, settings.index);
        let centre_weights: Vec<Vec<u32>> = candidates
            .iter()
            .zip(&weights)
            .map(|(candidates, weights)| match &candidates.all {
                Some((centres, table)) => table.pad(centres.iter().map(|&i| weights[usize::from(i)])),
                None => Vec::new(),
            })
            .collect();
        let direction = |direction: usize| {
            let view = patches.view(direction);
            Direction {
                direction,
                voxels: &in_bricks,
                patches,
                reach: settings.reach,
                isa,
                around: &around,
                candidates: &candidates[view],
                weights: &weights[view],
                centre_weights: &centre_weights[view],
            }
        };
        let wanted: Vec<_> = (0..3).filter(|&d| settings.directions[d]).map(direction).collect();
        found.clear();
        found.resize(voxels.len(), [(0, 0); 3]);
        found.par_chunks_mut(PORTION).zip(voxels.par_chunks(PORTION)).try_for_each_init(
            Scratch::new,
            |scratch, (found, voxels)| {
                for direction in &wanted {
                    check(control)?;
                    match_voxels(direction, voxels, found, scratch);
                }
                Ok(())
            },
        )?;
        let write = |(d, matched): (usize, &mut DirectionMatches)| {
            if settings.directions[d] {
                for (&voxel, found) in voxels.iter().zip(&found) {
                    (matched.pixels[voxel as usize], matched.codes[voxel as usize]) = found[d];
                }
            }
        };
        let count = || {
            for direction in &wanted {
                let view = patches.view(direction.direction);
                found.iter().for_each(|found| usage.add(view, found[direction.direction].0));
            }
        };
        rayon::join(|| directions.par_iter_mut().enumerate().for_each(write), count);
    }
    Ok(Matches { size: field.size, level: field.level, window: patches.window(), directions })
}

/// How often each pixel has been matched: in this sweep so far, and for the rest as in the last one.
pub(super) struct IndexUsage<'a> {
    before: &'a [Vec<u32>],
    now: Vec<Vec<u32>>,
    done: Vec<u64>,
    total: Vec<u64>,
    widths: Vec<i32>,
    centres: Vec<u64>,
}

impl<'a> IndexUsage<'a> {
    /// Before the first phase.
    pub fn new(field: &'a Field, patches: &Patches, settings: &SearchSettings) -> Self {
        let views = patches.views.len();
        let mut total = vec![0; views];
        for (direction, _) in settings.directions.iter().enumerate().filter(|(_, wanted)| **wanted) {
            total[patches.view(direction)] += field.voxels() as u64;
        }
        let window = patches.window();
        let centres = patches.views.iter().map(|view| {
            let edge = |n: i32| if view.tileable { n } else { n - window.size + 1 };
            (edge(view.width) as u64 * edge(view.height) as u64).max(1)
        });
        let fits = field.index.len() == views
            && field.index.iter().zip(&patches.views).all(|(i, v)| i.len() == (v.width * v.height) as usize);
        Self {
            before: if fits { &field.index } else { &[] },
            now: patches.views.iter().map(|view| vec![0; (view.width * view.height) as usize]).collect(),
            done: vec![0; views],
            total,
            widths: patches.views.iter().map(|view| view.width).collect(),
            centres: centres.collect(),
        }
    }

    /// Counts a match.
    pub fn add(&mut self, view: usize, pixel: Pixel) {
        let width = self.widths[view] as usize;
        self.now[view][usize::from(pixel >> 8) * width + usize::from(pixel & 255)] += 1;
        self.done[view] += 1;
    }

    /// For each view and pixel how much farther it counts, times 256.
    pub fn weights(&self, phi: Option<&ControlMap>, strength: f64) -> Vec<Vec<u32>> {
        let weigh = |view: usize| {
            let rest = 1.0 - self.done[view] as f64 / self.total[view].max(1) as f64;
            let before: &[u32] = self.before.get(view).map_or(&[], |before| before);
            let sum: u64 = before.iter().map(|&n| u64::from(n)).sum();
            // What the last sweep says of the rows to come, as if it had had as many.
            let share = if sum > 0 { rest * self.total[view] as f64 / sum as f64 } else { 0.0 };
            let mass = self.done[view] as f64 + share * sum as f64;
            let even = mass / self.centres[view] as f64;
            let count = self.now[view].len();
            (0..count)
                .map(|i| {
                    let h =
                        f64::from(self.now[view][i]) + share * f64::from(before.get(i).copied().unwrap_or(0));
                    let wanted = phi.map_or(1.0, |phi| phi.at(view, i));
                    let excess = if even > 0.0 { (h / (even * wanted) - 1.0).max(0.0) } else { 0.0 };
                    (256.0 * (1.0 + strength * excess)).min(16_777_216.0) as u32
                })
                .collect()
        };
        (0..self.now.len()).map(weigh).collect()
    }
}
